//! GeoTIFF (`ritter2000geotiff`), by the crate `tiff`.
//!
//! Where samples are and what they are measured in is in a few tags:
//!
//! ```text
//! 33550 ModelPixelScale       width and height of a pixel
//! 33922 ModelTiepoint         (column, row) of a pixel and where it is
//! 34264 ModelTransformation   both of them as a matrix, in place of them
//! 34735 GeoKeyDirectory       units; whether a place is that of a pixel's corner or of its middle
//! 42112 GDAL_METADATA         scale and offset of samples, their unit
//! 42113 GDAL_NODATA           the sample that stands for a missing height
//! ```

use std::io::{self, Cursor, Write};

use ::tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use ::tiff::encoder::colortype::{self, ColorType as Sample};
use ::tiff::encoder::{TiffEncoder, TiffKind, TiffKindBig, TiffKindStandard, TiffValue};
use ::tiff::tags::{PhotometricInterpretation, PlanarConfiguration, Tag, Type};
use ::tiff::{ColorType, TiffError};
use glam::DVec2;

use super::{Parsed, Ticker, check_inflation, check_size, check_spacing};
use crate::io::error::{Fail, ReadErrorKind};
use crate::io::{ALWAYS_INFLATES_TO, MOST_INFLATION};
use crate::{HeightField, Unit};

type Tiff<'a> = Decoder<Cursor<&'a [u8]>>;

const GDAL_METADATA: Tag = Tag::Unknown(42112);

/// The keys of the directory, and the values that we know.
mod key {
    pub const MODEL: u16 = 1024;
    pub const MODEL_PROJECTED: u16 = 1;
    pub const MODEL_GEOGRAPHIC: u16 = 2;
    pub const RASTER: u16 = 1025;
    pub const RASTER_POINT: u16 = 2;
    pub const ANGULAR_UNIT: u16 = 2054;
    pub const PROJECTED_SYSTEM: u16 = 3072;
    pub const LINEAR_UNIT: u16 = 3076;
    pub const VERTICAL_SYSTEM: u16 = 4096;
    pub const VERTICAL_UNIT: u16 = 4099;
    pub const USER_DEFINED: u16 = 32767;
}

/// Units of measure by their EPSG code; and how many of our units one of theirs is.
const UNITS: [(u16, Unit, f64); 7] = [
    (9001, Unit::Metre, 1.0),
    (9002, Unit::Foot, 1.0),
    (9003, Unit::UsSurveyFoot, 1.0),
    (9102, Unit::Degree, 1.0),
    (9122, Unit::Degree, 1.0),
    (9104, Unit::ArcSecond, 1.0),
    (9103, Unit::ArcSecond, 60.0),
];

/// Units of vertical systems by their EPSG code: heights above EGM96, EGM2008 and NAVD88, which is also used in feet.
const VERTICAL_SYSTEMS: [(u16, Unit); 5] =
    [(5773, Unit::Metre), (3855, Unit::Metre), (5703, Unit::Metre), (6360, Unit::UsSurveyFoot), (8228, Unit::Foot)];

pub(super) fn read(bytes: &[u8], ticker: &mut Ticker<'_>) -> Result<Parsed, Fail> {
    let most = (bytes.len() as u64).saturating_mul(MOST_INFLATION).max(ALWAYS_INFLATES_TO) as usize;
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.ifd_value_size, limits.intermediate_buffer_size) =
        (most, bytes.len(), bytes.len());
    check_directory(bytes)?;
    let tiff = &mut Decoder::new(Cursor::new(bytes)).map_err(fail)?.with_limits(limits);
    let (columns, rows) = tiff.dimensions().map_err(fail)?;
    check_size(columns.into(), rows.into()).map_err(Fail::file)?;
    check_inflation(columns, rows, bytes.len()).map_err(Fail::file)?;

    let mut notes = Vec::new();
    let bands = bands(tiff)?;
    if bands > 1 {
        notes.push(format!("the first of {bands} bands"));
    }
    let place = place(tiff, &mut notes)?;
    let mut meaning = meaning(tiff)?;
    let samples = samples(tiff, (columns, rows), bands, &meaning, most, ticker)?;
    let mut heights = samples.heights;
    if let Some(at) = heights.iter().position(|h| h.is_infinite()) {
        let what = "a height";
        let (column, row) = (at % columns as usize, at / columns as usize);
        notes.clear();
        let kind = ReadErrorKind::Unexpected {
            expected: format!("{what} that is a finite 32-bit number"),
            found: format!("another in column {column}, row {row}; set it to the nodata value"),
        };
        return Err(Fail::file(kind));
    }
    if place.rows_go_north {
        let columns = columns as usize;
        for row in 0..rows as usize / 2 {
            let (north, south) = heights.split_at_mut((rows as usize - 1 - row) * columns);
            north[row * columns..][..columns].swap_with_slice(&mut south[..columns]);
        }
    }
    // Above 2²⁴ not all whole numbers are 32-bit floating point.
    if samples.whole && samples.largest > f64::from(1 << 24) {
        notes.push("heights rounded to 32-bit floating point".to_owned());
    }
    let exact = samples.whole && samples.largest <= f64::from(1 << 24);
    if meaning.vertical == Unit::Unknown {
        meaning.vertical = place.vertical;
    }
    let field = HeightField {
        columns,
        rows,
        heights,
        origin: place.origin
            + if place.rows_go_north { DVec2::new(0.0, f64::from(rows - 1) * place.spacing.y) } else { DVec2::ZERO },
        spacing: place.spacing,
        horizontal: place.horizontal,
        vertical: meaning.vertical,
        step: exact.then_some(meaning.scale.abs() as f32),
    };
    Ok(Parsed { field, notes })
}

fn fail(error: TiffError) -> Fail {
    Fail::file(match error {
        TiffError::IoError(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
            ReadErrorKind::Truncated { expected: "more of the image".to_owned() }
        }
        TiffError::LimitsExceeded | TiffError::IntSizeError => ReadErrorKind::Unsupported {
            what: "a TIFF with parts out of proportion to its size".to_owned(),
            remedy: "write it anew, as gdal_translate does",
        },
        TiffError::UnsupportedError(e) => ReadErrorKind::Unsupported {
            what: format!("this kind of TIFF ({e})"),
            remedy: "convert it, as `gdal_translate -co COMPRESS=DEFLATE` does",
        },
        e => ReadErrorKind::Damaged { what: "TIFF", why: e.to_string() },
    })
}

fn unsupported(what: &str, remedy: &'static str) -> Fail {
    Fail::file(ReadErrorKind::Unsupported { what: what.to_owned(), remedy })
}

/// Looks at the directory before the decoder does, which multiplies sizes and makes tables unasked: refuses numbers of
/// strips beyond 32 bits, and tables of bytes. Whatever else is wrong is left to the decoder.
fn check_directory(bytes: &[u8]) -> Result<(), Fail> {
    let little = bytes.starts_with(b"II");
    let number = |at: usize, len: usize| -> Option<u64> {
        let field = bytes.get(at..at.checked_add(len)?)?;
        let join = |n, &byte: &u8| n << 8 | u64::from(byte);
        Some(if little { field.iter().rev().fold(0, join) } else { field.iter().fold(0, join) })
    };
    // Where the directory is, the lengths of its count and of its entries, and where an entry's value is.
    let big = number(2, 2) == Some(43);
    let (at, count_len, entry_len, value_at) = if big { (number(8, 8), 8, 20, 12) } else { (number(4, 4), 2, 12, 8) };
    let Some(at) = at.and_then(|at| usize::try_from(at).ok()) else { return Ok(()) };
    let (mut rows, mut bands) = (1, 1);
    for i in 0..number(at, count_len).unwrap_or(0).min(bytes.len() as u64) as usize {
        let Some(entry) = at.checked_add(count_len + i * entry_len) else { break };
        let (Some(tag), Some(kind)) = (number(entry, 2), number(entry + 2, 2)) else { break };
        let tag = Tag::from_u16_exhaustive(tag as u16);
        let is = |wanted: Type| u64::from(wanted.to_u16()) == kind;
        let value_len = if is(Type::SHORT) {
            2
        } else if is(Type::LONG8) {
            8
        } else {
            4
        };
        let value = || number(entry + value_at, value_len);
        match tag {
            Tag::ImageLength => rows = value().unwrap_or(1),
            Tag::SamplesPerPixel => bands = value().unwrap_or(1),
            Tag::StripOffsets
            | Tag::StripByteCounts
            | Tag::TileOffsets
            | Tag::TileByteCounts
            | Tag::BitsPerSample
            | Tag::SampleFormat
            | Tag::ExtraSamples
            | Tag::ChromaSubsampling
                if ![Type::SHORT, Type::LONG, Type::LONG8].into_iter().any(is) =>
            {
                let why = format!("tag {} holds type {kind}, not numbers of 16 to 64 bits", tag.to_u16());
                return Err(Fail::byte(entry, ReadErrorKind::Damaged { what: "TIFF", why }));
            }
            _ => {}
        }
    }
    match rows.saturating_mul(bands) <= u64::from(u32::MAX) {
        true => Ok(()),
        false => Err(Fail::file(ReadErrorKind::TooMany("strips"))),
    }
}

/// Refuses a tag whose values are of another type than the document says. The decoder takes 32 bytes for any value, so
/// a tag of bytes could take many times the file.
fn check_type(tiff: &mut Tiff<'_>, tag: Tag, wanted: Type) -> Result<(), Fail> {
    match tiff.image_ifd().find_entry(tag).map(|entry| entry.field_type()) {
        Some(found) if found != wanted => {
            let why = format!("tag {} holds {found:?}, not {wanted:?}", tag.to_u16());
            Err(Fail::file(ReadErrorKind::Damaged { what: "TIFF", why }))
        }
        _ => Ok(()),
    }
}

/// How many samples a pixel has; refuses colours.
fn bands(tiff: &mut Tiff<'_>) -> Result<usize, Fail> {
    let photometric = tiff.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(fail)?;
    if photometric == Some(PhotometricInterpretation::WhiteIsZero.to_u16()) {
        return Err(unsupported("a TIFF in which white is 0", "write it with black as 0, as gdal_translate does"));
    }
    match tiff.colortype() {
        Ok(ColorType::Gray(8..)) => Ok(1),
        Ok(ColorType::GrayA(8..)) => Ok(2),
        Ok(ColorType::Multiband { bit_depth: 8.., num_samples }) => Ok(usize::from(num_samples)),
        Ok(ColorType::Gray(_) | ColorType::GrayA(_) | ColorType::Multiband { .. }) => {
            Err(unsupported("a TIFF of less than 8 bits", "convert it to 16 bits, as `gdal_translate -ot Int16` does"))
        }
        _ => Err(unsupported("a TIFF in colour", "give one that holds heights, as whole numbers or floating point")),
    }
}

/// Where samples are.
struct Place {
    origin: DVec2,
    spacing: DVec2,
    rows_go_north: bool,
    horizontal: Unit,
    /// As the keys say.
    vertical: Unit,
}

fn place(tiff: &mut Tiff<'_>, notes: &mut Vec<String>) -> Result<Place, Fail> {
    check_type(tiff, Tag::GeoKeyDirectoryTag, Type::SHORT)?;
    let keys = tiff.find_tag_unsigned_vec::<u16>(Tag::GeoKeyDirectoryTag).map_err(fail)?.unwrap_or_default();
    // Four numbers each, of which the first four are the directory's own: key, where its value is (0: here), 1, value.
    let key = |wanted: u16| {
        let mut entries = keys.chunks_exact(4).skip(1);
        entries.find(|entry| entry[0] == wanted && entry[1] == 0).map(|entry| entry[3])
    };
    let unit = |code: u16| UNITS.iter().find(|unit| unit.0 == code).map(|&(_, unit, scale)| (unit, scale));
    let (horizontal, scale) = match key(key::MODEL) {
        Some(key::MODEL_GEOGRAPHIC) => {
            let code = key(key::ANGULAR_UNIT).unwrap_or(9102);
            unit(code).filter(|(unit, _)| unit.degrees().is_some()).ok_or_else(|| {
                unsupported(
                    &format!("a TIFF whose angles are in unit {code} of the EPSG"),
                    "convert it to degrees, as gdalwarp does",
                )
            })?
        }
        Some(key::MODEL_PROJECTED) => match key(key::LINEAR_UNIT) {
            Some(code) => unit(code).unwrap_or_else(|| {
                notes.push(format!("unit {code} of distances unknown"));
                (Unit::Unknown, 1.0)
            }),
            None => {
                notes.push("metres assumed for distances".to_owned());
                (Unit::Metre, 1.0)
            }
        },
        _ => (Unit::Unknown, 1.0),
    };
    let vertical = match key(key::VERTICAL_UNIT) {
        Some(code) => unit(code).filter(|&(unit, _)| unit.degrees().is_none()).map(|(unit, _)| unit),
        None => VERTICAL_SYSTEMS.iter().find(|s| Some(s.0) == key(key::VERTICAL_SYSTEM)).map(|s| s.1),
    };
    let vertical = vertical.unwrap_or(Unit::Unknown);

    let numbers = |tiff: &mut Tiff<'_>, tag| {
        check_type(tiff, tag, Type::DOUBLE)?;
        tiff.find_tag(tag).map_err(fail)?.map(|value| value.into_f64_vec().map_err(fail)).transpose()
    };
    let pixel = numbers(tiff, Tag::ModelPixelScaleTag)?.filter(|scale| scale.len() >= 2);
    let tie = numbers(tiff, Tag::ModelTiepointTag)?.filter(|tie| tie.len() >= 6);
    let matrix = numbers(tiff, Tag::ModelTransformationTag)?.filter(|matrix| matrix.len() >= 8);
    // Where pixel (0, 0) has its place, and the way to the next column and row; y grows to the north.
    let (corner, dx, dy) = match (pixel, tie, matrix) {
        (Some(pixel), Some(tie), _) => {
            let corner = DVec2::new(tie[3] - tie[0] * pixel[0], tie[4] + tie[1] * pixel[1]);
            (corner, pixel[0], -pixel[1])
        }
        (None, _, Some(matrix)) => {
            if matrix[1] != 0.0 || matrix[4] != 0.0 {
                return Err(unsupported(
                    "a TIFF that is turned against its coordinates",
                    "turn it north up with gdalwarp",
                ));
            }
            (DVec2::new(matrix[3], matrix[7]), matrix[0], matrix[5])
        }
        (Some(pixel), None, _) => {
            notes.push("corner at 0".to_owned());
            (DVec2::ZERO, pixel[0], -pixel[1])
        }
        _ => {
            notes.push("no place given".to_owned());
            (DVec2::ZERO, 1.0, -1.0)
        }
    };
    let spacing = DVec2::new(dx, dy.abs()) * scale;
    check_spacing(spacing.x, spacing.y).map_err(Fail::file)?;
    let is_point = key(key::RASTER) == Some(key::RASTER_POINT);
    let to_middle = if is_point { DVec2::ZERO } else { DVec2::new(0.5 * dx, 0.5 * dy) };
    let origin = (corner + to_middle) * scale;
    if !origin.is_finite() {
        return Err(Fail::file(ReadErrorKind::NotFinite { what: "the place of the corner" }));
    }
    Ok(Place { origin, spacing, rows_go_north: dy > 0.0, horizontal, vertical })
}

/// What samples mean: `height = scale · sample + offset`.
struct Meaning {
    scale: f64,
    offset: f64,
    nodata: Option<f64>,
    vertical: Unit,
}

fn meaning(tiff: &mut Tiff<'_>) -> Result<Meaning, Fail> {
    let string = |tiff: &mut Tiff<'_>, tag| {
        check_type(tiff, tag, Type::ASCII)?;
        tiff.find_tag(tag).map_err(fail)?.map(|value| value.into_string().map_err(fail)).transpose()
    };
    let number = |text: &str| fast_float2::parse::<f64, _>(text.trim_matches(['\0', ' ', '\n', '\r', '\t'])).ok();
    let nodata = string(tiff, Tag::GdalNodata)?.and_then(|text| number(&text));
    let mut meaning = Meaning { scale: 1.0, offset: 0.0, nodata, vertical: Unit::Unknown };
    // `<Item name="SCALE" sample="0" role="scale">0.1</Item>`
    let metadata = string(tiff, GDAL_METADATA)?.unwrap_or_default();
    for item in metadata.split("<Item ").skip(1) {
        let Some((attributes, rest)) = item.split_once('>') else { continue };
        let text = rest.split('<').next().unwrap_or_default();
        if !attributes.contains("sample=\"0\"") {
            continue;
        }
        let value = || {
            let what = "the scale or offset of samples";
            let finite = number(text).filter(|x| x.is_finite());
            finite.ok_or_else(|| Fail::file(ReadErrorKind::NotFinite { what }))
        };
        if attributes.contains("role=\"scale\"") {
            meaning.scale = value()?;
        } else if attributes.contains("role=\"offset\"") {
            meaning.offset = value()?;
        } else if attributes.contains("role=\"unittype\"") {
            meaning.vertical = match text.trim().to_lowercase().as_str() {
                "m" | "metre" | "meter" | "metres" | "meters" => Unit::Metre,
                "ft" | "foot" | "feet" => Unit::Foot,
                "us-ft" | "us survey foot" | "ftus" => Unit::UsSurveyFoot,
                _ => Unit::Unknown,
            };
        }
    }
    if meaning.scale == 0.0 {
        let found = "0".to_owned();
        return Err(Fail::file(ReadErrorKind::Unexpected { expected: "a scale of samples".to_owned(), found }));
    }
    Ok(meaning)
}

struct Samples {
    heights: Vec<f32>,
    /// Whether the file holds whole numbers.
    whole: bool,
    /// The largest of them, less the scale.
    largest: f64,
}

/// The heights of the first band, row by row as they are in the file.
fn samples(
    tiff: &mut Tiff<'_>,
    (columns, rows): (u32, u32),
    bands: usize,
    meaning: &Meaning,
    most: usize,
    ticker: &mut Ticker<'_>,
) -> Result<Samples, Fail> {
    let planar = tiff.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).map_err(fail)?;
    let bands = if planar == Some(PlanarConfiguration::Planar.to_u16()) { 1 } else { bands };
    let (width, height) = tiff.chunk_dimensions();
    let (width, height) = match tiff.get_chunk_type() {
        ChunkType::Strip => (width, height.min(rows)),
        ChunkType::Tile => (width, height),
    };
    // The decoder holds a chunk; eight bytes are the most for a sample.
    let chunk_bytes = u64::from(width).saturating_mul(height.into()).saturating_mul(8 * bands as u64);
    if chunk_bytes > most as u64 {
        return Err(fail(TiffError::LimitsExceeded));
    }
    let counts_tag = match tiff.get_chunk_type() {
        ChunkType::Strip => Tag::StripByteCounts,
        ChunkType::Tile => Tag::TileByteCounts,
    };
    let counts = tiff.find_tag_unsigned_vec::<u64>(counts_tag).map_err(fail)?.unwrap_or_default();

    // Where nothing is stored, everything is missing; or zero, if nothing says what missing is.
    let absent = if meaning.nodata.is_some() { f32::NAN } else { meaning.offset as f32 };
    let mut heights = vec![absent; columns as usize * rows as usize];
    let (mut whole, mut largest) = (true, 0f64);
    let (across, down) = (columns.div_ceil(width), rows.div_ceil(height));
    for chunk in 0..across * down {
        if counts.get(chunk as usize) == Some(&0) {
            continue;
        }
        let (left, top) = (chunk % across * width, chunk / across * height);
        let (chunk_width, chunk_height) = tiff.chunk_data_dimensions(chunk);
        let target = &mut heights[top as usize * columns as usize + left as usize..];
        let lines = Lines {
            target,
            columns: columns as usize,
            width: chunk_width.min(columns - left) as usize,
            chunk_width: chunk_width as usize,
            height: chunk_height.min(rows - top) as usize,
            bands,
        };
        let Meaning { scale, offset, nodata, .. } = *meaning;
        // Nodata is compared in the type of the samples: as text it has more digits than 32 bits hold.
        let in_f32 = nodata.map(|x| f64::from(x as f32));
        let floats = |nodata: Option<f64>| {
            move |x: f64| if Some(x) == nodata || x.is_nan() { f32::NAN } else { (scale * x + offset) as f32 }
        };
        let height = floats(nodata);
        let mut integers = |x: f64| {
            if Some(x) == nodata {
                return f32::NAN;
            }
            largest = largest.max(x.abs());
            (scale * x + offset) as f32
        };
        match tiff.read_chunk(chunk).map_err(fail)? {
            DecodingResult::U8(v) => lines.fill(&v, |x| integers(x.into())),
            DecodingResult::I8(v) => lines.fill(&v, |x| integers(x.into())),
            DecodingResult::U16(v) => lines.fill(&v, |x| integers(x.into())),
            DecodingResult::I16(v) => lines.fill(&v, |x| integers(x.into())),
            DecodingResult::U32(v) => lines.fill(&v, |x| integers(x.into())),
            DecodingResult::I32(v) => lines.fill(&v, |x| integers(x.into())),
            DecodingResult::U64(v) => lines.fill(&v, |x| integers(x as f64)),
            DecodingResult::I64(v) => lines.fill(&v, |x| integers(x as f64)),
            DecodingResult::F32(v) => {
                whole = false;
                lines.fill(&v, |x| floats(in_f32)(x.into()))
            }
            DecodingResult::F64(v) => {
                whole = false;
                lines.fill(&v, height)
            }
            DecodingResult::F16(v) => {
                whole = false;
                lines.fill(&v, |x| height(x.to_f64()))
            }
        }
        ticker.at((u64::from(chunk) * ticker.total / u64::from(across * down)) as usize);
    }
    Ok(Samples { heights, whole, largest })
}

/// Where the samples of a chunk go.
struct Lines<'a> {
    /// The heights from the chunk's first sample on.
    target: &'a mut [f32],
    columns: usize,
    /// How many samples of a line are wanted, and how many there are.
    width: usize,
    chunk_width: usize,
    height: usize,
    bands: usize,
}

impl Lines<'_> {
    fn fill<T: Copy>(self, samples: &[T], mut height: impl FnMut(T) -> f32) {
        let lines = samples.chunks_exact(self.chunk_width * self.bands).take(self.height);
        for (line, target) in lines.zip(self.target.chunks_mut(self.columns)) {
            for (to, from) in target[..self.width].iter_mut().zip(line.chunks_exact(self.bands)) {
                *to = height(from[0]);
            }
        }
    }
}

pub(super) fn refusal(field: &HeightField) -> Option<(&'static str, &'static str)> {
    (field.vertical.degrees().is_some()).then_some(("heights cannot be angles", "give them in metres or feet"))
}

/// Whole multiples of the step as 16-bit numbers where they fit, else 32-bit floating point; not compressed.
pub(super) fn write(out: &mut impl Write, field: &HeightField) -> io::Result<()> {
    // Offsets are 32 bits in ordinary files; a megabyte is ample for the tags.
    let big = 4 * field.heights.len() as u64 > u64::from(u32::MAX) - (1 << 20);
    let bytes = if big { encode::<TiffKindBig>(field) } else { encode::<TiffKindStandard>(field) };
    out.write_all(&bytes.map_err(|error| match error {
        TiffError::IoError(error) => error,
        error => io::Error::other(error),
    })?)
}

/// What stands for missing heights among 16-bit numbers.
const NODATA: i16 = i16::MIN;

fn encode<K: TiffKind>(field: &HeightField) -> Result<Vec<u8>, TiffError> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::<_, K>::new_generic(&mut bytes)?;
    match whole_numbers(field) {
        Some((numbers, step)) => {
            let nodata = NODATA.to_string();
            encode_image::<_, K, colortype::GrayI16>(&mut encoder, field, &numbers, step, &nodata)?;
        }
        None => encode_image::<_, K, colortype::Gray32Float>(&mut encoder, field, &field.heights, 1.0, "nan")?,
    }
    Ok(bytes.into_inner())
}

/// Heights as multiples of the step, if that gives back the very same heights.
fn whole_numbers(field: &HeightField) -> Option<(Vec<i16>, f32)> {
    let step = field.step.filter(|&step| step > 0.0)?;
    let numbers = field.heights.iter().map(|&height| {
        if height.is_nan() {
            return Some(NODATA);
        }
        let number = (f64::from(height) / f64::from(step)).round();
        let same = (number * f64::from(step)) as f32 == height;
        (same && (-32767.0..=32767.0).contains(&number)).then_some(number as i16)
    });
    Some((numbers.collect::<Option<_>>()?, step))
}

fn encode_image<W: Write + io::Seek, K: TiffKind, C: Sample>(
    encoder: &mut TiffEncoder<W, K>,
    field: &HeightField,
    samples: &[C::Inner],
    step: f32,
    nodata: &str,
) -> Result<(), TiffError>
where
    [C::Inner]: TiffValue,
{
    let mut image = encoder.new_image::<C>(field.columns, field.rows)?;
    let tags = image.encoder();
    let DVec2 { x: dx, y: dy } = field.spacing;
    tags.write_tag(Tag::ModelPixelScaleTag, &[dx, dy, 0.0][..])?;
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, field.origin.x, field.origin.y, 0.0][..])?;
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys(field)[..])?;
    tags.write_tag(Tag::GdalNodata, nodata)?;
    if step != 1.0 {
        // The same number in 64 bits, so that the product rounds as it was tried.
        let scale = f64::from(step);
        let items = format!(
            "<GDALMetadata>\n  <Item name=\"SCALE\" sample=\"0\" role=\"scale\">{scale}</Item>\n</GDALMetadata>"
        );
        tags.write_tag(GDAL_METADATA, &items[..])?;
    }
    image.write_data(samples)
}

/// The directory of keys for a field's units; samples are points.
fn keys(field: &HeightField) -> Vec<u16> {
    let code = |unit: Unit| UNITS.iter().find(|known| known.1 == unit).map(|known| known.0);
    let mut entries = Vec::new();
    let horizontal = code(field.horizontal);
    if let Some(code) = horizontal {
        let angular = field.horizontal.degrees().is_some();
        entries.push((key::MODEL, if angular { key::MODEL_GEOGRAPHIC } else { key::MODEL_PROJECTED }));
        entries.push((key::RASTER, key::RASTER_POINT));
        if angular {
            entries.push((key::ANGULAR_UNIT, code));
        } else {
            entries.extend([(key::PROJECTED_SYSTEM, key::USER_DEFINED), (key::LINEAR_UNIT, code)]);
        }
    } else {
        entries.push((key::RASTER, key::RASTER_POINT));
    }
    entries.extend(code(field.vertical).map(|code| (key::VERTICAL_UNIT, code)));
    let mut keys = vec![1, 1, 0, entries.len() as u16];
    keys.extend(entries.into_iter().flat_map(|(key, value)| [key, 0, 1, value]));
    keys
}
