//! The sections of the model `edge_collapse`: `Columns` to bytes and back. `docs/format.md` has them byte by byte.
//!
//! ```text
//! META │ BASE │ BNRM BCOL │ UTAB │ NTAB CTAB │ UPDT: page page page … │ NRML: page … │ COLR: page …
//!             if the base has them            coarse ──────────▶ fine
//! ```
//!
//! Tables and base mesh come before all pages, so that a first request for a few kilobytes tells where everything is,
//! and every page can be fetched, checked and unpacked by itself. Only the sums along the splits run through all pages.

use glam::{DVec3, Vec3};
use meshfront_hierarchies::SourceCounts;
use meshfront_hierarchies::edge_collapse::{Columns, Grid, Oct};
#[cfg(feature = "write")]
use meshfront_hierarchies::edge_collapse::{InvalidColumns, round_error_up};
use meshfront_mesh::{TriangleMesh, VertexColumns, VertexId};

use crate::container::{self, Section, checksum, u32_at, u64_at};
#[cfg(feature = "write")]
use crate::container::{Codec, Part, assemble};
#[cfg(feature = "write")]
use crate::error::EncodeError;
use crate::error::{Fault, ReadError};
use crate::parallel::map_all;
use crate::rans::{Decoder, decode_int, int_models};
#[cfg(feature = "write")]
use crate::rans::{Encoder, encode_int};
use attributes::{Attribute, value_of};
#[cfg(feature = "write")]
use lattice::split_residual;
use lattice::{Lattice, split_from_residual};

pub(crate) mod attributes;
mod info;
pub(crate) mod lattice;
pub(crate) mod page;

pub use info::inspect;
pub(crate) use info::{info_of, inspect_splits};
pub(crate) use lattice::of_ordered_bits;
#[cfg(feature = "write")]
pub(crate) use lattice::ordered_bits;

/// The model's name in the header.
pub const MODEL: &str = "edge_collapse";

/// Updates in a page that is not the last: some 30 kB, a good size for a request, and long enough for the models to
/// have learnt most of what they can.
pub const PAGE_UPDATES: usize = 4096;

/// Every section of this model, in the order of the file.
pub(crate) const SECTIONS: [&str; 10] =
    ["META", "BASE", "BNRM", "BCOL", "UTAB", "NTAB", "CTAB", "UPDT", "NRML", "COLR"];

const META_LENGTH: usize = 64;
const UPDATE_ROW: usize = 16;
const ATTRIBUTE_ROW: usize = 8;

/// Bits of the first number of META.
const HAS_GRID: u32 = 1;
pub(crate) const HAS_BASE_NORMALS: u32 = 2;
pub(crate) const HAS_BASE_COLORS: u32 = 4;
pub(crate) const HAS_NORMALS: u32 = 8;
pub(crate) const HAS_COLORS: u32 = 16;

/// What META holds.
#[derive(Clone, Copy)]
pub(crate) struct Meta {
    pub flags: u32,
    pub grid: Option<Grid>,
    pub base_vertices: usize,
    pub base_triangles: usize,
    pub updates: usize,
    pub floor_error: f32,
    pub source: SourceCounts,
}

impl Meta {
    pub(crate) fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }
}

/// Columns as the bytes of a file, whole.
///
/// Errors are rounded with [`round_error_up`]; everything else comes back from [`decode`] bit for bit (on a grid, a
/// coordinate of −0 comes back as 0). The same columns give the same bytes, on any number of threads.
///
/// # Errors
/// Columns of unequal lengths or with ids out of range; positions that are not finite or not on the grid; errors that
/// are negative or not finite. Whether every split can be applied is not checked here: `EdgeCollapse::new` does that.
#[cfg(feature = "write")]
pub fn encode(columns: &Columns) -> Result<Vec<u8>, EncodeError> {
    check(columns)?;
    pack(columns)
}

/// Packs columns that passed `check`.
#[cfg(feature = "write")]
fn pack(columns: &Columns) -> Result<Vec<u8>, EncodeError> {
    let Columns { grid, base, vertex, positions, normals, colors, errors, floor_error, source, .. } = columns;
    let (grid, floor_error, source) = (*grid, *floor_error, *source);
    let splits = Splits { grid, base, vertex, positions, normals, colors, errors, floor_error, source };
    let explicit = |m: usize| columns.explicit.partition_point(|split| split.update.ix() < m);
    pack_splits(MODEL, &splits, &splits.lattice_indices()?, |range, errors, residuals| {
        page::encode_page(&page::PageSource {
            vertex: &vertex[range.clone()],
            sides: &columns.sides[range.clone()],
            explicit: &columns.explicit[explicit(range.start)..explicit(range.end)],
            errors,
            residuals,
        })
    })
}

/// The columns that all models of splits have.
#[cfg(feature = "write")]
pub(crate) struct Splits<'a> {
    pub grid: Option<Grid>,
    pub base: &'a TriangleMesh,
    pub vertex: &'a [VertexId],
    pub positions: &'a [[Vec3; 2]],
    pub normals: &'a [[Oct; 2]],
    pub colors: &'a [[[u8; 4]; 2]],
    pub errors: &'a [f32],
    pub floor_error: f32,
    pub source: SourceCounts,
}

/// The updates of each page.
#[cfg(feature = "write")]
pub(crate) fn page_ranges(updates: usize) -> Vec<std::ops::Range<usize>> {
    (0..updates).step_by(PAGE_UPDATES).map(|at| at..updates.min(at + PAGE_UPDATES)).collect()
}

/// A file of splits, whole. `page` codes the updates of a page, given their errors as stored, and positions as differences.
#[cfg(feature = "write")]
pub(crate) fn pack_splits(
    model: &str,
    splits: &Splits,
    indices: &[[u32; 3]],
    page: impl Fn(std::ops::Range<usize>, &[f32], &[page::Residuals]) -> Vec<u8> + Sync + Send,
) -> Result<Vec<u8>, EncodeError> {
    let Splits { base, vertex, .. } = splits;
    let (base_count, updates) = (base.positions.len(), vertex.len());
    let ranges = page_ranges(updates);
    let pages = map_all(ranges.clone(), |range| {
        let residuals: Vec<_> = range
            .clone()
            .map(|m| {
                let child = base_count + 2 * m;
                split_residual(indices[vertex[m].ix()], indices[child], indices[child + 1])
            })
            .collect();
        let errors: Vec<f32> = splits.errors[range.clone()].iter().map(|&e| round_error_up(e).abs()).collect();
        let bytes = page(range, &errors, &residuals);
        (bytes, errors.into_iter().fold(0.0, f32::max))
    });

    let mut table = Vec::with_capacity(UPDATE_ROW * pages.len());
    let mut body = Vec::new();
    for ((bytes, max_error), range) in pages.iter().zip(&ranges) {
        table.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
        table.extend_from_slice(&(range.len() as u32).to_le_bytes());
        table.extend_from_slice(&max_error.to_le_bytes());
        table.extend_from_slice(&checksum(bytes).to_le_bytes());
        body.extend_from_slice(bytes);
    }

    let meta = Meta {
        flags: flags(splits.grid, base, !splits.normals.is_empty(), !splits.colors.is_empty()),
        grid: splits.grid,
        base_vertices: base_count,
        base_triangles: base.triangles.len(),
        updates,
        floor_error: splits.floor_error,
        source: splits.source,
    };
    let stored = |name, bytes| Part { name, codec: Codec::Stored, bytes };
    let coded = |name, bytes| Part { name, codec: Codec::Rans, bytes };
    let mut head = vec![stored("META", encode_meta(&meta)), coded("BASE", encode_base(base, indices))];
    let mut pages = vec![coded("UPDT", body)];
    let VertexColumns { normals, colors } = &base.vertex;
    let base_normals: Vec<Oct> = normals.iter().map(|&n| Oct::encode(n)).collect();
    if !normals.is_empty() {
        head.push(coded("BNRM", encode_base_normals(normals)));
    }
    if !colors.is_empty() {
        head.push(stored("BCOL", colors.concat()));
    }
    head.push(stored("UTAB", table));
    if !splits.normals.is_empty() {
        let (table, body) = encode_attribute(&base_normals, base_count, vertex, splits.normals, &ranges);
        head.push(stored("NTAB", table));
        pages.push(coded("NRML", body));
    }
    if !splits.colors.is_empty() {
        let (table, body) = encode_attribute(colors, base_count, vertex, splits.colors, &ranges);
        head.push(stored("CTAB", table));
        pages.push(coded("COLR", body));
    }
    head.extend(pages);
    Ok(assemble(model, &head))
}

/// Checks what the encoder relies on, and what the decoder will ask for.
#[cfg(feature = "write")]
fn check(columns: &Columns) -> Result<(), EncodeError> {
    let Columns { base, vertex, sides, explicit, positions, normals, colors, errors, .. } = columns;
    let updates = vertex.len();
    let base_count = base.positions.len();
    let length = |column, found, expected: usize, may_be_absent: bool| match found {
        _ if found == expected || may_be_absent && found == 0 => Ok(()),
        _ => Err(InvalidColumns::Length { column, found, expected }),
    };
    length("sides", sides.len(), updates, false)?;
    length("positions", positions.len(), updates, false)?;
    length("errors", errors.len(), updates, false)?;
    length("normals", normals.len(), updates, true)?;
    length("colors", colors.len(), updates, true)?;
    length("base.vertex.normals", base.vertex.normals.len(), base_count, true)?;
    length("base.vertex.colors", base.vertex.colors.len(), base_count, true)?;
    let most = u32::MAX as usize;
    if base_count.max(base.triangles.len()).saturating_add(2 * updates) > most {
        return Err(InvalidColumns::TooMany(updates).into());
    }
    if base.triangles.iter().flatten().any(|v| v.ix() >= base_count) {
        return Err(InvalidColumns::Base("a triangle names a vertex that does not exist").into());
    }
    if base.vertex.normals.iter().any(|n| !n.is_finite()) {
        return Err(InvalidColumns::Base("a normal is not finite").into());
    }
    let invalid = |m: usize, reason| InvalidColumns::Update { update: m as u32, reason };
    let mut listed = explicit.iter().peekable();
    for m in 0..updates {
        if vertex[m].ix() >= base_count + 2 * m {
            return Err(invalid(m, "splits a vertex that does not exist yet").into());
        }
        if !(errors[m] >= 0.0 && round_error_up(errors[m]).is_finite()) {
            return Err(invalid(m, "error is negative or not finite").into());
        }
        let added = listed.next_if(|split| split.update.ix() == m);
        if added.is_some() != (sides[m] & Columns::EXPLICIT != 0) {
            return Err(invalid(m, "explicit split and its flag do not match").into());
        }
        if added.is_some_and(|s| s.added.len() > 255 || s.added.iter().any(|t| t.star as usize >= Columns::MAX_STAR)) {
            return Err(invalid(m, "an added triangle is outside of the largest star").into());
        }
    }
    if let Some(split) = listed.next() {
        return Err(invalid(split.update.ix(), "explicit splits are not sorted by update").into());
    }
    if !(columns.floor_error >= 0.0 && columns.floor_error.is_finite()) {
        return Err(InvalidColumns::Base("floor error is negative or not finite").into());
    }
    if let Some(reason) = columns.grid.and_then(|grid| grid_fault(&grid)) {
        return Err(EncodeError::Grid(reason));
    }
    Ok(())
}

/// Why a grid cannot be used.
pub(crate) fn grid_fault(grid: &Grid) -> Option<&'static str> {
    let top = grid.origin + DVec3::splat(((1u64 << grid.bits.min(32)) - 1) as f64 * grid.step);
    if !(10..=24).contains(&grid.bits) {
        Some("bits must be 10 to 24")
    } else if !(grid.step > 0.0 && grid.step.is_finite() && grid.origin.is_finite()) {
        Some("step must be positive, step and origin finite")
    } else if !(grid.origin.as_vec3().is_finite() && top.as_vec3().is_finite()) {
        Some("its points are too large")
    } else {
        None
    }
}

#[cfg(feature = "write")]
impl Splits<'_> {
    /// The integers of all vertices, base and children.
    pub(crate) fn lattice_indices(&self) -> Result<Vec<[u32; 3]>, EncodeError> {
        let lattice = Lattice::new(self.grid);
        let base = &self.base.positions;
        let children: &[Vec3] = bytemuck::cast_slice(self.positions);
        const CHUNK: usize = 1 << 14;
        let chunks: Vec<&[Vec3]> = base.chunks(CHUNK).chain(children.chunks(CHUNK)).collect();
        let mut indices = vec![[0; 3]; base.len() + children.len()];
        let (base_indices, child_indices) = indices.split_at_mut(base.len());
        let targets = base_indices.chunks_mut(CHUNK).chain(child_indices.chunks_mut(CHUNK));
        let firsts = map_all(chunks.into_iter().zip(targets).collect(), |(points, indices)| {
            for (i, &p) in points.iter().enumerate() {
                if !p.is_finite() {
                    return Err(i);
                }
                indices[i] = lattice.index(p);
                if lattice.point(indices[i]) != Some(p) {
                    return Err(i);
                }
            }
            Ok(points.len())
        });
        let mut vertex = 0;
        for chunk in firsts {
            match chunk {
                Ok(length) => vertex += length,
                Err(i) if self.grid.is_some() => return Err(EncodeError::OffGrid { vertex: (vertex + i) as u32 }),
                Err(i) if vertex + i < base.len() => {
                    return Err(InvalidColumns::Base("a coordinate is not finite").into());
                }
                Err(i) => {
                    let update = ((vertex + i - base.len()) / 2) as u32;
                    return Err(InvalidColumns::Update { update, reason: "a coordinate is not finite" }.into());
                }
            }
        }
        Ok(indices)
    }
}

/// What is there of attributes and grid, as the first number of META.
#[cfg(feature = "write")]
pub(crate) fn flags(grid: Option<Grid>, base: &TriangleMesh, normals: bool, colors: bool) -> u32 {
    let flag = |set: bool, flag: u32| if set { flag } else { 0 };
    flag(grid.is_some(), HAS_GRID)
        | flag(!base.vertex.normals.is_empty(), HAS_BASE_NORMALS)
        | flag(!base.vertex.colors.is_empty(), HAS_BASE_COLORS)
        | flag(normals, HAS_NORMALS)
        | flag(colors, HAS_COLORS)
}

#[cfg(feature = "write")]
pub(crate) fn encode_meta(meta: &Meta) -> Vec<u8> {
    let Grid { bits, origin, step } = meta.grid.unwrap_or(Grid { bits: 0, origin: DVec3::ZERO, step: 0.0 });
    let mut bytes = Vec::with_capacity(META_LENGTH);
    bytes.extend_from_slice(&meta.flags.to_le_bytes());
    bytes.extend_from_slice(&bits.to_le_bytes());
    for number in [origin.x, origin.y, origin.z, step] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    for count in [meta.base_vertices, meta.base_triangles, meta.updates] {
        bytes.extend_from_slice(&(count as u32).to_le_bytes());
    }
    bytes.extend_from_slice(&meta.floor_error.to_le_bytes());
    bytes.extend_from_slice(&meta.source.vertices.to_le_bytes());
    bytes.extend_from_slice(&meta.source.triangles.to_le_bytes());
    bytes
}

/// `own`: flags of the model besides those that all have.
fn decode_meta(section: Section, own: u32) -> Result<Meta, Fault> {
    let bytes = section.bytes;
    if bytes.len() != META_LENGTH {
        return Err(section.fault(0, "length is not 64"));
    }
    let number = |at| f64::from_bits(u64_at(bytes, at));
    let count = |at| u32_at(bytes, at) as usize;
    let flags = u32_at(bytes, 0);
    if flags & !own >= 2 * HAS_COLORS {
        return Err(section.fault(0, "unknown flags"));
    }
    let grid = Grid { bits: u32_at(bytes, 4), origin: DVec3::new(number(8), number(16), number(24)), step: number(32) };
    let grid = (flags & HAS_GRID != 0).then_some(grid);
    if let Some(reason) = grid.and_then(|grid| grid_fault(&grid)) {
        return Err(section.fault(4, reason));
    }
    let meta = Meta {
        flags,
        grid,
        base_vertices: count(40),
        base_triangles: count(44),
        updates: count(48),
        floor_error: f32::from_bits(u32_at(bytes, 52)),
        source: SourceCounts { vertices: u32_at(bytes, 56), triangles: u32_at(bytes, 60) },
    };
    let ids = meta.base_vertices.max(meta.base_triangles) as u64 + 2 * meta.updates as u64;
    if ids > u32::MAX as u64 {
        return Err(section.fault(40, "more vertices or triangles than 32-bit ids can name"));
    }
    if !(meta.floor_error >= 0.0 && meta.floor_error.is_finite()) {
        return Err(section.fault(52, "floor error is negative or not finite"));
    }
    if meta.updates == 0 && flags & (HAS_NORMALS | HAS_COLORS) != 0 {
        return Err(section.fault(0, "attributes of no updates"));
    }
    Ok(meta)
}

#[cfg(feature = "write")]
pub(crate) fn encode_base(base: &TriangleMesh, indices: &[[u32; 3]]) -> Vec<u8> {
    let mut encoder = Encoder::default();
    let mut models = int_models::<3>();
    let mut before = [0u32; 3];
    for index in &indices[..base.positions.len()] {
        for axis in 0..3 {
            encode_int(&mut encoder, &mut models[axis], index[axis].wrapping_sub(before[axis]) as i32);
        }
        before = *index;
    }
    let positions = encoder.finish();
    let mut encoder = Encoder::default();
    let mut models = int_models::<3>();
    let mut first = 0u32;
    for t in &base.triangles {
        let mut before = first;
        for corner in 0..3 {
            encode_int(&mut encoder, &mut models[corner], t[corner].0.wrapping_sub(before) as i32);
            before = t[corner].0;
        }
        first = t[0].0;
    }
    let triangles = encoder.finish();
    let mut bytes = Vec::new();
    bytes.extend_from_slice(&(positions.len() as u32).to_le_bytes());
    bytes.extend_from_slice(&(triangles.len() as u32).to_le_bytes());
    bytes.extend_from_slice(&positions);
    bytes.extend_from_slice(&triangles);
    // At least a byte each, so that a reader can bound its memory by the file's size.
    bytes.resize(bytes.len().max(base.positions.len() + base.triangles.len()), 0);
    bytes
}

/// The base mesh without attributes, and the integers of its vertices.
pub(crate) fn decode_base(section: Section, meta: &Meta) -> Result<(TriangleMesh, Vec<[u32; 3]>), Fault> {
    let bytes = section.bytes;
    let least = meta.base_vertices + meta.base_triangles;
    if bytes.len() < 8 || bytes.len() < least {
        return Err(section.fault(0, "shorter than its vertices and triangles need"));
    }
    let lengths = [u32_at(bytes, 0) as usize, u32_at(bytes, 4) as usize];
    let end = 8 + lengths[0] as u64 + lengths[1] as u64;
    if end > bytes.len() as u64 {
        return Err(section.fault(0, "streams are longer than the section"));
    }
    let end = end as usize;
    if bytes[end..].iter().any(|&b| b != 0) || bytes.len() > end.max(least) {
        return Err(section.fault(end, "holds more than its streams"));
    }
    let lattice = Lattice::new(meta.grid);

    let mut decoder = Decoder::new(&bytes[8..8 + lengths[0]]);
    let mut models = int_models::<3>();
    let mut indices = vec![[0; 3]; meta.base_vertices];
    let mut positions = vec![Vec3::ZERO; meta.base_vertices];
    let mut index = [0u32; 3];
    for i in 0..meta.base_vertices {
        for axis in 0..3 {
            index[axis] = index[axis].wrapping_add(decode_int(&mut decoder, &mut models[axis]).0 as u32);
        }
        indices[i] = index;
        positions[i] = lattice.point(index).ok_or(section.fault(8, "a base vertex is outside of the grid"))?;
    }
    if !decoder.finish() {
        return Err(section.fault(8, "positions do not end where their stream does"));
    }

    let at = 8 + lengths[0];
    let mut decoder = Decoder::new(&bytes[at..end]);
    let mut models = int_models::<3>();
    let mut triangles = vec![[VertexId(0); 3]; meta.base_triangles];
    let mut first = 0u32;
    for t in &mut triangles {
        let mut before = first;
        for corner in 0..3 {
            before = before.wrapping_add(decode_int(&mut decoder, &mut models[corner]).0 as u32);
            t[corner] = VertexId(before);
        }
        if t.iter().any(|v| v.ix() >= meta.base_vertices) {
            return Err(section.fault(at, "a base triangle names a vertex that does not exist"));
        }
        first = t[0].0;
    }
    if !decoder.finish() {
        return Err(section.fault(at, "triangles do not end where their stream does"));
    }
    Ok((TriangleMesh { positions, triangles, vertex: VertexColumns::default() }, indices))
}

#[cfg(feature = "write")]
pub(crate) fn encode_base_normals(normals: &[Vec3]) -> Vec<u8> {
    let mut encoder = Encoder::default();
    let mut models = int_models::<3>();
    let mut before = [0u32; 3];
    for n in normals {
        let bits = n.to_array().map(ordered_bits);
        for axis in 0..3 {
            encode_int(&mut encoder, &mut models[axis], bits[axis].wrapping_sub(before[axis]) as i32);
        }
        before = bits;
    }
    encoder.finish()
}

pub(crate) fn decode_base_normals(section: Section, count: usize) -> Result<Vec<Vec3>, Fault> {
    let mut decoder = Decoder::new(section.bytes);
    let mut models = int_models::<3>();
    let mut bits = [0u32; 3];
    let normals: Vec<Vec3> = (0..count)
        .map(|_| {
            for axis in 0..3 {
                bits[axis] = bits[axis].wrapping_add(decode_int(&mut decoder, &mut models[axis]).0 as u32);
            }
            Vec3::from_array(bits.map(of_ordered_bits))
        })
        .collect();
    if !decoder.finish() {
        return Err(section.fault(0, "normals do not end where their stream does"));
    }
    if normals.iter().any(|n| !n.is_finite()) {
        return Err(section.fault(0, "a normal is not finite"));
    }
    Ok(normals)
}

pub(crate) fn decode_base_colors(section: Section, count: usize) -> Result<Vec<[u8; 4]>, Fault> {
    let colors = section.bytes.chunks_exact(4);
    if colors.len() != count || !colors.remainder().is_empty() {
        return Err(section.fault(0, "not as long as the base mesh's vertices need"));
    }
    Ok(colors.map(|c| c.try_into().expect("four bytes")).collect())
}

/// Table and pages of an attribute.
#[cfg(feature = "write")]
fn encode_attribute<A: Attribute>(
    base: &[A],
    base_count: usize,
    vertex: &[VertexId],
    children: &[[A; 2]],
    ranges: &[std::ops::Range<usize>],
) -> (Vec<u8>, Vec<u8>) {
    let pages = map_all(ranges.to_vec(), |range| {
        let differences: Vec<_> = range
            .map(|m| {
                let [u, v] = children[m];
                [u.minus(value_of(base, base_count, children, vertex[m].ix())), v.minus(u)]
            })
            .collect();
        attributes::encode_page::<A>(&differences)
    });
    let (mut table, mut body) = (Vec::new(), Vec::new());
    for page in pages {
        table.extend_from_slice(&(page.len() as u32).to_le_bytes());
        table.extend_from_slice(&checksum(&page).to_le_bytes());
        body.extend_from_slice(&page);
    }
    (table, body)
}

/// Pages of an attribute, unpacked and summed along the splits.
fn decode_attribute<A: Attribute>(
    table: Section,
    body: Section,
    rows: &[PageRow],
    base: &[A],
    base_count: usize,
    vertex: &[VertexId],
) -> Result<Vec<[A; 2]>, Fault> {
    if table.bytes.len() != ATTRIBUTE_ROW * rows.len() {
        return Err(table.fault(0, "does not have a row for each page"));
    }
    let mut children = vec![[A::default(); 2]; vertex.len()];
    let mut targets = Vec::with_capacity(rows.len());
    let mut rest = &mut children[..];
    let mut at = 0;
    for (i, row) in rows.iter().enumerate() {
        let length = u32_at(table.bytes, ATTRIBUTE_ROW * i) as usize;
        let page = page_section(body, at, length, u32_at(table.bytes, ATTRIBUTE_ROW * i + 4))?;
        at += length;
        let (target, after) = rest.split_at_mut(row.updates);
        rest = after;
        targets.push((page, target));
    }
    if at != body.bytes.len() {
        return Err(body.fault(at, "bytes that belong to no page"));
    }
    for page in map_all(targets, |(page, target)| attributes::decode_page(page, target)) {
        page?;
    }
    for m in 0..vertex.len() {
        // Both hold differences from zero; adding a difference from zero to a value adds the difference.
        let [u, v] = children[m];
        let u = value_of(base, base_count, &children, vertex[m].ix()).plus(u.minus(A::default()));
        children[m] = [u, u.plus(v.minus(A::default()))];
    }
    Ok(children)
}

/// A row of UTAB, with what follows from the rows before it.
pub(crate) struct PageRow<'a> {
    pub page: Section<'a>,
    pub first: usize,
    pub updates: usize,
    pub max_error: f32,
}

/// A page of a section, its checksum compared.
fn page_section(body: Section<'_>, at: usize, length: usize, sum: u32) -> Result<Section<'_>, Fault> {
    let end = at.checked_add(length).filter(|&end| end <= body.bytes.len());
    let end = end.ok_or(body.fault(at, "a page reaches beyond its section"))?;
    let page = Section { offset: body.offset + at, bytes: &body.bytes[at..end], ..body };
    if checksum(page.bytes) != sum { Err(page.fault(0, "checksum of a page is wrong")) } else { Ok(page) }
}

/// The rows of UTAB, checked against META and UPDT.
pub(crate) fn decode_table<'a>(table: Section, body: Section<'a>, meta: &Meta) -> Result<Vec<PageRow<'a>>, Fault> {
    if !table.bytes.len().is_multiple_of(UPDATE_ROW) {
        return Err(table.fault(0, "length is not a multiple of 16"));
    }
    let (mut at, mut first) = (0, 0);
    let mut rows = Vec::with_capacity(table.bytes.len() / UPDATE_ROW);
    for row in 0..table.bytes.len() / UPDATE_ROW {
        let number = |column: usize| u32_at(table.bytes, UPDATE_ROW * row + 4 * column);
        let (length, updates, max_error) = (number(0) as usize, number(1) as usize, f32::from_bits(number(2)));
        if updates == 0 || updates > length || updates > meta.updates - first {
            return Err(table.fault(UPDATE_ROW * row, "number of updates does not fit page or file"));
        }
        let page = page_section(body, at, length, number(3))?;
        rows.push(PageRow { page, first, updates, max_error });
        at += length;
        first += updates;
    }
    if first != meta.updates {
        return Err(table.fault(0, "pages hold fewer updates than the file"));
    }
    if at != body.bytes.len() {
        return Err(body.fault(at, "bytes that belong to no page"));
    }
    Ok(rows)
}

/// The base mesh that sections hold, with its normals and colours. `own_flags` as in [`Opened::with`].
pub(crate) fn base_of(sections: &[Section], own_flags: u32) -> Option<TriangleMesh> {
    let get = |name: &str| sections.iter().find(|s| s.name == name).copied();
    let meta = decode_meta(get("META")?, own_flags).ok()?;
    let (mut base, _) = decode_base(get("BASE")?, &meta).ok()?;
    if meta.has(HAS_BASE_NORMALS) {
        base.vertex.normals = decode_base_normals(get("BNRM")?, meta.base_vertices).ok()?;
    }
    if meta.has(HAS_BASE_COLORS) {
        base.vertex.colors = decode_base_colors(get("BCOL")?, meta.base_vertices).ok()?;
    }
    Some(base)
}

/// A file's sections, found and compared with META.
pub(crate) struct Opened<'a> {
    pub meta: Meta,
    pub sections: Vec<Section<'a>>,
}

impl<'a> Opened<'a> {
    fn new(bytes: &'a [u8], file: &str) -> Result<Opened<'a>, ReadError> {
        Opened::with(bytes, file, &SECTIONS, 0)
    }
    /// Of a model that has these of the sections, and these flags besides those that all have.
    pub(crate) fn with(
        bytes: &'a [u8],
        file: &str,
        known: &[&'static str],
        own_flags: u32,
    ) -> Result<Opened<'a>, ReadError> {
        let sections = container::open(bytes, file, known)?;
        let missing = |name| Fault { section: name, offset: 0, reason: "is missing" }.in_file(file);
        let get = |name: &str| sections.iter().find(|s| s.name == name).copied();
        let meta = decode_meta(get("META").ok_or_else(|| missing("META"))?, own_flags).map_err(|f| f.in_file(file))?;
        for &name in known {
            let expected = match name {
                "BNRM" => meta.has(HAS_BASE_NORMALS),
                "BCOL" => meta.has(HAS_BASE_COLORS),
                "NTAB" | "NRML" => meta.has(HAS_NORMALS),
                "CTAB" | "COLR" => meta.has(HAS_COLORS),
                _ => true,
            };
            match get(name) {
                None if expected => return Err(missing(name)),
                Some(section) if !expected => {
                    return Err(section.fault(0, "is there, but META says that it is not").in_file(file));
                }
                _ => {}
            }
        }
        Ok(Opened { meta, sections })
    }

    /// A section that is known to be there.
    pub(crate) fn section(&self, name: &str) -> Section<'a> {
        *self.sections.iter().find(|s| s.name == name).expect("compared with META")
    }
}

/// The columns of a file that lies in memory. `file` is what errors call it.
///
/// Every byte is covered by a checksum, and every number is checked before it is used or allocated for: beyond the
/// result, memory stays below 128 bytes for each byte of the file, whatever the file says. Whether each split can be applied is for
/// `EdgeCollapse::new` to check.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn decode(bytes: &[u8], file: &str) -> Result<Columns, ReadError> {
    let opened = Opened::new(bytes, file)?;
    decode_opened(&opened).map_err(|fault| fault.in_file(file))
}

fn decode_opened(opened: &Opened) -> Result<Columns, Fault> {
    let (unpacked, pages) = unpack_splits(opened, page::decode_page)?;
    let Unpacked { base, vertex, errors, positions, normals, colors, .. } = unpacked;
    let Meta { grid, floor_error, source, .. } = opened.meta;
    let (mut sides, mut explicit) = (Vec::with_capacity(vertex.len()), vec![]);
    for page in pages {
        sides.extend(page.0);
        explicit.extend(page.1);
    }
    Ok(Columns { grid, base, vertex, sides, explicit, positions, normals, colors, errors, floor_error, source })
}

/// Integers of two points.
pub(crate) type Indices = [[u32; 3]; 2];

/// The columns that all models of splits have.
pub(crate) struct Unpacked {
    pub base: TriangleMesh,
    /// Integers of the base vertices.
    pub base_indices: Vec<[u32; 3]>,
    pub vertex: Vec<VertexId>,
    pub errors: Vec<f32>,
    pub positions: Vec<[Vec3; 2]>,
    /// Integers of u and v.
    pub indices: Vec<Indices>,
    pub normals: Vec<[Oct; 2]>,
    pub colors: Vec<[[u8; 4]; 2]>,
}

/// What a file of splits holds, and for each page what `decode_page` makes of the rest.
pub(crate) fn unpack_splits<'a, T: Send>(
    opened: &Opened<'a>,
    decode_page: impl Fn(Section<'a>, &mut page::PageTarget) -> Result<T, Fault> + Sync + Send,
) -> Result<(Unpacked, Vec<T>), Fault> {
    let meta = &opened.meta;
    let rows = decode_table(opened.section("UTAB"), opened.section("UPDT"), meta)?;
    let (mut base, base_indices) = decode_base(opened.section("BASE"), meta)?;
    if meta.has(HAS_BASE_NORMALS) {
        base.vertex.normals = decode_base_normals(opened.section("BNRM"), meta.base_vertices)?;
    }
    if meta.has(HAS_BASE_COLORS) {
        base.vertex.colors = decode_base_colors(opened.section("BCOL"), meta.base_vertices)?;
    }

    let (mut vertex, mut errors) = (vec![VertexId(0); meta.updates], vec![0.0; meta.updates]);
    let mut residuals = vec![page::Residuals::default(); meta.updates];
    let mut targets = Vec::with_capacity(rows.len());
    let (mut vertex_left, mut errors_left, mut residuals_left) = (&mut vertex[..], &mut errors[..], &mut residuals[..]);
    for row in &rows {
        targets.push((
            row,
            page::PageTarget {
                first: row.first,
                vertex: vertex_left.split_off_mut(..row.updates).expect("counted"),
                errors: errors_left.split_off_mut(..row.updates).expect("counted"),
                residuals: residuals_left.split_off_mut(..row.updates).expect("counted"),
            },
        ));
    }
    let pages = map_all(targets, |(row, mut target)| {
        let rest = decode_page(row.page, &mut target)?;
        if target.errors.iter().copied().fold(0.0, f32::max).to_bits() != row.max_error.to_bits() {
            return Err(row.page.fault(0, "largest error is not what UTAB says"));
        }
        Ok(rest)
    });
    let pages = pages.into_iter().collect::<Result<Vec<T>, Fault>>()?;

    let (positions, indices) = sum_positions(meta, &rows, &vertex, &base_indices, residuals)?;
    let mut unpacked =
        Unpacked { base, base_indices, vertex, errors, positions, indices, normals: vec![], colors: vec![] };
    let (base, vertex) = (&unpacked.base.vertex, &unpacked.vertex);
    if meta.has(HAS_NORMALS) {
        let base: Vec<Oct> = base.normals.iter().map(|&n| Oct::encode(n)).collect();
        let (table, body) = (opened.section("NTAB"), opened.section("NRML"));
        unpacked.normals = decode_attribute(table, body, &rows, &base, meta.base_vertices, vertex)?;
    }
    if meta.has(HAS_COLORS) {
        let (table, body) = (opened.section("CTAB"), opened.section("COLR"));
        unpacked.colors = decode_attribute(table, body, &rows, &base.colors, meta.base_vertices, vertex)?;
    }
    Ok((unpacked, pages))
}

/// Sums differences along the splits, coarse to fine: points, and their integers.
fn sum_positions(
    meta: &Meta,
    rows: &[PageRow],
    vertex: &[VertexId],
    base: &[[u32; 3]],
    mut residuals: Vec<page::Residuals>,
) -> Result<(Vec<[Vec3; 2]>, Vec<Indices>), Fault> {
    let lattice = Lattice::new(meta.grid);
    let mut positions = vec![[Vec3::ZERO; 2]; meta.updates];
    for row in rows {
        for m in row.first..row.first + row.updates {
            let s = vertex[m].ix();
            let s = match s.checked_sub(meta.base_vertices) {
                None => base[s],
                // Children's integers replace the differences that they were made of.
                Some(child) if child < 2 * m => residuals[child / 2][child % 2].map(|i| i as u32),
                Some(_) => return Err(row.page.fault(0, "an update splits a vertex that does not exist yet")),
            };
            let children = split_from_residual(s, residuals[m]);
            for (child, index) in children.into_iter().enumerate() {
                let point = lattice.point(index);
                positions[m][child] = point.ok_or(row.page.fault(0, "a vertex is outside of the grid"))?;
            }
            residuals[m] = children.map(|index| index.map(|i| i as i32));
        }
    }
    let indices = residuals.into_iter().map(|pair| pair.map(|index| index.map(|i| i as u32))).collect();
    Ok((positions, indices))
}

#[cfg(all(test, feature = "write"))]
mod tests {
    use super::*;

    /// Two splits of the only base vertex's descendants; the first splits `vertex`.
    fn splits(vertex: u32) -> Vec<u8> {
        let columns = Columns {
            base: TriangleMesh { positions: vec![Vec3::ZERO], ..TriangleMesh::default() },
            vertex: vec![VertexId(vertex), VertexId(2)],
            sides: vec![0; 2],
            positions: vec![[Vec3::X, Vec3::Y]; 2],
            errors: vec![1.0; 2],
            ..Columns::default()
        };
        pack(&columns).unwrap()
    }

    #[test]
    fn a_vertex_that_does_not_exist_yet_cannot_split() {
        assert!(decode(&splits(0), "x").is_ok());
        for later in [1, 2, 3, 4] {
            let error = decode(&splits(later), "x").unwrap_err();
            assert!(error.to_string().contains("does not exist yet"), "{later}: {error}");
        }
    }
}
