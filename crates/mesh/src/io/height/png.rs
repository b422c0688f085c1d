//! PNG, grey: what image editors and game engines call a height map.
//!
//! Samples are heights as they are, whole numbers of a unit that nobody knows, at a distance of one such unit.
//! Transparent samples are missing.

use std::io::{self, Cursor, Write};

use ::png::{BitDepth, ColorType, Decoder, DecodingError, Encoder, Limits, Transformations};
use glam::DVec2;

use super::{Parsed, Ticker, check_inflation, check_size};
use crate::io::error::{Fail, ReadErrorKind};
use crate::{HeightField, Unit};

/// Room for chunks that hold no samples: text, profiles.
const OTHER_CHUNKS: usize = 1 << 20;

pub(super) fn read(bytes: &[u8], ticker: &mut Ticker<'_>) -> Result<Parsed, Fail> {
    let limits = Limits { bytes: bytes.len().saturating_mul(4).max(OTHER_CHUNKS) };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(Transformations::IDENTITY);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(fail)?;
    let info = reader.info();
    let (columns, rows) = (info.width, info.height);
    check_size(columns.into(), rows.into()).map_err(Fail::file)?;
    check_inflation(columns, rows, bytes.len()).map_err(Fail::file)?;
    let unsupported =
        |what: &str, remedy| Err(Fail::file(ReadErrorKind::Unsupported { what: format!("a PNG {what}"), remedy }));
    let channels = match info.color_type {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        _ => {
            return unsupported(
                "in colour",
                "convert it to grey of 16 bits; if its colours encode heights, decode them",
            );
        }
    };
    let wide = match info.bit_depth {
        BitDepth::Eight => false,
        BitDepth::Sixteen => true,
        _ => return unsupported("of less than 8 bits", "convert it to grey of 8 or 16 bits"),
    };
    // One grey may stand for transparent.
    let transparent = match info.trns.as_deref() {
        Some(&[high, low]) if channels == 1 => Some(u16::from_be_bytes([high, low])),
        _ => None,
    };
    let mut image = vec![0; reader.output_buffer_size().ok_or_else(|| Fail::file(ReadErrorKind::TooMany("samples")))?];
    reader.next_frame(&mut image).map_err(fail)?;
    ticker.at(bytes.len() / 2);

    let height = |value: u16, opaque: bool| match opaque && Some(value) != transparent {
        true => f32::from(value),
        false => f32::NAN,
    };
    let word = |bytes: &[u8]| u16::from_be_bytes([bytes[0], bytes[1]]);
    let heights = match (channels, wide) {
        (1, false) => image.iter().map(|&v| height(v.into(), true)).collect(),
        (1, true) => image.chunks_exact(2).map(|v| height(word(v), true)).collect(),
        (_, false) => image.chunks_exact(2).map(|v| height(v[0].into(), v[1] > 0)).collect(),
        (_, true) => image.chunks_exact(4).map(|v| height(word(v), word(&v[2..]) > 0)).collect(),
    };
    let field = HeightField {
        columns,
        rows,
        heights,
        origin: DVec2::ZERO,
        spacing: DVec2::ONE,
        horizontal: Unit::Unknown,
        vertical: Unit::Unknown,
        step: Some(1.0),
    };
    Ok(Parsed { field, notes: Vec::new() })
}

fn fail(error: DecodingError) -> Fail {
    Fail::file(match error {
        DecodingError::IoError(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
            ReadErrorKind::Truncated { expected: "more of the image".to_owned() }
        }
        DecodingError::LimitsExceeded => ReadErrorKind::Unsupported {
            what: "a PNG with parts out of proportion to its size".to_owned(),
            remedy: "write it anew with another program",
        },
        e => ReadErrorKind::Damaged { what: "PNG", why: e.to_string() },
    })
}

pub(super) fn refusal(field: &HeightField) -> Option<(&'static str, &'static str)> {
    let fits = |h: &f32| h.is_nan() || (0.0..=65535.0).contains(h) && h.fract() == 0.0;
    (!field.heights.iter().all(fits)).then_some((
        "a PNG holds whole heights from 0 to 65535 only",
        "use .tif or .asc, or round and shift the heights",
    ))
}

/// 16 bits; with transparency only where heights are missing.
pub(super) fn write(out: &mut impl Write, field: &HeightField) -> io::Result<()> {
    let masked = field.missing() > 0;
    let mut encoder = Encoder::new(out, field.columns, field.rows);
    encoder.set_color(if masked { ColorType::GrayscaleAlpha } else { ColorType::Grayscale });
    encoder.set_depth(BitDepth::Sixteen);
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    let mut line = Vec::new();
    for row in field.heights.chunks_exact(field.columns as usize) {
        line.clear();
        for &height in row {
            line.extend((height as u16).to_be_bytes());
            if masked {
                line.extend(if height.is_nan() { [0; 2] } else { [0xff; 2] });
            }
        }
        stream.write_all(&line)?;
    }
    stream.finish()?;
    Ok(writer.finish()?)
}
