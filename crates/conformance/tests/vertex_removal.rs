//! Vertex-removal hierarchies pass the suite.

use meshfront_conformance::{Source, check};
use meshfront_hierarchies::VertexRemoval;
use meshfront_mesh::TriangleMesh;
use meshfront_mesh::sample::{self, defects};
use meshfront_simplify::{BuildError, VertexRemovalOptions, vertex_removal};

fn build(mesh: &TriangleMesh, bits: Option<u32>, base_triangles: usize) -> VertexRemoval {
    vertex_removal(mesh, &VertexRemovalOptions { bits, base_triangles }, &()).expect("sample meshes are manifolds")
}

/// Without attributes and lossless; painted and on a coarse grid.
fn passes(mut mesh: TriangleMesh, base_triangles: usize) {
    let h = build(&mesh, None, base_triangles);
    assert!(h.base_mesh().triangles.len() < mesh.triangles.len() / 3, "there is something to refine");
    check(&h, &Source::new(mesh.clone()), 0.0, 1);
    sample::paint(&mut mesh);
    let h = build(&mesh, Some(12), base_triangles);
    let snap = h.grid().expect("built on a grid").step as f32 * 0.87;
    check(&h, &Source::new(mesh), snap, 2);
}

#[test]
fn closed() {
    passes(sample::sphere(700), 40);
}

#[test]
fn closed_with_a_handle() {
    passes(sample::knot(1000), 100);
}

#[test]
fn scan_with_holes() {
    passes(sample::scan(1000), 100);
}

#[test]
fn terrain() {
    passes(sample::terrain(800), 40);
}

#[test]
fn open_sheet() {
    passes(defects::open_sheet(600), 40);
}

#[test]
fn several_components() {
    passes(defects::several_components(800), 60);
}

#[test]
fn a_base_that_is_the_source() {
    let mesh = defects::tetrahedron();
    check(&build(&mesh, None, 300), &Source::new(mesh), 0.0, 3);
}

/// The error says which vertex, and what to do.
#[test]
fn other_than_manifolds_are_refused() {
    for mesh in [defects::non_manifold_edge(800), defects::bow_tie(800)] {
        let error = vertex_removal(&mesh, &VertexRemovalOptions::default(), &()).expect_err("no manifold");
        assert!(matches!(error, BuildError::NonManifold(_)));
        assert!(error.to_string().contains("edge collapse"), "{error}");
    }
}

/// The same columns, whatever the number of threads.
#[test]
fn threads_do_not_show() {
    let mut mesh = sample::scan(3000);
    sample::paint(&mut mesh);
    let columns = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| build(&mesh, Some(16), 200).columns())
    };
    assert!(columns(1) == columns(2), "one thread and two give different hierarchies");
}
