//! Small files of heights in every dialect, and what any height field must be.
#![allow(dead_code)]

use glam::DVec2;
use meshfront_mesh::io::height::{self, HeightFormat};
use meshfront_mesh::{HeightField, Unit};

/// Panics unless a field is what its documentation says.
pub fn assert_valid(field: &HeightField) {
    assert!(field.columns >= 2 && field.rows >= 2);
    assert_eq!(field.heights.len(), field.columns as usize * field.rows as usize);
    assert!(field.heights.iter().all(|h| h.is_finite() || h.is_nan()));
    assert!(field.heights.iter().any(|h| h.is_finite()));
    assert!(field.spacing.is_finite() && field.spacing.min_element() > 0.0, "{:?}", field.spacing);
    assert!(field.origin.is_finite());
    assert!(field.step.is_none_or(|step| step > 0.0 && step.is_finite()));
}

/// Heights as bits, all NaNs and both zeros the same.
pub fn bits(field: &HeightField) -> Vec<u32> {
    field.heights.iter().map(|h| if h.is_nan() { u32::MAX } else { (h + 0.0).to_bits() }).collect()
}

/// What all small files hold: 3 × 2 samples, one of them missing, 10 apart, the north-western one at (105, 215).
pub fn small() -> HeightField {
    HeightField {
        columns: 3,
        rows: 2,
        heights: vec![1.0, 2.0, f32::NAN, 4.0, 5.0, 6.0],
        origin: DVec2::new(105.0, 215.0),
        spacing: DVec2::splat(10.0),
        horizontal: Unit::Unknown,
        vertical: Unit::Unknown,
        step: Some(1.0),
    }
}

pub fn written(field: &HeightField, format: HeightFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    height::write_to(&mut bytes, field, format).unwrap();
    bytes
}

/// [`small`] in every dialect, by name; PNG without a place.
pub fn small_files() -> Vec<(&'static str, HeightFormat, Vec<u8>)> {
    use HeightFormat::*;
    let text = |s: &str| s.as_bytes().to_vec();
    let elevations = || Dem::of(vec![(105.0, 205.0, vec![4, 1]), (115.0, 205.0, vec![5, 2]), (125.0, 205.0, vec![6])]);
    let lines = Dem { layout: Layout::Lines, ..elevations() };
    let trimmed = Dem { layout: Layout::TrimmedLines, ..elevations() };
    let void = Dem {
        elevations: vec![(105.0, 205.0, vec![4, 1]), (115.0, 205.0, vec![5, 2]), (125.0, 205.0, vec![6, -32767])],
        ..elevations()
    };
    vec![
        (
            "asc",
            EsriAscii,
            text("ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -9999\n1 2 -9999\n4 5 6\n"),
        ),
        (
            "asc by centres, in another order, with Windows line ends",
            EsriAscii,
            text(
                "NROWS 2\r\nNCOLS 3\r\nNODATA_VALUE -1.5\r\nYLLCENTER 205\r\nXLLCENTER 105\r\nDX 10\r\nDY 10.0\r\n 1 2 -1.50 4 5\r\n 6",
            ),
        ),
        (
            "asc without nodata",
            EsriAscii,
            text("\u{feff}ncols 3\nnrows 2\nxllcenter 105\nyllcorner 2e2\ncellsize 10\n1\t2\tnan\n4\t5\t6\n"),
        ),
        ("dem", UsgsDem, elevations().bytes()),
        ("dem of lines", UsgsDem, lines.bytes()),
        ("dem of trimmed lines", UsgsDem, trimmed.bytes()),
        ("dem with a void", UsgsDem, void.bytes()),
        ("tif", GeoTiff, Tiff::default().bytes()),
        ("tif of a transformation", GeoTiff, Tiff { place: TiffPlace::Matrix, ..Tiff::default() }.bytes()),
        ("tif of points", GeoTiff, Tiff { place: TiffPlace::Points, ..Tiff::default() }.bytes()),
        ("tif with south up", GeoTiff, Tiff { place: TiffPlace::SouthUp, ..Tiff::default() }.bytes()),
        ("tif of tiles", GeoTiff, Tiff { tiles: true, ..Tiff::default() }.bytes()),
        ("tif of two bands", GeoTiff, Tiff { bands: 2, ..Tiff::default() }.bytes()),
        ("tif as written", GeoTiff, written(&small(), GeoTiff)),
        ("png as written", Png, written(&small(), Png)),
        ("asc as written", EsriAscii, written(&small(), EsriAscii)),
    ]
}

#[derive(Clone, Copy, PartialEq)]
pub enum Layout {
    Records,
    Lines,
    TrimmedLines,
}

/// A USGS DEM to be, made from the columns of its document.
pub struct Dem {
    /// Codes of units: of distances (as in the small files: none) and of elevations.
    pub units: [&'static str; 2],
    /// Distances between columns, between rows, and of elevations.
    pub spacing: [f64; 3],
    pub angle: f64,
    pub datum: f64,
    /// Where profiles begin, and their elevations to the north.
    pub elevations: Vec<(f64, f64, Vec<i32>)>,
    pub layout: Layout,
}

impl Dem {
    pub fn of(elevations: Vec<(f64, f64, Vec<i32>)>) -> Dem {
        Dem { units: ["", ""], spacing: [10.0, 10.0, 1.0], angle: 0.0, datum: 0.0, elevations, layout: Layout::Records }
    }

    pub fn bytes(&self) -> Vec<u8> {
        let real = |x: f64| {
            // As Fortran does: 0.557820000000000D+06.
            let exponent = if x == 0.0 { 0 } else { x.abs().log10().floor() as i32 + 1 };
            format!("{:>24}", format!("{:.15}D{exponent:+03}", x / 10f64.powi(exponent)))
        };
        let short = |x: f64| {
            let exponent = if x == 0.0 { 0 } else { x.abs().log10().floor() as i32 + 1 };
            format!("{:.6}E{exponent:+03}", x / 10f64.powi(exponent))
        };
        let mut records = Vec::new();
        let mut a = format!("{:144}", "A HILL");
        a += &format!("{:>6}{:>6}{:>6}{:>6}", 1, 1, 1, 10);
        a += &real(0.0).repeat(15);
        a += &format!("{:>6}{:>6}{:>6}", self.units[0], self.units[1], 4);
        a += &real(0.0).repeat(10);
        a += &real(self.angle);
        a += &format!("{:>6}", 1);
        a += &self.spacing.map(short).concat();
        a += &format!("{:>6}{:>6}", 1, self.elevations.len());
        assert_eq!(a.len(), 864);
        records.push(a);
        for (i, (x, y, elevations)) in self.elevations.iter().enumerate() {
            let mut b = format!("{:>6}{:>6}{:>6}{:>6}", 1, i + 1, elevations.len(), 1);
            b += &[*x, *y, self.datum, 0.0, 0.0].map(real).concat();
            assert_eq!(b.len(), 144);
            let (first, rest) = elevations.split_at(elevations.len().min(146));
            first.iter().for_each(|e| b += &format!("{e:>6}"));
            records.push(b);
            records.extend(rest.chunks(170).map(|part| part.iter().map(|e| format!("{e:>6}")).collect::<String>()));
        }
        let lines = records.iter().map(|record| match self.layout {
            Layout::Records => format!("{record:1024}"),
            Layout::Lines => format!("{record:1024}\r\n"),
            Layout::TrimmedLines => format!("{}\n", record.trim_end()),
        });
        lines.collect::<String>().into_bytes()
    }
}

#[derive(Clone, Copy, PartialEq)]
pub enum TiffPlace {
    /// Scale and tie point at the corner of pixel (1, 1).
    Tie,
    Matrix,
    /// Scale and tie point at a sample.
    Points,
    /// The rows stored from the south.
    SouthUp,
    Turned,
    None,
}

/// A TIFF to be, of 16-bit numbers, made from the document alone.
pub struct Tiff {
    pub place: TiffPlace,
    /// In tiles of 16 × 16, else in strips of one row.
    pub tiles: bool,
    pub bands: u16,
    /// Tags of other kinds: number, type, count and bytes.
    pub more: Vec<(u16, u16, u32, Vec<u8>)>,
    pub photometric: u16,
}

impl Default for Tiff {
    fn default() -> Tiff {
        Tiff { place: TiffPlace::Tie, tiles: false, bands: 1, more: Vec::new(), photometric: 1 }
    }
}

pub fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

impl Tiff {
    pub fn bytes(&self) -> Vec<u8> {
        const ASCII: u16 = 2;
        const SHORT: u16 = 3;
        const LONG: u16 = 4;
        const DOUBLE: u16 = 12;
        let field = small();
        let mut rows: Vec<Vec<u8>> = (field.heights.chunks(3))
            .map(|row| {
                let value = |h: &f32| if h.is_nan() { -77i16 } else { *h as i16 };
                let pixel = |h: &f32| [value(h), 1000].into_iter().take(self.bands.into()).flat_map(i16::to_le_bytes);
                row.iter().flat_map(pixel).collect()
            })
            .collect();
        if self.place == TiffPlace::SouthUp {
            rows.reverse();
        }
        let mut file = b"II*\0\0\0\0\0".to_vec();
        let mut chunks = Vec::new();
        if self.tiles {
            let mut tile = vec![0x55; 16 * 16 * 2 * usize::from(self.bands)];
            let stride = 16 * 2 * usize::from(self.bands);
            rows.iter().enumerate().for_each(|(i, row)| tile[i * stride..][..row.len()].copy_from_slice(row));
            rows = vec![tile];
        }
        for row in &rows {
            chunks.push((file.len() as u32, row.len() as u32));
            file.extend(row);
        }
        let longs = |values: Vec<u32>| values.into_iter().flat_map(u32::to_le_bytes).collect::<Vec<u8>>();
        let offsets = longs(chunks.iter().map(|c| c.0).collect());
        let counts = longs(chunks.iter().map(|c| c.1).collect());
        let count = chunks.len() as u32;
        let bands = usize::from(self.bands);
        let mut tags = vec![
            (256, SHORT, 1, shorts(&[3])),
            (257, SHORT, 1, shorts(&[2])),
            (258, SHORT, self.bands.into(), shorts(&vec![16; bands])),
            (259, SHORT, 1, shorts(&[1])),
            (262, SHORT, 1, shorts(&[self.photometric])),
            (277, SHORT, 1, shorts(&[self.bands])),
            (339, SHORT, self.bands.into(), shorts(&vec![2; bands])),
            (42113, ASCII, 4, b"-77\0".to_vec()),
        ];
        if bands > 1 {
            tags.push((338, SHORT, self.bands as u32 - 1, shorts(&vec![0; bands - 1])));
        }
        if self.tiles {
            tags.extend([(322, SHORT, 1, shorts(&[16])), (323, SHORT, 1, shorts(&[16]))]);
            tags.extend([(324, LONG, count, offsets), (325, LONG, count, counts)]);
        } else {
            tags.extend([(273, LONG, count, offsets), (278, SHORT, 1, shorts(&[1])), (279, LONG, count, counts)]);
        }
        match self.place {
            TiffPlace::Tie => {
                tags.push((33550, DOUBLE, 3, doubles(&[10.0, 10.0, 0.0])));
                tags.push((33922, DOUBLE, 6, doubles(&[1.0, 1.0, 0.0, 110.0, 210.0, 0.0])));
            }
            TiffPlace::Matrix | TiffPlace::Turned => {
                let turn = if self.place == TiffPlace::Turned { 1.0 } else { 0.0 };
                let matrix = [[10.0, turn, 0.0, 100.0], [turn, -10.0, 0.0, 220.0], [0.0; 4], [0.0, 0.0, 0.0, 1.0]];
                tags.push((34264, DOUBLE, 16, doubles(&matrix.concat())));
            }
            TiffPlace::Points => {
                tags.push((33550, DOUBLE, 3, doubles(&[10.0, 10.0, 0.0])));
                tags.push((33922, DOUBLE, 6, doubles(&[0.0, 0.0, 0.0, 105.0, 215.0, 0.0])));
                tags.push((34735, SHORT, 8, shorts(&[1, 1, 0, 1, 1025, 0, 1, 2])));
            }
            TiffPlace::SouthUp => {
                let matrix = [[10.0, 0.0, 0.0, 100.0], [0.0, 10.0, 0.0, 200.0], [0.0; 4], [0.0, 0.0, 0.0, 1.0]];
                tags.push((34264, DOUBLE, 16, doubles(&matrix.concat())));
            }
            TiffPlace::None => {}
        }
        for tag in &self.more {
            tags.retain(|t| t.0 != tag.0);
            tags.push(tag.clone());
        }
        tags.sort_by_key(|t| t.0);
        // Values of more than four bytes go before the directory.
        let mut directory = shorts(&[tags.len() as u16]);
        for (tag, kind, count, value) in tags {
            directory.extend(shorts(&[tag, kind]));
            directory.extend(count.to_le_bytes());
            if value.len() <= 4 {
                directory.extend([&value[..], &[0; 4][value.len()..]].concat());
            } else {
                file.extend(&[0; 1][..file.len() % 2]);
                directory.extend((file.len() as u32).to_le_bytes());
                file.extend(value);
            }
        }
        file.extend(&[0; 1][..file.len() % 2]);
        let start = (file.len() as u32).to_le_bytes();
        file[4..8].copy_from_slice(&start);
        file.extend(directory);
        file.extend([0; 4]);
        file
    }
}
