//! Heights that are written come back; every dialect is read; every damaged file is an error or a valid field.

#[path = "common/heights.rs"]
mod heights;

use std::fs;

use glam::DVec2;
use heights::*;
use meshfront_mesh::io::height::{self, HeightFormat, HeightSource, is_height_format};
use meshfront_mesh::io::{WriteError, WriteOptions};
use meshfront_mesh::{HeightField, Unit};
use proptest::prelude::*;
use tiff::encoder::compression::DeflateLevel;
use tiff::encoder::{Compression, Predictor, TiffEncoder};

use HeightFormat::{EsriAscii, GeoTiff, Png, UsgsDem};

fn read(bytes: &[u8], format: HeightFormat) -> HeightSource {
    height::read_bytes(bytes, format, "a file").unwrap_or_else(|e| panic!("{e}"))
}

/// The message of a file that must not be read.
fn message(bytes: &[u8], format: HeightFormat) -> String {
    height::read_bytes(bytes, format, "a file").expect_err("cannot be read").to_string()
}

#[test]
fn every_dialect_gives_the_same_field() {
    for (name, format, bytes) in small_files() {
        let source = height::read_bytes(&bytes, format, name).unwrap_or_else(|e| panic!("{e}"));
        assert_valid(&source.field);
        let mut expected = small();
        if format == Png {
            (expected.origin, expected.spacing) = (DVec2::ZERO, DVec2::ONE);
        }
        assert_eq!(bits(&source.field), bits(&expected), "{name}");
        expected.heights.clone_from(&source.field.heights);
        expected.heights[2] = 0.0;
        let mut field = source.field;
        field.heights[2] = 0.0;
        assert_eq!(field, expected, "{name}");
        assert_eq!(source.report.missing, 1, "{name}");
        assert_eq!(source.report.bytes, bytes.len() as u64);
    }
}

#[test]
fn a_cut_file_is_an_error_or_whole() {
    for (name, format, bytes) in small_files() {
        for cut in 0..bytes.len() {
            match height::read_bytes(&bytes[..cut], format, name) {
                Err(error) => assert!(error.to_string().starts_with(name)),
                Ok(source) => {
                    // Only what follows the last height may go: a line end, blanks, an empty end of the directory.
                    assert_eq!(bits(&source.field), bits(&small()), "{name} cut at {cut} of {}", bytes.len());
                }
            }
        }
    }
}

#[test]
fn a_changed_byte_is_an_error_or_a_valid_field() {
    for (name, format, bytes) in small_files() {
        for at in 0..bytes.len() {
            for change in [1, 0x10, 0x80, 0xff] {
                let mut bytes = bytes.clone();
                bytes[at] ^= change;
                if let Ok(source) = height::read_bytes(&bytes, format, name) {
                    assert_valid(&source.field);
                }
            }
        }
    }
}

#[test]
fn names_tell_the_format() {
    for (name, format) in
        [("a.tif", GeoTiff), ("b.c.TIFF", GeoTiff), ("x.png", Png), ("x.dem.gz", UsgsDem), ("x.Asc.GZ", EsriAscii)]
    {
        assert_eq!(HeightFormat::from_path(name), Some(format), "{name}");
    }
    for name in ["a.ply", "tif", "a.gz", "a.tif.zip", ""] {
        assert!(!is_height_format(name), "{name}");
    }
    let error = height::read("nothing.ply").unwrap_err().to_string();
    assert!(error.contains("nothing.ply") && error.contains(".asc"), "{error}");
    assert!(height::read("nothing.asc").unwrap_err().to_string().starts_with("nothing.asc: cannot be read"));
    // A name that lies is told from the content.
    for (wrong, right) in [(UsgsDem, EsriAscii), (EsriAscii, GeoTiff), (GeoTiff, Png)] {
        let error = message(&written(&small(), right), wrong);
        assert!(error.contains(&format!("expected {wrong}, found {right}: rename it to .")), "{error}");
    }
}

#[test]
fn reports_are_one_line() {
    let report = |bytes: &[u8], format| read(bytes, format).report.to_string();
    let asc = "ncols 2\nnrows 2\ncellsize 10\n1 2 3 -9999\n";
    assert_eq!(
        report(asc.as_bytes(), EsriAscii),
        "ESRI ASCII grid with 2 × 2 heights, 1 of them missing, 10 apart, taken for metres, corner at 0, -9999 \
         taken for missing"
    );
    let mut dem = Dem::of(vec![(0.0, 0.0, vec![1, 2]), (30.0, 0.0, vec![3, 4])]);
    (dem.units, dem.spacing) = (["2", "1"], [30.0, 15.0, 1.0]);
    assert_eq!(report(&dem.bytes(), UsgsDem), "USGS DEM with 2 × 2 heights, 30 × 15 metres apart, heights in feet");
    dem.units = ["3", ""];
    assert_eq!(
        report(&dem.bytes(), UsgsDem),
        "USGS DEM with 2 × 2 heights, 30 × 15 arc-seconds apart, heights taken for metres"
    );
    let two = Tiff { bands: 2, place: TiffPlace::None, ..Tiff::default() };
    assert_eq!(
        report(&two.bytes(), GeoTiff),
        "GeoTIFF with 3 × 2 heights, 1 of them missing, 1 apart, taken for metres, the first of 2 bands, no \
         place given"
    );
}

#[test]
fn text_grids_say_where_they_are_wrong() {
    let grid = |rest: &str| format!("ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\n{rest}");
    for (text, place, words) in [
        (grid("1 2 3\n4 five 6\n"), "line 7", "expected a height, found `five`"),
        (grid("1 2 3.00\n4 5\n"), "line 8", "the file ends where a height"),
        (grid("1 2 3\n4 5 6 7\n"), "line 7", "the end of the file after ncols × nrows heights"),
        (grid("1 2 3\n4 inf 6\n"), "line 7", "a height is not a finite"),
        (grid("1 2 3\n4 1e39 6\n"), "line 7", "a height is not a finite"),
        (grid("-9999 -9999 -9999 -9999 -9999 -9999\n"), "a file:", "all of its 6 samples are missing"),
        (
            grid("1 2 3 4 5 6").replace("cellsize 10", "cellsize -10"),
            "a file:",
            "a positive distance between samples, found -10",
        ),
        (grid("1 2 3 4 5 6").replace("cellsize 10", "cellsize nan"), "line 5", "the size of a cell"),
        (grid("1 2 3 4 5 6").replace("cellsize 10", "celsize 10"), "line 5", "found `celsize`"),
        (grid("1 2 3 4 5 6").replace("cellsize 10", ""), "line 6", "expected the word cellsize"),
        (grid("1 2 3 4 5 6").replace("ncols 3", "ncols 1"), "line 1", "the number of columns from 2"),
        (grid("1 2 3 4 5 6").replace("ncols 3", "ncols 2000000000"), "", "4000000000 heights are promised"),
        (grid("1 2 3 4 5 6").replace("ncols 3", "ncols 999999999999999999"), "", "are promised"),
        (String::new(), "", "the word ncols"),
    ] {
        let error = message(text.as_bytes(), EsriAscii);
        assert!(error.contains(place) && error.contains(words), "{error}");
    }
}

#[test]
fn whole_numbers_have_a_step() {
    let step = |heights: &str| read(format!("ncols 2 nrows 2 cellsize 1 {heights}").as_bytes(), EsriAscii).field.step;
    assert_eq!(step("1 -2 3000000 4"), Some(1.0));
    assert_eq!(step("1 2 3 4.5"), None);
    assert_eq!(step("1 2 3 123456789"), None, "not exact in 32 bits");
}

#[test]
fn a_quadrangle_has_missing_corners() {
    // Profiles of different length and start, as the meridians and parallels of a quadrangle cut them in UTM.
    let profiles = vec![
        (1000.0, 5060.0, vec![1, 2]),
        (1030.0, 5030.0, (10..210).collect()),
        (1060.0, 5000.0, (20..400).collect()),
        (1090.0, 5120.0, vec![3]),
    ];
    let dem = Dem { units: ["2", "2"], spacing: [30.0, 30.0, 0.5], datum: 100.0, ..Dem::of(profiles.clone()) };
    for layout in [Layout::Records, Layout::Lines, Layout::TrimmedLines] {
        let field = read(&Dem { layout, elevations: dem.elevations.clone(), ..dem }.bytes(), UsgsDem).field;
        assert_eq!((field.columns, field.rows), (4, 380));
        assert_eq!((field.horizontal, field.vertical, field.step), (Unit::Metre, Unit::Metre, Some(0.5)));
        assert_eq!(field.origin, DVec2::new(1000.0, 5000.0 + 379.0 * 30.0));
        assert_eq!(field.missing(), 4 * 380 - 2 - 200 - 380 - 1);
        for (column, (x, y, elevations)) in profiles.iter().enumerate() {
            assert_eq!(field.origin.x + column as f64 * field.spacing.x, *x);
            for (i, &elevation) in elevations.iter().enumerate() {
                let row = (field.origin.y - (y + 30.0 * i as f64)) / field.spacing.y;
                assert_eq!(field.height(column as u32, row as u32), 100.0 + 0.5 * elevation as f32);
            }
        }
    }
}

#[test]
fn dem_units_are_known() {
    let units = |codes| {
        let dem = Dem { units: codes, ..Dem::of(vec![(0.0, 0.0, vec![1, 2]), (10.0, 0.0, vec![3, 4])]) };
        let field = read(&dem.bytes(), UsgsDem).field;
        (field.horizontal, field.vertical, field.spacing.x)
    };
    assert_eq!(units(["3", "1"]), (Unit::ArcSecond, Unit::Foot, 10.0));
    assert_eq!(units(["1", "2"]), (Unit::UsSurveyFoot, Unit::Metre, 10.0));
    assert_eq!(units(["0", "2"]), (Unit::Degree, Unit::Metre, 10f64.to_degrees()));
    // The header has too few digits for a third of an arc-second; the profiles have enough.
    let columns = (0..301).map(|i| (-439200.0 + f64::from(i) / 3.0, 151200.0, vec![1, 2, 3])).collect();
    let dem = Dem { units: ["3", "2"], spacing: [1.0 / 3.0, 1.0 / 3.0, 1.0], ..Dem::of(columns) };
    let field = read(&dem.bytes(), UsgsDem).field;
    assert!((field.spacing - DVec2::splat(1.0 / 3.0)).length() < 1e-12);
    assert_eq!((field.columns, field.rows), (301, 3));
}

#[test]
fn dems_say_where_they_are_wrong() {
    let two = || Dem { units: ["2", "2"], ..Dem::of(vec![(0.0, 0.0, vec![1, 2]), (10.0, 0.0, vec![3, 4])]) };
    let with = |at: usize, field: &str| {
        let mut bytes = two().bytes();
        bytes[at..at + field.len()].copy_from_slice(field.as_bytes());
        message(&bytes, UsgsDem)
    };
    for (error, words) in [
        (with(528, "     7"), "byte 528: expected a USGS DEM, with a number for the unit"),
        (with(858, "999999"), "the file ends where a profile should be"),
        (with(816, "-.100000E+02"), "a positive distance between samples"),
        (with(840, "garbage!!!!!"), "byte 840: expected the resolution of elevations, found `garbage!!!!!`"),
        (with(1024 + 12, "999999"), "999999 elevations are promised"),
        (with(1024 + 12, "     0"), "at least 1 elevation"),
        (with(1024 + 150, "    x9"), "byte 1174: expected an elevation, found `x9`"),
        (with(2048 + 24, "   0.500000000000000D+01"), "profile 2, which begins beside the grid"),
        (with(2048 + 48, "   0.500000000000000D+38"), "profile 1, which begins beside the grid"),
        (message(&Dem { angle: 0.1, ..two() }.bytes(), UsgsDem), "turned against its coordinates"),
        (message(b"", UsgsDem), "the first record"),
        (message(&[b'\n'; 5000], UsgsDem), "the first record"),
        (message(&[0xff; 5000], UsgsDem), "expected a USGS DEM"),
        (
            message(&Dem { elevations: vec![(0.0, 0.0, vec![1]), (10.0, 0.0, vec![2])], ..two() }.bytes(), UsgsDem),
            "at least 2 × 2 samples, found 2 × 1",
        ),
    ] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn tiff_keys_scale_and_offset() {
    let keys = |entries: &[[u16; 4]]| {
        let all = [&[[1, 1, 0, entries.len() as u16]], entries].concat().concat();
        (34735, 3, all.len() as u32, shorts(&all))
    };
    let metadata = |items: &str| {
        let text = format!("<GDALMetadata>{items}</GDALMetadata>\0");
        (42112, 2, text.len() as u32, text.into_bytes())
    };
    let field = |more| read(&Tiff { more, ..Tiff::default() }.bytes(), GeoTiff).field;
    let geographic = field(vec![keys(&[[1024, 0, 1, 2], [1025, 0, 1, 1], [4096, 0, 1, 6360]])]);
    assert_eq!((geographic.horizontal, geographic.vertical), (Unit::Degree, Unit::UsSurveyFoot));
    let projected = field(vec![keys(&[[1024, 0, 1, 1], [3076, 0, 1, 9003], [4099, 0, 1, 9002]])]);
    assert_eq!((projected.horizontal, projected.vertical), (Unit::UsSurveyFoot, Unit::Foot));
    let scaled = field(vec![metadata(
        "<Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.5</Item><Item name=\"OFFSET\" sample=\"0\" role=\"offset\">-100\
         </Item><Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">metre</Item><Item name=\"SCALE\" sample=\"1\" \
         role=\"scale\">7</Item><Item name=\"CREATOR\">me</Item>",
    )]);
    assert_eq!(&scaled.heights[3..], [-98.0, -97.5, -97.0]);
    assert_eq!((scaled.missing(), scaled.step, scaled.vertical), (1, Some(0.5), Unit::Metre));
    // Floating point: the same twelve bytes a row are three 32-bit numbers, read in a file of 3 × 1 and refused.
    let error = message(&Tiff { more: vec![(257, 3, 1, shorts(&[1]))], ..Tiff::default() }.bytes(), GeoTiff);
    assert!(error.contains("a file"), "{error}");
}

#[test]
fn tiffs_that_are_no_heights_are_refused() {
    let refused = |tiff: Tiff| message(&tiff.bytes(), GeoTiff);
    let more = |more| refused(Tiff { more, ..Tiff::default() });
    for (error, words) in [
        (refused(Tiff { place: TiffPlace::Turned, ..Tiff::default() }), "turn it north up"),
        (refused(Tiff { photometric: 0, ..Tiff::default() }), "white is 0"),
        (refused(Tiff { photometric: 2, bands: 3, ..Tiff::default() }), "in colour"),
        (more(vec![(33550, 12, 3, doubles(&[10.0, 0.0, 0.0]))]), "a positive distance between samples"),
        (more(vec![(33550, 12, 3, doubles(&[f64::NAN, 1.0, 0.0]))]), "a positive distance between samples"),
        (more(vec![(259, 3, 1, shorts(&[34887]))]), "gdal_translate"),
        (more(vec![(34735, 1, 8, vec![1; 8])]), "tag 34735 holds BYTE, not SHORT"),
        // Numbers of strips and tiles beyond all counting.
        (
            more(vec![
                (257, 4, 1, vec![0xff; 4]),
                (277, 3, 1, shorts(&[0xffff])),
                (258, 3, 1, shorts(&[16])),
                (284, 3, 1, shorts(&[2])),
            ]),
            "a file",
        ),
        (
            refused(Tiff {
                tiles: true,
                more: vec![
                    (256, 4, 1, vec![0xff; 4]),
                    (257, 4, 1, vec![0xff; 4]),
                    (322, 3, 1, shorts(&[1])),
                    (323, 3, 1, shorts(&[1])),
                    (277, 3, 1, shorts(&[0xffff])),
                    (258, 3, 1, shorts(&[16])),
                    (284, 3, 1, shorts(&[2])),
                ],
                ..Tiff::default()
            }),
            "a file",
        ),
        // A kilobyte that promises gigabytes.
        (
            more(vec![(256, 3, 1, shorts(&[60000])), (257, 3, 1, shorts(&[60000])), (278, 3, 1, shorts(&[30000]))]),
            "3600000000 samples are promised",
        ),
    ] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn floats_that_are_nodata_in_32_bits_are_missing() {
    // The lowest number, in the digits that programs write; -9999.9 is not exact in 32 bits.
    for (nodata, value) in [("-3.40282346638529e+38", f32::MIN), ("-9999.9", -9999.9), ("nan", f32::NAN)] {
        let row = |v: [f32; 3]| v.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let mut text = nodata.as_bytes().to_vec();
        text.push(0);
        let twice = b"<Item name=\"SCALE\" sample=\"0\" role=\"scale\">2</Item>\0".to_vec();
        let tiff = Tiff {
            more: vec![
                (258, 3, 1, shorts(&[32])),
                (339, 3, 1, shorts(&[3])),
                (42112, 2, twice.len() as u32, twice),
                (42113, 2, text.len() as u32, text),
                // Six samples in one strip, which lies where its own tag says: in the value of a private tag.
                (65000, 1, 24, [row([1.0, value, 3.0]), row([4.5, 5.0, 6.0])].concat()),
            ],
            ..Tiff::default()
        };
        let mut bytes = tiff.bytes();
        let at = bytes.windows(12).position(|w| w == row([4.5, 5.0, 6.0])).unwrap() as u32 - 12;
        for (entry, values) in [(273u16, [at, at + 12]), (279, [12, 12])] {
            let tag = bytes.windows(4).position(|w| w == shorts(&[entry, 4])).unwrap();
            let to = u32::from_le_bytes(bytes[tag + 8..tag + 12].try_into().unwrap()) as usize;
            bytes[to..to + 8].copy_from_slice(&values.map(u32::to_le_bytes).concat());
        }
        let field = read(&bytes, GeoTiff).field;
        assert!(field.heights[1].is_nan());
        assert_eq!((field.missing(), field.heights[3], field.step), (1, 9.0, None), "{nodata}");
    }
}

/// A TIFF by the encoder of the crate.
fn tiff_of<C, K>(width: u32, compression: Compression, predictor: Predictor, samples: &[C::Inner]) -> Vec<u8>
where
    C: tiff::encoder::colortype::ColorType,
    K: tiff::encoder::TiffKind,
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut bytes = std::io::Cursor::new(Vec::new());
    let encoder = TiffEncoder::<_, K>::new_generic(&mut bytes).unwrap();
    let mut encoder = encoder.with_compression(compression).with_predictor(predictor);
    encoder.write_image::<C>(width, samples.len() as u32 / width, samples).unwrap();
    bytes.into_inner()
}

#[test]
fn tiffs_of_all_samples_and_compressions() {
    use tiff::encoder::{TiffKindBig as Big, TiffKindStandard as Standard, colortype::*};
    let numbers: Vec<i8> = (0..35).map(|i| ((i * 7) % 31 - 9) as i8).collect();
    macro_rules! check {
        ($color:ident, $kind:ident, $compression:expr, $predictor:expr, $type:ty) => {
            let signed = !stringify!($type).starts_with('u');
            let number = |x: i8| if signed { x as $type } else { x.unsigned_abs() as $type };
            let samples: Vec<$type> = numbers.iter().map(|&x| number(x)).collect();
            let field = read(&tiff_of::<$color, $kind>(5, $compression, $predictor, &samples), GeoTiff).field;
            assert_eq!((field.columns, field.rows), (5, 7));
            assert!(samples.iter().zip(&field.heights).all(|(a, b)| *a as f32 == *b), stringify!($color));
            let whole = !stringify!($type).starts_with('f');
            assert_eq!(field.step.is_some(), whole, stringify!($color));
        };
    }
    let deflate = Compression::Deflate(DeflateLevel::Fast);
    check!(Gray8, Standard, Compression::Uncompressed, Predictor::None, u8);
    check!(Gray16, Big, Compression::Lzw, Predictor::Horizontal, u16);
    check!(Gray32, Standard, deflate, Predictor::None, u32);
    check!(Gray64, Standard, Compression::Packbits, Predictor::None, u64);
    check!(GrayI8, Standard, Compression::Uncompressed, Predictor::None, i8);
    check!(GrayI16, Standard, Compression::Packbits, Predictor::Horizontal, i16);
    check!(GrayI32, Big, deflate, Predictor::Horizontal, i32);
    check!(GrayI64, Standard, Compression::Lzw, Predictor::None, i64);
    check!(Gray32Float, Standard, deflate, Predictor::None, f32);
    check!(Gray64Float, Big, Compression::Lzw, Predictor::None, f64);
    // Whole numbers that 32-bit floating point rounds have no step; a height beyond it is an error.
    let rounded = tiff_of::<Gray32, Standard>(2, Compression::Uncompressed, Predictor::None, &[1, 2, 3, (1 << 24) + 1]);
    let source = read(&rounded, GeoTiff);
    assert_eq!(source.field.step, None);
    assert!(source.report.to_string().contains("rounded"));
    let beyond =
        tiff_of::<Gray64Float, Standard>(2, Compression::Uncompressed, Predictor::None, &[1.0, 1e39, 3.0, 4.0]);
    assert!(message(&beyond, GeoTiff).contains("found another in column 1, row 0"));
}

/// A PNG by the encoder of the crate.
fn png(color: png::ColorType, depth: png::BitDepth, transparent: Option<&[u8]>, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if let Some(grey) = transparent {
        encoder.set_trns(grey.to_vec());
    }
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

#[test]
fn pngs_of_grey_are_read_and_others_refused() {
    use png::{BitDepth::*, ColorType::*};
    let eight = read(&png(Grayscale, Eight, None, &[0, 1, 254, 255]), Png).field;
    assert_eq!((&eight.heights[..], eight.step), (&[0.0, 1.0, 254.0, 255.0][..], Some(1.0)));
    let keyed = read(&png(Grayscale, Sixteen, Some(&[1, 2]), &[0, 1, 1, 2, 0xff, 0xff, 2, 1]), Png).field;
    assert_eq!((keyed.heights[0], keyed.heights[2], keyed.heights[3]), (1.0, 65535.0, 513.0));
    assert!(keyed.heights[1].is_nan());
    let masked = read(&png(GrayscaleAlpha, Eight, None, &[7, 255, 8, 0, 9, 1, 10, 128]), Png).field;
    assert_eq!((masked.heights[0], masked.heights[2], masked.missing()), (7.0, 9.0, 1));
    for (bytes, words) in [
        (png(Rgb, Eight, None, &[0; 12]), "a PNG in colour cannot be read; convert it to grey"),
        (png(Grayscale, Four, None, &[0; 2]), "less than 8 bits"),
        (png(GrayscaleAlpha, Eight, None, &[0; 8]), "all of its 4 samples are missing"),
    ] {
        let error = message(&bytes, Png);
        assert!(error.contains(words), "{error}");
    }
    // A header that promises gigabytes.
    let mut huge = png(Grayscale, Eight, None, &[0; 4]);
    huge[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let crc = crc32(&huge[12..29]);
    huge[29..33].copy_from_slice(&crc.to_be_bytes());
    assert!(message(&huge, Png).contains("4294836225 samples are promised"), "{}", message(&huge, Png));
}

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 > 0 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &b| (0..8).fold(crc ^ u32::from(b), |crc, _| step(crc)))
}

#[test]
fn files_are_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["a.asc", "a.tif", "a.png", "a.asc.gz"] {
        height::write(at(name), &small(), WriteOptions::default()).unwrap();
        assert_eq!(bits(&height::read(at(name)).unwrap().field), bits(&small()), "{name}");
        let again = height::write(at(name), &small(), WriteOptions::default());
        assert!(matches!(again, Err(WriteError::Exists { .. })));
        height::write(at(name), &small(), WriteOptions { overwrite: true }).unwrap();
    }
    let files = fs::read_dir(folder.path()).unwrap().count();
    let fraction = HeightField { heights: vec![0.5; 6], ..small() };
    let angle = HeightField { vertical: Unit::Degree, ..small() };
    let nothing = HeightField { heights: vec![f32::NAN; 6], ..small() };
    for (name, field, words) in [
        ("b.png", &fraction, "whole heights from 0 to 65535"),
        ("b.tif", &angle, "heights cannot be angles"),
        ("b.asc", &nothing, "no surface"),
        ("b.dem", &small(), "read but not written"),
        ("b.ply", &small(), ".tif, .png or .asc"),
    ] {
        let error = height::write(at(name), field, WriteOptions::default()).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(words), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), files);
    // The unit of a text grid stands beside it.
    fs::write(at("a.prj"), "GEOGCS[\"x\",UNIT[\"Degree\",0.0174532925199433]]").unwrap();
    for name in ["a.asc", "a.asc.gz"] {
        let source = height::read(at(name)).unwrap();
        assert_eq!((source.field.horizontal, source.report.horizontal), (Unit::Degree, Unit::Degree));
    }
}

prop_compose! {
    /// Any heights: whole multiples of the step, or anything.
    fn any_field()(columns in 2u32..9, rows in 2u32..9)(
        (columns, rows) in Just((columns, rows)),
        step in prop::sample::select(vec![None, Some(1.0f32), Some(0.1), Some(2.5), Some(0.3048)]),
        numbers in prop::collection::vec(-30_000i16..30_000, (columns * rows) as usize),
        anything in prop::collection::vec(prop::num::f32::NORMAL | prop::num::f32::ZERO | prop::num::f32::SUBNORMAL, (columns * rows) as usize),
        missing in prop::collection::vec(prop::bool::weighted(0.2), (columns * rows) as usize),
        origin in prop::array::uniform2(-1e7..1e7f64),
        spacing in prop::array::uniform2(1e-5..1e5f64),
        units in (0..6usize, 0..4usize),
    ) -> HeightField {
        let units_of = [Unit::Unknown, Unit::Metre, Unit::Foot, Unit::UsSurveyFoot, Unit::Degree, Unit::ArcSecond];
        let height = |i: usize| match step {
            _ if missing[i] && i > 0 => f32::NAN,
            Some(step) => (f64::from(numbers[i]) * f64::from(step)) as f32,
            None => anything[i],
        };
        HeightField {
            columns,
            rows,
            heights: (0..numbers.len()).map(height).collect(),
            origin: DVec2::from(origin),
            spacing: DVec2::from(spacing),
            horizontal: units_of[units.0],
            vertical: units_of[units.1],
            step,
        }
    }
}

/// Everything of a field but its heights.
fn frame(field: &HeightField) -> HeightField {
    HeightField { heights: Vec::new(), ..field.clone() }
}

proptest! {
    #[test]
    fn tiff_gives_back_everything(field in any_field()) {
        let back = read(&written(&field, GeoTiff), GeoTiff).field;
        assert_valid(&back);
        prop_assert_eq!(bits(&back), bits(&field));
        prop_assert_eq!(frame(&back), frame(&field));
    }

    #[test]
    fn text_gives_back_all_but_units(field in any_field(), square in any::<bool>()) {
        let mut field = field;
        if square {
            field.spacing.y = field.spacing.x;
        }
        let back = read(&written(&field, EsriAscii), EsriAscii).field;
        prop_assert_eq!(bits(&back), bits(&field));
        prop_assert_eq!(back.spacing, field.spacing);
        // The north is the south plus a multiple of the spacing: two roundings.
        let size = field.origin.abs() + 10.0 * field.spacing;
        prop_assert!((back.origin - field.origin).abs().cmple(1e-15 * size).all(), "{} {}", back.origin, field.origin);
        prop_assert_eq!(back.step, field.step.filter(|&step| step == 1.0));
    }

    #[test]
    fn images_give_back_heights(field in any_field()) {
        let heights = field.heights.iter().map(|h| if h.is_nan() { *h } else { h.abs().min(65535.0).round() });
        let field = HeightField { heights: heights.collect(), ..field };
        let back = read(&written(&field, Png), Png).field;
        prop_assert_eq!(bits(&back), bits(&field));
        prop_assert_eq!(back.step, Some(1.0));
    }
}
