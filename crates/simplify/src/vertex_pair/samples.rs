//! Where the surface was: vertices of the source, each on the triangle that is nearest to it now.

use crate::measure::nearest;
use glam::Vec3;

const NONE: u32 = u32::MAX;
/// A triangle keeps no more: half of them are those that are farthest, the others any.
const MOST: usize = 12;

/// Lists of vertices of the source, one per triangle.
pub(super) struct Samples {
    points: Vec<Vec3>,
    first: Vec<u32>,
    next: Vec<u32>,
}

impl Samples {
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Samples {
        let mut samples =
            Samples { points: points.to_vec(), first: vec![NONE; triangles.len()], next: vec![NONE; points.len()] };
        let mut seen = vec![false; points.len()];
        for (t, corners) in triangles.iter().enumerate() {
            for &v in corners {
                if !std::mem::replace(&mut seen[v as usize], true) {
                    samples.next[v as usize] = std::mem::replace(&mut samples.first[t], v);
                }
            }
        }
        samples
    }

    pub fn of(&self, triangle: u32) -> impl Iterator<Item = u32> {
        let some = |v: u32| (v != NONE).then_some(v);
        std::iter::successors(some(self.first[triangle as usize]), move |&v| some(self.next[v as usize]))
    }

    pub fn at(&self, sample: u32) -> Vec3 {
        self.points[sample as usize]
    }

    /// Puts samples on a triangle, given with their squared distances from it, instead of those that were there.
    pub fn put(&mut self, triangle: u32, on: &mut Vec<(f32, u32)>) {
        if on.len() > MOST {
            let hash = |v: u32| v.wrapping_mul(0x9e37_79b9);
            on.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            on[MOST / 2..].sort_unstable_by_key(|s| hash(s.1));
            on.truncate(MOST);
        }
        self.first[triangle as usize] = NONE;
        for &(_, v) in on.iter() {
            self.next[v as usize] = std::mem::replace(&mut self.first[triangle as usize], v);
        }
    }
}

/// Squared distance of a point from a triangle.
#[inline]
pub(super) fn distance(p: Vec3, corners: [Vec3; 3]) -> f32 {
    nearest(corners.map(|c| c - p))
}
