//! The record, sorted coarse to fine and numbered: the columns of the hierarchy.

use super::merge::Record;
use crate::measure::Errors;
use crate::order::order;
use meshfront_hierarchies::SourceCounts;
use meshfront_hierarchies::vertex_pair::{Columns, Grid};
use meshfront_mesh::{Bounds, TriangleMesh, VertexId};

/// No merge; no number yet.
const NONE: u32 = u32::MAX;

pub(super) fn arrange(source: &TriangleMesh, grid: Option<Grid>, record: Record, errors: Errors) -> Columns {
    let leaves = record.leaves as usize;
    let updates = record.merges.len();
    let mut parent = vec![NONE; leaves + updates];
    for (i, c) in record.merges.iter().enumerate() {
        parent[c.u as usize] = i as u32;
        parent[c.v as usize] = i as u32;
    }
    // Whoever is a corner of M⁻ or of M⁺ but for u and v.
    let needs = |i: usize| {
        let star = record.star[record.star_of(i)].iter().flat_map(|t| [t.after, t.before]);
        let removed = record.removed_of(i).iter().flat_map(|r| r.corners);
        let all = star.chain(removed).chain([(leaves + i) as u32]);
        all.map(|x| parent[x as usize]).filter(move |&p| p != NONE && p != i as u32)
    };
    let bounds = Bounds::of(&record.nodes.positions).expect("a mesh with triangles has vertices");
    let mut error = errors.steps;
    let order = order(&bounds, &record.nodes.positions[leaves..], needs, &mut error);

    let mut number = vec![NONE; leaves + updates];
    let (base, mut triangles) = record.nodes.base_mesh(&record.base, &bounds, &mut number);
    let base_vertices = base.positions.len() as u32;
    for (m, &i) in order.iter().enumerate() {
        let merge = record.merges[i as usize];
        number[merge.u as usize] = base_vertices + 2 * m as u32;
        number[merge.v as usize] = base_vertices + 2 * m as u32 + 1;
        triangles.extend(record.removed_of(i as usize).iter().map(|r| r.triangle));
    }
    let both = |i: &u32| [record.merges[*i as usize].u, record.merges[*i as usize].v].map(|x| x as usize);
    let pick_normals = |i: &u32| both(i).map(|x| record.nodes.normals[x]);
    let pick_colors = |i: &u32| both(i).map(|x| record.nodes.colors[x]);
    let leaf = |&t: &u32| source.triangles[t as usize].map(|v| VertexId(number[v.ix()]));
    Columns {
        grid,
        base,
        triangles: triangles.iter().map(leaf).collect(),
        added: order.iter().map(|&i| record.removed_of(i as usize).len() as u32).collect(),
        vertex: order.iter().map(|&i| VertexId(number[leaves + i as usize])).collect(),
        positions: order.iter().map(|i| both(i).map(|x| record.nodes.positions[x])).collect(),
        normals: if record.nodes.normals.is_empty() { vec![] } else { order.iter().map(pick_normals).collect() },
        colors: if record.nodes.colors.is_empty() { vec![] } else { order.iter().map(pick_colors).collect() },
        errors: order.iter().map(|&i| error[i as usize]).collect(),
        floor_error: errors.floor,
        source: SourceCounts { vertices: source.positions.len() as u32, triangles: source.triangles.len() as u32 },
    }
}
