//! Extracted meshes against the source, measured from outside.

use std::sync::LazyLock;

use meshfront::mesh::{Bounds, sample};
use meshfront::{
    CompareOptions, EdgeCollapse, EdgeCollapseOptions, Everything, Request, TriangleMesh, TriangleModel, Uniform,
    compare, edge_collapse, extract, finest, fly_by, survey,
};

static SOURCE: LazyLock<TriangleMesh> = LazyLock::new(|| sample::scan(6_000));
static HIERARCHY: LazyLock<EdgeCollapse> = LazyLock::new(|| build(Some(16)));

fn build(bits: Option<u32>) -> EdgeCollapse {
    edge_collapse(&SOURCE, &EdgeCollapseOptions { bits, ..EdgeCollapseOptions::default() }, &()).unwrap()
}

fn measured(mesh: &TriangleMesh) -> f64 {
    compare(&SOURCE, mesh, &CompareOptions { samples: 50_000 }).unwrap().a_to_b.max
}

#[test]
fn the_source_is_as_near_as_promised() {
    let diagonal = HIERARCHY.bounds().diagonal();
    let mut last = usize::MAX;
    for tolerance in [1e-4, 1e-3, 1e-2, 5e-2].map(|share| share * diagonal) {
        let coarse = extract(&*HIERARCHY, &Uniform, &Request::tolerance(tolerance));
        assert!(coarse.error <= tolerance, "{} where {tolerance} was asked", coarse.error);
        let measured = measured(&coarse.mesh);
        assert!(measured <= coarse.error as f64, "{measured} where {} is promised", coarse.error);
        assert!(coarse.mesh.triangles.len() < last, "a larger tolerance gives no smaller mesh");
        last = coarse.mesh.triangles.len();
    }
}

#[test]
fn a_budget_is_kept_and_the_promise_with_it() {
    let least = HIERARCHY.base_mesh().triangles.len();
    for most in [least, 1_000, 3_000] {
        let request = Request { max_cells: Some(most), ..Request::tolerance(0.0) };
        let coarse = extract(&*HIERARCHY, &Uniform, &request);
        let n = coarse.mesh.triangles.len();
        assert!(n <= most && n * 10 >= most * 9, "{n} of {most}");
        assert!(measured(&coarse.mesh) <= coarse.error as f64);
        assert!(coarse.outcome.budget_bound);
    }
}

#[test]
fn the_finest_mesh_is_the_source() {
    let lossless = finest(&build(None));
    let corners = |mesh: &TriangleMesh| {
        let bits = |t: &[meshfront::mesh::VertexId; 3]| {
            let corners = t.map(|v| mesh.positions[v.ix()].to_array().map(f32::to_bits));
            // Whichever corner comes first: the same triangle.
            (0..3).map(|i| [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]]).min().unwrap()
        };
        let mut all: Vec<_> = mesh.triangles.iter().map(bits).collect();
        all.sort_unstable();
        all
    };
    assert!(corners(&lossless) == corners(&SOURCE), "triangles of the source are missing or changed");
    let quantized = finest(&*HIERARCHY);
    assert!(measured(&quantized) <= extract(&*HIERARCHY, &Everything, &Request::default()).error as f64);
    assert_eq!(survey(&quantized).boundary_edges, survey(&SOURCE).boundary_edges);
}

#[test]
fn the_flight_is_the_one_on_paper() {
    // Half diagonal 3, centre (1, 2, 3).
    let bounds = Bounds { min: glam::vec3(-1.0, 1.0, 1.0), max: glam::vec3(3.0, 3.0, 5.0) };
    let near = |found: glam::Vec3, x: f32, y: f32, z: f32| {
        assert!(found.distance(glam::vec3(x, y, z)) < 0.05, "{found} where {x}, {y}, {z} is expected");
    };
    let first = fly_by::camera(bounds, 0);
    near(first.eye, 1.0 + 6.6, 2.0, 3.0);
    near(first.target, 1.0, 2.0, 3.0);
    // A quarter of the way: a = π/2, d = R (2.2 − 0.7).
    let quarter = fly_by::camera(bounds, fly_by::FRAMES / 4);
    near(quarter.eye, 1.0, 2.0, 3.0 + 4.5);
    near(quarter.target, 1.0, 2.9, 3.0);
    let half = fly_by::camera(bounds, fly_by::FRAMES / 2);
    near(half.eye, 1.0 - 2.4, 2.0, 3.0);
    near(fly_by::camera(bounds, fly_by::FRAMES - 1).eye, 7.6, 2.0, 3.0);
    assert_eq!((first.width_px, first.height_px), (1024.0, 1024.0));
    assert!(((first.fov_y / 2.0).tan() - 0.558).abs() < 1e-6);
}
