//! STL: triangles without shared vertices, as text or binary.
//!
//! ```text
//! 80 bytes of anything, u32 n, then n times: normal, a, b, c (3 × f32 each), u16          little endian
//! solid name  facet normal x y z  outer loop  vertex x y z ...  endloop  endfacet  endsolid
//! ```
//!
//! Many binary files start with the word `solid` too, so a file is binary where its length fits its count. Facet
//! normals and the colours that some programs hide in the last two bytes are skipped.
//!
//! Our own parser: `stl_io` 0.11 takes NaN from binary files, and its errors name no line or byte.

use std::io::{self, Write};

use glam::Vec3;

use super::Ticker;
use super::error::{Fail, ReadErrorKind, quote};
use super::soup::Soup;
use super::text::Scanner;
use crate::{TriangleId, TriangleMesh};

const HEADER: usize = 84;
const FACET: usize = 50;

pub(super) fn read(bytes: &[u8], ticker: &mut Ticker<'_>) -> Result<Soup, Fail> {
    let count = bytes.get(80..HEADER).map(|c| u64::from(u32::from_le_bytes([c[0], c[1], c[2], c[3]])));
    let fits = count.is_some_and(|n| HEADER as u64 + FACET as u64 * n == bytes.len() as u64);
    if !fits && bytes.trim_ascii_start().get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid")) {
        return read_text(bytes, ticker);
    }
    let Some(promised) = count else {
        let expected = "the word `solid`, or 80 bytes of header and the number of triangles".to_owned();
        return Err(Fail::byte(0, ReadErrorKind::Unexpected { expected, found: quote(&bytes[..bytes.len().min(20)]) }));
    };
    let remaining = (bytes.len() - HEADER) as u64;
    let most = remaining / FACET as u64;
    if promised > most {
        let what = "triangles".to_owned();
        return Err(Fail::byte(80, ReadErrorKind::CountTooLarge { what, promised, remaining, most }));
    }
    // A few bytes of padding are harmless; whole triangles behind the last one mean that the count is wrong.
    if promised < most {
        let expected = format!("the end of the file after the {promised} triangles that it promises");
        let found = format!("{} more bytes", remaining - promised * FACET as u64);
        let at = HEADER + promised as usize * FACET;
        return Err(Fail::byte(at, ReadErrorKind::Unexpected { expected, found }));
    }

    if 3 * promised >= u64::from(u32::MAX) {
        return Err(Fail::file(ReadErrorKind::TooMany("vertices")));
    }
    let n = promised as usize;
    let mut soup = Soup::new(3 * promised);
    soup.mesh.positions.reserve_exact(3 * n);
    soup.mesh.triangles.reserve_exact(n);
    for (i, facet) in bytes[HEADER..].chunks_exact(FACET).take(n).enumerate() {
        for corner in facet[12..48].chunks_exact(12) {
            let number = |at: usize| f32::from_le_bytes([corner[at], corner[at + 1], corner[at + 2], corner[at + 3]]);
            let position = Vec3::new(number(0), number(4), number(8));
            if !position.is_finite() {
                return Err(Fail::byte(HEADER + i * FACET, ReadErrorKind::NotFinite { what: "a coordinate" }));
            }
            soup.mesh.positions.push(position);
        }
        let first = 3 * i as u32;
        soup.push_face(&[first, first + 1, first + 2]);
        ticker.at(HEADER + i * FACET);
    }
    Ok(soup)
}

fn read_text(bytes: &[u8], ticker: &mut Ticker<'_>) -> Result<Soup, Fail> {
    let mut text = Scanner::new(bytes);
    let mut soup = Soup::default();
    let mut corners = Vec::new();
    while text.remaining() > 0 {
        word(&mut text, "solid")?;
        text.skip_line();
        loop {
            let next = words(&mut text, &["facet", "endsolid"])?;
            if next == "endsolid" {
                text.skip_line();
                text.skip_space();
                break;
            }
            word(&mut text, "normal")?;
            for _ in 0..3 {
                text.skip_space();
                // Some programs write normals that are no numbers.
                if text.token().is_empty() {
                    return Err(text.unexpected("a component of the facet's normal"));
                }
            }
            word(&mut text, "outer")?;
            word(&mut text, "loop")?;
            corners.clear();
            while words(&mut text, &["vertex", "endloop"])? == "vertex" {
                let mut number = |what: &'static str| {
                    text.skip_space();
                    text.f32(what)
                };
                let position =
                    Vec3::new(number("an x coordinate")?, number("a y coordinate")?, number("a z coordinate")?);
                corners.push(soup.mesh.positions.len() as u32);
                Soup::check_corners(corners.len()).map_err(|kind| text.fail(kind))?;
                soup.mesh.positions.push(position);
            }
            word(&mut text, "endfacet")?;
            soup.push_face(&corners);
            soup.check_size()?;
            ticker.at(text.at);
        }
    }
    soup.vertices_in_file = soup.mesh.positions.len() as u64;
    Ok(soup)
}

fn word(text: &mut Scanner<'_>, expected: &'static str) -> Result<(), Fail> {
    words(text, &[expected]).map(|_| ())
}

/// The one of some words that is next, upper or lower case.
fn words(text: &mut Scanner<'_>, expected: &[&'static str]) -> Result<&'static str, Fail> {
    text.skip_space();
    let start = text.at;
    let token = text.token();
    match expected.iter().find(|w| token.eq_ignore_ascii_case(w.as_bytes())) {
        Some(word) => Ok(word),
        None => {
            text.at = start;
            let quoted: Vec<String> = expected.iter().map(|w| format!("`{w}`")).collect();
            Err(text.unexpected(&quoted.join(" or ")))
        }
    }
}

pub(super) fn write(out: &mut impl Write, mesh: &TriangleMesh) -> io::Result<()> {
    // Must not start with `solid`.
    let mut header = [0; 80];
    header[..29].copy_from_slice(b"binary STL, made by Meshfront");
    out.write_all(&header)?;
    out.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for t in 0..mesh.triangles.len() as u32 {
        let [a, b, c] = mesh.corners(TriangleId(t));
        let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3();
        let mut facet = [0; FACET];
        for (slot, p) in facet.chunks_exact_mut(12).zip([normal, a, b, c]) {
            slot.copy_from_slice(bytemuck::cast_slice(&p.to_array().map(f32::to_le_bytes)));
        }
        out.write_all(&facet)?;
    }
    Ok(())
}
