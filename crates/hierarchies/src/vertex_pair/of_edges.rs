//! Edge collapses as a forest: the same nodes and updates, and triangles by their leaves.

use super::columns::Columns;
use crate::EdgeCollapse;
use crate::edge_collapse::ExplicitSplit;
use meshfront_mesh::VertexId;
use meshfront_refine::{MultiTessellation, UpdateId};

impl From<&EdgeCollapse> for Columns {
    /// Applies all updates, and sees at which vertices of the source the triangles end. Nodes and updates keep their
    /// numbers, triangles their order.
    fn from(h: &EdgeCollapse) -> Columns {
        let c = h.columns();
        let (base, updates) = (c.base.triangles.len() as u32, c.vertex.len());
        // Where the third triangles and more of explicit splits are numbered.
        let mut extra = vec![];
        for ExplicitSplit { update, added } in &c.explicit {
            extra.extend((2..added.len()).map(|_| *update));
        }
        let adder = |number: u32| {
            let later = number.checked_sub(base)? as usize;
            Some(extra.get(later.wrapping_sub(2 * updates)).map_or(later as u32 / 2, |m| m.0))
        };
        let mut front = h.base();
        for m in (0..updates as u32).map(UpdateId) {
            h.refine(&mut front, m);
            front.buffers.clear_changes();
        }
        let mut triangles: Vec<(Option<u32>, u32, [VertexId; 3])> =
            front.numbered_triangles().map(|(number, t)| (adder(number), number, t)).collect();
        triangles.sort_unstable_by_key(|&(adder, number, _)| (adder, number));
        let mut added = vec![0; updates];
        for m in triangles.iter().filter_map(|t| t.0) {
            added[m as usize] += 1;
        }
        Columns {
            grid: c.grid,
            base: c.base,
            triangles: triangles.into_iter().map(|(_, _, t)| t).collect(),
            added,
            vertex: c.vertex,
            positions: c.positions,
            normals: c.normals,
            colors: c.colors,
            errors: c.errors,
            floor_error: c.floor_error,
            source: c.source,
        }
    }
}
