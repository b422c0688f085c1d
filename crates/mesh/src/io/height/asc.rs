//! The ASCII grid of ESRI.
//!
//! ```text
//! ncols 4                words in any case and order; dx and dy may stand for cellsize
//! nrows 3
//! xllcorner 500          the outer corner of the south-western cell, or xllcenter: its middle, where the sample is
//! yllcorner 4000
//! cellsize 30
//! NODATA_value -9999     missing heights; -9999 where nothing is said
//! 12 13 13.5 11          from the north-west, row by row; line ends do not matter
//! ...
//! ```

use std::fs;
use std::io::{self, Read, Write};
use std::path::Path;

use glam::DVec2;

use super::{Parsed, Ticker, check_size, check_spacing};
use crate::io::error::{Fail, ReadErrorKind, quote};
use crate::io::text::Scanner;
use crate::{HeightField, Unit};

/// What missing heights are where the header does not say.
const NODATA: f32 = -9999.0;

#[derive(Default)]
struct Header {
    columns: Option<u64>,
    rows: Option<u64>,
    /// Easting and northing of the south-western cell: of its corner, or (true) of its middle.
    x: Option<(f64, bool)>,
    y: Option<(f64, bool)>,
    dx: Option<f64>,
    dy: Option<f64>,
    nodata: Option<f32>,
}

pub(super) fn read(bytes: &[u8], ticker: &mut Ticker<'_>) -> Result<Parsed, Fail> {
    let text = &mut Scanner::new(bytes);
    let header = header(text)?;
    let need = |what: &str| {
        let found = "a header without it".to_owned();
        text.fail(ReadErrorKind::Unexpected { expected: format!("the word {what} before the heights"), found })
    };
    let columns = header.columns.ok_or_else(|| need("ncols"))?;
    let rows = header.rows.ok_or_else(|| need("nrows"))?;
    let dx = header.dx.ok_or_else(|| need("cellsize"))?;
    let dy = header.dy.ok_or_else(|| need("cellsize"))?;
    check_spacing(dx, dy).map_err(Fail::file)?;
    // A height takes a digit and a blank; the last one may go without the latter.
    let most = (text.remaining() as u64).div_ceil(2);
    if columns.checked_mul(rows).is_none_or(|samples| samples > most) {
        let promised = columns.saturating_mul(rows);
        let (what, remaining) = ("heights".to_owned(), text.remaining() as u64);
        return Err(text.fail(ReadErrorKind::CountTooLarge { what, promised, remaining, most }));
    }
    check_size(columns, rows).map_err(Fail::file)?;

    let mut notes = Vec::new();
    if header.x.is_none() || header.y.is_none() {
        notes.push("corner at 0".to_owned());
    }
    let nodata = header.nodata.unwrap_or(NODATA);
    let mut heights = Vec::with_capacity((columns * rows) as usize);
    let mut whole = true;
    for _ in 0..rows {
        for _ in 0..columns {
            let (value, is_whole) = height(text)?;
            let missing = value == nodata || value.is_nan();
            whole &= is_whole || missing;
            heights.push(if missing { f32::NAN } else { value });
        }
        ticker.at(text.at);
    }
    text.skip_space();
    if text.remaining() > 0 {
        return Err(text.unexpected("the end of the file after ncols × nrows heights"));
    }
    if header.nodata.is_none() && heights.iter().any(|h| h.is_nan()) {
        notes.push("-9999 taken for missing".to_owned());
    }

    // From the corner of a cell to its middle.
    let middle = |(at, is_middle): (f64, bool), spacing: f64| if is_middle { at } else { at + 0.5 * spacing };
    let west = middle(header.x.unwrap_or_default(), dx);
    let south = middle(header.y.unwrap_or_default(), dy);
    let field = HeightField {
        columns: columns as u32,
        rows: rows as u32,
        heights,
        origin: DVec2::new(west, south + (rows - 1) as f64 * dy),
        spacing: DVec2::new(dx, dy),
        horizontal: Unit::Unknown,
        vertical: Unit::Unknown,
        step: whole.then_some(1.0),
    };
    Ok(Parsed { field, notes })
}

/// The words and their values, up to the first height.
fn header(text: &mut Scanner<'_>) -> Result<Header, Fail> {
    let mut header = Header::default();
    loop {
        text.skip_space();
        let start = text.at;
        let word = text.token().to_ascii_lowercase();
        // A height may be the word nan.
        if !word.first().is_some_and(u8::is_ascii_alphabetic) || word == b"nan" {
            text.at = start;
            return Ok(header);
        }
        text.skip_blanks();
        match &word[..] {
            b"ncols" => header.columns = Some(count(text, "the number of columns")?),
            b"nrows" => header.rows = Some(count(text, "the number of rows")?),
            b"xllcorner" => header.x = Some((text.f64("the corner")?, false)),
            b"xllcenter" | b"xllcentre" => header.x = Some((text.f64("the middle of a cell")?, true)),
            b"yllcorner" => header.y = Some((text.f64("the corner")?, false)),
            b"yllcenter" | b"yllcentre" => header.y = Some((text.f64("the middle of a cell")?, true)),
            b"cellsize" => {
                let size = text.f64("the size of a cell")?;
                (header.dx, header.dy) = (Some(size), Some(size));
            }
            b"dx" => header.dx = Some(text.f64("the width of a cell")?),
            b"dy" => header.dy = Some(text.f64("the height of a cell")?),
            b"nodata_value" | b"nodata" => header.nodata = Some(text.any_f32("the value of missing heights")?),
            _ => {
                let expected =
                    "a word of the header (ncols, nrows, xllcorner, yllcorner, cellsize, NODATA_value) or a height";
                let kind = ReadErrorKind::Unexpected { expected: expected.to_owned(), found: quote(&word) };
                return Err(text.fail_at(start, kind));
            }
        }
    }
}

fn count(text: &mut Scanner<'_>, what: &'static str) -> Result<u64, Fail> {
    let start = text.at;
    let n = text.lone_integer(what)?;
    let kind = || ReadErrorKind::Unexpected { expected: format!("{what} from 2"), found: format!("`{n}`") };
    if n < 2 { Err(text.fail_at(start, kind())) } else { Ok(n as u64) }
}

/// The next height, which may be NaN, and whether it is written as a whole number that 32 bits hold exactly.
#[inline]
fn height(text: &mut Scanner<'_>) -> Result<(f32, bool), Fail> {
    text.skip_space();
    let start = text.at;
    let rest = &text.bytes[start..];
    let sign = rest.first() == Some(&b'-');
    let digits = &rest[sign as usize..];
    // Most grids are whole numbers: seven digits are exact in 32 bits.
    let (mut value, mut len) = (0i32, 0);
    while len < 8 && digits.get(len).is_some_and(u8::is_ascii_digit) {
        value = value * 10 + i32::from(digits[len] - b'0');
        len += 1;
    }
    if (1..8).contains(&len) && matches!(digits.get(len), None | Some(b' ' | b'\n' | b'\r' | b'\t')) {
        text.at += sign as usize + len;
        return Ok((if sign { -value } else { value } as f32, true));
    }
    let value = text.any_f32("a height")?;
    if value.is_infinite() {
        return Err(text.fail_at(start, ReadErrorKind::NotFinite { what: "a height" }));
    }
    Ok((value, false))
}

/// The horizontal unit that a `.prj` beside a grid names: the last `UNIT` of its projection.
pub(super) fn unit_beside(path: &Path) -> Option<Unit> {
    let inner = if crate::io::is_gz(path) { path.with_extension("") } else { path.to_owned() };
    let mut text = Vec::new();
    // Such files have a few hundred bytes.
    fs::File::open(inner.with_extension("prj")).ok()?.take(1 << 16).read_to_end(&mut text).ok()?;
    unit_of_wkt(&String::from_utf8_lossy(&text).to_lowercase())
}

/// The unit of the coordinates in a projection as well-known text, in lower case.
fn unit_of_wkt(text: &str) -> Option<Unit> {
    // Projected systems hold a geographic one with its own unit, and end with theirs.
    let name = text[text.rfind("unit[\"")? + 6..].split('"').next()?;
    match name {
        "metre" | "meter" | "metres" | "meters" | "m" => Some(Unit::Metre),
        "degree" | "degrees" | "decimal_degree" => Some(Unit::Degree),
        "foot" | "feet" | "international foot" => Some(Unit::Foot),
        "foot_us" | "us survey foot" | "us_foot" | "survey_foot" => Some(Unit::UsSurveyFoot),
        _ => None,
    }
}

/// Cells are given by their corner, which all programs read; only where they are not square, by `dx` and `dy`.
pub(super) fn write(out: &mut impl Write, field: &HeightField) -> io::Result<()> {
    let DVec2 { x: dx, y: dy } = field.spacing;
    let south = field.origin.y - f64::from(field.rows - 1) * dy;
    writeln!(out, "ncols {}\nnrows {}", field.columns, field.rows)?;
    writeln!(out, "xllcorner {}\nyllcorner {}", field.origin.x - 0.5 * dx, south - 0.5 * dy)?;
    if dx == dy {
        writeln!(out, "cellsize {dx}")?;
    } else {
        writeln!(out, "dx {dx}\ndy {dy}")?;
    }
    // A value that is no height of this field.
    let nodata = (1u16..).map(|k| f32::from(k) * NODATA).find(|v| !field.heights.contains(v)).unwrap_or(f32::MIN);
    writeln!(out, "NODATA_value {nodata}")?;
    let whole = field.step.is_some_and(|step| step.fract() == 0.0);
    for row in field.heights.chunks_exact(field.columns as usize) {
        for (i, &height) in row.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            match height {
                h if h.is_nan() => write!(out, "{gap}{nodata}")?,
                h if whole => write!(out, "{gap}{h}")?,
                // With a point, so that nobody takes the numbers for whole ones.
                h => write!(out, "{gap}{h:?}")?,
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_projections() {
        let geographic = r#"geogcs["gcs_wgs_1984",datum["d_wgs_1984",spheroid["wgs_1984",6378137.0,298.257223563]],primem["greenwich",0.0],unit["degree",0.0174532925199433]]"#;
        assert_eq!(unit_of_wkt(geographic), Some(Unit::Degree));
        let projected = |unit: &str| format!(r#"projcs["x",{geographic},projection["lambert"],unit["{unit}",0.3]]"#);
        assert_eq!(unit_of_wkt(&projected("meter")), Some(Unit::Metre));
        assert_eq!(unit_of_wkt(&projected("foot_us")), Some(Unit::UsSurveyFoot));
        assert_eq!(unit_of_wkt(&projected("link")), None);
        assert_eq!(unit_of_wkt(""), None);
    }
}
