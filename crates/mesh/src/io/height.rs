//! Files to height fields and back.
//!
//! [`read`] tells the format by the name's ending (`.gz` behind it is seen through), checks it by the content, and says
//! in a [`HeightReport`] what was there and what was assumed. [`write()`] replaces nothing unless asked, and leaves
//! either the whole new file or what was there before.
//!
//! | format     | read                                                       | written                | holds                 |
//! | ---------- | ---------------------------------------------------------- | ---------------------- | --------------------- |
//! | GeoTIFF    | 8 to 64 bit, strips and tiles, deflate, LZW, PackBits      | 16 or 32 bit           | all                   |
//! | PNG        | grey of 8 or 16 bit, with or without transparency          | 16 bit                 | whole heights, missing|
//! | USGS DEM   | ASCII, any units, profiles of any length                   | no                     | all                   |
//! | ESRI ASCII | header in any order and case, corners or centres           | corners                | all but units         |
//!
//! A height that is missing (the file's nodata value, NaN, transparency, outside of a quadrangle) becomes NaN. Heights
//! are stored in 32 bits, in the file's units. Reading holds the file's bytes and the heights (of a PNG, its samples as
//! well): an image whose heights would take more than [`MOST_INFLATION`] times the file is
//! refused.

mod asc;
mod dem;
mod png;
mod tiff;

use std::fmt;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

use super::error::{Fail, ReadErrorKind};
use super::{
    ALWAYS_INFLATES_TO, MOST_INFLATION, Phase, Place, Progress, ReadError, Ticker, WriteError, WriteOptions,
    inner_ending, plain, write_whole,
};
use crate::{HeightField, Thousands, Unit};

/// The formats of files of heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HeightFormat {
    /// TIFF with the tags of GeoTIFF, or without.
    GeoTiff,
    /// Portable Network Graphics, grey.
    Png,
    /// The ASCII digital elevation model of the United States Geological Survey.
    UsgsDem,
    /// The ASCII grid of ESRI.
    EsriAscii,
}

impl HeightFormat {
    /// All of them.
    pub const ALL: [HeightFormat; 4] =
        [HeightFormat::GeoTiff, HeightFormat::Png, HeightFormat::UsgsDem, HeightFormat::EsriAscii];
    /// What names may end with, for messages.
    pub const ENDINGS: &str = ".tif, .tiff, .png, .dem and .asc, each also with .gz behind it";

    /// The endings of names, without the dot; the usual one first.
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            HeightFormat::GeoTiff => &["tif", "tiff"],
            HeightFormat::Png => &["png"],
            HeightFormat::UsgsDem => &["dem"],
            HeightFormat::EsriAscii => &["asc"],
        }
    }

    /// The format by the ending of a name, upper or lower case, with or without `.gz` behind it.
    pub fn from_path(path: impl AsRef<Path>) -> Option<HeightFormat> {
        let ending = inner_ending(path.as_ref())?;
        HeightFormat::ALL.into_iter().find(|f| f.endings().contains(&&*ending))
    }

    /// The format by the first bytes, where those of no other format look so.
    fn from_content(bytes: &[u8]) -> Option<HeightFormat> {
        let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        if bytes.starts_with(b"\x89PNG") {
            Some(HeightFormat::Png)
        } else if [&b"II*\0"[..], b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| bytes.starts_with(magic)) {
            Some(HeightFormat::GeoTiff)
        } else if start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"ncols")) {
            Some(HeightFormat::EsriAscii)
        } else {
            None
        }
    }
}

impl fmt::Display for HeightFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            HeightFormat::GeoTiff => "GeoTIFF",
            HeightFormat::Png => "PNG",
            HeightFormat::UsgsDem => "USGS DEM",
            HeightFormat::EsriAscii => "ESRI ASCII grid",
        })
    }
}

/// Whether the ending of a name is that of a format of heights, and not of a mesh.
pub fn is_height_format(path: impl AsRef<Path>) -> bool {
    HeightFormat::from_path(path).is_some()
}

/// A height field from a file, and what is to say about it.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightSource {
    /// The heights: at least 2 × 2 samples, at least one of them not missing.
    pub field: HeightField,
    /// What was in the file and what was assumed.
    pub report: HeightReport,
}

/// What was in a file of heights and what was assumed. `Display` gives it as one line for the user.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightReport {
    /// The format read.
    pub format: HeightFormat,
    /// Size of the file; for a `.gz`, compressed.
    pub bytes: u64,
    /// Samples from west to east.
    pub columns: u32,
    /// Samples from north to south.
    pub rows: u32,
    /// Samples without a height.
    pub missing: u64,
    /// Distance between columns and between rows, units of `horizontal`.
    pub spacing: [f64; 2],
    /// The unit of distances.
    pub horizontal: Unit,
    /// The unit of heights.
    pub vertical: Unit,
    /// What was left out or assumed for want of a word in the file, each a few words.
    pub notes: Vec<String>,
}

impl fmt::Display for HeightReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (columns, rows) = (Thousands(self.columns.into()), Thousands(self.rows.into()));
        write!(f, "{} with {columns} × {rows} heights", self.format)?;
        if self.missing > 0 {
            write!(f, ", {} of them missing", Thousands(self.missing))?;
        }
        let [x, y] = self.spacing;
        write!(f, ", {x}")?;
        if x != y {
            write!(f, " × {y}")?;
        }
        match plural(self.horizontal) {
            Some(units) => write!(f, " {units} apart")?,
            None => f.write_str(" apart, taken for metres")?,
        }
        match plural(self.vertical) {
            _ if self.vertical == self.horizontal => {}
            Some(units) => write!(f, ", heights in {units}")?,
            None => f.write_str(", heights taken for metres")?,
        }
        self.notes.iter().try_for_each(|note| write!(f, ", {note}"))
    }
}

/// A unit's name behind a number, if it is known.
fn plural(unit: Unit) -> Option<&'static str> {
    match unit {
        Unit::Unknown => None,
        Unit::Metre => Some("metres"),
        Unit::Foot => Some("feet"),
        Unit::UsSurveyFoot => Some("US survey feet"),
        Unit::Degree => Some("degrees"),
        Unit::ArcSecond => Some("arc-seconds"),
    }
}

/// What the reader of a format makes of the bytes.
struct Parsed {
    field: HeightField,
    notes: Vec<String>,
}

/// Reads the height field in a file.
///
/// The format is the one the ending names. A text grid without units takes the horizontal one from a `.prj` beside it.
/// Errors: the file cannot be opened, its ending is unknown, its bytes are not heights of that format, there are fewer
/// than 2 × 2 samples, or all are missing; the message names the file, the place and the remedy.
pub fn read(path: impl AsRef<Path>) -> Result<HeightSource, ReadError> {
    read_with(path, None)
}

/// [`read`] that tells how far it is, about two hundred times.
pub fn read_with(
    path: impl AsRef<Path>,
    progress: Option<&mut dyn FnMut(Progress)>,
) -> Result<HeightSource, ReadError> {
    let path = path.as_ref();
    let whole = |kind| ReadError { name: path.display().to_string(), place: Place::File, kind };
    let format = HeightFormat::from_path(path).ok_or_else(|| {
        let what = "a name that does not tell a format of heights".to_owned();
        let remedy = "the ending should be .tif, .tiff, .png, .dem or .asc, also with .gz behind it";
        whole(ReadErrorKind::Unsupported { what, remedy })
    })?;
    let bytes = fs::read(path).map_err(|e| whole(ReadErrorKind::Io(e)))?;
    let mut source = read_from(&bytes, format, &path.display().to_string(), progress)?;
    if source.field.horizontal == Unit::Unknown
        && let Some(unit) = asc::unit_beside(path)
    {
        (source.field.horizontal, source.report.horizontal) = (unit, unit);
    }
    Ok(source)
}

/// Reads the height field in some bytes, which may be gzip of the format. `name` is for messages.
pub fn read_bytes(bytes: &[u8], format: HeightFormat, name: &str) -> Result<HeightSource, ReadError> {
    read_from(bytes, format, name, None)
}

fn read_from(
    bytes: &[u8],
    format: HeightFormat,
    name: &str,
    progress: Option<&mut dyn FnMut(Progress)>,
) -> Result<HeightSource, ReadError> {
    let ticker = &mut Ticker::new(progress);
    parse(bytes, format, ticker).map_err(|Fail { place, kind }| ReadError { name: name.to_owned(), place, kind })
}

fn parse(file: &[u8], format: HeightFormat, ticker: &mut Ticker<'_>) -> Result<HeightSource, Fail> {
    let bytes: &[u8] = &plain(file, ticker)?;
    ticker.start(Phase::Parse, bytes.len() as u64);
    if let Some(found) = HeightFormat::from_content(bytes).filter(|&found| found != format) {
        let found = format!("{found}: rename it to .{}", found.endings()[0]);
        return Err(Fail::file(ReadErrorKind::Unexpected { expected: format.to_string(), found }));
    }
    let Parsed { field, notes } = match format {
        HeightFormat::GeoTiff => tiff::read(bytes, ticker),
        HeightFormat::Png => png::read(bytes, ticker),
        HeightFormat::UsgsDem => dem::read(bytes, ticker),
        HeightFormat::EsriAscii => asc::read(bytes, ticker),
    }?;
    ticker.at(bytes.len());
    debug_assert_eq!(field.heights.len() as u64, u64::from(field.columns) * u64::from(field.rows));
    let missing = field.missing();
    if missing == field.heights.len() {
        return Err(Fail::file(ReadErrorKind::NoHeights { samples: missing as u64 }));
    }
    let report = HeightReport {
        format,
        bytes: file.len() as u64,
        columns: field.columns,
        rows: field.rows,
        missing: missing as u64,
        spacing: field.spacing.to_array(),
        horizontal: field.horizontal,
        vertical: field.vertical,
        notes,
    };
    Ok(HeightSource { field, report })
}

/// Refuses grids without a cell. To be asked before the memory for them is.
fn check_size(columns: u64, rows: u64) -> Result<(), ReadErrorKind> {
    if columns < 2 || rows < 2 {
        let found = format!("{columns} × {rows}");
        return Err(ReadErrorKind::Unexpected { expected: "at least 2 × 2 samples".to_owned(), found });
    }
    // Samples are numbered in 32 bits by those who build from them.
    match columns.checked_mul(rows).is_some_and(|samples| samples <= u64::from(u32::MAX)) {
        true => Ok(()),
        false => Err(ReadErrorKind::TooMany("samples")),
    }
}

/// Refuses images whose samples, as 32-bit heights, would be out of proportion to the `len` bytes of their file.
fn check_inflation(columns: u32, rows: u32, len: usize) -> Result<(), ReadErrorKind> {
    let most = (len as u64).saturating_mul(MOST_INFLATION).max(ALWAYS_INFLATES_TO);
    if u64::from(columns) * u64::from(rows) <= most / 4 {
        return Ok(());
    }
    Err(ReadErrorKind::CountTooLarge {
        what: "samples".to_owned(),
        promised: u64::from(columns) * u64::from(rows),
        remaining: len as u64,
        most: most / 4,
    })
}

/// Refuses distances between samples that are not positive numbers.
fn check_spacing(x: f64, y: f64) -> Result<(), ReadErrorKind> {
    // A span of the whole grid has to stay finite in 32 bits.
    if [x, y].iter().all(|&s| s > 0.0 && s < 1e27) {
        return Ok(());
    }
    let expected = "a positive distance between samples".to_owned();
    Err(ReadErrorKind::Unexpected { expected, found: if x > 0.0 && x < 1e27 { y } else { x }.to_string() })
}

/// Writes a height field to a file in the format that its ending names, compressed where that is `.gz`.
///
/// What the format has no place for is left out (see the table above). Errors: the file exists and may not be replaced,
/// the format cannot hold the heights, or the disk refuses; the folder is then as it was.
pub fn write(path: impl AsRef<Path>, field: &HeightField, options: WriteOptions) -> Result<(), WriteError> {
    let path = path.as_ref();
    let unsupported =
        |(what, remedy): (&'static str, &'static str)| WriteError::Unsupported { path: path.to_owned(), what, remedy };
    let format = HeightFormat::from_path(path)
        .ok_or_else(|| unsupported(("the ending is of no format of heights", "name the output .tif, .png or .asc")))?;
    match refusal(field, format) {
        Some(why) => Err(unsupported(why)),
        None => write_whole(path, options, |out| write_body(out, field, format)),
    }
}

/// Writes a height field to a stream, in many small pieces: give it a buffer.
///
/// Errors are those of the stream, and `InvalidInput` for heights that the format cannot hold.
pub fn write_to(out: &mut impl Write, field: &HeightField, format: HeightFormat) -> io::Result<()> {
    match refusal(field, format) {
        Some((what, remedy)) => Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{what}; {remedy}"))),
        None => write_body(out, field, format),
    }
}

fn write_body(out: &mut impl Write, field: &HeightField, format: HeightFormat) -> io::Result<()> {
    match format {
        HeightFormat::GeoTiff => tiff::write(out, field),
        HeightFormat::Png => png::write(out, field),
        HeightFormat::EsriAscii => asc::write(out, field),
        HeightFormat::UsgsDem => unreachable!("refused before"),
    }
}

/// What a format cannot hold, and what to do.
fn refusal(field: &HeightField, format: HeightFormat) -> Option<(&'static str, &'static str)> {
    if field.columns < 2 || field.rows < 2 || field.missing() == field.heights.len() {
        return Some(("there is no surface in these heights", "give at least 2 × 2 samples that are not all missing"));
    }
    match format {
        HeightFormat::GeoTiff => tiff::refusal(field),
        HeightFormat::Png => png::refusal(field),
        HeightFormat::UsgsDem => Some(("USGS DEM is read but not written", "use .tif or .asc")),
        HeightFormat::EsriAscii => None,
    }
}
