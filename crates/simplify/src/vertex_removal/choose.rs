//! The best triangulation of the polygon that a vertex leaves, and what it costs.
//!
//! Dynamic programming over the parts of the polygon (`klincsek1980`). A triangle costs the squared distances from its
//! plane of the samples above and below it, each times the area that it stands for: vertices that went before, the vertex that
//! goes now, and, where those are few, the middles of the fan's spokes. Above and below is along the mean normal of the fan:
//! seen so, each sample is in one triangle of each triangulation, and the best one is found among all.

use super::rings::{NONE, Rings, Spoke};
use super::samples::{self, Samples};
use crate::metrics::quadric::Quadric;
use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};
use meshfront_hierarchies::vertex_removal::{MOST_CORNERS, Triangulation};
use std::collections::HashMap;

/// What a new triangle must keep.
#[derive(Clone, Copy)]
pub(super) struct Guard {
    /// Its normal may be off the mean normal of the fan by at most the angle of this cosine.
    cos: f32,
    /// Its |cross product| over the sum of its squared edges (0.289 when equilateral) may fall to this.
    shape: f32,
}

/// Strict first; when nothing is left that keeps the guard, the next one lets through what blocks the rest.
pub(super) const GUARDS: [Guard; 3] =
    [Guard { cos: 0.2, shape: 0.005 }, Guard { cos: 0.0, shape: 0.001 }, Guard { cos: -0.5, shape: 0.0 }];

/// Cost of length where samples say nothing, relative to area times squared length: flat regions get short edges.
const LENGTH_COST: f32 = 1e-7;
/// The area that spokes stand for, of that of the fan, where there is no sample but the vertex.
const SPOKE_WEIGHT: f32 = 0.6;

/// What removing a vertex costs, and what comes in its place. Corner 0 of the polygon is the first of the vertex's ring.
#[derive(Clone, Copy)]
pub(super) struct Choice {
    /// By how much squared distance times area grows; infinite where the vertex has to stay.
    pub cost: f32,
    pub triangulation: Triangulation,
}

impl Choice {
    pub const STAY: Choice = Choice { cost: f32::INFINITY, triangulation: Triangulation { corners: 3, index: 0 } };
}

/// What choosing looks at.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub rings: &'a Rings,
    pub points: &'a [Vec3],
    pub samples: &'a Samples,
    /// Per boundary vertex: the planes of the boundary that it stands for.
    pub rims: &'a HashMap<u32, Quadric>,
}

/// Entry [i][j] is about corners i < j.
type Table<T> = [[T; MOST_CORNERS]; MOST_CORNERS];

/// A place of the surface as it is, or was.
#[derive(Clone, Copy)]
struct Sample {
    at: Vec3,
    flat: Vec2,
    weight: f32,
}

/// Bits of a mask: eight samples for each of eleven cells, the vertex and the spokes.
const MOST_SAMPLES: usize = 128;
const _: () = assert!(MOST_SAMPLES > (samples::MOST + 1) * MOST_CORNERS);

/// A vertex with its polygon. The vertex is the origin; `flat` is seen along the mean normal of the fan.
struct Star {
    corners: ArrayVec<Vec3, MOST_CORNERS>,
    flat: ArrayVec<Vec2, MOST_CORNERS>,
    mean: Vec3,
    samples: ArrayVec<Sample, MOST_SAMPLES>,
    /// What the fan costs as it is.
    before: f32,
    open: bool,
}

impl Around<'_> {
    /// The best triangulation of the polygon around a vertex.
    pub fn choose(&self, v: u32, guard: Guard) -> Choice {
        let ring = self.rings.of_vertex(v);
        let n = ring.len();
        if !(3..=MOST_CORNERS).contains(&n) {
            return Choice::STAY;
        }
        let open = ring[n - 1].cell == NONE;
        let taken = taken_edges(self.rings, ring, open);
        if taken[0] >> (n - 1) & 1 == 1 || (n == 3 && !open && is_tetrahedron(self.rings, ring)) {
            return Choice::STAY;
        }
        let star = self.star(v, ring, open);
        let (left, outside) = star.left();
        let Some((mut cost, triangulation)) = star.best(&taken, &left, guard) else {
            return Choice::STAY;
        };
        if open {
            // The boundary gets a new edge: what v remembers of the old ones is measured from it.
            let near = nearest_on(star.corners[n - 1], star.corners[0], Vec3::ZERO) + self.points[v as usize];
            let rim = self.rims.get(&v).map_or(0.0, |q| q.at(near.as_dvec3()));
            cost += outside + rim.max(0.0) as f32;
        }
        Choice { cost: (cost - star.before).max(0.0), triangulation }
    }

    fn star(&self, v: u32, ring: &[Spoke], open: bool) -> Star {
        let n = ring.len();
        let center = self.points[v as usize];
        let corners: ArrayVec<Vec3, MOST_CORNERS> =
            ring.iter().map(|s| self.points[s.vertex as usize] - center).collect();
        let fan = n - usize::from(open);
        let normals: ArrayVec<Vec3, MOST_CORNERS> = (0..fan).map(|j| corners[j].cross(corners[(j + 1) % n])).collect();
        let mean = normals.iter().sum::<Vec3>().normalize_or_zero();
        let (x, y) = if mean == Vec3::ZERO { (Vec3::X, Vec3::Y) } else { mean.any_orthonormal_pair() };
        let flatten = |p: Vec3| Vec2::new(p.dot(x), p.dot(y));

        let mut samples = ArrayVec::new();
        let mut add = |at: Vec3, weight: f32| samples.push(Sample { at, flat: flatten(at), weight });
        let mut before = 0.0;
        let mut count = 0;
        for (normal, s) in normals.iter().zip(ring) {
            let upright = normal.normalize_or_zero();
            for sample in self.samples.of(s.cell) {
                let at = self.samples.points[sample as usize] - center;
                let weight = self.samples.weight[sample as usize];
                add(at, weight);
                before += weight * upright.dot(at).powi(2);
                count += 1;
            }
        }
        add(Vec3::ZERO, self.samples.weight[v as usize]);
        // Where few are there, the spokes say how the fan lies.
        let area: f32 = normals.iter().map(|n| n.length()).sum();
        corners.iter().for_each(|&c| add(c * 0.5, SPOKE_WEIGHT * area / (n + count) as f32));
        Star { flat: corners.iter().map(|&c| flatten(c)).collect(), corners, mean, samples, before, open }
    }
}

impl Star {
    /// Per chord: the samples to the left of it, as a mask. What is outside of a side belongs to the triangle on it; but what
    /// is beyond the new edge of a boundary costs its distance from there, which is given too.
    fn left(&self) -> (Table<u128>, f32) {
        let n = self.corners.len();
        let mut left: Table<u128> = [[0; MOST_CORNERS]; MOST_CORNERS];
        let mut outside = 0.0;
        for i in 0..n {
            for j in i + 1..n {
                let closing = i == 0 && j == n - 1;
                if j == i + 1 {
                    left[i][j] = u128::MAX >> (MOST_SAMPLES - self.samples.len());
                    continue;
                }
                if closing && !self.open {
                    continue;
                }
                let chord = self.flat[j] - self.flat[i];
                for (k, s) in self.samples.iter().enumerate() {
                    let is_left = chord.perp_dot(s.flat - self.flat[i]) >= 0.0;
                    left[i][j] |= u128::from(is_left) << k;
                    if closing && is_left {
                        outside += s.weight * s.at.distance_squared(nearest_on(self.corners[i], self.corners[j], s.at));
                    }
                }
            }
        }
        (left, outside)
    }

    /// The triangulation of least cost that joins no corners that are joined already and keeps the guard.
    fn best(&self, taken: &[u16; MOST_CORNERS], left: &Table<u128>, guard: Guard) -> Option<(f32, Triangulation)> {
        let n = self.corners.len();
        let mut best: Table<f32> = [[0.0; MOST_CORNERS]; MOST_CORNERS];
        let mut apex: Table<u8> = [[0; MOST_CORNERS]; MOST_CORNERS];
        for size in 2..n {
            for i in 0..n - size {
                let j = i + size;
                best[i][j] = f32::INFINITY;
                if taken[i] >> j & 1 == 1 {
                    continue;
                }
                for a in i + 1..j {
                    let parts = best[i][a] + best[a][j];
                    if parts >= best[i][j] {
                        continue;
                    }
                    let inside = left[i][a] & left[a][j] & !left[i][j];
                    let cost = parts + self.cost([i, a, j].map(|c| self.corners[c]), inside, guard);
                    if cost < best[i][j] {
                        (best[i][j], apex[i][j]) = (cost, a as u8);
                    }
                }
            }
        }
        let cost = best[0][n - 1];
        if cost == f32::INFINITY {
            return None;
        }
        let mut triangles = ArrayVec::<[u8; 3], MOST_CORNERS>::new();
        let mut parts = ArrayVec::<[u8; 2], MOST_CORNERS>::new();
        parts.push([0, n as u8 - 1]);
        while let Some([i, j]) = parts.pop() {
            if j - i > 1 {
                let a = apex[i as usize][j as usize];
                triangles.push([i, a, j]);
                parts.extend([[a, j], [i, a]]);
            }
        }
        Some((cost, Triangulation::of(n, &triangles).expect("parts make a whole")))
    }

    /// What a triangle costs with the samples of a mask on it; infinite where it does not keep the guard.
    #[inline]
    fn cost(&self, [p, q, r]: [Vec3; 3], mut inside: u128, guard: Guard) -> f32 {
        let normal = (q - p).cross(r - p);
        let area = normal.length();
        let squares = (q - p).length_squared() + (r - q).length_squared() + (p - r).length_squared();
        if area < guard.shape * squares || normal.dot(self.mean) < guard.cos * area {
            return f32::INFINITY;
        }
        let upright = normal / area.max(f32::MIN_POSITIVE);
        let mut moment = 0.0;
        while inside != 0 {
            let s = &self.samples[inside.trailing_zeros() as usize];
            inside &= inside - 1;
            moment += s.weight * upright.dot(s.at - p).powi(2);
        }
        moment + LENGTH_COST * area * squares
    }
}

/// Bit j of entry i < j: corners i and j of the polygon may not be joined, because an edge outside of it joins them.
fn taken_edges(rings: &Rings, ring: &[Spoke], open: bool) -> [u16; MOST_CORNERS] {
    let n = ring.len();
    let mut taken = [0; MOST_CORNERS];
    let mut mark = |i: usize, j: usize| {
        let (i, j) = (i.min(j), i.max(j));
        let side = j == i + 1 || (i == 0 && j == n - 1 && !open);
        taken[i] |= u16::from(!side) << j;
    };
    // An edge is seen from both its ends: where many meet at one, the other one is asked.
    const LONG: usize = 64;
    let neighbours = |i: usize| rings.of_vertex(ring[i].vertex);
    for i in 0..n {
        if neighbours(i).len() <= LONG {
            for s in neighbours(i) {
                if let Some(j) = (0..n).find(|&j| ring[j].vertex == s.vertex) {
                    mark(i, j);
                }
            }
            continue;
        }
        for j in (0..i).filter(|&j| neighbours(j).len() > LONG) {
            let (few, other) = if neighbours(i).len() < neighbours(j).len() { (i, j) } else { (j, i) };
            if neighbours(few).iter().any(|s| s.vertex == ring[other].vertex) {
                mark(i, j);
            }
        }
    }
    taken
}

/// Whether the triangle between the three neighbours of a vertex is there already.
fn is_tetrahedron(rings: &Rings, ring: &[Spoke]) -> bool {
    ring.iter().all(|s| rings.of_vertex(s.vertex).len() == 3 && !rings.is_open(s.vertex))
}

/// Whether a triangulation that was chosen before may still be made: other removals may have joined corners since.
pub(super) fn is_free(rings: &Rings, v: u32, triangulation: Triangulation) -> bool {
    let ring = rings.of_vertex(v);
    let open = rings.is_open(v);
    let taken = taken_edges(rings, ring, open);
    let joined = |i: u8, j: u8| taken[i as usize] >> j & 1 == 1;
    let blocked = triangulation.triangles().iter().any(|&[i, a, j]| joined(i, a) || joined(a, j) || joined(i, j));
    !blocked && (open || ring.len() > 3 || !is_tetrahedron(rings, ring))
}

/// The point of a segment nearest to another.
fn nearest_on(a: Vec3, b: Vec3, p: Vec3) -> Vec3 {
    let along = (p - a).dot(b - a) / (b - a).length_squared().max(f32::MIN_POSITIVE);
    a + (b - a) * along.clamp(0.0, 1.0)
}
