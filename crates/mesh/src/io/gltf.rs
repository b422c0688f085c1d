//! glTF 2.0: `.glb`, and `.gltf` with its buffers inside or beside it.
//!
//! All triangle primitives of the scene become one mesh, in world space: each node's transform is applied, a mirroring
//! one turns the triangles. Skins and morph targets stay in their rest pose; materials and textures are skipped.
//!
//! `serde_json` reads the JSON into the few structures below, and every index and byte range is checked where it is
//! used. The crate `gltf` (1.4.1) does not keep our promises: `Gltf::from_slice` panics on a primitive whose POSITION
//! accessor does not exist and (with overflow checks) on a header length below 12, reads nothing where an accessor leaves its view, and
//! refuses legal files (a scene without nodes, quantized positions, unknown chunks).

use std::borrow::Cow;
use std::fs;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use glam::{DMat3, DMat4, DQuat, DVec3, Vec3};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::Ticker;
use super::error::{Fail, ReadErrorKind, quote};
use super::soup::Soup;
use crate::{Bounds, TriangleMesh};

/// A scene may show a mesh many times. Merged, its columns may take this many times the bytes of the file ...
const MOST_GROWTH: usize = 16;
/// ... or this many, whichever is more.
const ALWAYS_GROWS_TO: usize = 64 << 20;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Root<'a> {
    #[serde(borrow)]
    asset: Asset<'a>,
    scene: Option<usize>,
    #[serde(default)]
    scenes: Vec<Scene>,
    /// [`Node`]s, unread: in a file one may take three bytes, here a hundred.
    #[serde(borrow, default)]
    nodes: Vec<&'a RawValue>,
    #[serde(default)]
    meshes: Vec<Mesh>,
    #[serde(default)]
    accessors: Vec<Accessor>,
    #[serde(default)]
    buffer_views: Vec<View>,
    #[serde(borrow, default)]
    buffers: Vec<Buffer<'a>>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
struct Asset<'a> {
    #[serde(borrow)]
    version: Cow<'a, str>,
}

#[derive(Deserialize)]
struct Scene {
    #[serde(default)]
    nodes: Vec<usize>,
}

#[derive(Deserialize)]
struct Node {
    #[serde(default)]
    children: Vec<usize>,
    mesh: Option<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct Mesh {
    #[serde(default)]
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    mode: Option<u32>,
}

#[derive(Deserialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
    #[serde(rename = "NORMAL")]
    normal: Option<usize>,
    #[serde(rename = "COLOR_0")]
    color: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    #[serde(default)]
    normalized: bool,
    count: usize,
    #[serde(rename = "type")]
    shape: Shape,
    sparse: Option<Box<Sparse>>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
enum Shape {
    #[serde(rename = "SCALAR")]
    Scalar,
    #[serde(rename = "VEC3")]
    Vec3,
    #[serde(rename = "VEC4")]
    Vec4,
    #[serde(other)]
    Other,
}

#[derive(Deserialize)]
struct Sparse {
    count: usize,
    indices: SparsePart,
    values: SparsePart,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SparsePart {
    buffer_view: usize,
    #[serde(default)]
    byte_offset: usize,
    component_type: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Buffer<'a> {
    #[serde(borrow)]
    uri: Option<Cow<'a, str>>,
    byte_length: usize,
}

pub(super) fn read(bytes: &[u8], folder: Option<&Path>, ticker: &mut Ticker<'_>) -> Result<Soup, Fail> {
    let (json, binary) = if bytes.starts_with(b"glTF") { split_container(bytes)? } else { (bytes, None) };
    let root: Root<'_> = serde_json::from_slice(json).map_err(|error| {
        let kind = ReadErrorKind::Unexpected { expected: "glTF as JSON".to_owned(), found: error.to_string() };
        if bytes.len() == json.len() && error.line() > 0 {
            Fail { place: super::Place::Line(error.line() as u64), kind }
        } else {
            Fail::file(kind)
        }
    })?;
    if !root.asset.version.starts_with("2.") {
        return Err(unsupported(
            format!("version {} of glTF", quote(root.asset.version.as_bytes())),
            "export glTF 2.0",
        ));
    }
    // Quantization only allows more types of numbers, which we read; the texture extensions are about pictures.
    const FINE: [&str; 4] =
        ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_texture_basisu", "KHR_materials_unlit"];
    if let Some(name) = root.extensions_required.iter().find(|e| !FINE.contains(&e.as_str())) {
        let remedy = if name.contains("draco") || name.contains("meshopt") {
            "export it without mesh compression"
        } else {
            "export it without this extension"
        };
        return Err(unsupported(format!("the glTF extension {}", quote(name.as_bytes())), remedy));
    }
    let buffers =
        root.buffers.iter().enumerate().map(|(i, b)| buffer(b, i, binary, folder)).collect::<Result<Vec<_>, _>>()?;
    let size = bytes.len() + buffers.iter().map(|b| b.len()).sum::<usize>();
    let most = size.saturating_mul(MOST_GROWTH).max(ALWAYS_GROWS_TO);
    let mut merge = Merge { root: &root, buffers: &buffers, soup: Soup::default(), read: 0, most };
    merge.scene(ticker)?;
    Ok(merge.soup)
}

fn unsupported(what: String, remedy: &'static str) -> Fail {
    Fail::file(ReadErrorKind::Unsupported { what, remedy })
}

fn unexpected(expected: impl Into<String>, found: impl Into<String>) -> Fail {
    Fail::file(ReadErrorKind::Unexpected { expected: expected.into(), found: found.into() })
}

/// The JSON and the binary chunk of a `.glb`: twelve bytes of header, then chunks of length, kind and bytes.
fn split_container(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fail> {
    let word = |at: usize| bytes.get(at..at + 4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]) as usize);
    let truncated = |what: &str| Fail::byte(bytes.len(), ReadErrorKind::Truncated { expected: what.to_owned() });
    let (Some(version), Some(length)) = (word(4), word(8)) else { return Err(truncated("the header of a GLB")) };
    if version != 2 {
        return Err(unsupported(format!("version {version} of GLB"), "export glTF 2.0"));
    }
    if length > bytes.len() {
        let what = "bytes".to_owned();
        let (promised, remaining) = (length as u64, bytes.len() as u64);
        return Err(Fail::byte(8, ReadErrorKind::CountTooLarge { what, promised, remaining, most: remaining }));
    }
    let mut at = 12;
    let (mut json, mut binary) = (None, None);
    while let (Some(length), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) {
        let Some(chunk) = bytes[at + 8..].get(..length) else { return Err(truncated("the rest of a chunk")) };
        match kind {
            b"JSON" => json = json.or(Some(chunk)),
            b"BIN\0" => binary = binary.or(Some(chunk)),
            // Other kinds are for extensions.
            _ => {}
        }
        at += 8 + length;
    }
    json.map(|json| (json, binary)).ok_or_else(|| truncated("a JSON chunk"))
}

/// The bytes of a buffer: the container's, a data URI's, or those of a file in the folder of the `.gltf`.
fn buffer<'a>(
    buffer: &Buffer<'_>,
    number: usize,
    binary: Option<&'a [u8]>,
    folder: Option<&Path>,
) -> Result<Cow<'a, [u8]>, Fail> {
    let bytes = match &buffer.uri {
        None => Cow::Borrowed(binary.filter(|_| number == 0).unwrap_or_default()),
        Some(uri) if uri.starts_with("data:") => {
            let data = uri.split_once(";base64,").map(|(_, data)| data);
            let decoded = data.and_then(|d| base64::engine::general_purpose::STANDARD.decode(d).ok());
            Cow::Owned(decoded.ok_or_else(|| unexpected(format!("buffer {number} in base64"), "something else"))?)
        }
        Some(uri) => {
            let Some(folder) = folder else {
                return Err(unsupported(format!("buffer {number} in a file of its own"), "use a .glb"));
            };
            let name = PathBuf::from(percent_decoded(uri));
            // A mesh has no business outside of its folder.
            if uri.contains("://") || !name.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir))
            {
                let what = format!("buffer {number} at {}", quote(uri.as_bytes()));
                return Err(unsupported(what, "put it beside the .gltf, or use a .glb"));
            }
            let path = folder.join(name);
            let is_file = fs::metadata(&path).and_then(|m| match m.is_file() {
                true => Ok(()),
                false => Err(io::Error::other("not a file")),
            });
            let bytes = is_file.and_then(|()| fs::read(&path)).map_err(|e| {
                let what = format!("{}: {e}", path.display());
                Fail::file(ReadErrorKind::Io(io::Error::new(e.kind(), what)))
            })?;
            Cow::Owned(bytes)
        }
    };
    if bytes.len() < buffer.byte_length {
        let (expected, found) = (format!("{} bytes in buffer {number}", buffer.byte_length), bytes.len());
        return Err(unexpected(expected, format!("{found}; the file was probably cut short: copy or export it again")));
    }
    Ok(bytes)
}

fn percent_decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let code = uri.get(i + 1..i + 3).filter(|_| bytes[i] == b'%').and_then(|hex| u8::from_str_radix(hex, 16).ok());
        out.push(code.unwrap_or(bytes[i]));
        i += if code.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// Equal items at equal distances in a buffer.
#[derive(Clone, Copy)]
struct Rows<'a> {
    bytes: &'a [u8],
    stride: usize,
    item: usize,
    count: usize,
}

impl<'a> Rows<'a> {
    fn row(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..][..self.item]
    }
}

struct Merge<'a> {
    root: &'a Root<'a>,
    buffers: &'a [Cow<'a, [u8]>],
    soup: Soup,
    /// Bytes of accessors read, for the progress.
    read: usize,
    /// Most bytes that the columns may take.
    most: usize,
}

impl<'a> Merge<'a> {
    fn scene(&mut self, ticker: &mut Ticker<'_>) -> Result<(), Fail> {
        let root = self.root;
        if root.nodes.is_empty() {
            for mesh in &root.meshes {
                self.mesh(mesh, DMat4::IDENTITY, ticker)?;
            }
        }
        let roots = match (root.scene, root.scenes.first()) {
            (Some(i), _) => look_up(&root.scenes, i, "scene")?.nodes.clone(),
            (None, Some(scene)) => scene.nodes.clone(),
            // A library of parts: whatever has no parent.
            (None, None) => {
                let mut is_child = vec![false; root.nodes.len()];
                for i in 0..root.nodes.len() {
                    for child in self.node(i)?.children {
                        if let Some(flag) = is_child.get_mut(child) {
                            *flag = true;
                        }
                    }
                }
                (0..root.nodes.len()).filter(|&i| !is_child[i]).collect()
            }
        };
        let mut seen = vec![false; root.nodes.len()];
        // For each level above the current node: the siblings still to come, and where their parent is.
        let mut path = vec![(roots.into_iter(), DMat4::IDENTITY)];
        while let Some((siblings, world_from_parent)) = path.last_mut() {
            let Some(i) = siblings.next() else {
                path.pop();
                continue;
            };
            let node = self.node(i)?;
            if std::mem::replace(&mut seen[i], true) {
                return Err(unexpected("a tree of nodes", format!("node {i} with two parents")));
            }
            let world_from_node = *world_from_parent * parent_from_node(&node);
            if let Some(mesh) = node.mesh {
                self.mesh(look_up(&root.meshes, mesh, "mesh")?, world_from_node, ticker)?;
            }
            if !node.children.is_empty() {
                path.push((node.children.into_iter(), world_from_node));
            }
        }
        Ok(())
    }

    fn node(&self, i: usize) -> Result<Node, Fail> {
        let json = look_up(&self.root.nodes, i, "node")?.get();
        serde_json::from_str(json).map_err(|error| unexpected(format!("node {i}"), error.to_string()))
    }

    fn mesh(&mut self, mesh: &Mesh, world_from_mesh: DMat4, ticker: &mut Ticker<'_>) -> Result<(), Fail> {
        for primitive in &mesh.primitives {
            match primitive.mode.unwrap_or(4) {
                0..=3 => self.soup.primitives_skipped += 1,
                mode @ 4..=6 => self.primitive(primitive, mode, world_from_mesh)?,
                mode => return Err(unexpected("a primitive mode from 0 to 6", mode.to_string())),
            }
            ticker.at(self.read.min(ticker.total as usize));
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, mode: u32, world_from_mesh: DMat4) -> Result<(), Fail> {
        let Some(position) = primitive.attributes.position else {
            return Err(unexpected("the attribute POSITION", "a primitive without one"));
        };
        let positions = self.vectors::<3>(position)?;
        let n = positions.len();
        let first = self.soup.mesh.positions.len();
        self.soup.vertices_in_file += n as u64;

        let linear = DMat3::from_mat4(world_from_mesh);
        let is_identity = world_from_mesh == DMat4::IDENTITY;
        for p in positions {
            let point = match is_identity {
                true => Vec3::from(p),
                false => world_from_mesh.transform_point3(Vec3::from(p).as_dvec3()).as_vec3(),
            };
            if !point.is_finite() {
                return Err(Fail::file(ReadErrorKind::NotFinite { what: "a coordinate" }));
            }
            self.soup.mesh.positions.push(point);
        }

        // Columns that only some primitives have: zero normals are recomputed later, and no colour is white.
        let same_length = |len: usize, what: &str| match len == n {
            true => Ok(()),
            false => Err(unexpected(format!("{n} {what}, as many as positions"), len.to_string())),
        };
        if let Some(normal) = primitive.attributes.normal {
            let normals = self.vectors::<3>(normal)?;
            same_length(normals.len(), "normals")?;
            // The inverse transpose but for its length, and so also right for flat matrices.
            let turn = cofactors(linear) * linear.determinant().signum();
            let column = &mut self.soup.mesh.vertex.normals;
            column.resize(first, Vec3::ZERO);
            column.extend(normals.into_iter().map(|n| match is_identity {
                true => Vec3::from(n),
                false => (turn * Vec3::from(n).as_dvec3()).normalize_or_zero().as_vec3(),
            }));
        }
        if let Some(color) = primitive.attributes.color {
            let colors = self.vectors::<4>(color)?;
            same_length(colors.len(), "colours")?;
            let column = &mut self.soup.mesh.vertex.colors;
            column.resize(first, [255; 4]);
            column.extend(colors.into_iter().map(|c| c.map(|x| (x * 255.0).round().clamp(0.0, 255.0) as u8)));
        }
        if !self.soup.mesh.vertex.normals.is_empty() {
            self.soup.mesh.vertex.normals.resize(first + n, Vec3::ZERO);
        }
        if !self.soup.mesh.vertex.colors.is_empty() {
            self.soup.mesh.vertex.colors.resize(first + n, [255; 4]);
        }

        let corners = match primitive.indices {
            Some(indices) => self.indices(indices, n)?,
            None => (0..n as u32).collect(),
        };
        let triangles = if mode == 4 { corners.len() / 3 } else { corners.len().saturating_sub(2) };
        if mode == 4 && !corners.len().is_multiple_of(3) {
            return Err(unexpected("three corners to each triangle", format!("{} corners", corners.len())));
        }
        self.check_growth(0, triangles)?;
        let mirrored = linear.determinant() < 0.0;
        let first = first as u32;
        for t in 0..triangles {
            let [a, mut b, mut c] = match mode {
                4 => [corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]],
                5 if t % 2 == 1 => [corners[t + 1], corners[t], corners[t + 2]],
                5 => [corners[t], corners[t + 1], corners[t + 2]],
                _ => [corners[0], corners[t + 1], corners[t + 2]],
            };
            if mirrored {
                std::mem::swap(&mut b, &mut c);
            }
            self.soup.push_face(&[first + a, first + b, first + c]);
        }
        self.soup.check_size()
    }

    /// Refuses what would take too much memory, before it does.
    fn check_growth(&self, vertices: usize, triangles: usize) -> Result<(), Fail> {
        let mesh = &self.soup.mesh;
        let bytes = |n: usize, size: usize, more: usize| n.saturating_add(more).saturating_mul(size);
        // 28 bytes for position, normal and colour.
        let total =
            bytes(mesh.positions.len(), 28, vertices).saturating_add(bytes(mesh.triangles.len(), 12, triangles));
        if total <= self.most {
            return Ok(());
        }
        let what = format!("a scene that grows from its file to {total} bytes or more");
        Err(unsupported(what, "export the mesh without its copies (instances)"))
    }

    /// The items of a view that an accessor, or its sparse part, wants.
    fn rows(&self, view: usize, offset: usize, item: usize, count: usize) -> Result<Rows<'a>, Fail> {
        let (root, buffers) = (self.root, self.buffers);
        let outside = || unexpected(format!("{count} items of {item} bytes in buffer view {view}"), "fewer bytes");
        let v = look_up(&root.buffer_views, view, "buffer view")?;
        let buffer = look_up(buffers, v.buffer, "buffer")?;
        let end = v.byte_offset.checked_add(v.byte_length).filter(|&end| end <= buffer.len());
        let Some(end) = end else {
            return Err(unexpected(format!("buffer view {view} within its buffer"), "a longer one"));
        };
        let bytes = buffer[v.byte_offset..end].get(offset..).ok_or_else(outside)?;
        let stride = v.byte_stride.unwrap_or(item);
        if stride < item {
            return Err(unexpected(format!("a stride of {item} bytes or more"), stride.to_string()));
        }
        let needed = count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(item));
        if needed.is_none_or(|n| n > bytes.len()) {
            return Err(outside());
        }
        Ok(Rows { bytes, stride, item, count })
    }

    /// The numbers of an accessor of three or four columns as fractions or plain numbers; a missing fourth is 1.
    fn vectors<const N: usize>(&mut self, accessor: usize) -> Result<Vec<[f32; N]>, Fail> {
        let a = look_up(&self.root.accessors, accessor, "accessor")?;
        let columns = match a.shape {
            Shape::Vec3 => 3,
            Shape::Vec4 if N == 4 => 4,
            _ => return Err(unexpected(format!("vectors of {N} in accessor {accessor}"), "another type")),
        };
        let size = component_size(a.component_type, accessor)?;
        self.check_growth(a.count, 0)?;
        let decode = |row: &[u8]| {
            let mut vector = [1.0; N];
            for (slot, bytes) in vector.iter_mut().zip(row.chunks_exact(size)) {
                *slot = component(bytes, a.component_type, a.normalized);
            }
            vector
        };
        let zero = decode(&[0; 16][..columns * size]);
        let mut vectors = match a.buffer_view {
            Some(view) => {
                let rows = self.rows(view, a.byte_offset, columns * size, a.count)?;
                (0..rows.count).map(|i| decode(rows.row(i))).collect()
            }
            None => vec![zero; a.count],
        };
        if let Some(sparse) = &a.sparse {
            let places = self.integers(
                sparse.indices.buffer_view,
                sparse.indices.byte_offset,
                sparse.indices.component_type.unwrap_or(0),
                sparse.count,
                accessor,
                a.count,
            )?;
            let rows = self.rows(sparse.values.buffer_view, sparse.values.byte_offset, columns * size, sparse.count)?;
            for (i, place) in places.into_iter().enumerate() {
                vectors[place as usize] = decode(rows.row(i));
            }
        }
        self.read += a.count * columns * size;
        Ok(vectors)
    }

    /// The indices of a primitive of `vertices` vertices.
    fn indices(&mut self, accessor: usize, vertices: usize) -> Result<Vec<u32>, Fail> {
        let a = look_up(&self.root.accessors, accessor, "accessor")?;
        let (Shape::Scalar, Some(view), None) = (a.shape, a.buffer_view, &a.sparse) else {
            return Err(unexpected(format!("plain indices in accessor {accessor}"), "another kind"));
        };
        self.check_growth(0, a.count / 3)?;
        self.read += 4 * a.count;
        self.integers(view, a.byte_offset, a.component_type, a.count, accessor, vertices)
    }

    /// Unsigned integers below `limit`.
    fn integers(
        &self,
        view: usize,
        offset: usize,
        component: u32,
        count: usize,
        accessor: usize,
        limit: usize,
    ) -> Result<Vec<u32>, Fail> {
        if !matches!(component, 5121 | 5123 | 5125) {
            return Err(unexpected(format!("unsigned integers in accessor {accessor}"), format!("type {component}")));
        }
        let rows = self.rows(view, offset, component_size(component, accessor)?, count)?;
        let mut integers = Vec::with_capacity(count);
        for i in 0..count {
            let index = match *rows.row(i) {
                [a] => u32::from(a),
                [a, b] => u32::from(u16::from_le_bytes([a, b])),
                [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
                _ => 0,
            };
            if index as usize >= limit {
                let (index, count) = (i64::from(index), limit as u64);
                return Err(Fail::file(ReadErrorKind::IndexOutOfRange { what: "vertex", index, count, first: 0 }));
            }
            integers.push(index);
        }
        Ok(integers)
    }
}

fn look_up<'a, T>(list: &'a [T], index: usize, what: &'static str) -> Result<&'a T, Fail> {
    list.get(index).ok_or_else(|| {
        let (index, count) = (index as i64, list.len() as u64);
        Fail::file(ReadErrorKind::IndexOutOfRange { what, index, count, first: 0 })
    })
}

fn parent_from_node(node: &Node) -> DMat4 {
    if let Some(matrix) = &node.matrix {
        return DMat4::from_cols_array(matrix);
    }
    let scale = node.scale.map_or(DVec3::ONE, DVec3::from);
    let rotation = node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
    let translation = node.translation.map_or(DVec3::ZERO, DVec3::from);
    // A quaternion that is not a unit one would scale.
    let length = rotation.length();
    let rotation = if length > 0.0 && length.is_finite() { rotation / length } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(scale, rotation, translation)
}

fn cofactors(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

fn component_size(component: u32, accessor: usize) -> Result<usize, Fail> {
    match component {
        5120 | 5121 => Ok(1),
        5122 | 5123 => Ok(2),
        5125 | 5126 => Ok(4),
        other => Err(unexpected(format!("a type of number in accessor {accessor}"), other.to_string())),
    }
}

/// One number; integers are fractions of the greatest of their type where they are `normalized`.
fn component(bytes: &[u8], component: u32, normalized: bool) -> f32 {
    let (value, greatest) = match (component, bytes) {
        (5120, &[a]) => (f32::from(a as i8), 127.0),
        (5121, &[a]) => (f32::from(a), 255.0),
        (5122, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (5123, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
        (5125, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32),
        (_, &[a, b, c, d]) => (f32::from_le_bytes([a, b, c, d]), 1.0),
        _ => (0.0, 1.0),
    };
    if normalized && component != 5126 { (value / greatest).max(-1.0) } else { value }
}

pub(super) fn write(out: &mut impl Write, mesh: &TriangleMesh) -> io::Result<()> {
    let (n, normals, colors) = (mesh.positions.len(), &mesh.vertex.normals, &mesh.vertex.colors);
    let bounds = mesh.bounds().unwrap_or(Bounds { min: Vec3::ZERO, max: Vec3::ZERO });
    let Bounds { min, max } = bounds;
    // One view and one accessor for each column; targets 34962 and 34963 are vertices and indices.
    let (mut views, mut accessors, mut length) = (Vec::new(), Vec::new(), 0);
    let mut column = |bytes: usize, target: u32, accessor: String| {
        views.push(format!(r#"{{"buffer":0,"byteOffset":{length},"byteLength":{bytes},"target":{target}}}"#));
        accessors.push(format!(r#"{{"bufferView":{},{accessor}}}"#, accessors.len()));
        length += bytes;
        accessors.len() - 1
    };
    let range = format!(r#""min":[{},{},{}],"max":[{},{},{}]"#, min.x, min.y, min.z, max.x, max.y, max.z);
    let of = |count: usize, component: u32, shape: &str| {
        format!(r#""componentType":{component},"count":{count},"type":"{shape}""#)
    };
    let mut attributes = format!(r#""POSITION":{}"#, column(12 * n, 34962, format!("{},{range}", of(n, 5126, "VEC3"))));
    if !normals.is_empty() {
        attributes += &format!(r#","NORMAL":{}"#, column(12 * n, 34962, of(n, 5126, "VEC3")));
    }
    if !colors.is_empty() {
        attributes +=
            &format!(r#","COLOR_0":{}"#, column(4 * n, 34962, format!(r#"{},"normalized":true"#, of(n, 5121, "VEC4"))));
    }
    let corners = 3 * mesh.triangles.len();
    let indices = column(4 * corners, 34963, of(corners, 5125, "SCALAR"));
    let (views, accessors) = (views.join(","), accessors.join(","));
    let mut json =
        r#"{"asset":{"version":"2.0","generator":"Meshfront"},"scene":0,"scenes":[{"nodes":[0]}],"#.to_owned();
    json += &format!(
        r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{{attributes}}},"indices":{indices}}}]}}],"#
    );
    json += &format!(r#""accessors":[{accessors}],"bufferViews":[{views}],"buffers":[{{"byteLength":{length}}}]}}"#);
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }

    out.write_all(b"glTF")?;
    for word in [2, 12 + 8 + json.len() + 8 + length, json.len()] {
        out.write_all(&(word as u32).to_le_bytes())?;
    }
    out.write_all(b"JSON")?;
    out.write_all(json.as_bytes())?;
    out.write_all(&(length as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    for v in mesh.positions.iter().chain(normals) {
        out.write_all(bytemuck::cast_slice(&v.to_array().map(f32::to_le_bytes)))?;
    }
    for rgba in colors {
        out.write_all(rgba)?;
    }
    for corners in &mesh.triangles {
        out.write_all(bytemuck::cast_slice(&corners.map(|v| v.0.to_le_bytes())))?;
    }
    Ok(())
}
