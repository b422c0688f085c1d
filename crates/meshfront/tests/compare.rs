//! Distances against what geometry says, and against looking at every triangle.

use glam::Vec3;
use meshfront::compare::{CompareError, CompareOptions, Side, Surface, compare};
use meshfront::mesh::{TriangleMesh, VertexId, sample};
use proptest::prelude::*;

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} where {expected} is expected");
}

fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> TriangleMesh {
    TriangleMesh {
        positions: positions.iter().map(|&p| Vec3::from_array(p)).collect(),
        triangles: triangles.iter().map(|t| t.map(VertexId)).collect(),
        ..Default::default()
    }
}

/// A square [0, side]² at height z.
fn square(side: f32, z: f32) -> TriangleMesh {
    mesh(&[[0.0, 0.0, z], [side, 0.0, z], [side, side, z], [0.0, side, z]], &[[0, 1, 2], [0, 2, 3]])
}

const SAMPLES: CompareOptions = CompareOptions { samples: 20_000 };

#[test]
fn a_mesh_lies_on_itself() {
    let terrain = sample::terrain(2_000);
    let c = compare(&terrain, &terrain, &SAMPLES).unwrap();
    // Points on faces are rounded off their plane by less than a double's precision.
    assert!(c.max() < 1e-12 * c.diagonal, "{c:?}");
    assert_eq!(c.a_to_b.samples, 20_000 + terrain.positions.len());
}

#[test]
fn parallel_squares_are_as_far_apart_as_their_planes() {
    let c = compare(&square(2.0, 0.0), &square(2.0, 0.25), &SAMPLES).unwrap();
    for d in [c.a_to_b, c.b_to_a] {
        close(d.max, 0.25, 1e-12);
        close(d.mean, 0.25, 1e-12);
        close(d.rms, 0.25, 1e-12);
    }
    close(c.diagonal, 8f64.sqrt(), 1e-6);
}

#[test]
fn a_part_is_near_the_whole_and_the_whole_is_far_from_the_part() {
    // The unit square in one corner of a square of side 3: one way nothing, the other way from the far corner.
    let c = compare(&square(1.0, 0.0), &square(3.0, 0.0), &CompareOptions { samples: 200_000 }).unwrap();
    close(c.a_to_b.max, 0.0, 1e-12);
    close(c.b_to_a.max, 8f64.sqrt(), 1e-6);
    assert_eq!(c.b_to_a.farthest, Vec3::new(3.0, 3.0, 0.0));
    // Over the big square, in closed form: two bands of 2 × 1 at mean distance 1, and a corner of 2 × 2.
    let (corner_mean, corner_square): (f64, f64) = (2.0 / 3.0 * (2f64.sqrt() + 1f64.asinh()), 8.0 / 3.0);
    close(c.b_to_a.mean, (4.0 * 1.0 + 4.0 * corner_mean) / 9.0, 1e-3);
    close(c.b_to_a.rms, ((4f64 * (4.0 / 3.0) + 4.0 * corner_square) / 9.0).sqrt(), 1e-3);
    close(c.max(), 8f64.sqrt(), 1e-6);
}

#[test]
fn a_coarse_sphere_is_off_by_its_sagitta() {
    let (fine, coarse) = (sample::sphere(50_000), sample::sphere(500));
    let c = compare(&fine, &coarse, &SAMPLES).unwrap();
    // The deepest point of a chordal triangle, found by hand: the plane of each face against the unit sphere.
    let sagitta = coarse.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| coarse.positions[v.ix()].as_dvec3());
        1.0 - (b - a).cross(c - a).normalize().dot(a)
    });
    let deepest = sagitta.fold(0.0, f64::max);
    close(c.max(), deepest, 0.05 * deepest);
    assert!(c.a_to_b.mean < c.a_to_b.rms && c.a_to_b.rms < c.a_to_b.max);
}

#[test]
fn means_count_area_and_not_triangles() {
    // A tiny square at height 1 with most of the triangles, a large one at height 0 with two.
    let mut a = square(10.0, 0.0);
    for i in 0..1000 {
        let x = i as f32 * 1e-5;
        let first = a.positions.len() as u32;
        a.positions.extend([Vec3::new(x, 0.0, 1.0), Vec3::new(x + 1e-5, 0.0, 1.0), Vec3::new(x, 1e-5, 1.0)]);
        a.triangles.push([first, first + 1, first + 2].map(VertexId));
    }
    let c = compare(&a, &square(10.0, 0.0), &SAMPLES).unwrap();
    close(c.a_to_b.max, 1.0, 1e-6);
    close(c.a_to_b.mean, 0.0, 1e-3);
}

#[test]
fn degenerate_triangles_are_the_segments_and_points_that_they_cover() {
    let needle = mesh(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[[0, 1, 2]]);
    let surface = Surface::new(&needle).unwrap();
    close(surface.distance(Vec3::new(1.5, 1.0, 0.0)), 1.0, 1e-12);
    close(surface.distance(Vec3::new(4.0, 0.0, 0.0)), 2.0, 1e-12);
    let dot = mesh(&[[1.0, 1.0, 1.0]], &[[0, 0, 0]]);
    close(Surface::new(&dot).unwrap().distance(Vec3::ZERO), 3f64.sqrt(), 1e-7);
    // Without area there are only vertices to measure from.
    let c = compare(&dot, &needle, &SAMPLES).unwrap();
    assert_eq!((c.a_to_b.samples, c.diagonal), (1, 0.0));
    close(c.a_to_b.mean, 2f64.sqrt(), 1e-7);
}

#[test]
fn a_mesh_without_triangles_is_refused() {
    let (empty, full) = (TriangleMesh::default(), square(1.0, 0.0));
    assert_eq!(compare(&empty, &full, &SAMPLES), Err(CompareError::NoTriangles(Side::A)));
    assert_eq!(compare(&full, &empty, &SAMPLES), Err(CompareError::NoTriangles(Side::B)));
}

#[test]
fn threads_do_not_change_a_bit() {
    let (a, b) = (sample::scan(5_000), sample::scan(1_000));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| compare(&a, &b, &SAMPLES).unwrap())
    };
    assert_eq!(with(1), with(3));
}

/// The distance as a search over a fine barycentric grid sees it: never less than the true one, and not more than
/// the grid is wide above it.
fn by_search(mesh: &TriangleMesh, point: Vec3) -> (f64, f64) {
    const STEPS: u32 = 40;
    let mut best = (f64::MAX, 0.0);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| mesh.positions[v.ix()].as_dvec3());
        let width = (b - a).length().max((c - a).length()).max((c - b).length()) / STEPS as f64;
        for i in 0..=STEPS {
            for j in 0..=STEPS - i {
                let (s, t) = (i as f64 / STEPS as f64, j as f64 / STEPS as f64);
                let distance = (a + (b - a) * s + (c - a) * t).distance(point.as_dvec3());
                if distance < best.0 {
                    best = (distance, width);
                }
            }
        }
    }
    best
}

fn point() -> impl Strategy<Value = [f32; 3]> {
    prop::array::uniform3(-1.0f32..1.0)
}

proptest! {
    #[test]
    fn nearest_is_nearest(
        positions in prop::collection::vec(point(), 3..40),
        // The same point seen from far and large: rounding must not pass over the right box.
        (offset, scale) in prop_oneof![Just((0.0f32, 1.0f32)), Just((1000.0, 1.0)), Just((0.0, 1e-6))],
        from in point(),
    ) {
        let place = |p: [f32; 3]| (p.map(|x| x * scale + offset)).into();
        let n = positions.len() as u32;
        let soup = TriangleMesh {
            positions: positions.iter().map(|&p| place(p)).collect(),
            triangles: (0..n - 2).map(|i| [i, (i + 7) % n, i + 2].map(VertexId)).collect(),
            ..Default::default()
        };
        let point: Vec3 = place(from);
        let found = Surface::new(&soup).unwrap().distance(point);
        let (searched, width) = by_search(&soup, point);
        prop_assert!(found <= searched * (1.0 + 1e-5) + 1e-12, "{found} > {searched}");
        prop_assert!(found >= searched - width, "{found} < {searched} - {width}");
    }
}
