//! Neighbours in space: the edges of a three-dimensional Delaunay triangulation, by insertion (`bowyer1981`, `watson1981`).
//!
//! Every decision is exact (`shewchuk1997`, the crate `robust`), and points are shaken by a billionth of their extent first, so
//! that no five lie on one sphere: grids, circles and planes, of which machine parts are made, are as fast as any other points.
//! The corners of a tetrahedron far around take the place of infinity, so flat sets need no case of their own. What a large
//! empty ball alone would show is lost: of edges between neighbours, none.

use crate::order::morton;
use glam::{DVec3, Vec3};
use meshfront_mesh::Bounds;
use robust::{Coord3D, insphere, orient3d};

/// How far points are shaken, relative to the diagonal: less than an `f32` can say, and far more than rounding in `f64`.
const SHAKE: f64 = 1e-9;
/// How far the outer corners are, in diagonals.
const FAR: f64 = 100.0;
/// Number of outer corners, the first points.
const OUTER: u32 = 4;
const NONE: u32 = u32::MAX;

/// Positive as `robust` has it: [`orient3d`] of the corners is above 0. Not in use where the corners are `NONE`.
#[derive(Clone, Copy)]
struct Tetrahedron {
    corners: [u32; 4],
    /// Tetrahedra across the face opposite to each corner.
    across: [u32; 4],
}

/// All Delaunay edges no longer than `longest`, each once, ascending. Some 10 µs a point and 300 bytes.
pub(crate) fn edges(points: &[Vec3], longest: f32) -> Vec<[u32; 2]> {
    let Some(bounds) = Bounds::of(points) else { return vec![] };
    let triangulation = Triangulation::of(points, &bounds);
    let mut edges = vec![];
    for t in &triangulation.tetrahedra {
        if t.corners[0] == NONE {
            continue;
        }
        let inner = t.corners.map(|c| c.checked_sub(OUTER));
        for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            if let (Some(a), Some(b)) = (inner[i], inner[j])
                && points[a as usize].distance_squared(points[b as usize]) <= longest * longest
            {
                edges.push([a.min(b), a.max(b)]);
            }
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges
}

struct Triangulation {
    /// The outer corners, then all points, shaken.
    points: Vec<Coord3D<f64>>,
    tetrahedra: Vec<Tetrahedron>,
    /// Tetrahedra that are not in use.
    free: Vec<u32>,
    /// Per tetrahedron: the last insertion that looked at it, and what it saw: 2i + 1 where the new point is in its ball, 2i else.
    seen: Vec<u32>,
    /// Scratch: tetrahedra whose balls hold the new point; and faces around them, as (edge of the face, new tetrahedron, corner).
    cavity: Vec<u32>,
    open: Vec<([u32; 2], u32, u8)>,
}

impl Triangulation {
    fn of(points: &[Vec3], bounds: &Bounds) -> Triangulation {
        let [min, max] = [bounds.min, bounds.max].map(|p| p.as_dvec3());
        let (middle, diagonal) = ((min + max) * 0.5, min.distance(max).max(f64::MIN_POSITIVE));
        let corners =
            [DVec3::ONE, DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::new(-1.0, -1.0, 1.0)];
        let outer = corners.map(|c| coord(middle + c * (FAR * diagonal)));
        let shaken = |(i, p): (usize, &Vec3)| {
            let shift = DVec3::from_array(std::array::from_fn(|axis| random(3 * i as u64 + axis as u64)));
            coord(p.as_dvec3() + shift * (SHAKE * diagonal))
        };
        let mut all = Triangulation {
            points: outer.into_iter().chain(points.iter().enumerate().map(shaken)).collect(),
            tetrahedra: Vec::with_capacity(7 * points.len() + 1),
            free: vec![],
            seen: vec![NONE],
            cavity: vec![],
            open: vec![],
        };
        let mut first = Tetrahedron { corners: [0, 1, 2, 3], across: [NONE; 4] };
        if all.turn(first.corners) < 0.0 {
            first.corners.swap(0, 1);
        }
        all.tetrahedra.push(first);
        // Neighbours in space one after the other: the way to the next is short.
        let mut order: Vec<(u64, u32)> =
            points.iter().enumerate().map(|(i, &p)| (morton(bounds, p), i as u32)).collect();
        order.sort_unstable();
        let mut near = 0;
        for (i, (_, p)) in order.into_iter().enumerate() {
            near = all.insert(p + OUTER, i as u32, near);
        }
        all
    }

    fn turn(&self, corners: [u32; 4]) -> f64 {
        let [a, b, c, d] = corners.map(|v| self.points[v as usize]);
        orient3d(a, b, c, d)
    }

    /// The tetrahedron that holds a point, walking from another.
    fn locate(&self, p: u32, from: u32) -> u32 {
        let mut at = from;
        let mut first = 0;
        'walk: loop {
            let t = self.tetrahedra[at as usize];
            // Faces in turn: no walk goes in circles (`devillers2002`).
            first = (first + 1) % 4;
            for k in (0..4).map(|k| (first + k) % 4) {
                let mut corners = t.corners;
                corners[k] = p;
                if t.across[k] != NONE && self.turn(corners) < 0.0 {
                    at = t.across[k];
                    continue 'walk;
                }
            }
            return at;
        }
    }

    /// Replaces the tetrahedra whose balls hold a point by those that join it to the faces around them; gives one of these.
    fn insert(&mut self, p: u32, insertion: u32, near: u32) -> u32 {
        let start = self.locate(p, near);
        let (inside, outside) = (2 * insertion + 1, 2 * insertion);
        self.cavity.clear();
        self.open.clear();
        self.cavity.push(start);
        self.seen[start as usize] = inside;
        let mut next = 0;
        // Faces around the cavity: corners, and the tetrahedron outside.
        let mut faces: Vec<(Tetrahedron, usize)> = vec![];
        while next < self.cavity.len() {
            let at = self.cavity[next];
            let t = self.tetrahedra[at as usize];
            next += 1;
            for k in 0..4 {
                let other = t.across[k];
                if other != NONE && self.seen[other as usize] != inside {
                    if self.seen[other as usize] != outside && self.ball_holds(other, p) {
                        self.seen[other as usize] = inside;
                        self.cavity.push(other);
                        continue;
                    }
                    self.seen[other as usize] = outside;
                }
                if other == NONE || self.seen[other as usize] == outside {
                    let mut new = t;
                    new.corners[k] = p;
                    new.across = [NONE; 4];
                    new.across[k] = other;
                    // The face as the neighbour knows it: it is across from there to `at`.
                    if other != NONE {
                        let back = self.tetrahedra[other as usize].across.iter().position(|&x| x == at);
                        faces.push((new, back.expect("neighbours know each other")));
                    } else {
                        faces.push((new, 4));
                    }
                }
            }
        }
        for &t in &self.cavity {
            self.tetrahedra[t as usize].corners = [NONE; 4];
        }
        self.free.extend(&self.cavity);
        for (new, back) in faces {
            let number = self.free.pop().unwrap_or(self.tetrahedra.len() as u32);
            if number as usize == self.tetrahedra.len() {
                self.tetrahedra.push(new);
                self.seen.push(NONE);
            }
            self.tetrahedra[number as usize] = new;
            self.seen[number as usize] = NONE;
            let k = new.corners.iter().position(|&c| c == p).expect("it has the new point");
            if new.across[k] != NONE {
                self.tetrahedra[new.across[k] as usize].across[back] = number;
            }
            for j in (0..4).filter(|&j| j != k) {
                let mut edge = [0; 2];
                let others = (0..4).filter(|&i| i != j && i != k);
                edge.iter_mut().zip(others).for_each(|(e, i)| *e = new.corners[i]);
                edge.sort_unstable();
                self.open.push((edge, number, j as u8));
            }
        }
        self.open.sort_unstable();
        for pair in self.open.chunks_exact(2) {
            let [(_, a, j), (_, b, k)] = [pair[0], pair[1]];
            self.tetrahedra[a as usize].across[j as usize] = b;
            self.tetrahedra[b as usize].across[k as usize] = a;
        }
        self.open.last().map_or(start, |o| o.1)
    }

    fn ball_holds(&self, t: u32, p: u32) -> bool {
        let [a, b, c, d] = self.tetrahedra[t as usize].corners.map(|v| self.points[v as usize]);
        insphere(a, b, c, d, self.points[p as usize]) > 0.0
    }
}

fn coord(p: DVec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

/// A number in [-1, 1) that looks random: the same for the same key on every machine.
fn random(key: u64) -> f64 {
    let mut x = key.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678_9abc_def1;
    x = (x ^ x >> 31).wrapping_mul(0x7fb5_d329_728e_a185);
    x = (x ^ x >> 27).wrapping_mul(0x81da_def4_bc2d_d44d);
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(n: usize) -> Vec<Vec3> {
        (0..n as u64).map(|i| Vec3::from_array(std::array::from_fn(|k| random(7 + 3 * i + k as u64) as f32))).collect()
    }

    fn lattice(columns: usize, rows: usize, layers: usize) -> Vec<Vec3> {
        let all = (0..columns * rows * layers).map(|i| (i % columns, i / columns % rows, i / columns / rows));
        all.map(|(i, j, k)| Vec3::new(i as f32, j as f32, k as f32)).collect()
    }

    /// Edges whose least ball holds no other point, not even nearly, are in every Delaunay triangulation.
    fn surely(points: &[Vec3]) -> Vec<[u32; 2]> {
        let n = points.len() as u32;
        let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b]));
        let empty = |&[a, b]: &[u32; 2]| {
            let [p, q] = [a, b].map(|v| points[v as usize]);
            let radius = 0.5 * p.distance(q) * 1.0001;
            (0..n).all(|c| c == a || c == b || points[c as usize].distance(p.midpoint(q)) > radius)
        };
        pairs.filter(empty).collect()
    }

    #[test]
    fn neighbours_are_found_wherever_points_lie() {
        let circle = |k: usize| Vec3::new((k as f32 * 0.1).cos(), (k as f32 * 0.1).sin(), 0.0);
        let sets: [Vec<Vec3>; 7] = [
            cloud(300),
            lattice(6, 6, 6),
            lattice(15, 15, 1),
            lattice(80, 1, 1),
            (0..60).map(circle).collect(),
            (0..60).map(circle).chain((0..60).map(|k| circle(k) + Vec3::Z)).collect(),
            cloud(3),
        ];
        for points in &sets {
            let found = edges(points, f32::INFINITY);
            let sure = surely(points);
            assert!(sure.len() + 1 >= points.len(), "the least tree that joins all is among them");
            for edge in sure {
                assert!(found.binary_search(&edge).is_ok(), "{edge:?} of {} points", points.len());
            }
            assert!(found.len() <= 16 * points.len(), "{} edges of {} points", found.len(), points.len());
        }
        assert!(edges(&[], 1.0).is_empty() && edges(&[Vec3::X], 1.0).is_empty());
    }

    #[test]
    fn balls_are_empty() {
        for points in [cloud(150), lattice(5, 5, 5)] {
            let bounds = Bounds::of(&points).unwrap();
            let made = Triangulation::of(&points, &bounds);
            let used = |t: &u32| made.tetrahedra[*t as usize].corners[0] != NONE;
            for t in (0..made.tetrahedra.len() as u32).filter(used) {
                assert!(made.turn(made.tetrahedra[t as usize].corners) > 0.0);
                assert!((0..made.points.len() as u32).all(|p| !made.ball_holds(t, p)));
            }
            // Euler: with f faces, 4t = 2f - 4 (the outer hull has four faces), and v - e + f - t = 1.
            let mut edges: Vec<[u32; 2]> = vec![];
            for t in made.tetrahedra.iter().filter(|t| t.corners[0] != NONE) {
                let [a, b, c, d] = t.corners;
                edges.extend([[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]].map(|[x, y]| [x.min(y), x.max(y)]));
            }
            edges.sort_unstable();
            edges.dedup();
            let (v, t) = (made.points.len() as i64, (made.tetrahedra.len() - made.free.len()) as i64);
            assert_eq!(v - edges.len() as i64 + (4 * t + 4) / 2 - t, 1);
        }
    }
}
