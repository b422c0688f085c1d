//! Where the surface was: removed vertices, each on the cell that is nearest to it now.

use super::rings::{NONE, Rings};
use glam::Vec3;

/// A cell keeps no more; the weight of the others goes to those that stay.
pub(super) const MOST: usize = 8;

/// Lists of removed vertices, one per cell.
pub(super) struct Samples {
    /// Per vertex: where it is in the source.
    pub points: Vec<Vec3>,
    /// Per vertex: the area that it stands for.
    pub weight: Vec<f32>,
    /// Per cell: its first sample.
    first: Vec<u32>,
    /// Per vertex: the next one on its cell.
    next: Vec<u32>,
}

impl Samples {
    pub fn new(points: &[Vec3], rings: &Rings, cells: usize) -> Samples {
        let n = points.len();
        let area = |v: usize| {
            let ring = rings.of_vertex(v as u32);
            let at = |i: usize| points[ring[i % ring.len()].vertex as usize] - points[v];
            let cells = ring.iter().enumerate().filter(|(_, s)| s.cell != NONE);
            cells.map(|(i, _)| at(i).cross(at(i + 1)).length() / 6.0).sum()
        };
        Samples {
            weight: (0..n).map(area).collect(),
            points: points.to_vec(),
            first: vec![NONE; cells],
            next: vec![NONE; n],
        }
    }

    /// The samples on a cell.
    pub fn of(&self, cell: u32) -> impl Iterator<Item = u32> {
        let some = |v: u32| (v != NONE).then_some(v);
        std::iter::successors(some(self.first[cell as usize]), move |&v| some(self.next[v as usize]))
    }

    /// Adds a cell with these samples.
    pub fn push(&mut self, mut on: Vec<u32>) {
        if on.len() > MOST {
            on.sort_unstable_by_key(|&v| v.wrapping_mul(0x9e37_79b9));
            let all: f32 = on.iter().map(|&v| self.weight[v as usize]).sum();
            on.truncate(MOST);
            let kept: f32 = on.iter().map(|&v| self.weight[v as usize]).sum();
            on.iter().for_each(|&v| self.weight[v as usize] *= all / kept);
        }
        self.first.push(on.first().copied().unwrap_or(NONE));
        for (i, &v) in on.iter().enumerate() {
            self.next[v as usize] = on.get(i + 1).copied().unwrap_or(NONE);
        }
    }
}
