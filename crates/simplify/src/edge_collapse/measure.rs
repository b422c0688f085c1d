//! How far the source is from the coarse cells of each update, measured.
//!
//! Points of the source are followed through the record: a point lies on a cell; when a collapse replaces that
//! cell, the point moves to the nearest of the collapse's coarse cells M⁻ (never to another: only so is its cell
//! part of *every* front in which the collapse is not undone). The largest distance that a collapse sees
//! is its error. In any front each point is on exactly one cell, which was made by an unapplied update,
//! so the largest error of the unapplied updates bounds the distance of all points from the front.
//!
//! Each point's way depends on no other point: they are followed in parallel, and maxima do not depend on order.

use super::collapse::Record;
use crate::{BuildError, Progress};
use glam::Vec3;
use meshfront_hierarchies::edge_collapse::Columns;
use meshfront_mesh::TriangleMesh;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

/// No collapse.
const NONE: u32 = u32::MAX;

pub(super) struct Errors {
    /// Per collapse, mesh units.
    pub collapses: Vec<f32>,
    /// Of the full-resolution front: what quantization alone does.
    pub floor: f32,
}

pub(super) fn measure(source: &TriangleMesh, record: &Record, progress: &dyn Progress) -> Result<Errors, BuildError> {
    let ways = Ways::of(record, source.triangles.len());
    progress.phase("measure", "points", source.positions.len() as u64);
    let squared: Vec<AtomicU32> = (0..record.collapses.len()).map(|_| AtomicU32::new(0)).collect();
    let floor = AtomicU32::new(0);
    let done = AtomicU64::new(0);

    // A triangle of each vertex to start from: vertices of one triangle follow each other, near in memory.
    let mut start = vec![NONE; source.positions.len()];
    for (t, corners) in source.triangles.iter().enumerate() {
        for v in corners {
            if start[v.ix()] == NONE {
                start[v.ix()] = t as u32;
            }
        }
    }
    let points: Vec<u32> = (0..source.positions.len() as u32).filter(|&v| start[v as usize] != NONE).collect();
    points.par_chunks(4096).for_each(|chunk| {
        if progress.cancelled() {
            return;
        }
        for &v in chunk {
            let p = source.positions[v as usize];
            raise(&floor, p.distance_squared(record.positions[v as usize]));
            follow(record, &ways, &squared, p, start[v as usize], NONE);
        }
        progress.at(done.fetch_add(chunk.len() as u64, Relaxed) + chunk.len() as u64);
    });
    if progress.cancelled() {
        return Err(BuildError::Cancelled);
    }
    let root = |a: AtomicU32| f32::from_bits(a.into_inner()).sqrt();
    Ok(Errors { collapses: squared.into_iter().map(root).collect(), floor: root(floor) })
}

/// Where a point goes next: `collapse << 5 | place`, the place of its triangle in the collapse's star, or `VANISHES`.
type Way = u32;
const VANISHES: u32 = 31;
const _: () = assert!(Columns::MAX_STAR <= VANISHES as usize);

struct Ways {
    /// Per source triangle: where its points go first.
    first: Vec<Way>,
    /// Parallel to `Record::star`: where the points on that cell go next.
    next: Vec<Way>,
}

impl Ways {
    fn of(record: &Record, triangles: usize) -> Ways {
        let mut touch = vec![NONE; triangles];
        let mut next = vec![NONE; record.star.len()];
        for i in (0..record.collapses.len()).rev() {
            for (place, e) in record.star_of(i).enumerate() {
                let t = record.star[e].triangle as usize;
                next[e] = std::mem::replace(&mut touch[t], (i as u32) << 5 | place as u32);
            }
            for r in record.removed_of(i) {
                touch[r.triangle as usize] = (i as u32) << 5 | VANISHES;
            }
        }
        Ways { first: touch, next }
    }
}

/// Raises a non-negative `f32` kept as bits, whose order is that of the numbers.
#[inline]
fn raise(cell: &AtomicU32, value: f32) {
    let bits = value.to_bits();
    if cell.load(Relaxed) < bits {
        cell.fetch_max(bits, Relaxed);
    }
}

/// Follows a point from a source triangle through at most `steps` collapses.
fn follow(record: &Record, ways: &Ways, squared: &[AtomicU32], p: Vec3, triangle: u32, steps: u32) {
    let mut way = ways.first[triangle as usize];
    let mut left = steps;
    while way != NONE && left > 0 {
        left -= 1;
        let i = (way >> 5) as usize;
        let star = record.star_of(i);
        let s = record.positions[record.leaves as usize + i] - p;
        let distance = |e: usize| {
            let cell = record.star[e];
            let a = record.positions[cell.after as usize] - p;
            let b = record.positions[cell.before as usize] - p;
            nearest(s, a, b)
        };
        // Mostly the point's own triangle is still there, and the point still above it: then that is near enough.
        let place = way & VANISHES;
        if place != VANISHES {
            let own = star.start + place as usize;
            if let (d, true) = distance(own) {
                raise(&squared[i], d);
                way = ways.next[own];
                continue;
            }
        }
        let mut best = f32::INFINITY;
        way = ways.next[star.start];
        for e in star {
            let (d, _) = distance(e);
            if d < best {
                (best, way) = (d, ways.next[e]);
            }
        }
        raise(&squared[i], best);
    }
}

/// Squared distance of the origin from a triangle, and whether the origin is above its inside (`ericson2005`, 5.1.5:
/// by the region of the nearest point).
#[inline]
fn nearest(a: Vec3, b: Vec3, c: Vec3) -> (f32, bool) {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (-ab.dot(a), -ac.dot(a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a.length_squared(), false);
    }
    let (d3, d4) = (-ab.dot(b), -ac.dot(b));
    if d3 >= 0.0 && d4 <= d3 {
        return (b.length_squared(), false);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return ((a + ab * (d1 / (d1 - d3))).length_squared(), false);
    }
    let (d5, d6) = (-ab.dot(c), -ac.dot(c));
    if d6 >= 0.0 && d5 <= d6 {
        return (c.length_squared(), false);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return ((a + ac * (d2 / (d2 - d6))).length_squared(), false);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return ((b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))).length_squared(), false);
    }
    let n = ab.cross(ac);
    if n.length_squared() < f32::MIN_POSITIVE {
        return (a.length_squared().min(b.length_squared()).min(c.length_squared()), false);
    }
    let along = n.dot(a);
    (along * along / n.length_squared(), true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_agrees_with_a_dense_search() {
        let mut seed = 7u64;
        let mut random = || {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed % 2001) as f32 / 1000.0 - 1.0
        };
        for _ in 0..200 {
            let [a, b, c] = std::array::from_fn(|_| Vec3::new(random(), random(), random()));
            let mut dense = f32::INFINITY;
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let p = a + (b - a) * (i as f32 / 60.0) + (c - a) * (j as f32 / 60.0);
                    dense = dense.min(p.length());
                }
            }
            let d = nearest(a, b, c).0.sqrt();
            assert!(d <= dense + 1e-5 && d >= dense - 0.06, "{d} {dense}");
        }
    }
}
