//! How far the source is from the coarse cells of each update, measured.
//!
//! Points of the source are followed through the record of a simplification: a point lies on a cell; when a step replaces that
//! cell, the point moves to the nearest of the step's coarse cells M⁻ (never to another: only so is its cell
//! part of *every* front in which the step is not undone). The largest distance that a step sees
//! is its error. In any front each point is on exactly one cell, which was made by an unapplied update,
//! so the largest error of the unapplied updates bounds the distance of all points from the front.
//!
//! Each point's way depends on no other point: they are followed in parallel, and maxima do not depend on order.

use crate::{BuildError, Progress};
use glam::Vec3;
use meshfront_mesh::{TriangleMesh, VertexId};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

/// A record that points can be followed through: which cells each step replaces by which, fine to coarse.
pub(crate) trait Trail: Sync {
    /// What a [`Way`] fits into: more bits for more coarse cells in a step.
    type Word: Word;
    /// Whether the coarse cells of a step are a fan, each next to the one before.
    const FAN: bool;
    /// Whether all vertices of coarse cells are where the source has one. The distance of a source triangle from the coarse
    /// cells is then greatest on its edges: where they end, or cross those of coarse cells.
    const KEEPS_VERTICES: bool;
    /// Whether what lies on a cell is a surface like the one that a point comes from, as dense as it is. Where objects join, few
    /// points may speak for a whole one.
    const EVEN: bool;
    /// Number of steps.
    fn steps(&self) -> usize;
    /// Where a source vertex is at full resolution: on the grid, where there is one.
    fn position(&self, vertex: VertexId) -> Vec3;
    /// Whether a source vertex lies on an edge with other than two triangles.
    fn on_rim(&self, vertex: VertexId) -> bool;
    /// The coarse cells of a step: their indices among those of all steps.
    fn coarse(&self, step: usize) -> Range<usize>;
    /// The corners of one of them.
    fn corners(&self, step: usize, cell: usize) -> [Vec3; 3];
    /// Where the vertices are that a step takes away.
    fn gone(&self, step: usize) -> impl Iterator<Item = Vec3>;
    /// Where points go, given the number of source triangles.
    fn ways(&self, triangles: usize) -> Ways<Self::Word>;
}

/// What holds a [`Way`].
pub(crate) trait Word: Copy + PartialEq + Send + Sync {
    /// As many coarse cells as a step may have.
    const MOST_CELLS: usize;
    const MAX: Self;
    fn pack(bits: u64) -> Self;
    fn bits(self) -> u64;
}

impl Word for u32 {
    const MOST_CELLS: usize = 32;
    const MAX: u32 = u32::MAX;
    #[inline]
    fn pack(bits: u64) -> u32 {
        bits as u32
    }
    #[inline]
    fn bits(self) -> u64 {
        self as u64
    }
}

/// For large stars.
impl Word for u64 {
    const MOST_CELLS: usize = 1 << 20;
    const MAX: u64 = u64::MAX;
    #[inline]
    fn pack(bits: u64) -> u64 {
        bits
    }
    #[inline]
    fn bits(self) -> u64 {
        self
    }
}

/// Where the points on a cell go next.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Way<W>(W);

impl<W: Word> Way<W> {
    /// Nowhere: no step replaces the cell.
    pub const NONE: Way<W> = Way(W::MAX);
    const BITS: u32 = W::MOST_CELLS.trailing_zeros();

    /// To the place-th coarse cell of a step, which is the cell itself, moved.
    pub fn stays(step: usize, place: usize) -> Way<W> {
        Way(W::pack((step as u64) << (Self::BITS + 1) | place as u64))
    }
    /// To the coarse cells of a step, of which the place-th is near: the cell itself is gone.
    pub fn vanishes(step: usize, place: usize) -> Way<W> {
        Way(W::pack(Self::stays(step, place).0.bits() | 1 << Self::BITS))
    }
    pub fn step(self) -> usize {
        (self.0.bits() >> (Self::BITS + 1)) as usize
    }
    fn place(self) -> usize {
        self.0.bits() as usize & (W::MOST_CELLS - 1)
    }
    fn is_to_itself(self) -> bool {
        self.0.bits() >> Self::BITS & 1 == 0
    }
}

pub(crate) struct Ways<W> {
    /// Per source triangle: where its points go first.
    pub first: Vec<Way<W>>,
    /// Per coarse cell: where the points on it go next.
    pub next: Vec<Way<W>>,
}

pub(crate) struct Errors {
    /// Per step, mesh units.
    pub steps: Vec<f32>,
    /// Of the full-resolution front: what quantization alone does.
    pub floor: f32,
}

/// Followed points: source vertices, `pieces - 1` inside each edge, and inside each triangle those of a lattice that
/// is finer by one, where there may be a greatest distance.
#[derive(Clone, Copy)]
struct Sampling {
    pieces: u32,
    inside: bool,
}

impl Sampling {
    /// The fewest: middles of edges and of triangles.
    const FEWEST: Sampling = Sampling { pieces: 2, inside: true };

    /// Small meshes can afford more points, and need them: few triangles stand behind each cell.
    fn of<T: Trail>(triangles: usize) -> Sampling {
        const MOST_PIECES: u32 = 8;
        let (fewest, most_points) =
            if T::KEEPS_VERTICES { (Sampling { pieces: 4, inside: false }, 8e5) } else { (Sampling::FEWEST, 4e5) };
        let fits = |s: &Sampling| s.per_triangle() * triangles as f32 <= most_points;
        let finer = (fewest.pieces..=MOST_PIECES).rev().map(|pieces| Sampling { pieces, ..fewest });
        finer.into_iter().find(fits).unwrap_or(fewest)
    }
    /// Its inside, half of each edge, a sixth of each corner.
    fn per_triangle(self) -> f32 {
        let n = self.pieces as f32;
        let inside = if self.inside { n * (n - 1.0) * 0.5 } else { 0.0 };
        inside + 1.5 * (n - 1.0) + 0.5
    }
    /// What the distance of all other points may exceed that of the followed ones by, on a cell with the area of so many
    /// source triangles like the one that the point comes from (the square of that number is given).
    ///
    /// Set from dense samples, and the suite checks it too. Where points lie everywhere, on scans and on small random
    /// complexes: most where cells are of the size of the source's triangles, so that few points are on each. Where points lie on
    /// edges, the pieces count: of a million samples on scans, terrains and knots of 1,000 to 100,000 triangles the farthest
    /// was up to 1.7 times as far with 4 pieces, 1.34 times with 6, 1.3 times with 8. Where no point is left out, of 400,000 samples
    /// on scans, parts, sheets that share edges, terrains and knots of 2,000 to 150,000 triangles, the farthest was 1.57 times as
    /// far with 2 pieces, 1.35 times with 3, 1.2 times with 4 and 1.13 times with 8; less than 1.1 times on cells of the area of
    /// sixteen triangles or more.
    #[inline]
    fn margin<T: Trail>(self, triangles_squared: f32) -> f32 {
        let doublings = 0.5 * triangles_squared.max(1.0).log2();
        if !T::EVEN {
            1.0 + (2.4 / self.pieces as f32 - 0.08 * doublings).max(0.2)
        } else if self.inside {
            (2.9 - 0.15 * doublings).clamp(1.4, 2.3)
        } else {
            1.0 + 4.0 / self.pieces as f32
        }
    }
    /// As fractions of an edge.
    fn on_edge(self) -> impl Iterator<Item = f32> {
        (1..self.pieces).map(move |i| i as f32 / self.pieces as f32)
    }
    /// As weights of the second and the third corner.
    fn within(self) -> impl Iterator<Item = [f32; 2]> {
        let n = if self.inside { self.pieces + 1 } else { 1 };
        (1..n).flat_map(move |i| (1..n - i).map(move |j| [i as f32 / n as f32, j as f32 / n as f32]))
    }
}

/// How many points a cell keeps, on average. With more, those that are no farther away than the step itself moved
/// the surface are thinned out: neighbours see what they would see.
const PER_CELL: f32 = 10.0;
/// Measures the error of each step, in parallel; the result does not depend on the number of threads.
pub(crate) fn measure<T: Trail>(
    source: &TriangleMesh,
    trail: &T,
    progress: &dyn Progress,
) -> Result<Errors, BuildError> {
    let count = source.triangles.len();
    progress.phase("measure", "triangles", count as u64);
    let ways = trail.ways(count);
    let squared: Vec<AtomicU32> = (0..trail.steps()).map(|_| AtomicU32::new(0)).collect();
    let floor = AtomicU32::new(0);
    let sampling = Sampling::of::<T>(count);
    let done = AtomicU64::new(0);

    // Each vertex goes with the first triangle that has it, so that what goes the same way goes together.
    let mut seen = vec![false; source.positions.len()];
    let first_here = |v: VertexId| !std::mem::replace(&mut seen[v.ix()], true);
    let fresh: Vec<[bool; 3]> = source
        .triangles
        .iter()
        .map({
            let mut first_here = first_here;
            move |t| t.map(&mut first_here)
        })
        .collect();

    let moved: Vec<f32> = (0..trail.steps()).into_par_iter().map(|i| moved(trail, i)).collect();
    let walk = Walk { trail, sampling, ways: &ways, moved: &moved, squared: &squared };
    let triangles: Vec<u32> = (0..count as u32).collect();
    triangles.par_chunks(4096).for_each(|chunk| {
        if progress.cancelled() {
            return;
        }
        for &t in chunk {
            let corners = source.triangles[t as usize];
            let [a, b, c] = corners.map(|v| source.positions[v.ix()]);
            let area = (b - a).cross(c - a).length();
            // A sliver stands for as little as its area, and says as little as its length.
            let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
            let mut count = 0;
            let mut follow = |p: Vec3| {
                count += 1;
                walk.follow(p, t, longest, PER_CELL * area / Sampling::FEWEST.per_triangle() / fraction(t, count));
            };
            for k in 0..3 {
                if fresh[t as usize][k] {
                    let at = source.positions[corners[k].ix()];
                    raise(&floor, at.distance_squared(trail.position(corners[k])));
                    follow(at);
                }
            }
            for [along_b, along_c] in sampling.within() {
                follow(a + (b - a) * along_b + (c - a) * along_c);
            }
            for (k, p, q) in [(0, a, b), (1, b, c), (2, c, a)] {
                // An inner edge is seen from both sides: it is followed from one.
                let (from, to) = (corners[k], corners[(k + 1) % 3]);
                if from < to || (trail.on_rim(from) && trail.on_rim(to)) {
                    for along in sampling.on_edge() {
                        follow(p + (q - p) * along);
                    }
                }
            }
        }
        progress.at(done.fetch_add(chunk.len() as u64, Relaxed) + chunk.len() as u64);
    });
    if progress.cancelled() {
        return Err(BuildError::Cancelled);
    }
    let root = |a: AtomicU32| f32::from_bits(a.into_inner()).sqrt();
    Ok(Errors { steps: squared.into_iter().map(root).collect(), floor: root(floor) })
}

/// A number in (0, 1] that looks random: the same for the same point on every machine.
fn fraction(triangle: u32, count: u32) -> f32 {
    let mut x = (triangle as u64) << 8 | count as u64;
    x = (x ^ x >> 31).wrapping_mul(0x7fb5_d329_728e_a185);
    x = (x ^ x >> 27).wrapping_mul(0x81da_def4_bc2d_d44d);
    ((x >> 40) + 1) as f32 / (1 << 24) as f32
}

/// The squared distance from the surface of the farthest of the vertices that a step takes away.
fn moved(trail: &impl Trail, step: usize) -> f32 {
    let from = |p: Vec3| {
        trail.coarse(step).map(|e| nearest(seen_from(p, trail.corners(step, e)))).fold(f32::INFINITY, f32::min)
    };
    trail.gone(step).map(from).fold(0.0, f32::max)
}

#[inline]
fn seen_from(p: Vec3, corners: [Vec3; 3]) -> [Vec3; 3] {
    corners.map(|c| c - p)
}

/// What points are followed through.
struct Walk<'a, T: Trail> {
    trail: &'a T,
    sampling: Sampling,
    ways: &'a Ways<T::Word>,
    moved: &'a [f32],
    squared: &'a [AtomicU32],
}

impl<T: Trail> Walk<'_, T> {
    /// Follows a point from a source triangle of twice this area until no step is left, or until its cell has more
    /// than `PER_CELL` points a `fraction` of which stays, and is no farther than the step itself moved the surface.
    fn follow(&self, p: Vec3, triangle: u32, longest: f32, crowd: f32) {
        let per_area_squared = 4.0 / 3.0 / (longest * longest).max(f32::MIN_POSITIVE);
        let crowd_squared = crowd * crowd;
        let mut way = self.ways.first[triangle as usize];
        while way != Way::NONE {
            let i = way.step();
            let cells = self.trail.coarse(i);
            let start = cells.start + way.place();
            let corners = self.cell(i, start, p);
            // Mostly the point's own triangle is still there, or one on the same side, and the point above it: that is near
            // enough.
            let own = if way.is_to_itself() || !T::FAN { above(corners) } else { None };
            let (mut distance, mut at) = match own {
                Some(distance) => (distance, start),
                None if T::FAN => self.nearest_in_fan(i, &cells, start, nearest(corners), p),
                None => (f32::INFINITY, start),
            };
            if distance > self.moved[i] {
                // It may be the one that counts: look at all cells.
                for e in cells {
                    let d = nearest(self.cell(i, e, p));
                    if d < distance {
                        (distance, at) = (d, e);
                    }
                }
            }
            let [a, b, c] = self.cell(i, at, p);
            let area_squared = (b - a).cross(c - a).length_squared();
            raise(&self.squared[i], distance * self.sampling.margin::<T>(area_squared * per_area_squared).powi(2));
            way = self.ways.next[at];
            if T::EVEN && distance <= self.moved[i] && area_squared > crowd_squared {
                return;
            }
        }
    }

    /// The corners of a coarse cell as seen from a point.
    #[inline]
    fn cell(&self, step: usize, cell: usize, p: Vec3) -> [Vec3; 3] {
        seen_from(p, self.trail.corners(step, cell))
    }

    /// Walks around a fan in both directions for as long as cells are no farther.
    #[inline]
    fn nearest_in_fan(&self, i: usize, fan: &Range<usize>, start: usize, distance: f32, p: Vec3) -> (f32, usize) {
        let mut best = (distance, start);
        let mut at = start;
        loop {
            at = if at + 1 == fan.end { fan.start } else { at + 1 };
            let distance = if at == start { f32::INFINITY } else { nearest(self.cell(i, at, p)) };
            if distance > best.0 {
                break;
            }
            best = (distance, at);
        }
        let stop = best.1;
        at = start;
        loop {
            at = if at == fan.start { fan.end - 1 } else { at - 1 };
            let distance = if at == stop { f32::INFINITY } else { nearest(self.cell(i, at, p)) };
            if distance > best.0 {
                break;
            }
            best = (distance, at);
        }
        best
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

/// The squared distance of the origin from a triangle where the origin is above its inside.
#[inline]
fn above([a, b, c]: [Vec3; 3]) -> Option<f32> {
    let n = (b - a).cross(c - a);
    let inside = a.cross(b).dot(n).min(b.cross(c).dot(n)).min(c.cross(a).dot(n));
    let squared = n.length_squared();
    if inside >= 0.0 && squared >= f32::MIN_POSITIVE {
        let along = n.dot(a);
        return Some(along * along / squared);
    }
    None
}

/// Squared distance of the origin from a triangle (`ericson2005`, 5.1.5: by the region of the nearest point).
#[inline]
pub(crate) fn nearest([a, b, c]: [Vec3; 3]) -> f32 {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (-ab.dot(a), -ac.dot(a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a.length_squared();
    }
    let (d3, d4) = (-ab.dot(b), -ac.dot(b));
    if d3 >= 0.0 && d4 <= d3 {
        return b.length_squared();
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3))).length_squared();
    }
    let (d5, d6) = (-ab.dot(c), -ac.dot(c));
    if d6 >= 0.0 && d5 <= d6 {
        return c.length_squared();
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6))).length_squared();
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return (b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))).length_squared();
    }
    let n = ab.cross(ac);
    if n.length_squared() < f32::MIN_POSITIVE {
        return a.length_squared().min(b.length_squared()).min(c.length_squared());
    }
    let along = n.dot(a);
    along * along / n.length_squared()
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
            let d = nearest([a, b, c]).sqrt();
            assert!(d <= dense + 1e-5 && d >= dense - 0.06, "{d} {dense}");
        }
    }
}
