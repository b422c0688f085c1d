//! An assembly as CAD programs export it: many closed parts, close to each other, none touching.

use std::f64::consts::TAU;

use glam::DVec3;

use super::hash_unit;
use crate::{TriangleMesh, VertexId};

/// Modules of ten parts each: where their corners are along x and z, and how large they are. They are side by side.
/// One has four times the size of the sixteen least, three have twice: machines have parts of all sizes.
fn modules() -> impl Iterator<Item = ([f64; 2], f64)> {
    let medium = (0..3).map(|k| ([4.0, 2.0 * k as f64], 2.0));
    let small = (0..16).map(|k| match k {
        0..8 => ([(k % 4) as f64, (4 + k / 4) as f64], 1.0),
        8..14 => ([6.0, (k - 8) as f64], 1.0),
        _ => ([(k - 14) as f64, 6.0], 1.0),
    });
    std::iter::once(([0.0, 0.0], 4.0)).chain(medium).chain(small)
}

/// Holes along each side of a plate; a bolt is in each of the four in the corners.
const HOLES: usize = 3;

/// A machine of 200 closed parts that do not touch, y up: twenty modules of two plates with nine holes each, four hexagonal
/// bolts through both, a box, an angle, a bushing and a motor. One module is four times as large as most, three are twice.
///
/// Flat faces are triangulated as modellers do: from corner to corner, in fans, over any distance. More triangles make rounder
/// circles and more rows along what is long; fewer than some 12,000 cannot be.
pub fn assembly(triangles: usize) -> TriangleMesh {
    let (mut fine, mut coarse) = (2, 1);
    while make(fine).triangles.len() < triangles {
        (coarse, fine) = (fine, 2 * fine);
    }
    while fine - coarse > 1 {
        let middle = (coarse + fine) / 2;
        if make(middle).triangles.len() < triangles {
            coarse = middle;
        } else {
            fine = middle;
        }
    }
    let both = [make(coarse), make(fine)];
    both.into_iter().min_by_key(|mesh| mesh.triangles.len().abs_diff(triangles)).expect("there are two")
}

/// With `4 * detail` segments in a circle.
fn make(detail: usize) -> TriangleMesh {
    let mut parts = Parts { mesh: TriangleMesh::default(), corner: DVec3::ZERO, size: 1.0, detail };
    for (module, ([x, z], size)) in modules().enumerate() {
        (parts.corner, parts.size) = (DVec3::new(x - 3.5, -1.0, z - 3.0), size);
        let vary = |what: u64| hash_unit(10 * module as u64 + what);
        let hole = 0.065 + 0.01 * vary(0);
        parts.plate(0.0, 0.08, hole);
        parts.plate(0.5, 0.56, hole);
        for k in 0..4 {
            let [x, z] = [k % 2, k / 2].map(|side| hole_center(side * (HOLES - 1)));
            let shank = 0.75 * hole;
            parts.bolt(x, z, [-0.08, 0.58, 0.64], [shank, 1.7 * shank]);
        }
        parts.block([0.1, 0.1, 0.3], [0.42 + 0.02 * vary(1), 0.46, 0.7]);
        parts.angle([0.52, 0.1, 0.12], [0.74, 0.4 + 0.05 * vary(2), 0.36], 0.04);
        parts.bushing(0.68, 0.62, [0.1, 0.3], [0.07, 0.15 + 0.02 * vary(3)]);
        parts.motor(0.5, 0.5, [0.59, 0.85 + 0.1 * vary(4)], 0.2);
    }
    parts.mesh
}

/// Along one side of a module.
fn hole_center(k: usize) -> f64 {
    0.02 + 0.96 * (k as f64 + 0.5) / HOLES as f64
}

struct Parts {
    mesh: TriangleMesh,
    /// Of the module.
    corner: DVec3,
    size: f64,
    detail: usize,
}

impl Parts {
    fn vertex(&mut self, x: f64, y: f64, z: f64) -> VertexId {
        self.mesh.positions.push((0.5 * (self.corner + self.size * DVec3::new(x, y, z))).as_vec3());
        VertexId(self.mesh.positions.len() as u32 - 1)
    }

    /// Two triangles, a to d the way round as seen from outside.
    fn quad(&mut self, [a, b, c, d]: [VertexId; 4]) {
        self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// Rows along what is long.
    fn rows(&self) -> usize {
        (self.detail / 2).max(1)
    }

    /// A module's plate between two heights: square cells with a round hole each.
    fn plate(&mut self, bottom: f64, top: f64, hole: f64) {
        let around = 4 * self.detail;
        let side = HOLES + 1;
        // Per height: corners of cells, row by row, then the circles.
        let mut layers = vec![];
        for y in [bottom, top] {
            let mut ids = vec![];
            let edge = |k: usize| 0.02 + 0.96 * k as f64 / HOLES as f64;
            for k in 0..side * side {
                ids.push(self.vertex(edge(k % side), y, edge(k / side)));
            }
            for k in 0..HOLES * HOLES {
                for i in 0..around {
                    // From the direction of the first corner on, -x and -z, to that of +x and -z.
                    let (sin, cos) = (TAU * (i as f64 / around as f64 - 0.375)).sin_cos();
                    let [x, z] = [(k % HOLES, cos), (k / HOLES, sin)].map(|(k, c)| hole_center(k) + hole * c);
                    ids.push(self.vertex(x, y, z));
                }
            }
            layers.push(ids);
        }
        let [low, high] = [&layers[0], &layers[1]];
        for cell in 0..HOLES * HOLES {
            let (i, j) = (cell % HOLES, cell / HOLES);
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| j * side + i);
            let ring = |k: usize| side * side + cell * around + k % around;
            for q in 0..4 {
                // A side of the square and the quarter of the circle that looks at it: half of it sees either corner.
                let (a, b) = (corners[q], corners[(q + 1) % 4]);
                let first = q * self.detail;
                let middle = first + self.detail.div_ceil(2);
                for k in first..first + self.detail {
                    let corner = if k < middle { a } else { b };
                    self.cap([low, high], [ring(k), ring(k + 1), corner]);
                }
                self.cap([low, high], [ring(middle), b, a]);
            }
            for k in 0..around {
                self.quad([low[ring(k)], low[ring(k + 1)], high[ring(k + 1)], high[ring(k)]]);
            }
        }
        for k in 0..HOLES {
            let last = HOLES * side;
            let edges = [[k, k + 1], [last + k + 1, last + k], [(k + 1) * side, k * side]];
            let right = [k * side + HOLES, (k + 1) * side + HOLES];
            for [a, b] in edges.into_iter().chain([right]) {
                self.quad([low[a], high[a], high[b], low[b]]);
            }
        }
    }

    /// A triangle of the lower face of a plate, and the opposite one of the upper.
    fn cap(&mut self, [low, high]: [&Vec<VertexId>; 2], [a, b, c]: [usize; 3]) {
        self.mesh.triangles.extend([[low[a], low[c], low[b]], [high[a], high[b], high[c]]]);
    }

    /// A ring of vertices around an upright axis.
    fn ring(&mut self, [x, z]: [f64; 2], y: f64, around: usize, radius: impl Fn(f64) -> f64) -> Vec<VertexId> {
        let place = |i: usize| TAU * i as f64 / around as f64;
        (0..around)
            .map(|i| {
                let (sin, cos) = place(i).sin_cos();
                let r = radius(place(i));
                self.vertex(x + r * cos, y, z + r * sin)
            })
            .collect()
    }

    /// Joins rings of as many vertices, each the next as seen on the way around the solid from its bottom to its top.
    fn skin(&mut self, rings: &[Vec<VertexId>]) {
        for pair in rings.windows(2) {
            let n = pair[0].len();
            for i in 0..n {
                self.quad([pair[0][i], pair[1][i], pair[1][(i + 1) % n], pair[0][(i + 1) % n]]);
            }
        }
    }

    /// A fan over a ring, seen from below or from above.
    fn fan(&mut self, [x, z]: [f64; 2], y: f64, ring: &[VertexId], from_above: bool) {
        let middle = self.vertex(x, y, z);
        for i in 0..ring.len() {
            let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
            self.mesh.triangles.push(if from_above { [middle, b, a] } else { [middle, a, b] });
        }
    }

    /// A shank from the first height to the second, and a hexagonal head on it up to the third.
    fn bolt(&mut self, x: f64, z: f64, [bottom, neck, top]: [f64; 3], [shank, head]: [f64; 2]) {
        let around = 6 * (2 * self.detail).div_ceil(3);
        let rows = self.rows();
        // Distance of a hexagon's side from its middle, in the direction of an angle.
        let hexagon = |angle: f64| head * 0.75f64.sqrt() / (angle.rem_euclid(TAU / 6.0) - TAU / 12.0).cos();
        let mut rings: Vec<Vec<VertexId>> = (0..=rows)
            .map(|k| self.ring([x, z], bottom + (neck - bottom) * k as f64 / rows as f64, around, |_| shank))
            .collect();
        rings.extend([neck, top].map(|y| self.ring([x, z], y, around, hexagon)));
        self.skin(&rings);
        self.fan([x, z], bottom, &rings[0], false);
        self.fan([x, z], top, &rings[rings.len() - 1], true);
    }

    /// A cylinder with fans for ends.
    fn motor(&mut self, x: f64, z: f64, [bottom, top]: [f64; 2], radius: f64) {
        let (around, rows) = (4 * self.detail, self.rows());
        let rings: Vec<Vec<VertexId>> = (0..=rows)
            .map(|k| self.ring([x, z], bottom + (top - bottom) * k as f64 / rows as f64, around, |_| radius))
            .collect();
        self.skin(&rings);
        self.fan([x, z], bottom, &rings[0], false);
        self.fan([x, z], top, &rings[rows], true);
    }

    /// A tube.
    fn bushing(&mut self, x: f64, z: f64, [bottom, top]: [f64; 2], [inner, outer]: [f64; 2]) {
        let around = 4 * self.detail;
        let rings: Vec<Vec<VertexId>> = [(inner, top), (inner, bottom), (outer, bottom), (outer, top)]
            .map(|(radius, y)| self.ring([x, z], y, around, |_| radius))
            .into();
        self.skin(&rings);
        self.skin(&[rings[3].clone(), rings[0].clone()]);
    }

    /// A box.
    fn block(&mut self, [x0, y0, z0]: [f64; 3], [x1, y1, z1]: [f64; 3]) {
        self.beam(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]], [z0, z1]);
    }

    /// An L of some thickness: one side lies, the other stands.
    fn angle(&mut self, [x0, y0, z0]: [f64; 3], [x1, y1, z1]: [f64; 3], thick: f64) {
        let inner = [x0 + thick, y0 + thick];
        self.beam(&[inner, [x0 + thick, y1], [x0, y1], [x0, y0], [x1, y0], [x1, y0 + thick]], [z0, z1]);
    }

    /// A profile in x and y, anticlockwise as seen from +z and all of it seen from its first corner, drawn out along z.
    fn beam(&mut self, profile: &[[f64; 2]], [from, to]: [f64; 2]) {
        let rows = self.rows();
        let slices: Vec<Vec<VertexId>> = (0..=rows)
            .map(|k| {
                let z = from + (to - from) * k as f64 / rows as f64;
                profile.iter().map(|&[x, y]| self.vertex(x, y, z)).collect()
            })
            .collect();
        let n = profile.len();
        for pair in slices.windows(2) {
            for i in 0..n {
                self.quad([pair[0][i], pair[0][(i + 1) % n], pair[1][(i + 1) % n], pair[1][i]]);
            }
        }
        for i in 1..n - 1 {
            let (first, last) = (&slices[0], &slices[rows]);
            self.mesh.triangles.extend([[first[0], first[i + 1], first[i]], [last[0], last[i], last[i + 1]]]);
        }
    }
}
