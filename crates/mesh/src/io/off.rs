//! OFF: the Object File Format of Geomview, as text.
//!
//! ```text
//! CNOFF                                 letters before OFF say what follows each point, in the order N, C, ST
//! 3 1 0                                 vertices, faces, edges (not used)
//! 0 0 0  0 0 1  255 0 0 255             point, normal (N), colour (C): integers to 255 or fractions to 1, alpha or not
//! ...
//! 3 0 1 2                               corners; what follows them on the line (a colour) is skipped
//! ```
//!
//! Our own parser: no maintained crate reads the vertex columns.

use std::io::{self, Write};

use glam::Vec3;

use super::Ticker;
use super::error::{Fail, ReadErrorKind, quote};
use super::soup::Soup;
use super::text::Scanner;
use crate::TriangleMesh;

pub(super) fn read(bytes: &[u8], ticker: &mut Ticker<'_>) -> Result<Soup, Fail> {
    let mut text = Scanner::new(bytes);
    text.skip_space_and_comments();
    let columns = header(&mut text)?;
    text.skip_space_and_comments();
    let vertices = count(&mut text, "vertices", "0 0 0\n")?;
    text.skip_space_and_comments();
    let faces = count(&mut text, "faces", "0\n")?;
    // The number of edges: most files have it, some leave it out, nobody needs it.
    if !text.line_is_done() {
        text.lone_integer("the number of edges")?;
    }

    let mut soup = Soup::new(vertices as u64);
    let mesh = &mut soup.mesh;
    mesh.positions.reserve_exact(vertices);
    for _ in 0..vertices {
        let mut number = |what: &'static str| {
            text.skip_space_and_comments();
            text.f32(what)
        };
        let position = Vec3::new(number("an x coordinate")?, number("a y coordinate")?, number("a z coordinate")?);
        mesh.positions.push(position);
        if columns.normals {
            let mut component = || {
                text.skip_space_and_comments();
                text.any_f32("a component of a normal")
            };
            mesh.vertex.normals.push(Vec3::new(component()?, component()?, component()?));
        }
        if columns.colors {
            mesh.vertex.colors.push(color(&mut text)?);
        }
        // Texture coordinates, and whatever else an exporter thought of.
        text.skip_line();
        ticker.at(text.at);
    }

    // A face needs eight bytes ("3 0 1 2\n") to become a triangle.
    soup.mesh.triangles.reserve(faces.min(text.remaining() / 8 + 1));
    let mut corners = Vec::new();
    for _ in 0..faces {
        text.skip_space_and_comments();
        let start = text.at;
        let size = text.lone_integer("the number of corners of a face")?;
        if size < 0 || size as usize > text.remaining() {
            return Err(too_many(&text, start, "corners", size, text.remaining() / 2));
        }
        Soup::check_corners(size as usize).map_err(|kind| text.fail_at(start, kind))?;
        corners.clear();
        for _ in 0..size {
            text.skip_space_and_comments();
            let start = text.at;
            let index = text.lone_integer("a vertex index")?;
            if index < 0 || index as usize >= vertices {
                let kind = ReadErrorKind::IndexOutOfRange { what: "vertex", index, count: vertices as u64, first: 0 };
                return Err(text.fail_at(start, kind));
            }
            corners.push(index as u32);
        }
        soup.push_face(&corners);
        text.skip_line();
        ticker.at(text.at);
    }
    text.skip_space_and_comments();
    if text.remaining() > 0 {
        return Err(text.unexpected("the end of the file after the faces that it promises"));
    }
    Ok(soup)
}

struct Columns {
    normals: bool,
    colors: bool,
}

fn header(text: &mut Scanner<'_>) -> Result<Columns, Fail> {
    let start = text.at;
    let word = text.token();
    // The word may be missing: then the file starts with its counts.
    if word.first().is_some_and(u8::is_ascii_digit) && word.iter().all(u8::is_ascii_digit) {
        text.at = start;
        return Ok(Columns { normals: false, colors: false });
    }
    let Some(mut letters) = word.strip_suffix(b"OFF") else {
        let kind = ReadErrorKind::Unexpected { expected: "the word OFF".to_owned(), found: quote(word) };
        return Err(text.fail_at(start, kind));
    };
    let mut take = |letter: &[u8]| match letters.strip_prefix(letter) {
        Some(rest) => {
            letters = rest;
            true
        }
        None => false,
    };
    take(b"ST");
    let columns = Columns { colors: take(b"C"), normals: take(b"N") };
    if !letters.is_empty() {
        let what = format!("the kind {} of OFF", quote(word));
        let remedy = "export it as OFF, COFF, NOFF or CNOFF, with three coordinates";
        return Err(text.fail_at(start, ReadErrorKind::Unsupported { what, remedy }));
    }
    text.skip_space_and_comments();
    if text.bytes[text.at..].starts_with(b"BINARY") {
        let kind = ReadErrorKind::Unsupported { what: "binary OFF".to_owned(), remedy: "export it as text or as PLY" };
        return Err(text.fail(kind));
    }
    Ok(columns)
}

/// A count of things of which each takes at least the bytes of `least`.
fn count(text: &mut Scanner<'_>, what: &'static str, least: &str) -> Result<usize, Fail> {
    let start = text.at;
    let promised = text.lone_integer(if what == "faces" { "the number of faces" } else { "the number of vertices" })?;
    // The last one may go without its line end.
    let most = (text.remaining() + 1) / least.len();
    if promised < 0 || promised as u64 > most as u64 {
        return Err(too_many(text, start, what, promised, most));
    }
    Ok(promised as usize)
}

fn too_many(text: &Scanner<'_>, start: usize, what: &str, promised: i64, most: usize) -> Fail {
    let (what, remaining) = (what.to_owned(), text.remaining() as u64);
    if promised < 0 {
        let expected = format!("a number of {what} from 0");
        return text.fail_at(start, ReadErrorKind::Unexpected { expected, found: format!("`{promised}`") });
    }
    let (promised, most) = (promised as u64, most as u64);
    text.fail_at(start, ReadErrorKind::CountTooLarge { what, promised, remaining, most })
}

/// Three or four numbers to the end of the line: integers are 0 to 255, numbers with a point or exponent 0 to 1.
fn color(text: &mut Scanner<'_>) -> Result<[u8; 4], Fail> {
    let mut rgba = [0, 0, 0, 255];
    for (i, channel) in rgba.iter_mut().enumerate() {
        if i == 3 && text.line_is_done() {
            break;
        }
        text.skip_space_and_comments();
        let start = text.at;
        let value = text.f32("a colour")?;
        let is_fraction = text.bytes[start..text.at].iter().any(|b| matches!(b, b'.' | b'e' | b'E'));
        *channel = (if is_fraction { value * 255.0 } else { value }).round().clamp(0.0, 255.0) as u8;
    }
    Ok(rgba)
}

pub(super) fn write(out: &mut impl Write, mesh: &TriangleMesh) -> io::Result<()> {
    let (normals, colors) = (&mesh.vertex.normals, &mesh.vertex.colors);
    let letters = if colors.is_empty() { "" } else { "C" };
    writeln!(out, "{letters}{}OFF", if normals.is_empty() { "" } else { "N" })?;
    writeln!(out, "{} {} 0", mesh.positions.len(), mesh.triangles.len())?;
    for (i, p) in mesh.positions.iter().enumerate() {
        write!(out, "{} {} {}", p.x, p.y, p.z)?;
        if let Some(n) = normals.get(i) {
            write!(out, " {} {} {}", n.x, n.y, n.z)?;
        }
        if let Some([r, g, b, a]) = colors.get(i) {
            write!(out, " {r} {g} {b} {a}")?;
        }
        writeln!(out)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "3 {} {} {}", a.0, b.0, c.0)?;
    }
    Ok(())
}
