//! The record, sorted coarse to fine and numbered: the columns of the hierarchy.

use super::collapse::Record;
use crate::measure::Errors;
use crate::order::order;
use meshfront_hierarchies::SourceCounts;
use meshfront_hierarchies::edge_collapse::{Columns, ExplicitSplit, Grid, StarTriangle, encode_split, round_error_up};
use meshfront_mesh::{Bounds, TriangleMesh, VertexId};
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

    let bounds = Bounds::of(&record.nodes.positions).expect("a mesh with triangles has vertices");
    let own = errors.steps.clone();
    let mut error = errors.steps;
    let order = order(&bounds, &record.nodes.positions[leaves..], needs, &mut error);

    let mut made = Columns {
        grid,
        floor_error: errors.floor,
        source: SourceCounts { vertices: source.positions.len() as u32, triangles: source.triangles.len() as u32 },
        ..Columns::default()
    };
    let mut vertex_number = vec![NONE; leaves + updates];
    let mut triangle_number = vec![NONE; source.triangles.len()];
    let (base, base_triangles) = record.nodes.base_mesh(&record.base, &bounds, &mut vertex_number);
    made.base = base;
    for (number, &t) in base_triangles.iter().enumerate() {
        triangle_number[t as usize] = number as u32;
    }
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
        made.positions.push([record.nodes.positions[u as usize], record.nodes.positions[v as usize]]);
        if !record.nodes.normals.is_empty() {
            made.normals.push([record.nodes.normals[u as usize], record.nodes.normals[v as usize]]);
        }
        if !record.nodes.colors.is_empty() {
            made.colors.push([record.nodes.colors[u as usize], record.nodes.colors[v as usize]]);
        }
        made.errors.push(error[i]);
    }
    let own = order.iter().map(|&i| round_error_up(own[i as usize])).collect();
    (made, own)
}
