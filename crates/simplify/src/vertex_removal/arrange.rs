//! The record, sorted coarse to fine and numbered: the columns of the hierarchy.

use super::remove::Record;
use super::rings::NONE;
use crate::measure::Errors;
use crate::order::{morton, order};
use glam::Vec3;
use meshfront_hierarchies::vertex_removal::{Columns, Grid, Oct, Patch, SourceCounts, Triangulation};
use meshfront_mesh::{Bounds, TriangleMesh, VertexColumns, VertexId};
use rayon::prelude::*;

pub(super) fn arrange(source: &TriangleMesh, grid: Option<Grid>, record: Record, errors: Errors) -> Columns {
    let updates = record.removals.len();
    let bounds = Bounds::of(&record.positions).expect("a mesh with triangles has vertices");
    // Per coarse cell: the removal that takes it away again, and the place in its ring.
    let mut end = vec![(NONE, 0u32); record.coarse.len()];
    for i in 0..updates {
        for (j, s) in record.ring_of(i).iter().enumerate().filter(|(_, s)| s.cell != NONE) {
            if let Some(e) = s.cell.checked_sub(record.triangles) {
                end[e as usize] = (i as u32, j as u32);
            }
        }
    }
    let needs = |i: usize| end[record.coarse_of(i)].iter().map(|e| e.0).filter(|&p| p != NONE);
    let mut error = errors.steps;
    let places: Vec<Vec3> = record.removals.iter().map(|r| record.positions[r.vertex as usize]).collect();
    let order = order(&bounds, &places, needs, &mut error);
    let mut update = vec![NONE; updates];
    for (m, &i) in order.iter().enumerate() {
        update[i as usize] = m as u32;
    }

    let (base, base_cells) = base_mesh(source, &record, &bounds);
    let base_triangles = base.triangles.len();
    let mut cell_number = vec![NONE; record.coarse.len()];
    for (number, (cell, _)) in base_cells.iter().enumerate() {
        if let Some(e) = cell.checked_sub(record.triangles) {
            cell_number[e as usize] = number as u32;
        }
    }
    let turns: Vec<usize> = (0..updates).into_par_iter().map(|i| best_turn(&record, i)).collect();
    for (number, &(i, j)) in cell_number.iter_mut().zip(&end).filter(|(_, e)| e.0 != NONE) {
        let n = record.ring_of(i as usize).len();
        let place = (j as usize + n - turns[i as usize]) % n;
        *number = Columns::first_cell(base_triangles, update[i as usize]) + place as u32;
    }
    let patch = |&i: &u32| {
        let i = i as usize;
        let (ring, removal) = (record.ring_of(i), record.removals[i]);
        let n = ring.len();
        let [last, first] = [n - 1, 0].map(|c| ring[(c + turns[i]) % n].vertex);
        let root = record.coarse_of(i).find(|&e| {
            let t = record.coarse[e];
            (0..3).any(|k| t[k] == last && t[(k + 1) % 3] == first)
        });
        let root = root.expect("each side of a polygon has a triangle");
        // Corners as the cell has them where it was made.
        let corners = match end[root] {
            (NONE, _) => base_cells[cell_number[root] as usize].1,
            (maker, j) => {
                let ring = record.ring_of(maker as usize);
                let next = ring[(j as usize + 1) % ring.len()].vertex;
                [record.removals[maker as usize].vertex, ring[j as usize].vertex, next]
            }
        };
        Patch {
            cell: cell_number[root],
            edge: corners.iter().position(|&v| v == last).expect("a cell keeps its corners") as u8,
            boundary: ring[n - 1].cell == NONE,
            triangulation: removal.triangulation.turned(turns[i]),
        }
    };
    let vertices: Vec<u32> = order.iter().map(|&i| record.removals[i as usize].vertex).collect();
    Columns {
        grid,
        patches: order.par_iter().map(patch).collect(),
        positions: pick(&record.positions, &vertices).copied().collect(),
        normals: pick(&source.vertex.normals, &vertices).map(|&n| Oct::encode(n)).collect(),
        colors: pick(&source.vertex.colors, &vertices).copied().collect(),
        errors: order.iter().map(|&i| error[i as usize]).collect(),
        floor_error: errors.floor,
        source: SourceCounts { vertices: source.positions.len() as u32, triangles: source.triangles.len() as u32 },
        connectivity: Default::default(),
        base,
    }
}

/// A column's entries of some vertices; none where the column is empty.
fn pick<'a, T>(column: &'a [T], vertices: &'a [u32]) -> impl Iterator<Item = &'a T> {
    vertices.iter().filter_map(|&v| column.get(v as usize))
}

/// By how much a ring turns so that its triangulation has the least number; an open one stays. Which corner of a closed ring
/// is the first says nothing: so few of the numbers are used, and those are short.
fn best_turn(record: &Record, i: usize) -> usize {
    let ring = record.ring_of(i);
    let triangulation = record.removals[i].triangulation;
    if ring[ring.len() - 1].cell == NONE || ring.len() == 3 {
        return 0;
    }
    let index = |&by: &usize| -> (u16, usize) {
        let turned: Triangulation = triangulation.turned(by);
        (turned.index, by)
    };
    (0..ring.len()).min_by_key(index).unwrap_or(0)
}

/// The base mesh along a space-filling curve, so that neighbours have near numbers, and its cells with their corners
/// in the source, in its order.
fn base_mesh(source: &TriangleMesh, record: &Record, bounds: &Bounds) -> (TriangleMesh, Vec<(u32, [u32; 3])>) {
    let at = |v: u32| record.positions[v as usize];
    let mut vertices: Vec<u32> = record.base.iter().flat_map(|(_, corners)| *corners).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.sort_by_key(|&v| morton(bounds, at(v)));
    let mut number = vec![NONE; record.positions.len()];
    for (n, &v) in vertices.iter().enumerate() {
        number[v as usize] = n as u32;
    }
    let mut cells = record.base.clone();
    cells.sort_by_key(|(cell, corners)| (corners.map(|v| number[v as usize]).into_iter().min(), *cell));
    let mesh = TriangleMesh {
        positions: pick(&record.positions, &vertices).copied().collect(),
        triangles: cells.iter().map(|(_, corners)| corners.map(|v| VertexId(number[v as usize]))).collect(),
        vertex: VertexColumns {
            normals: pick(&source.vertex.normals, &vertices).copied().collect(),
            colors: pick(&source.vertex.colors, &vertices).copied().collect(),
        },
    };
    (mesh, cells)
}
