//! The record, sorted coarse to fine and numbered: the columns of the hierarchy.
//!
//! Order: by octave of the error, so that a prefix is a mesh of that error; inside an octave along a space-filling curve,
//! each update right after those of its needs that were still missing. Neighbours in space are neighbours in
//! memory and in the file.

use super::collapse::Record;
use super::measure::Errors;
use glam::Vec3;
use meshfront_hierarchies::SourceCounts;
use meshfront_hierarchies::edge_collapse::{Columns, ExplicitSplit, Grid, StarTriangle, encode_split, round_error_up};
use meshfront_mesh::{Bounds, TriangleMesh, VertexColumns, VertexId};
use meshfront_refine::UpdateId;
use rayon::prelude::*;

/// No collapse; no number yet.
const NONE: u32 = u32::MAX;

pub(super) fn arrange(source: &TriangleMesh, grid: Option<Grid>, record: Record, errors: Errors) -> Columns {
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

    // Errors never grow downwards: what is needed is at least as wrong. Needs come later in the record.
    let mut error: Vec<f32> = errors.collapses.into_iter().map(round_error_up).collect();
    for i in 0..updates {
        for p in needs(i) {
            error[p as usize] = error[p as usize].max(error[i]);
        }
    }
    let octave: Vec<u32> = error.iter().map(|e| e.to_bits() >> 23).collect();
    let bounds = Bounds::of(&record.positions).expect("a mesh with triangles has vertices");
    let curve: Vec<u64> = record.positions[leaves..].par_iter().map(|&p| morton(&bounds, p)).collect();
    let mut along: Vec<u32> = (0..updates as u32).collect();
    along.par_sort_unstable_by_key(|&i| (std::cmp::Reverse(octave[i as usize]), curve[i as usize], i));
    let mut order: Vec<u32> = Vec::with_capacity(updates);
    let mut placed = vec![false; updates];
    let mut stack = vec![];
    for &seed in &along {
        stack.push(seed);
        while let Some(&i) = stack.last() {
            let open = stack.len();
            if !placed[i as usize] {
                stack.extend(needs(i as usize).filter(|&p| !placed[p as usize]));
            }
            if stack.len() == open {
                stack.pop();
                if !std::mem::replace(&mut placed[i as usize], true) {
                    order.push(i);
                }
            }
        }
    }

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
    made
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

/// The place of a point on a Z-order curve through a box, 21 bits a side.
fn morton(bounds: &Bounds, p: Vec3) -> u64 {
    let side = (bounds.max - bounds.min).max_element().max(f32::MIN_POSITIVE);
    let cell = ((p - bounds.min) / side * ((1 << 21) - 1) as f32).as_uvec3();
    // Spreads 21 bits to every third place, in halves.
    let spread = |x: u32| {
        let mut x = x as u64 & 0x1f_ffff;
        for (shift, mask) in [
            (32, 0x1f_0000_0000_ffff),
            (16, 0x1f_0000_ff00_00ff),
            (8, 0x100f_00f0_0f00_f00f),
            (4, 0x10c3_0c30_c30c_30c3),
            (2, 0x1249_2492_4924_9249),
        ] {
            x = (x | x << shift) & mask;
        }
        x
    };
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}
