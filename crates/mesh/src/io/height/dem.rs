//! The ASCII digital elevation model of the United States Geological Survey (`usgs1998dem`).
//!
//! ```text
//! record A   1024 bytes: names, units, spacing, number of profiles
//! record B   one profile, south to north: 144 bytes of header, 146 elevations; 170 in each record that continues it
//! record B   the next profile to the east
//! ...
//! record C   statistics, or nothing
//! ```
//!
//! All fields have fixed columns, as Fortran wrote them: `I6`, `D24.15`, `E12.6`. Records are 1024 bytes without line
//! ends, or lines of which trailing blanks may be gone. The profiles of a quadrangle in UTM differ in length and start,
//! since its borders are meridians and parallels: what is outside of it becomes missing.

use std::ops::Range;

use glam::DVec2;

use super::{Parsed, Ticker, check_size, check_spacing};
use crate::io::error::{Fail, ReadErrorKind, quote};
use crate::{HeightField, Unit};

const RECORD: usize = 1024;
/// Bytes of a profile before its elevations.
const PROFILE_HEADER: usize = 144;
/// Most elevations in the first record of a profile, and in those that continue it.
const FIRST: usize = 146;
const NEXT: usize = 170;
/// An elevation that is missing.
const VOID: i64 = -32767;

/// The records of a file, and where they are.
struct Records<'a> {
    bytes: &'a [u8],
    /// Start of the next record.
    at: usize,
    /// Whether records are lines.
    lines: bool,
}

/// A record: its bytes without line end, and where in the file it begins.
#[derive(Clone, Copy)]
struct Record<'a> {
    bytes: &'a [u8],
    start: usize,
}

impl<'a> Records<'a> {
    fn next(&mut self, expected: &str) -> Result<Record<'a>, Fail> {
        let mut rest = &self.bytes[self.at..];
        if self.lines {
            self.at += rest.iter().take_while(|b| matches!(b, b'\n' | b'\r')).count();
            rest = &self.bytes[self.at..];
        }
        let start = self.at;
        let len = match self.lines {
            true => memchr::memchr(b'\n', rest).unwrap_or(rest.len()),
            false => rest.len().min(RECORD),
        };
        self.at += len;
        if rest.trim_ascii().is_empty() {
            return Err(self.fail(self.bytes.len(), ReadErrorKind::Truncated { expected: expected.to_owned() }));
        }
        Ok(Record { bytes: rest[..len].trim_ascii_end(), start })
    }

    fn fail(&self, at: usize, kind: ReadErrorKind) -> Fail {
        if self.lines { Fail::line(self.bytes, at, kind) } else { Fail::byte(at, kind) }
    }

    /// A field's bytes without blanks; none where the record ends before.
    fn text(record: Record<'a>, columns: Range<usize>) -> &'a [u8] {
        let end = columns.end.min(record.bytes.len());
        record.bytes.get(columns.start..end).unwrap_or_default().trim_ascii()
    }

    /// Whether nothing but blanks follows a record.
    fn is_last(&self, record: Record<'_>) -> bool {
        record.start + record.bytes.len() >= self.bytes.trim_ascii_end().len()
    }

    /// What is wrong with a field that is not what it should be.
    #[cold]
    fn unexpected(&self, record: Record<'_>, columns: Range<usize>, expected: &str) -> Fail {
        let expected = expected.to_owned();
        if record.bytes.len() < columns.end && self.is_last(record) {
            return self.fail(self.bytes.len(), ReadErrorKind::Truncated { expected });
        }
        let field = Records::text(record, columns.clone());
        self.fail(record.start + columns.start, ReadErrorKind::Unexpected { expected, found: quote(field) })
    }

    /// An `I6` field; `None` where it is blank.
    #[inline]
    fn integer(&self, record: Record<'_>, columns: Range<usize>, what: &str) -> Result<Option<i64>, Fail> {
        let field = Records::text(record, columns.clone());
        let negative = field.first() == Some(&b'-');
        let digits = &field[(negative || field.first() == Some(&b'+')) as usize..];
        if field.is_empty() {
            return Ok(None);
        }
        // Numbers stand at the right of their field: half a field at the end of the file is half a number.
        let cut = record.bytes.len() < columns.end && self.is_last(record);
        if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) || cut {
            return Err(self.unexpected(record, columns, what));
        }
        let value = digits.iter().fold(0, |value, &b| 10 * value + i64::from(b - b'0'));
        Ok(Some(if negative { -value } else { value }))
    }

    fn need_integer(&self, record: Record<'_>, columns: Range<usize>, what: &str) -> Result<i64, Fail> {
        self.integer(record, columns.clone(), what)?.ok_or_else(|| self.unexpected(record, columns, what))
    }

    /// A `D24.15` or `E12.6` field; `None` where it is blank.
    fn real(&self, record: Record<'_>, columns: Range<usize>, what: &str) -> Result<Option<f64>, Fail> {
        let field = Records::text(record, columns.clone());
        if field.is_empty() {
            return Ok(None);
        }
        let text: Vec<u8> = field.iter().map(|&b| if matches!(b, b'D' | b'd') { b'E' } else { b }).collect();
        match fast_float2::parse::<f64, _>(&text) {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(self.unexpected(record, columns, what)),
        }
    }

    fn need_real(&self, record: Record<'_>, columns: Range<usize>, what: &str) -> Result<f64, Fail> {
        self.real(record, columns.clone(), what)?.ok_or_else(|| self.unexpected(record, columns, what))
    }
}

/// A north-south row of samples.
struct Profile {
    /// Its number from the west, as the file says.
    id: i64,
    /// Where its first, southernmost sample is.
    south: DVec2,
    /// Where its elevations are among all.
    heights: Range<usize>,
    /// What is added to its elevations.
    datum: f64,
    /// Where its record is in the file.
    start: usize,
}

/// What record A says.
struct Header {
    horizontal: Unit,
    vertical: Unit,
    /// Units of `horizontal` in one of the file's; not one only for radians.
    scale: f64,
    spacing: DVec2,
    /// The height of one elevation.
    step: f64,
    profiles: Option<usize>,
}

pub(super) fn read(bytes: &[u8], ticker: &mut Ticker<'_>) -> Result<Parsed, Fail> {
    let mut notes = Vec::new();
    let lines = memchr::memchr(b'\n', &bytes[..bytes.len().min(RECORD + 2)]).is_some();
    let records = &mut Records { bytes, at: 0, lines };
    let first = records.next("the first record of a USGS DEM")?;
    let header = header(records, first, &mut notes)?;
    if !lines {
        // Old writers, and some that followed no document, cut the first record short.
        let starts = [RECORD, 864, 893, 918];
        let is_profile = |&at: &usize| {
            let ids = bytes.get(at..at + 12).map(|ids| (ids[..6].trim_ascii(), ids[6..].trim_ascii()));
            ids == Some((b"1", b"1"))
        };
        records.at = starts.into_iter().find(is_profile).unwrap_or(RECORD).min(bytes.len());
    }

    let mut profiles: Vec<Profile> = Vec::new();
    let mut heights = Vec::with_capacity(bytes.len() / 6);
    while header.profiles.is_none_or(|n| profiles.len() < n) {
        if header.profiles.is_none() && bytes[records.at..].trim_ascii().is_empty() {
            break;
        }
        profiles.push(profile(records, &header, &mut heights)?);
        ticker.at(records.at);
    }
    let field = arrange(records, &header, &profiles, &heights)?;
    Ok(Parsed { field, notes })
}

fn header(records: &Records<'_>, a: Record<'_>, notes: &mut Vec<String>) -> Result<Header, Fail> {
    let what = "a USGS DEM, with a number for the unit of distances";
    let (horizontal, scale) = match records.integer(a, 528..534, what)? {
        Some(0) => (Unit::Degree, 1f64.to_degrees()),
        // State plane coordinates of the United States.
        Some(1) => (Unit::UsSurveyFoot, 1.0),
        Some(2) => (Unit::Metre, 1.0),
        Some(3) => (Unit::ArcSecond, 1.0),
        None if a.bytes.len() >= 852 => (Unit::Unknown, 1.0),
        _ => return Err(records.unexpected(a, 528..534, what)),
    };
    let vertical = match records.integer(a, 534..540, "a unit of elevations")? {
        Some(1) => Unit::Foot,
        Some(2) => Unit::Metre,
        None => Unit::Unknown,
        _ => return Err(records.unexpected(a, 534..540, "1 for feet or 2 for metres")),
    };
    if records.real(a, 786..810, "the angle of the grid")?.is_some_and(|angle| angle != 0.0) {
        let what = "a grid that is turned against its coordinates".to_owned();
        let remedy = "resample it to north up, as gdalwarp does";
        return Err(records.fail(a.start + 786, ReadErrorKind::Unsupported { what, remedy }));
    }
    let dx = records.need_real(a, 816..828, "the distance between columns")?;
    let dy = records.need_real(a, 828..840, "the distance between rows")?;
    check_spacing(dx * scale, dy * scale).map_err(|kind| records.fail(a.start + 816, kind))?;
    let mut step = records.real(a, 840..852, "the resolution of elevations")?.unwrap_or_default();
    if step == 0.0 {
        notes.push("no resolution of heights given, 1 assumed".to_owned());
        step = 1.0;
    }
    if !(1e-9..=1e9).contains(&step) {
        return Err(records.unexpected(a, 840..852, "a positive resolution of elevations"));
    }
    let profiles = match records.integer(a, 858..864, "the number of profiles")? {
        Some(n @ 2..) => Some(n as usize),
        None | Some(0) => None,
        _ => return Err(records.unexpected(a, 858..864, "at least 2 profiles")),
    };
    Ok(Header { horizontal, vertical, scale, spacing: DVec2::new(dx, dy) * scale, step, profiles })
}

/// Reads the records of a profile, and puts its elevations behind `heights`.
fn profile(records: &mut Records<'_>, header: &Header, heights: &mut Vec<f32>) -> Result<Profile, Fail> {
    let mut record = records.next("a profile")?;
    let start = record.start;
    let id = records.need_integer(record, 6..12, "the number of a profile")?;
    let count = records.need_integer(record, 12..18, "the number of elevations of a profile")?;
    if records.need_integer(record, 18..24, "1 column in a profile")? != 1 {
        return Err(records.unexpected(record, 18..24, "1 column in a profile"));
    }
    // The last elevation may go without trailing blanks.
    let most = (records.bytes.len() - start).saturating_sub(PROFILE_HEADER).div_ceil(6) as u64;
    if count < 1 || count as u64 > most {
        let (what, promised) = ("elevations".to_owned(), count.max(0) as u64);
        let kind = match count {
            ..1 => ReadErrorKind::Unexpected {
                expected: "at least 1 elevation in a profile".to_owned(),
                found: format!("`{count}`"),
            },
            _ => ReadErrorKind::CountTooLarge { what, promised, remaining: 6 * most, most },
        };
        return Err(records.fail(start + 12, kind));
    }
    let x = records.need_real(record, 24..48, "where a profile begins")?;
    let y = records.need_real(record, 48..72, "where a profile begins")?;
    let datum = records.real(record, 72..96, "the datum of a profile")?.unwrap_or_default();

    let from = heights.len();
    let (mut column, mut left_in_record) = (PROFILE_HEADER, FIRST);
    for _ in 0..count {
        if left_in_record == 0 {
            record = records.next("the rest of a profile")?;
            (column, left_in_record) = (0, NEXT);
        }
        let value = records.need_integer(record, column..column + 6, "an elevation")?;
        let height = (datum + header.step * value as f64) as f32;
        if !height.is_finite() {
            return Err(records.fail(record.start + column, ReadErrorKind::NotFinite { what: "a height" }));
        }
        heights.push(if value == VOID { f32::NAN } else { height });
        column += 6;
        left_in_record -= 1;
    }
    Ok(Profile { id, south: DVec2::new(x, y) * header.scale, heights: from..heights.len(), datum, start })
}

/// Puts profiles side by side into a grid that holds them all.
fn arrange(records: &Records<'_>, header: &Header, profiles: &[Profile], heights: &[f32]) -> Result<HeightField, Fail> {
    check_size(profiles.len() as u64, profiles.iter().map(|p| p.heights.len()).max().unwrap_or(0).max(2) as u64)
        .map_err(Fail::file)?;
    let (first, last) = (&profiles[0], &profiles[profiles.len() - 1]);
    // Profiles are told apart by their numbers; where those do not count, all are there.
    let counted = profiles.windows(2).all(|pair| pair[0].id < pair[1].id);
    let column = |i: usize| if counted { (profiles[i].id - first.id) as u64 } else { i as u64 };
    let columns = column(profiles.len() - 1) + 1;

    // The header has seven digits of the distance, the profiles fifteen of where they are.
    let mut spacing = header.spacing;
    let measured = (last.south.x - first.south.x) / (columns - 1) as f64;
    if (measured - spacing.x).abs() < 0.01 * spacing.x {
        if spacing.x == spacing.y && header.horizontal.degrees().is_some() {
            spacing.y = measured;
        }
        spacing.x = measured;
    }
    let off_grid = |profile: &Profile| {
        let what = format!("profile {}, which begins beside the grid of the others,", profile.id);
        let remedy = "convert it to GeoTIFF, as gdal_translate does";
        records.fail(profile.start + 24, ReadErrorKind::Unsupported { what, remedy })
    };
    let north = |p: &Profile| p.south.y + (p.heights.len() - 1) as f64 * spacing.y;
    let top = profiles.iter().map(north).fold(f64::NEG_INFINITY, f64::max);
    let bottom = profiles.iter().map(|p| p.south.y).fold(f64::INFINITY, f64::min);
    let rows = ((top - bottom) / spacing.y).round() + 1.0;
    // A quadrangle fills most of the grid; this one would be mostly holes.
    let most = 4 * records.bytes.len() as u64;
    if rows.is_nan() || rows * columns as f64 > most as f64 {
        return Err(off_grid(profiles.iter().min_by(|a, b| a.heights.len().cmp(&b.heights.len())).unwrap_or(first)));
    }
    let rows = rows as u64;
    check_size(columns, rows).map_err(Fail::file)?;

    let (columns, rows) = (columns as usize, rows as usize);
    let mut grid = vec![f32::NAN; columns * rows];
    let mut one_step = true;
    for (i, profile) in profiles.iter().enumerate() {
        let column = column(i) as usize;
        let x = (profile.south.x - first.south.x) / spacing.x;
        let y = (top - profile.south.y) / spacing.y;
        if !((x - column as f64).abs() <= 0.25 && (y - y.round()).abs() <= 0.25) {
            return Err(off_grid(profile));
        }
        let mut row = (y.round() as usize).min(rows - 1);
        for &height in &heights[profile.heights.clone()] {
            grid[row * columns + column] = height;
            row = row.saturating_sub(1);
        }
        one_step &= ((profile.datum - first.datum) / header.step).fract() == 0.0;
    }
    Ok(HeightField {
        columns: columns as u32,
        rows: rows as u32,
        heights: grid,
        origin: DVec2::new(first.south.x, top),
        spacing,
        horizontal: header.horizontal,
        vertical: header.vertical,
        step: one_step.then_some(header.step as f32),
    })
}
