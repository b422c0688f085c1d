//! PLY: the Polygon File Format (Turk 1994), as text or binary of either byte order.
//!
//! The header says what follows: elements (`vertex`, `face`, anything) with properties, numbers or lists of numbers.
//! Of `vertex` we take x y z, nx ny nz and red green blue alpha in whatever type and order; of `face` the list
//! `vertex_indices`; of `tristrips` its strips. All else is skipped.
//!
//! Our own parser. `ply-rs-bw` 4.0.1 gives a line number and no byte offset for damage in a binary body and quotes its
//! grammar for a NaN; for 100 MB of text it took 1.1 to 1.6 s (61 to 88 MB/s) to parse, where the whole of
//! `cargo run --release -p meshfront-mesh --example read_time -- big.ply` took 0.65 to 0.95 s, cleaning included
//! (medians, runs taking turns on two busy cores).

use std::io::{self, Write};

use glam::Vec3;

use super::Ticker;
use super::error::{Fail, ReadErrorKind, quote};
use super::soup::Soup;
use super::text::Scanner;
use crate::{TriangleMesh, VertexId};

/// Types of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn of(word: &[u8]) -> Option<Type> {
        Some(match word {
            b"char" | b"int8" => Type::I8,
            b"uchar" | b"uint8" => Type::U8,
            b"short" | b"int16" => Type::I16,
            b"ushort" | b"uint16" => Type::U16,
            b"int" | b"int32" => Type::I32,
            b"uint" | b"uint32" => Type::U32,
            b"float" | b"float32" => Type::F32,
            b"double" | b"float64" => Type::F64,
            _ => return None,
        })
    }
    fn size(self) -> usize {
        match self {
            Type::I8 | Type::U8 => 1,
            Type::I16 | Type::U16 => 2,
            Type::I32 | Type::U32 | Type::F32 => 4,
            Type::F64 => 8,
        }
    }
    fn is_float(self) -> bool {
        matches!(self, Type::F32 | Type::F64)
    }
}

/// What a property is to us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// x, y, z are 0 to 2; the normal 3 to 5; red, green, blue, alpha 6 to 9.
    Number(usize),
    /// The corners of a face or the strips of a surface.
    Corners,
    Skip,
}

struct Property {
    /// Of a list: the type of its length.
    list: Option<Type>,
    item: Type,
    role: Role,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

pub(super) fn read(bytes: &[u8], ticker: &mut Ticker<'_>) -> Result<Soup, Fail> {
    let mut text = Scanner::new(bytes);
    let (encoding, elements) = header(&mut text)?;
    let body = match encoding {
        Encoding::Ascii => Body::Text(text),
        Encoding::LittleEndian => Body::Binary { bytes, at: text.at, big: false },
        Encoding::BigEndian => Body::Binary { bytes, at: text.at, big: true },
    };
    let vertices = elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut reader = Reader { body, vertices, soup: Soup::default(), corners: Vec::new() };
    for element in &elements {
        reader.body.check_count(element)?;
        match element.name.as_str() {
            "vertex" => reader.vertices(element, ticker)?,
            _ => reader.others(element, ticker)?,
        }
    }
    reader.body.end()?;
    // Faces may come before their vertices; that those exist was checked against the header's count.
    Ok(reader.soup)
}

fn header(text: &mut Scanner<'_>) -> Result<(Encoding, Vec<Element>), Fail> {
    let wrong = |text: &Scanner<'_>, at: usize, expected: &str, found: &[u8]| {
        text.fail_at(at, ReadErrorKind::Unexpected { expected: expected.to_owned(), found: quote(found) })
    };
    let magic = text.line();
    if magic != b"ply" {
        return Err(wrong(text, 0, "the word `ply`", &magic[..magic.len().min(32)]));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        if text.remaining() == 0 {
            return Err(text.unexpected("a header line or `end_header`"));
        }
        let at = text.at;
        let line = text.line();
        let words: Vec<&[u8]> = line.split(|b| b.is_ascii_whitespace()).filter(|w| !w.is_empty()).take(6).collect();
        match words[..] {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", kind, _version] => {
                encoding = Some(match kind {
                    b"ascii" => Encoding::Ascii,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(wrong(text, at, "ascii, binary_little_endian or binary_big_endian", kind)),
                });
            }
            [b"element", name, count] => {
                let count = str::from_utf8(count).ok().and_then(|c| c.parse().ok());
                let Some(count) = count else { return Err(wrong(text, at, "a number of elements", line)) };
                let name = String::from_utf8_lossy(name).into_owned();
                if elements.iter().any(|e| e.name == name) {
                    return Err(wrong(text, at, "an element that was not declared before", line));
                }
                elements.push(Element { name, count, properties: Vec::new() });
            }
            [b"property", ref words @ ..] => {
                let property = match words {
                    [b"list", length, item, name] => {
                        Type::of(length).filter(|t| !t.is_float()).zip(Type::of(item)).map(|(l, i)| (Some(l), i, *name))
                    }
                    [item, name] => Type::of(item).map(|i| (None, i, *name)),
                    _ => None,
                };
                let (Some((list, item, name)), Some(element)) = (property, elements.last_mut()) else {
                    return Err(wrong(text, at, "`property TYPE NAME` or `property list TYPE TYPE NAME`", line));
                };
                let role = role(&element.name, list.is_some(), name);
                if role == Role::Corners && item.is_float() {
                    return Err(wrong(text, at, "integers as vertex indices", line));
                }
                if role != Role::Skip && element.properties.iter().any(|p| p.role == role) {
                    return Err(wrong(text, at, "a property that was not declared before", line));
                }
                element.properties.push(Property { list, item, role });
            }
            [b"end_header"] => break,
            _ => return Err(wrong(text, at, "a header line (format, element, property, comment, end_header)", line)),
        }
    }
    let Some(encoding) = encoding else {
        return Err(wrong(text, 0, "a line `format` in the header", b""));
    };
    let Some(vertex) = elements.iter().find(|e| e.name == "vertex") else {
        return Err(wrong(text, 0, "an element `vertex` in the header", b""));
    };
    if !(0..3).all(|i| vertex.properties.iter().any(|p| p.role == Role::Number(i))) {
        return Err(wrong(text, 0, "the properties x, y and z of element `vertex` in the header", b""));
    }
    if vertex.count >= u64::from(u32::MAX) {
        return Err(Fail::file(ReadErrorKind::TooMany("vertices")));
    }
    Ok((encoding, elements))
}

fn role(element: &str, is_list: bool, name: &[u8]) -> Role {
    match (element, is_list, name) {
        ("face", true, b"vertex_indices" | b"vertex_index") | ("tristrips", true, b"vertex_indices") => Role::Corners,
        ("vertex", false, _) => match name {
            b"x" => Role::Number(0),
            b"y" => Role::Number(1),
            b"z" => Role::Number(2),
            b"nx" | b"normal_x" => Role::Number(3),
            b"ny" | b"normal_y" => Role::Number(4),
            b"nz" | b"normal_z" => Role::Number(5),
            b"red" | b"r" | b"diffuse_red" => Role::Number(6),
            b"green" | b"g" | b"diffuse_green" => Role::Number(7),
            b"blue" | b"b" | b"diffuse_blue" => Role::Number(8),
            b"alpha" | b"a" | b"diffuse_alpha" => Role::Number(9),
            _ => Role::Skip,
        },
        _ => Role::Skip,
    }
}

/// The rest of the file behind the header.
enum Body<'a> {
    Text(Scanner<'a>),
    Binary { bytes: &'a [u8], at: usize, big: bool },
}

const COORDINATES: [&str; 10] = [
    "an x coordinate",
    "a y coordinate",
    "a z coordinate",
    "a normal",
    "a normal",
    "a normal",
    "a colour",
    "a colour",
    "a colour",
    "a colour",
];

impl Body<'_> {
    fn at(&self) -> usize {
        match self {
            Body::Text(text) => text.at,
            Body::Binary { at, .. } => *at,
        }
    }

    fn remaining(&self) -> usize {
        match self {
            Body::Text(text) => text.remaining(),
            Body::Binary { bytes, at, .. } => bytes.len() - at,
        }
    }

    fn fail_at(&self, at: usize, kind: ReadErrorKind) -> Fail {
        match self {
            Body::Text(text) => text.fail_at(at, kind),
            Body::Binary { .. } => Fail::byte(at, kind),
        }
    }

    /// The fewest bytes a row of this element takes.
    fn least_row(&self, element: &Element) -> usize {
        let least = |p: &Property| match self {
            Body::Text(_) => 2,
            Body::Binary { .. } => p.list.unwrap_or(p.item).size(),
        };
        element.properties.iter().map(least).sum()
    }

    fn check_count(&self, element: &Element) -> Result<(), Fail> {
        let least = self.least_row(element);
        // In a text the last number may go without the line end behind it.
        let slack = matches!(self, Body::Text(_)) as usize;
        let remaining = self.remaining();
        let most = (remaining + slack).checked_div(least).map_or(u64::MAX, |n| n as u64);
        if element.count <= most {
            return Ok(());
        }
        let what = if element.name == "vertex" { "vertices" } else { element.name.as_str() };
        let what = if what == "face" { "faces".to_owned() } else { quote(what.as_bytes()).replace('`', "") };
        let kind = ReadErrorKind::CountTooLarge { what, promised: element.count, remaining: remaining as u64, most };
        Err(self.fail_at(self.at(), kind))
    }

    /// The next bytes of a binary body.
    #[inline]
    fn take<const N: usize>(bytes: &[u8], at: &mut usize, big: bool) -> Result<[u8; N], Fail> {
        let Some(chunk) = bytes.get(*at..).and_then(|rest| rest.first_chunk::<N>()) else {
            return Err(Self::short(*at));
        };
        *at += N;
        let mut chunk = *chunk;
        if big {
            chunk.reverse();
        }
        Ok(chunk)
    }

    #[cold]
    fn short(at: usize) -> Fail {
        Fail::byte(at, ReadErrorKind::Truncated { expected: "the next number".to_owned() })
    }

    /// Any number, finite or not, as text may have in place of any type.
    #[inline]
    fn number(&mut self, ty: Type, what: &'static str) -> Result<f64, Fail> {
        match self {
            Body::Text(text) => {
                text.skip_space();
                // 32 bits, read as such: rounding to 64 and then to 32 bits is not always the same.
                text.any_f32(what).map(f64::from)
            }
            Body::Binary { bytes, at, big } => Ok(match ty {
                Type::I8 => f64::from(i8::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::U8 => f64::from(u8::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::I16 => f64::from(i16::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::U16 => f64::from(u16::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::I32 => f64::from(i32::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::U32 => f64::from(u32::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::F32 => f64::from(f32::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::F64 => f64::from_le_bytes(Self::take(bytes, at, *big)?),
            }),
        }
    }

    /// An integer of an integer type.
    #[inline]
    fn integer(&mut self, ty: Type, what: &'static str) -> Result<i64, Fail> {
        match self {
            Body::Text(text) => {
                text.skip_space();
                text.lone_integer(what)
            }
            Body::Binary { bytes, at, big } => Ok(match ty {
                Type::I8 => i64::from(i8::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::U8 => i64::from(u8::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::I16 => i64::from(i16::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::U16 => i64::from(u16::from_le_bytes(Self::take(bytes, at, *big)?)),
                Type::I32 => i64::from(i32::from_le_bytes(Self::take(bytes, at, *big)?)),
                _ => i64::from(u32::from_le_bytes(Self::take(bytes, at, *big)?)),
            }),
        }
    }

    /// Skips `n` numbers.
    fn skip(&mut self, ty: Type, n: u64) -> Result<(), Fail> {
        match self {
            Body::Text(text) => {
                for _ in 0..n {
                    text.skip_space();
                    if text.token().is_empty() {
                        return Err(text.unexpected("a number"));
                    }
                }
            }
            Body::Binary { bytes, at, .. } => {
                if n.saturating_mul(ty.size() as u64) > (bytes.len() - *at) as u64 {
                    return Err(Self::short(*at));
                }
                *at += n as usize * ty.size();
            }
        }
        Ok(())
    }

    /// The end of a row: in a text, of its line. A number too many is noticed where it stands.
    #[inline]
    fn end_row(&mut self) -> Result<(), Fail> {
        match self {
            Body::Text(text) => match text.line_is_done() {
                true => Ok(()),
                false => Err(text.unexpected("the end of the line")),
            },
            Body::Binary { .. } => Ok(()),
        }
    }

    /// The end of the file, or padding: more rows than the header promises mean that it is damaged.
    fn end(&mut self) -> Result<(), Fail> {
        let (at, rest) = match self {
            Body::Text(text) => (text.at, &text.bytes[text.at..]),
            Body::Binary { bytes, at, .. } => (*at, &bytes[*at..]),
        };
        let Some(more) = rest.iter().position(|b| !b.is_ascii_whitespace() && *b != 0) else { return Ok(()) };
        let expected = "the end of the file after the elements that the header promises".to_owned();
        let found = format!("{} more bytes", rest.len() - more);
        Err(self.fail_at(at + more, ReadErrorKind::Unexpected { expected, found }))
    }

    /// The length of a list whose items are still to come.
    #[inline]
    fn length(&mut self, length: Type, item: Type) -> Result<u64, Fail> {
        let at = self.at();
        let n = self.integer(length, "the length of a list")?;
        let least = if matches!(self, Body::Text(_)) { 2 } else { item.size() };
        let most = (self.remaining() + 1) / least;
        if n < 0 || n as u64 > most as u64 {
            let what = "list items".to_owned();
            let (promised, remaining, most) = (n as u64, self.remaining() as u64, most as u64);
            return Err(self.fail_at(
                at,
                if n < 0 {
                    let (expected, found) = ("the length of a list".to_owned(), format!("`{n}`"));
                    ReadErrorKind::Unexpected { expected, found }
                } else {
                    ReadErrorKind::CountTooLarge { what, promised, remaining, most }
                },
            ));
        }
        Ok(n as u64)
    }

    fn skip_property(&mut self, property: &Property) -> Result<(), Fail> {
        let n = match property.list {
            Some(length) => self.length(length, property.item)?,
            None => 1,
        };
        self.skip(property.item, n)
    }
}

struct Reader<'a> {
    body: Body<'a>,
    /// Vertices that the header promises.
    vertices: u64,
    soup: Soup,
    corners: Vec<u32>,
}

impl Reader<'_> {
    fn vertices(&mut self, element: &Element, ticker: &mut Ticker<'_>) -> Result<(), Fail> {
        let has = |role: usize| element.properties.iter().any(|p| p.role == Role::Number(role));
        let has_normals = (3..6).all(has);
        let has_colors = (6..9).all(has);
        let n = element.count as usize;
        self.soup.vertices_in_file = element.count;
        let mesh = &mut self.soup.mesh;
        mesh.positions.reserve_exact(n);
        mesh.vertex.normals.reserve_exact(if has_normals { n } else { 0 });
        mesh.vertex.colors.reserve_exact(if has_colors { n } else { 0 });
        for _ in 0..n {
            let mut values = [0f32; 10];
            values[9] = 255.0;
            for property in &element.properties {
                let Role::Number(slot) = property.role else {
                    self.body.skip_property(property)?;
                    continue;
                };
                if let Body::Text(text) = &mut self.body {
                    // Also moves an error about the number to the number.
                    text.skip_space();
                }
                let at = self.body.at();
                let value = self.body.number(property.item, COORDINATES[slot])?;
                values[slot] = value as f32;
                if slot < 3 && !values[slot].is_finite() {
                    return Err(self.body.fail_at(at, ReadErrorKind::NotFinite { what: COORDINATES[slot] }));
                }
                if slot >= 6 {
                    values[slot] = match property.item {
                        Type::F32 | Type::F64 => values[slot] * 255.0,
                        Type::U16 => values[slot] / 257.0,
                        _ => values[slot],
                    };
                }
            }
            self.body.end_row()?;
            mesh.positions.push(Vec3::new(values[0], values[1], values[2]));
            if has_normals {
                mesh.vertex.normals.push(Vec3::new(values[3], values[4], values[5]));
            }
            if has_colors {
                let channel = |slot: usize| values[slot].round().clamp(0.0, 255.0) as u8;
                mesh.vertex.colors.push([channel(6), channel(7), channel(8), channel(9)]);
            }
            ticker.at(self.body.at());
        }
        Ok(())
    }

    /// Faces, strips, and what we have no use for.
    fn others(&mut self, element: &Element, ticker: &mut Ticker<'_>) -> Result<(), Fail> {
        if element.properties.is_empty() {
            return Ok(());
        }
        let corners = element.properties.iter().position(|p| p.role == Role::Corners);
        let is_strips = element.name == "tristrips";
        if let (Some(c), false) = (corners, is_strips) {
            // Bytes of a row with three corners: no more triangles than this can come of faces of three.
            let triangle = self.body.least_row(element)
                + 3 * if matches!(self.body, Body::Text(_)) { 2 } else { element.properties[c].item.size() };
            self.soup.mesh.triangles.reserve((element.count as usize).min(self.body.remaining() / triangle + 1));
        }
        for _ in 0..element.count {
            for property in &element.properties {
                match (property.role, property.list) {
                    (Role::Corners, Some(length)) if is_strips => self.strip(length, property.item)?,
                    (Role::Corners, Some(length)) => {
                        let at = self.body.at();
                        let n = self.body.length(length, property.item)?;
                        Soup::check_corners(n as usize).map_err(|kind| self.body.fail_at(at, kind))?;
                        self.corners.clear();
                        for _ in 0..n {
                            let index = self.index(property.item)?;
                            self.corners.push(index);
                        }
                        self.soup.push_face(&self.corners);
                    }
                    _ => self.body.skip_property(property)?,
                }
            }
            self.body.end_row()?;
            ticker.at(self.body.at());
        }
        Ok(())
    }

    #[inline]
    fn index(&mut self, item: Type) -> Result<u32, Fail> {
        if let Body::Text(text) = &mut self.body {
            text.skip_space();
        }
        let at = self.body.at();
        let index = self.body.integer(item, "a vertex index")?;
        if index < 0 || index as u64 >= self.vertices {
            return Err(self.out_of_range(at, index));
        }
        Ok(index as u32)
    }

    #[cold]
    fn out_of_range(&self, at: usize, index: i64) -> Fail {
        let kind = ReadErrorKind::IndexOutOfRange { what: "vertex", index, count: self.vertices, first: 0 };
        self.body.fail_at(at, kind)
    }

    /// One list of strips, with -1 between them: each index makes a triangle with the two before it, every second one
    /// turned. Triangles with a repeated corner only steer the strip and are no faces.
    fn strip(&mut self, length: Type, item: Type) -> Result<(), Fail> {
        let n = self.body.length(length, item)?;
        self.corners.clear();
        for _ in 0..n {
            if let Body::Text(text) = &mut self.body {
                text.skip_space();
            }
            let at = self.body.at();
            let index = self.body.integer(item, "a vertex index or -1")?;
            if index == -1 {
                self.corners.clear();
                continue;
            }
            if index < 0 || index as u64 >= self.vertices {
                return Err(self.out_of_range(at, index));
            }
            self.corners.push(index as u32);
            if let [.., a, b, c] = self.corners[..]
                && a != b
                && b != c
                && c != a
            {
                let turned = self.corners.len().is_multiple_of(2);
                self.soup.push_face(&if turned { [b, a, c] } else { [a, b, c] });
            }
        }
        Ok(())
    }
}

pub(super) fn write(out: &mut impl Write, mesh: &TriangleMesh) -> io::Result<()> {
    let (normals, colors) = (&mesh.vertex.normals, &mesh.vertex.colors);
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.positions.len());
    header += "property float x\nproperty float y\nproperty float z\n";
    if !normals.is_empty() {
        header += "property float nx\nproperty float ny\nproperty float nz\n";
    }
    if !colors.is_empty() {
        header += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    }
    // Most readers expect signed indices; unsigned ones only where they are needed.
    let index = if mesh.positions.len() > i32::MAX as usize { "uint" } else { "int" };
    header +=
        &format!("element face {}\nproperty list uchar {index} vertex_indices\nend_header\n", mesh.triangles.len());
    out.write_all(header.as_bytes())?;
    for (i, p) in mesh.positions.iter().enumerate() {
        write_vector(out, p)?;
        if let Some(n) = normals.get(i) {
            write_vector(out, n)?;
        }
        if let Some(rgba) = colors.get(i) {
            out.write_all(rgba)?;
        }
    }
    for corners in &mesh.triangles {
        let mut row = [3; 13];
        row[1..].copy_from_slice(bytemuck::cast_slice(&corners.map(|VertexId(v)| v.to_le_bytes())));
        out.write_all(&row)?;
    }
    Ok(())
}

fn write_vector(out: &mut impl Write, v: &Vec3) -> io::Result<()> {
    out.write_all(bytemuck::cast_slice(&v.to_array().map(f32::to_le_bytes)))
}
