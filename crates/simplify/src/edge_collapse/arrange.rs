//! The record, sorted coarse to fine and numbered: the columns of the hierarchy.

use super::collapse::Record;
use crate::measure::Errors;
use crate::order::{morton, order};
use meshfront_hierarchies::SourceCounts;
use meshfront_hierarchies::edge_collapse::{Columns, ExplicitSplit, Grid, StarTriangle, encode_split, round_error_up};
use meshfront_mesh::{Bounds, TriangleMesh, VertexColumns, VertexId};
use meshfront_refine::UpdateId;

/// No collapse; no number yet.
const NONE: u32 = u32::MAX;

/// The columns, and the errors of the updates by themselves, as a file holds them.
pub(super) fn arrange(
    source: &TriangleMesh,
    grid: Option<Grid>,
    record: Record,
    errors: Errors,
) -> (Columns, Vec<f32>) {
    let leaves = record.leaves as usize;
    let updates = record.collapses.len();
    let mut parent = vec![NONE; leaves + updates];
    for (i, c) in record.collapses.iter().enumerate() {
        parent[c.u as usize] = i as u32;
        parent[c.v as usize] = i as u32;
    }
    let needs = |i: usize| {
        let ring = record.star[record.star_of(i)].iter().flat_map(|t| [t.after, t.before]);
        ring.chain([(leaves + i) as u32]).map(|x| parent[x as usize]).filter(|&p| p != NONE)
    };

    let bounds = Bounds::of(&record.positions).expect("a mesh with triangles has vertices");
    let own = errors.steps.clone();
    let mut error = errors.steps;
    let order = order(&bounds, &record.positions[leaves..], needs, &mut error);

    let mut made = Columns {
        grid,
        floor_error: errors.floor,
        source: SourceCounts { vertices: source.positions.len() as u32, triangles: source.triangles.len() as u32 },
        ..Columns::default()
    };
    let mut vertex_number = vec![NONE; leaves + updates];
    let mut triangle_number = vec![NONE; source.triangles.len()];
    number_base(&record, &bounds, &mut made, &mut vertex_number, &mut triangle_number);
    let base_vertices = made.base.positions.len() as u32;
    let base_triangles = made.base.triangles.len() as u32;
    let mut extra = base_triangles + 2 * updates as u32;

    for (m, &i) in order.iter().enumerate() {
        let i = i as usize;
        let collapse = record.collapses[i];
        let mut star: Vec<StarTriangle> = record.star[record.star_of(i)]
            .iter()
            .map(|t| StarTriangle {
                number: triangle_number[t.triangle as usize],
                after: t.after,
                before: t.before,
                on_v: t.on_v,
            })
            .collect();
        let removed = record.removed_of(i);
        let split = encode_split(&mut star, &removed.iter().map(|r| (r.w, r.flipped)).collect::<Vec<_>>());
        for (j, &r) in split.order.iter().enumerate() {
            triangle_number[removed[r].triangle as usize] = match j {
                0 | 1 => base_triangles + 2 * m as u32 + j as u32,
                _ => {
                    extra += 1;
                    extra - 1
                }
            };
        }
        let (u, v) = if split.swapped { (collapse.v, collapse.u) } else { (collapse.u, collapse.v) };
        vertex_number[u as usize] = base_vertices + 2 * m as u32;
        vertex_number[v as usize] = base_vertices + 2 * m as u32 + 1;
        made.vertex.push(VertexId(vertex_number[leaves + i]));
        made.sides.push(split.sides);
        made.explicit.extend(split.explicit.map(|added| ExplicitSplit { update: UpdateId(m as u32), added }));
        made.positions.push([record.positions[u as usize], record.positions[v as usize]]);
        if !record.normals.is_empty() {
            made.normals.push([record.normals[u as usize], record.normals[v as usize]]);
        }
        if !record.colors.is_empty() {
            made.colors.push([record.colors[u as usize], record.colors[v as usize]]);
        }
        made.errors.push(error[i]);
    }
    let own = order.iter().map(|&i| round_error_up(own[i as usize])).collect();
    (made, own)
}

/// The base mesh along a space-filling curve, so that neighbours have near numbers.
fn number_base(
    record: &Record,
    bounds: &Bounds,
    made: &mut Columns,
    vertex_number: &mut [u32],
    triangle_number: &mut [u32],
) {
    let at = |version: u32| record.positions[version as usize];
    let mut vertices: Vec<u32> = record.base.iter().flat_map(|(_, corners)| *corners).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.sort_by_key(|&v| morton(bounds, at(v)));
    for (number, &v) in vertices.iter().enumerate() {
        vertex_number[v as usize] = number as u32;
    }
    let mut triangles: Vec<(u32, [u32; 3])> =
        record.base.iter().map(|(t, c)| (*t, c.map(|v| vertex_number[v as usize]))).collect();
    triangles.sort_by_key(|(t, c)| (c.iter().min().copied(), *t));
    for (number, (t, _)) in triangles.iter().enumerate() {
        triangle_number[*t as usize] = number as u32;
    }
    made.base = TriangleMesh {
        positions: vertices.iter().map(|&v| at(v)).collect(),
        triangles: triangles.iter().map(|(_, c)| c.map(VertexId)).collect(),
        vertex: VertexColumns {
            normals: if record.normals.is_empty() {
                vec![]
            } else {
                vertices.iter().map(|&v| record.normals[v as usize].decode()).collect()
            },
            colors: if record.colors.is_empty() {
                vec![]
            } else {
                vertices.iter().map(|&v| record.colors[v as usize]).collect()
            },
        },
    };
}
