//! The sections of the model `vertex_removal`: columns to bytes and back. `docs/format.md` has them byte by byte.
//!
//! ```text
//! META │ BASE │ BNRM BCOL │ UTAB │ INSR: page page page …
//!             if the base has them      coarse ──────────▶ fine
//! ```
//!
//! META, BASE, BNRM, BCOL and UTAB are those of `edge_collapse`. A page has all there is of its updates. A vertex is coded as its
//! difference from the vertex that made the cell which its polygon is found from: that one is near.

#[cfg(feature = "write")]
use glam::Vec3;
use meshfront_hierarchies::edge_collapse::Oct;
use meshfront_hierarchies::vertex_removal::{Columns, Connectivity, Patch, Triangulation};

use std::iter::from_fn;

use crate::container::Section;
#[cfg(feature = "write")]
use crate::container::{Codec, Part, assemble, checksum};
#[cfg(feature = "write")]
use crate::edge_collapse::Meta;
use crate::edge_collapse::attributes::Attribute;
use crate::edge_collapse::lattice::Lattice;
#[cfg(feature = "write")]
use crate::edge_collapse::page::join;
use crate::edge_collapse::page::{check_length, split};
use crate::edge_collapse::{self as shared, Opened};
use crate::error::{Fault, ReadError};
use crate::info::{ColumnInfo, Info, PageInfo};
use crate::parallel::map_all;
use crate::rans::{Decoder, IntModel, Model, decode_int, int_models};
#[cfg(feature = "write")]
use crate::rans::{Encoder, encode_int};

/// The model's name in the header.
pub const MODEL: &str = "vertex_removal";

const SECTIONS: [&str; 6] = ["META", "BASE", "BNRM", "BCOL", "UTAB", "INSR"];

/// Flags of META: the place in [`Connectivity::ALL`].
pub(crate) const CONNECTIVITY: u32 = 7 * FIRST_CONNECTIVITY;
const FIRST_CONNECTIVITY: u32 = 2 * shared::HAS_COLORS;

/// Bits of an error that rounding leaves 0.
const ERROR_SHIFT: u32 = 19;

/// What there is of each update, and how.
#[derive(Clone, Copy)]
struct Parts {
    normals: bool,
    colors: bool,
    connectivity: Connectivity,
}

#[cfg(feature = "write")]
fn flags_of(connectivity: Connectivity) -> u32 {
    let place = Connectivity::ALL.iter().position(|&c| c == connectivity).expect("ALL has all");
    FIRST_CONNECTIVITY * place as u32
}

fn connectivity_of(flags: u32) -> Result<Connectivity, &'static str> {
    let place = (flags & CONNECTIVITY) / FIRST_CONNECTIVITY;
    Connectivity::ALL.get(place as usize).copied().ok_or("unknown connectivity")
}

/// Everything of one update, as integers: differences from the vertex that its cell was made by.
#[derive(Clone, Copy)]
struct Row {
    cell: u32,
    edge: u8,
    boundary: bool,
    triangulation: Triangulation,
    error: u32,
    position: [i32; 3],
    normal: [i32; 4],
    color: [i32; 4],
}

/// One model for each kind of integer.
struct Models {
    cell: [IntModel; 2],
    place: Model<8>,
    error: IntModel,
    position: [[IntModel; 4]; 3],
    normal: [IntModel; 2],
    color: [IntModel; 4],
}

impl Models {
    fn new() -> Models {
        Models {
            cell: int_models(),
            place: Model::new(),
            error: IntModel::new(),
            position: std::array::from_fn(|_| int_models()),
            normal: int_models(),
            color: int_models(),
        }
    }
}

/// Models for magnitudes after a magnitude.
fn context(class: usize) -> usize {
    (class / 8).min(3)
}

/// The vertex that a cell was made by; `None` where there is no such cell yet.
fn maker(base: &[[meshfront_mesh::VertexId; 3]], vertices: usize, cell: u32, update: usize) -> Option<usize> {
    match Columns::cell_maker(base.len(), cell) {
        Ok((m, _)) => ((m as usize) < update).then(|| vertices + m as usize),
        Err(t) => base.get(t as usize).map(|t| t[0].ix()),
    }
}

/// Columns as the bytes of a file, whole. Errors are rounded with [`round_error_up`](crate::round_error_up); everything
/// else comes back from [`decode`] bit for bit. The same columns give the same bytes, on any number of threads.
///
/// # Errors
/// Columns that are no hierarchy by their lengths, ranges and numbers. Whether every update can be applied is not checked
/// here.
#[cfg(feature = "write")]
pub fn encode(columns: &Columns) -> Result<Vec<u8>, crate::EncodeError> {
    use meshfront_hierarchies::edge_collapse::InvalidColumns;
    let Columns { grid, base, patches, positions, normals, colors, errors, floor_error, source, connectivity } =
        columns;
    let (updates, vertices) = (patches.len(), base.positions.len());
    columns.check()?;
    if let Some(reason) = grid.and_then(|grid| shared::grid_fault(&grid)) {
        return Err(crate::EncodeError::Grid(reason));
    }
    let lattice = Lattice::new(*grid);
    let points: Vec<Vec3> = base.positions.iter().chain(positions).copied().collect();
    let indices: Vec<[u32; 3]> = points.iter().map(|&p| lattice.index(p)).collect();
    if let Some(i) = (0..points.len()).find(|&i| lattice.point(indices[i]) != Some(points[i])) {
        return Err(crate::EncodeError::OffGrid { vertex: i as u32 });
    }
    let base_normals: Vec<Oct> = base.vertex.normals.iter().map(|&n| Oct::encode(n)).collect();
    let normal = |v: usize| if v < vertices { base_normals[v] } else { normals[v - vertices] };
    let color = |v: usize| if v < vertices { base.vertex.colors[v] } else { colors[v - vertices] };

    let ranges = shared::page_ranges(updates);
    let rows: Vec<Row> = (0..updates)
        .map(|m| {
            let Patch { cell, edge, boundary, triangulation } = patches[m];
            let invalid = |reason| InvalidColumns::Update { update: m as u32, reason };
            let from = maker(&base.triangles, vertices, cell, m).ok_or(invalid("its cell does not exist yet"))?;
            let (here, there) = (indices[vertices + m], indices[from]);
            Ok(Row {
                cell,
                edge,
                boundary,
                triangulation,
                error: crate::round_error_up(errors[m]).abs().to_bits() >> ERROR_SHIFT,
                position: [0, 1, 2].map(|k| here[k].wrapping_sub(there[k]) as i32),
                normal: if normals.is_empty() { [0; 4] } else { normals[m].minus(normal(from)) },
                color: if colors.is_empty() { [0; 4] } else { colors[m].minus(color(from)) },
            })
        })
        .collect::<Result<_, InvalidColumns>>()?;
    let parts = Parts { normals: !normals.is_empty(), colors: !colors.is_empty(), connectivity: *connectivity };
    let pages = map_all(ranges.clone(), |range| encode_page(&rows[range.clone()], parts));
    let mut table = Vec::new();
    for (page, range) in pages.iter().zip(ranges) {
        let worst = rows[range.clone()].iter().map(|row| row.error).max().unwrap_or(0) << ERROR_SHIFT;
        for number in [page.len() as u32, range.len() as u32, worst, checksum(page)] {
            table.extend_from_slice(&number.to_le_bytes());
        }
    }

    let meta = Meta {
        flags: shared::flags(*grid, base, parts.normals, parts.colors) | flags_of(*connectivity),
        grid: *grid,
        base_vertices: vertices,
        base_triangles: base.triangles.len(),
        updates,
        floor_error: *floor_error,
        source: *source,
    };
    let stored = |name, bytes| Part { name, codec: Codec::Stored, bytes };
    let coded = |name, bytes| Part { name, codec: Codec::Rans, bytes };
    let mut parts =
        vec![stored("META", shared::encode_meta(&meta)), coded("BASE", shared::encode_base(base, &indices))];
    if !base.vertex.normals.is_empty() {
        parts.push(coded("BNRM", shared::encode_base_normals(&base.vertex.normals)));
    }
    if !base.vertex.colors.is_empty() {
        parts.push(stored("BCOL", base.vertex.colors.concat()));
    }
    parts.extend([stored("UTAB", table), coded("INSR", pages.concat())]);
    Ok(assemble(MODEL, &parts))
}

#[cfg(feature = "write")]
fn encode_page(rows: &[Row], parts: Parts) -> Vec<u8> {
    let (mut e, mut models) = (Encoder::default(), Models::new());
    let (mut cell, mut error, mut class) = (0u32, 0u32, 0);
    for row in rows {
        encode_int(&mut e, &mut models.cell[0], (row.cell / Columns::CELLS).wrapping_sub(cell / Columns::CELLS) as i32);
        encode_int(&mut e, &mut models.cell[1], (row.cell % Columns::CELLS) as i32);
        e.symbol(&mut models.place, 2 * row.edge as usize + usize::from(row.boundary));
        parts.connectivity.encode(row.triangulation, row.boundary).bits().for_each(|bit| e.raw(bit.into(), 1));
        encode_int(&mut e, &mut models.error, row.error.wrapping_sub(error) as i32);
        for axis in 0..3 {
            class = encode_int(&mut e, &mut models.position[axis][context(class)], row.position[axis]);
        }
        if parts.normals {
            for k in 0..2 {
                encode_int(&mut e, &mut models.normal[k], row.normal[k]);
            }
        }
        if parts.colors {
            for k in 0..4 {
                encode_int(&mut e, &mut models.color[k], row.color[k]);
            }
        }
        (cell, error) = (row.cell, row.error);
    }
    join(&[e.finish()], rows.len())
}

fn decode_page(page: Section, updates: usize, parts: Parts) -> Result<Vec<Row>, Fault> {
    let ([stream], end) = split(page)?;
    check_length(page, end, updates)?;
    let (mut d, mut models) = (Decoder::new(stream.bytes), Models::new());
    let mut rows = Vec::with_capacity(updates);
    let (mut cell, mut error, mut class) = (0u32, 0u32, 0);
    for _ in 0..updates {
        let sixteens = (cell / Columns::CELLS).wrapping_add(decode_int(&mut d, &mut models.cell[0]).0 as u32);
        let rest = decode_int(&mut d, &mut models.cell[1]).0 as u32;
        let here = sixteens.wrapping_mul(Columns::CELLS).wrapping_add(rest);
        if rest >= Columns::CELLS || sixteens > u32::MAX / Columns::CELLS {
            return Err(page.fault(4, "a cell is out of range"));
        }
        let place = d.symbol(&mut models.place);
        let (edge, boundary) = (place as u8 / 2, place % 2 == 1);
        if edge > 2 {
            return Err(page.fault(4, "an edge that is none"));
        }
        let triangulation = parts.connectivity.decode(&mut from_fn(|| Some(d.raw(1) == 1)), boundary);
        let triangulation = triangulation.ok_or(page.fault(4, "a triangulation that is none"))?;
        let mut row = Row {
            cell: here,
            edge,
            boundary,
            triangulation,
            error: 0,
            position: [0; 3],
            normal: [0; 4],
            color: [0; 4],
        };
        row.error = error.wrapping_add(decode_int(&mut d, &mut models.error).0 as u32);
        if row.error >= 0x7f80_0000 >> ERROR_SHIFT {
            return Err(page.fault(4, "an error is negative or not finite"));
        }
        for axis in 0..3 {
            (row.position[axis], class) = decode_int(&mut d, &mut models.position[axis][context(class)]);
        }
        if parts.normals {
            (0..2).for_each(|k| row.normal[k] = decode_int(&mut d, &mut models.normal[k]).0);
        }
        if parts.colors {
            (0..4).for_each(|k| row.color[k] = decode_int(&mut d, &mut models.color[k]).0);
        }
        (cell, error) = (row.cell, row.error);
        rows.push(row);
    }
    if d.finish() { Ok(rows) } else { Err(page.fault(4, "the stream is damaged")) }
}

/// The columns of a file that lies in memory. `file` is what errors call it.
///
/// Every byte is covered by a checksum, and every number is checked before it is used or allocated for: memory stays
/// below 200 bytes for each byte of the file. Whether each update can be applied is for `VertexRemoval::new` to check.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn decode(bytes: &[u8], file: &str) -> Result<Columns, ReadError> {
    let opened = Opened::with(bytes, file, &SECTIONS, CONNECTIVITY)?;
    decode_opened(&opened).map_err(|fault| fault.in_file(file))
}

fn decode_opened(opened: &Opened) -> Result<Columns, Fault> {
    let meta = &opened.meta;
    let body = opened.section("INSR");
    let table = shared::decode_table(opened.section("UTAB"), body, meta)?;
    let (mut base, mut indices) = shared::decode_base(opened.section("BASE"), meta)?;
    if meta.has(shared::HAS_BASE_NORMALS) {
        base.vertex.normals = shared::decode_base_normals(opened.section("BNRM"), meta.base_vertices)?;
    }
    if meta.has(shared::HAS_BASE_COLORS) {
        base.vertex.colors = shared::decode_base_colors(opened.section("BCOL"), meta.base_vertices)?;
    }
    let connectivity = connectivity_of(meta.flags).map_err(|reason| opened.section("META").fault(0, reason))?;
    let (has_normals, has_colors) = (meta.has(shared::HAS_NORMALS), meta.has(shared::HAS_COLORS));
    let parts = Parts { normals: has_normals, colors: has_colors, connectivity };
    let mut normals: Vec<Oct> = base.vertex.normals.iter().map(|&n| Oct::encode(n)).collect();
    let mut colors = base.vertex.colors.clone();
    normals.resize(meta.base_vertices, Oct::default());
    colors.resize(meta.base_vertices, [0; 4]);

    let lattice = Lattice::new(meta.grid);
    let worst: Vec<(Section, f32)> = table.iter().map(|row| (row.page, row.max_error)).collect();
    let pages = map_all(table, |row| decode_page(row.page, row.updates, parts));
    let mut columns = Columns {
        grid: meta.grid,
        floor_error: meta.floor_error,
        source: meta.source,
        connectivity,
        ..Columns::default()
    };
    for (rows, (page, max_error)) in pages.into_iter().zip(worst) {
        let rows = rows?;
        if rows.iter().map(|row| row.error).max().unwrap_or(0) << ERROR_SHIFT != max_error.to_bits() {
            return Err(page.fault(0, "largest error is not what UTAB says"));
        }
        for row in rows {
            let m = columns.patches.len();
            let from = maker(&base.triangles, meta.base_vertices, row.cell, m);
            let from = from.ok_or(page.fault(4, "a polygon at a cell that does not exist yet"))?;
            let index = [0, 1, 2].map(|k| indices[from][k].wrapping_add(row.position[k] as u32));
            indices.push(index);
            columns.positions.push(lattice.point(index).ok_or(page.fault(4, "a vertex is outside of the grid"))?);
            if has_normals {
                normals.push(normals[from].plus(row.normal));
            }
            if has_colors {
                colors.push(colors[from].plus(row.color));
            }
            columns.errors.push(f32::from_bits(row.error << ERROR_SHIFT));
            columns.patches.push(Patch {
                cell: row.cell,
                edge: row.edge,
                boundary: row.boundary,
                triangulation: row.triangulation,
            });
        }
    }
    if has_normals {
        columns.normals = normals.split_off(meta.base_vertices);
    }
    if has_colors {
        columns.colors = colors.split_off(meta.base_vertices);
    }
    columns.base = base;
    Ok(columns)
}

/// What a file that lies in memory holds. `file` is what errors call it. Pages are not unpacked.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn inspect(bytes: &[u8], file: &str) -> Result<Info, ReadError> {
    let opened = Opened::with(bytes, file, &SECTIONS, CONNECTIVITY)?;
    let body = opened.section("INSR");
    let rows = shared::decode_table(opened.section("UTAB"), body, &opened.meta).map_err(|f| f.in_file(file))?;
    let page = |row: &shared::PageRow| PageInfo {
        offset: row.page.offset as u64,
        bytes: row.page.bytes.len() as u64,
        first_update: row.first as u32,
        updates: row.updates as u32,
        max_error: Some(row.max_error),
    };
    let pages: Vec<PageInfo> = rows.iter().map(page).collect();
    Ok(Info {
        columns: vec![ColumnInfo { name: "insertions", bytes: body.bytes.len() as u64 }],
        pages,
        ..shared::info_of(MODEL, bytes, body.offset, &opened, &rows)
    })
}
