//! Vertex-pair hierarchies pass the suite, whatever is merged.

use meshfront_conformance::Source;
use meshfront_conformance::merger::{Merging, merge};
use meshfront_conformance::suite::{
    Updates, budgets, error_in_force, follow, full_is_the_source, promises, tolerances, wander,
};
use meshfront_hierarchies::VertexPair;
use meshfront_mesh::TriangleMesh;
use meshfront_mesh::sample::{self, defects};
use meshfront_refine::MultiTessellation;

/// The suite, but for how tight errors are: these are bounds.
fn check(h: &VertexPair, source: &Source, snap: f32, seed: u64) {
    let updates = Updates::watch(h);
    updates.footprints_nest(h);
    full_is_the_source(&updates.full, source, snap);
    promises::<VertexPair>(&updates.base, source, error_in_force(h, |_| false));
    promises::<VertexPair>(&updates.full, source, h.floor_error());
    for round in 0..3 {
        wander(h, &updates, source, 3 * seed + round);
    }
    tolerances(h, source);
    for kind in 0..4 {
        follow(h, source, kind, seed + kind as u64);
    }
    budgets(h, source, seed);
}

/// Without attributes and lossless; painted and on a coarse grid.
fn passes(mut mesh: TriangleMesh, base_triangles: usize) {
    for far in [4, 1000] {
        let options = Merging { bits: None, base_triangles, far, seed: far as u64 };
        let columns = merge(&mesh, &options);
        let h = VertexPair::new(columns.clone()).expect("merged soundly");
        assert_eq!(h.columns(), columns);
        println!("{} updates, {} hidden needs", h.len(), h.hidden_needs().len());
        check(&h, &Source::new(mesh.clone()), 0.0, 1);
    }
    sample::paint(&mut mesh);
    let h = VertexPair::new(merge(&mesh, &Merging { bits: Some(12), base_triangles, far: 10, seed: 5 }));
    let h = h.expect("merged soundly");
    let snap = h.grid().expect("on a grid").step as f32 * 0.87;
    check(&h, &Source::new(mesh), snap, 2);
}

#[test]
fn closed() {
    passes(sample::sphere(400), 20);
}

#[test]
fn scan_with_holes() {
    passes(sample::scan(400), 20);
}

#[test]
fn several_components() {
    passes(defects::several_components(400), 10);
}

#[test]
fn three_sheets_on_one_edge() {
    passes(defects::non_manifold_edge(400), 10);
}

#[test]
fn two_fans_on_one_vertex() {
    passes(defects::bow_tie(400), 10);
}
