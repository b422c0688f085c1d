//! OBJ: Wavefront's text format.
//!
//! ```text
//! v x y z [w] [r g b]      point; colours are fractions to 1, or to 255 where one is above 1
//! vn x y z                 normal
//! f v v/t v/t/n v//n ...   corners, counted from 1, or from the last one backwards with -1
//! ```
//!
//! Texture coordinates, groups, materials, lines, points and curves are skipped. A vertex that faces use with several
//! normals becomes several vertices, in the order of the points.
//!
//! Our own parser. `tobj` 4.0.5 names no line in its errors, lets NaN pass, cuts every polygon as a fan and is slower:
//! for 103 MB of text it took 2.0 to 3.4 s (30 to 52 MB/s) and 450 MB of memory, where the whole of
//! `cargo run --release -p meshfront-mesh --example read_time -- big.obj` took 0.7 s, cleaning included, and 214 MB
//! (medians, runs taking turns on two busy cores).

use std::io::{self, Write};

use glam::Vec3;

use super::Ticker;
use super::error::{Fail, ReadErrorKind, quote};
use super::soup::Soup;
use super::text::Scanner;
use crate::{TriangleMesh, VertexId};

/// No normal, no vertex.
const NONE: u32 = u32::MAX;

pub(super) fn read(bytes: &[u8], ticker: &mut Ticker<'_>) -> Result<Soup, Fail> {
    let mut text = Scanner::new(bytes);
    let mut soup = Soup::default();
    let mut colors: Vec<[f32; 3]> = Vec::new();
    let mut normals: Vec<Vec3> = Vec::new();
    // Per triangle, once a face has used a normal.
    let mut corner_normals: Vec<[u32; 3]> = Vec::new();
    let (mut corners, mut face_normals) = (Vec::new(), Vec::new());

    loop {
        text.skip_space();
        let start = text.at;
        let Some(first) = text.peek() else { break };
        let word = if first == b'#' { &bytes[start..=start] } else { text.token() };
        match word {
            b"v" => {
                let position = vector(&mut text)?;
                if !position.is_finite() {
                    return Err(text.fail_at(start, ReadErrorKind::NotFinite { what: "a coordinate" }));
                }
                soup.mesh.positions.push(position);
                if !text.line_is_done() || !colors.is_empty() {
                    vertex_color(&mut text, &mut colors, soup.mesh.positions.len())?;
                }
            }
            b"vn" => normals.push(vector(&mut text)?),
            b"f" => {
                corners.clear();
                face_normals.clear();
                while !text.line_is_done() {
                    let (v, n) = corner(&mut text, soup.mesh.positions.len(), normals.len())?;
                    corners.push(v);
                    Soup::check_corners(corners.len()).map_err(|kind| text.fail_at(start, kind))?;
                    face_normals.push(n);
                }
                let before = soup.mesh.triangles.len();
                soup.push_face(&corners);
                if corners.len() >= 3 && (!corner_normals.is_empty() || face_normals.iter().any(|&n| n != NONE)) {
                    corner_normals.resize(before, [NONE; 3]);
                    corner_normals.extend(
                        (1..corners.len() - 1).map(|i| [face_normals[0], face_normals[i], face_normals[i + 1]]),
                    );
                }
            }
            // Statements start with a letter (`vt`, `usemtl`, `#` for comments); bytes that do not are no OBJ.
            _ if first == b'#' || first.is_ascii_alphabetic() && word.iter().all(u8::is_ascii_graphic) => {}
            _ => {
                let expected = "a statement such as `v`, `vn` or `f`".to_owned();
                return Err(text.fail_at(start, ReadErrorKind::Unexpected { expected, found: quote(word) }));
            }
        }
        text.skip_line();
        ticker.at(text.at);
    }

    soup.vertices_in_file = soup.mesh.positions.len() as u64;
    soup.check_size()?;
    if normals.len() >= NONE as usize {
        return Err(Fail::file(ReadErrorKind::TooMany("normals")));
    }
    if !colors.is_empty() {
        let scale = if colors.iter().flatten().any(|&c| c > 1.0) { 1.0 } else { 255.0 };
        let channel = |c: f32| (c * scale).round().clamp(0.0, 255.0) as u8;
        soup.mesh.vertex.colors = colors.iter().map(|&[r, g, b]| [channel(r), channel(g), channel(b), 255]).collect();
    }
    if !corner_normals.is_empty() {
        split_by_normal(&mut soup.mesh, &normals, &corner_normals);
    }
    Ok(soup)
}

/// Three numbers on this line, finite or not.
#[inline]
fn vector(text: &mut Scanner<'_>) -> Result<Vec3, Fail> {
    let mut number = |what: &'static str| {
        text.skip_blanks();
        text.any_f32(what)
    };
    Ok(Vec3::new(number("an x coordinate")?, number("a y coordinate")?, number("a z coordinate")?))
}

/// What follows the coordinates of vertex number `vertices`: a weight (skipped), a colour, or both. Vertices without a
/// colour are white.
fn vertex_color(text: &mut Scanner<'_>, colors: &mut Vec<[f32; 3]>, vertices: usize) -> Result<(), Fail> {
    const WHITE: [f32; 3] = [1.0; 3];
    let mut extra = [0.0; 4];
    let mut n = 0;
    while n < extra.len() && !text.line_is_done() {
        extra[n] = text.f32("a colour")?;
        n += 1;
    }
    let color = match n {
        3 => Some([extra[0], extra[1], extra[2]]),
        4 => Some([extra[1], extra[2], extra[3]]),
        _ => None,
    };
    if color.is_some() || !colors.is_empty() {
        colors.resize(vertices - 1, WHITE);
        colors.push(color.unwrap_or(WHITE));
    }
    Ok(())
}

/// One corner of a face: vertex and normal, counted from 0.
#[inline]
fn corner(text: &mut Scanner<'_>, vertices: usize, normals: usize) -> Result<(u32, u32), Fail> {
    let v = index(text, "vertex", vertices)?;
    let mut n = NONE;
    if text.peek() == Some(b'/') {
        text.at += 1;
        if text.peek() != Some(b'/') {
            text.integer("the index of a texture coordinate")?;
        }
        if text.peek() == Some(b'/') {
            text.at += 1;
            // `v/t/` without a normal is found in the wild.
            if text.peek().is_some_and(|b| b == b'-' || b.is_ascii_digit()) {
                n = index(text, "normal", normals)?;
            }
        }
    }
    if !matches!(text.peek(), None | Some(b' ' | b'\t' | b'\r' | b'\n' | b'#' | 0x0b | 0x0c)) {
        return Err(text.unexpected("a corner such as 1, 1/2, 1/2/3 or 1//3"));
    }
    Ok((v, n))
}

#[inline]
fn index(text: &mut Scanner<'_>, what: &'static str, count: usize) -> Result<u32, Fail> {
    let start = text.at;
    let index = text.integer(if what == "vertex" { "a vertex index" } else { "a normal index" })?;
    let from_zero = if index < 0 { count as i64 + index } else { index - 1 };
    if from_zero < 0 || from_zero >= (count as i64).min(i64::from(NONE)) {
        let kind = ReadErrorKind::IndexOutOfRange { what, index, count: count as u64, first: 1 };
        return Err(text.fail_at(start, kind));
    }
    Ok(from_zero as u32)
}

/// Makes one vertex for each pair of a point and a normal that occurs. Points that no face uses go.
fn split_by_normal(mesh: &mut TriangleMesh, normals: &[Vec3], corner_normals: &[[u32; 3]]) {
    // Pairs by point: `head[point]` and then `next[pair]` are the pairs of a point, newest first.
    let mut head = vec![NONE; mesh.positions.len()];
    let mut next: Vec<u32> = Vec::with_capacity(mesh.positions.len());
    let mut pair_normal: Vec<u32> = Vec::with_capacity(mesh.positions.len());
    for (t, corners) in mesh.triangles.iter_mut().enumerate() {
        for i in 0..3 {
            let (point, normal) = (corners[i].ix(), corner_normals[t][i]);
            let mut pair = head[point];
            while pair != NONE && pair_normal[pair as usize] != normal {
                pair = next[pair as usize];
            }
            if pair == NONE {
                pair = next.len() as u32;
                next.push(head[point]);
                pair_normal.push(normal);
                head[point] = pair;
            }
            corners[i] = VertexId(pair);
        }
    }
    // Numbered by point, so that a file with one normal per point keeps its order.
    let mut number = vec![0; next.len()];
    let old = std::mem::take(&mut mesh.positions);
    let old_colors = std::mem::take(&mut mesh.vertex.colors);
    mesh.positions.reserve_exact(next.len());
    for (point, &first) in head.iter().enumerate() {
        let mut pair = first;
        while pair != NONE {
            let p = pair as usize;
            number[p] = mesh.positions.len() as u32;
            mesh.positions.push(old[point]);
            mesh.vertex.normals.push(normals.get(pair_normal[p] as usize).copied().unwrap_or(Vec3::ZERO));
            mesh.vertex.colors.extend(old_colors.get(point));
            pair = next[p];
        }
    }
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = VertexId(number[v.ix()]));
}

pub(super) fn write(out: &mut impl Write, mesh: &TriangleMesh) -> io::Result<()> {
    let (normals, colors) = (&mesh.vertex.normals, &mesh.vertex.colors);
    for (i, p) in mesh.positions.iter().enumerate() {
        write!(out, "v {} {} {}", p.x, p.y, p.z)?;
        match colors.get(i) {
            Some(c) => writeln!(out, " {} {} {}", fraction(c[0]), fraction(c[1]), fraction(c[2]))?,
            None => writeln!(out)?,
        }
    }
    for n in normals {
        writeln!(out, "vn {} {} {}", n.x, n.y, n.z)?;
    }
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|v| u64::from(v.0) + 1);
        if normals.is_empty() {
            writeln!(out, "f {a} {b} {c}")?;
        } else {
            writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
        }
    }
    Ok(())
}

fn fraction(channel: u8) -> f32 {
    f32::from(channel) / 255.0
}
