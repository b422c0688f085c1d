//! Two-sided distance between two surfaces, by sampling one and looking for the nearest point of the other
//! (Cignoni, Rocchini & Scopigno, "Metro: measuring error on simplified surfaces", 1998).
//!
//! Samples are every vertex that a triangle uses, and points spread evenly over the area. The means count the
//! area samples alone, all of the same weight; the maximum counts both. A maximum over samples is a lower bound of the
//! true one-sided Hausdorff distance, and converges to it from below as samples are added.
//!
//! The bounding-volume hierarchy is parry's. The distance to one triangle is taken here in double precision:
//! slivers of a simplified mesh lose too much in single precision for a figure that checks a promise. Among triangles
//! whose squared distances round to the same single-precision number any may be taken for the nearest: a relative 3e-8.

use glam::{DVec3, Vec3};
use meshfront_mesh::{Bounds, TriangleMesh};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhLeafCost};
use rayon::prelude::*;

/// How [`compare`] samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CompareOptions {
    /// Points spread over each surface, besides its vertices.
    pub samples: usize,
}

impl Default for CompareOptions {
    fn default() -> Self {
        CompareOptions { samples: 1_000_000 }
    }
}

/// How far the samples of one surface are from another surface, in mesh units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// The greatest distance.
    pub max: f64,
    /// The area-weighted mean distance.
    pub mean: f64,
    /// The area-weighted root of the mean squared distance.
    pub rms: f64,
    /// The sample with the greatest distance.
    pub farthest: Vec3,
    /// How many points were measured.
    pub samples: usize,
}

/// The distances both ways, in mesh units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// From points of A to the surface B.
    pub a_to_b: Distances,
    /// From points of B to the surface A.
    pub b_to_a: Distances,
    /// Diagonal of A's bounding box: divide by it for relative figures. 0 where all of A is one point.
    pub diagonal: f64,
}

impl Comparison {
    /// The larger of the two maxima: the symmetric Hausdorff distance, as far as the samples see it.
    pub fn max(&self) -> f64 {
        self.a_to_b.max.max(self.b_to_a.max)
    }
    /// The mean of the two means.
    pub fn mean(&self) -> f64 {
        0.5 * (self.a_to_b.mean + self.b_to_a.mean)
    }
    /// The root of the mean of the two mean squares.
    pub fn rms(&self) -> f64 {
        (0.5 * (self.a_to_b.rms.powi(2) + self.b_to_a.rms.powi(2))).sqrt()
    }
}

/// Why two meshes cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// There is no surface to measure.
    #[error("mesh {0} has no triangles")]
    NoTriangles(Side),
}

/// Which of the two meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The first.
    A,
    /// The second.
    B,
}

impl std::fmt::Display for Side {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Side::A => "A",
            Side::B => "B",
        })
    }
}

/// Measures the distance between two surfaces both ways, on rayon's current pool. The same input gives the same
/// bits on any number of threads.
///
/// # Errors
/// A mesh without triangles.
pub fn compare(a: &TriangleMesh, b: &TriangleMesh, options: &CompareOptions) -> Result<Comparison, CompareError> {
    let surface_a = Surface::new(a).ok_or(CompareError::NoTriangles(Side::A))?;
    let surface_b = Surface::new(b).ok_or(CompareError::NoTriangles(Side::B))?;
    let used =
        |mesh: &TriangleMesh| mesh.triangles.iter().flatten().map(|v| mesh.positions[v.ix()]).collect::<Vec<_>>();
    let diagonal = Bounds::of(&used(a)).map_or(0.0, |bounds| bounds.diagonal() as f64);
    Ok(Comparison {
        a_to_b: one_sided(a, &surface_b, options.samples),
        b_to_a: one_sided(b, &surface_a, options.samples),
        diagonal,
    })
}

/// The surface of a mesh, ready for nearest-point questions.
///
/// Costs about 100 bytes and 1 µs per triangle to make.
pub struct Surface<'a> {
    mesh: &'a TriangleMesh,
    bvh: Bvh,
}

/// The squared distance of a triangle, as the cost of a leaf.
struct Leaf(f64);

impl BvhLeafCost for Leaf {
    fn cost(&self) -> f32 {
        self.0 as f32
    }
}

impl<'a> Surface<'a> {
    /// Sorts the triangles of a mesh into a bounding-volume hierarchy; `None` where there are none.
    pub fn new(mesh: &'a TriangleMesh) -> Option<Surface<'a>> {
        if mesh.triangles.is_empty() {
            return None;
        }
        let boxes = mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v.ix()]);
            Aabb::new(Vector::from(a.min(b).min(c).to_array()), Vector::from(a.max(b).max(c).to_array()))
        });
        let bvh = Bvh::from_iter(BvhBuildStrategy::Binned, boxes.enumerate());
        Some(Surface { mesh, bvh })
    }

    /// Distance of a point from the surface, in mesh units.
    pub fn distance(&self, point: Vec3) -> f64 {
        self.nearest(point.as_dvec3(), 0).1.sqrt()
    }

    /// The nearest triangle and the squared distance from it. `guess` is a triangle that may be near: the better
    /// it is, the less is searched.
    fn nearest(&self, point: DVec3, guess: u32) -> (u32, f64) {
        // Boxes are measured in single precision: a relative margin above its rounding keeps a box that holds
        // the nearest triangle from being passed over.
        const MARGIN: f32 = 1.0 - 1e-5;
        let p = point.as_vec3();
        let known = self.squared_distance(guess, point);
        let found = self.bvh.find_best(
            known as f32,
            |node, _| {
                let (min, max) = (Vec3::from(node.mins().to_array()), Vec3::from(node.maxs().to_array()));
                MARGIN * (min - p).max(p - max).max(Vec3::ZERO).length_squared()
            },
            |triangle, _| Some(Leaf(self.squared_distance(triangle, point))),
        );
        found.map_or((guess, known), |(triangle, leaf)| (triangle, leaf.0))
    }

    fn squared_distance(&self, triangle: u32, point: DVec3) -> f64 {
        let [a, b, c] = self.mesh.triangles[triangle as usize].map(|v| self.mesh.positions[v.ix()].as_dvec3());
        squared_distance_to_triangle(point, a, b, c)
    }
}

/// Squared distance of a point from a triangle; a degenerate triangle is the segment or point that it covers
/// (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5).
fn squared_distance_to_triangle(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let area_squared = normal.length_squared();
    if area_squared > 0.0 {
        // Barycentric signs by the edge planes: inside all three, the foot of the perpendicular is on the face.
        let inside = |from: DVec3, edge: DVec3| edge.cross(p - from).dot(normal) >= 0.0;
        if inside(a, ab) && inside(b, c - b) && inside(c, a - c) {
            return ap.dot(normal).powi(2) / area_squared;
        }
    }
    let to_segment = |from: DVec3, edge: DVec3| {
        let length_squared = edge.length_squared();
        let t = if length_squared > 0.0 { ((p - from).dot(edge) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
        (from + edge * t).distance_squared(p)
    };
    to_segment(a, ab).min(to_segment(b, c - b)).min(to_segment(c, a - c))
}

/// Samples in one piece of work: sums are added up piece by piece, in order, whatever the threads do.
const PIECE: usize = 4096;

/// Running figures over some samples.
#[derive(Clone, Copy)]
struct Sum {
    max_squared: f64,
    farthest: Vec3,
    distances: f64,
    squares: f64,
}

impl Sum {
    const EMPTY: Sum = Sum { max_squared: -1.0, farthest: Vec3::ZERO, distances: 0.0, squares: 0.0 };

    fn add(&mut self, point: DVec3, squared: f64) {
        self.distances += squared.sqrt();
        self.squares += squared;
        if squared > self.max_squared {
            (self.max_squared, self.farthest) = (squared, point.as_vec3());
        }
    }
    fn merge(self, other: Sum) -> Sum {
        let far = if other.max_squared > self.max_squared { other } else { self };
        Sum {
            max_squared: far.max_squared,
            farthest: far.farthest,
            distances: self.distances + other.distances,
            squares: self.squares + other.squares,
        }
    }
}

fn one_sided(from: &TriangleMesh, to: &Surface, samples: usize) -> Distances {
    let vertices = vertices_in_order_of_use(from);
    let pieces = |count: usize| (0..count.div_ceil(PIECE)).into_par_iter();
    let add_up = |sums: Vec<Sum>| sums.into_iter().fold(Sum::EMPTY, Sum::merge);

    let at_vertices = add_up(
        pieces(vertices.len())
            .map(|piece| {
                let (mut sum, mut guess) = (Sum::EMPTY, 0);
                for &v in &vertices[piece * PIECE..vertices.len().min((piece + 1) * PIECE)] {
                    let point = from.positions[v as usize].as_dvec3();
                    let (triangle, squared) = to.nearest(point, guess);
                    guess = triangle;
                    sum.add(point, squared);
                }
                sum
            })
            .collect(),
    );

    let area = AreaSampler::new(from);
    let samples = if area.total() > 0.0 { samples } else { 0 };
    let on_faces = add_up(
        pieces(samples)
            .map(|piece| {
                let (mut sum, mut guess) = (Sum::EMPTY, 0);
                area.visit(piece * PIECE..samples.min((piece + 1) * PIECE), samples, |point| {
                    let (triangle, squared) = to.nearest(point, guess);
                    guess = triangle;
                    sum.add(point, squared);
                });
                sum
            })
            .collect(),
    );

    let all = at_vertices.merge(on_faces);
    // A surface without area, or a request for no area samples: the vertices are all there is to average.
    let (mean_over, count) = if samples > 0 { (on_faces, samples) } else { (at_vertices, vertices.len()) };
    Distances {
        max: all.max_squared.max(0.0).sqrt(),
        mean: mean_over.distances / count as f64,
        rms: (mean_over.squares / count as f64).sqrt(),
        farthest: all.farthest,
        samples: vertices.len() + samples,
    }
}

/// Every vertex that a triangle uses, once: neighbours in the list are mostly neighbours in space.
fn vertices_in_order_of_use(mesh: &TriangleMesh) -> Vec<u32> {
    let mut seen = vec![false; mesh.positions.len()];
    let mut vertices = Vec::new();
    for v in mesh.triangles.iter().flatten() {
        if !std::mem::replace(&mut seen[v.ix()], true) {
            vertices.push(v.0);
        }
    }
    vertices
}

/// Points spread over the area of a mesh: one in each of N equal shares of the area, in order of triangle.
struct AreaSampler<'a> {
    mesh: &'a TriangleMesh,
    /// Area of all triangles up to and including each.
    area_up_to: Vec<f64>,
}

impl<'a> AreaSampler<'a> {
    fn new(mesh: &'a TriangleMesh) -> Self {
        let mut total = 0.0;
        let area_up_to = mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v.ix()].as_dvec3());
            total += 0.5 * (b - a).cross(c - a).length();
            total
        });
        AreaSampler { mesh, area_up_to: area_up_to.collect() }
    }
    fn total(&self) -> f64 {
        self.area_up_to.last().copied().unwrap_or(0.0)
    }
    /// Visits samples number `range` of `count`.
    fn visit(&self, range: std::ops::Range<usize>, count: usize, mut visit: impl FnMut(DVec3)) {
        let share = self.total() / count as f64;
        let middle = |k: usize| (k as f64 + 0.5) * share;
        let last = self.area_up_to.len() - 1;
        let mut triangle = self.area_up_to.partition_point(|&up_to| up_to <= middle(range.start)).min(last);
        for k in range {
            while triangle < last && self.area_up_to[triangle] <= middle(k) {
                triangle += 1;
            }
            let [a, b, c] = self.mesh.triangles[triangle].map(|v| self.mesh.positions[v.ix()].as_dvec3());
            // Where in the triangle: the R2 low-discrepancy sequence (Roberts 2018), folded into the triangle.
            const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
            let [mut s, mut t] = R2.map(|step| (0.5 + step * (k + 1) as f64).fract());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            visit(a + (b - a) * s + (c - a) * t);
        }
    }
}
