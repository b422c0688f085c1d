//! The best triangulation of the polygon that a vertex leaves, and what it costs.
//!
//! Dynamic programming over the parts of the polygon (Klincsek 1980, "Minimal triangulations of polygonal domains"): a
//! triangle costs its area times the mean squared distance of its edges' middles from the planes that the quadrics of the
//! vertices around remember; which for a quadric is the integral over the triangle.

use super::rings::{NONE, Rings, Spoke};
use crate::metrics::quadric::Quadric;
use arrayvec::ArrayVec;
use glam::{DVec3, Vec3};
use meshfront_hierarchies::vertex_removal::{MOST_CORNERS, Triangulation};

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

/// Cost of length where the quadrics see none, relative to the area: flat regions get short edges.
const LENGTH_COST: f32 = 1e-7;

/// What removing a vertex costs, and what comes in its place. Corner 0 of the polygon is the first of the vertex's ring.
#[derive(Clone, Copy)]
pub(super) struct Choice {
    /// Squared distance times area; infinite where the vertex has to stay.
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
    pub quadrics: &'a [Quadric],
}

type Table<T> = [[T; MOST_CORNERS]; MOST_CORNERS];

impl Around<'_> {
    /// The best triangulation of the polygon around a vertex.
    pub fn choose(&self, v: u32, guard: Guard) -> Choice {
        let ring = self.rings.of_vertex(v);
        let n = ring.len();
        if !(3..=MOST_CORNERS).contains(&n) {
            return Choice::STAY;
        }
        let open = ring[n - 1].cell == NONE;
        let at = |v: u32| self.points[v as usize];
        let corners: ArrayVec<Vec3, MOST_CORNERS> = ring.iter().map(|s| at(s.vertex)).collect();
        let center = at(v);
        let mean = (0..n - usize::from(open))
            .map(|j| (corners[j] - center).cross(corners[(j + 1) % n] - center))
            .sum::<Vec3>()
            .normalize_or_zero();

        // What the edges would cost, per area; infinite for chords that are edges already.
        let own = self.quadrics[v as usize];
        let mut edge = [[f32::INFINITY; MOST_CORNERS]; MOST_CORNERS];
        let taken = taken_edges(self.rings, ring, open);
        for i in 0..n {
            let half = own + self.quadrics[ring[i].vertex as usize];
            for j in i + 1..n {
                if taken[i] >> j & 1 == 0 {
                    let q = half + self.quadrics[ring[j].vertex as usize];
                    let middle = (corners[i].as_dvec3() + corners[j].as_dvec3()) * 0.5;
                    let weight = q.a[0] + q.a[3] + q.a[5];
                    let squared = if weight > 0.0 { q.at(middle).max(0.0) / weight } else { 0.0 };
                    edge[i][j] = squared as f32 + LENGTH_COST * corners[i].distance_squared(corners[j]);
                }
            }
        }
        if edge[0][n - 1] == f32::INFINITY || (n == 3 && !open && is_tetrahedron(self.rings, ring)) {
            return Choice::STAY;
        }

        let mut best: Table<f32> = [[0.0; MOST_CORNERS]; MOST_CORNERS];
        let mut apex: Table<u8> = [[0; MOST_CORNERS]; MOST_CORNERS];
        for size in 2..n {
            for i in 0..n - size {
                let j = i + size;
                best[i][j] = f32::INFINITY;
                if edge[i][j] == f32::INFINITY {
                    continue;
                }
                let chord = corners[j] - corners[i];
                let chord_squared = chord.length_squared();
                for a in i + 1..j {
                    let parts = best[i][a] + best[a][j];
                    if parts >= best[i][j] {
                        continue;
                    }
                    let (left, right) = (corners[a] - corners[i], corners[j] - corners[a]);
                    let normal = left.cross(chord);
                    let area = normal.length();
                    let squares = chord_squared + left.length_squared() + right.length_squared();
                    if area < guard.shape * squares || normal.dot(mean) < guard.cos * area {
                        continue;
                    }
                    let cost = parts + area * (1.0 / 6.0) * (edge[i][a] + edge[a][j] + edge[i][j]);
                    if cost < best[i][j] {
                        (best[i][j], apex[i][j]) = (cost, a as u8);
                    }
                }
            }
        }
        let mut cost = best[0][n - 1];
        if cost == f32::INFINITY {
            return Choice::STAY;
        }
        if open {
            // The boundary gets a new edge: what v remembers of the old ones is measured from it.
            let [from, to] = [corners[n - 1], corners[0]].map(Vec3::as_dvec3);
            cost += own.at(nearest_on(from, to, center.as_dvec3())).max(0.0) as f32;
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
        let triangulation = Triangulation::of(n, &triangles).expect("parts make a whole");
        Choice { cost, triangulation }
    }
}

/// Bit j of entry i < j: corners i and j of the polygon may not be joined, because an edge outside of it joins them.
fn taken_edges(rings: &Rings, ring: &[Spoke], open: bool) -> [u16; MOST_CORNERS] {
    let n = ring.len();
    let mut taken = [0; MOST_CORNERS];
    for i in 0..n - 1 {
        for s in rings.of_vertex(ring[i].vertex) {
            if let Some(j) = (i + 1..n).find(|&j| ring[j].vertex == s.vertex) {
                let side = j == i + 1 || (i == 0 && j == n - 1 && !open);
                taken[i] |= u16::from(!side) << j;
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
    !(ring.len() == 3 && !open && is_tetrahedron(rings, ring))
        && !triangulation.triangles().iter().any(|&[i, a, j]| joined(i, a) || joined(a, j) || joined(i, j))
}

/// The point of a segment nearest to another.
fn nearest_on(a: DVec3, b: DVec3, p: DVec3) -> DVec3 {
    let along = (p - a).dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE);
    a + (b - a) * along.clamp(0.0, 1.0)
}
