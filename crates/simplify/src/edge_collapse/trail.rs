//! How points of the source find their way through a record of collapses.

use super::collapse::Record;
use crate::measure::{Trail, Way, Ways, Word};
use glam::Vec3;
use meshfront_hierarchies::edge_collapse::Columns;
use meshfront_mesh::VertexId;
use std::ops::Range;

const _: () = assert!(Columns::MAX_STAR < <u32 as Word>::MOST_CELLS);

/// Coarse cells are those of the stars.
impl Trail for Record {
    type Word = u32;
    const FAN: bool = true;
    const KEEPS_VERTICES: bool = false;
    const EVEN: bool = true;

    fn steps(&self) -> usize {
        self.collapses.len()
    }
    fn position(&self, vertex: VertexId) -> Vec3 {
        self.nodes.positions[vertex.ix()]
    }
    fn on_rim(&self, vertex: VertexId) -> bool {
        self.rim[vertex.ix()]
    }
    #[inline]
    fn coarse(&self, step: usize) -> Range<usize> {
        self.star_of(step)
    }
    #[inline]
    fn corners(&self, step: usize, cell: usize) -> [Vec3; 3] {
        let cell = self.star[cell];
        [self.leaves + step as u32, cell.after, cell.before].map(|v| self.nodes.positions[v as usize])
    }
    fn gone(&self, step: usize) -> impl Iterator<Item = Vec3> {
        let collapse = self.collapses[step];
        [collapse.u, collapse.v].map(|v| self.nodes.positions[v as usize]).into_iter()
    }

    fn ways(&self, triangles: usize) -> Ways<u32> {
        let mut touch = vec![Way::NONE; triangles];
        let mut next = vec![Way::NONE; self.star.len()];
        for i in (0..self.collapses.len()).rev() {
            let star = self.star_of(i);
            for (place, e) in star.clone().enumerate() {
                let t = self.star[e].triangle as usize;
                next[e] = std::mem::replace(&mut touch[t], Way::stays(i, place));
            }
            for r in self.removed_of(i) {
                let place = self.star[star.clone()].iter().position(|t| t.after == r.w || t.before == r.w);
                touch[r.triangle as usize] = Way::vanishes(i, place.unwrap_or(0));
            }
        }
        Ways { first: touch, next }
    }
}
