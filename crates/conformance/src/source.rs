//! The original surface.

use crate::random::Random;
use crate::topology::{Topology, edges};
use glam::{DVec3, Vec3};
use meshfront_mesh::{TriangleId, TriangleMesh};

/// The mesh that a hierarchy was built from.
pub struct Source {
    /// The mesh itself.
    pub mesh: TriangleMesh,
    /// Its topology.
    pub topology: Topology,
    /// All its vertices, and places on its triangles.
    pub samples: Vec<Vec3>,
    /// Its boundary edges, each as a triangle with a corner twice.
    pub rim: Vec<[Vec3; 3]>,
    /// Length of the diagonal of its box.
    pub diagonal: f32,
}

/// Places on each source triangle, besides its corners.
const SAMPLES: usize = 5;

impl Source {
    /// Takes samples: every vertex, and random places on every triangle.
    ///
    /// # Panics
    /// For a mesh without vertices.
    pub fn new(mesh: TriangleMesh) -> Source {
        let mut random = Random::new(mesh.triangles.len() as u64);
        let mut samples = mesh.positions.clone();
        for t in 0..mesh.triangles.len() as u32 {
            let [a, b, c] = mesh.corners(TriangleId(t));
            for _ in 0..SAMPLES {
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                samples.push(a + (b - a) * u + (c - a) * v);
            }
        }
        let cells: Vec<_> = mesh.triangles.iter().map(|t| t.map(|v| v.0)).collect();
        let rim = edges(&cells).into_iter().filter(|&(_, count)| count == 1);
        let rim = rim.map(|([a, b], _)| [a, b, b].map(|v| mesh.positions[v as usize])).collect();
        let diagonal = mesh.bounds().expect("a source has vertices").diagonal();
        Source { topology: Topology::of(&cells), samples, rim, diagonal, mesh }
    }
}

/// Triangles (or segments: a corner twice) to measure distances from. Every one is looked at, but for those whose
/// enclosing ball is farther away than what is known.
pub struct Target {
    triangles: Vec<([DVec3; 3], DVec3, f64)>,
}

impl Target {
    /// From corners.
    pub fn new(triangles: &[[Vec3; 3]]) -> Target {
        let ball = |t: &[Vec3; 3]| {
            let t = t.map(Vec3::as_dvec3);
            let center = (t[0] + t[1] + t[2]) / 3.0;
            (t, center, t.map(|p| p.distance(center)).into_iter().fold(0.0, f64::max))
        };
        Target { triangles: triangles.iter().map(ball).collect() }
    }
    /// Distance of a point from the nearest triangle; infinite where there is none.
    pub fn distance(&self, p: Vec3) -> f32 {
        let p = p.as_dvec3();
        let mut best = f64::INFINITY;
        for &(t, center, radius) in &self.triangles {
            let reach = best + radius;
            if p.distance_squared(center) < reach * reach {
                best = best.min(distance(p, t));
            }
        }
        best as f32
    }
    /// The greatest distance of some points.
    pub fn farthest(&self, points: &[Vec3]) -> f32 {
        points.iter().map(|&p| self.distance(p)).fold(0.0, f32::max)
    }
}

/// Distance of a point from a triangle: from its plane where it projects inside, else from its nearest side.
fn distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = |a: DVec3, b: DVec3| normal.dot((b - a).cross(p - a)) >= 0.0;
    if normal.length_squared() > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        return normal.dot(p - a).abs() / normal.length();
    }
    let side = |a: DVec3, b: DVec3| {
        let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(if along.is_nan() { a } else { a + (b - a) * along })
    };
    side(a, b).min(side(b, c)).min(side(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_nearest_place() {
        let mut random = Random::new(5);
        for _ in 0..200 {
            let t = [random.cube(), random.cube(), random.cube()];
            let p = random.cube() * 2.0;
            let found = Target::new(&[t]).distance(p);
            let n = 60;
            let places = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i as f32 / n as f32, j as f32 / n as f32)));
            let nearest = places.map(|(u, v)| p.distance(t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v));
            let nearest = nearest.fold(f32::MAX, f32::min);
            assert!(found <= nearest + 1e-6 && found >= nearest - 0.08, "{found} {nearest}");
        }
    }
}
