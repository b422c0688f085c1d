//! Vertex-pair hierarchies pass the suite: as they are built, and whatever is merged.

use glam::{Vec3, vec3};
use meshfront_conformance::Source;
use meshfront_conformance::merger::{Merging, merge};
use meshfront_conformance::random::Random;
use meshfront_conformance::suite::{
    Updates, budgets, error_in_force, follow, full_is_the_source, promises, replacements, tolerances, wander,
};
use meshfront_hierarchies::VertexPair;
use meshfront_mesh::sample::{self, defects};
use meshfront_mesh::{TriangleMesh, VertexId};
use meshfront_refine::MultiTessellation;
use meshfront_simplify::{VertexPairOptions, vertex_pair_columns};

/// The suite, but for how tight errors are: that is given.
fn check(h: &VertexPair, source: &Source, snap: f32, seed: u64) -> Option<f32> {
    let updates = Updates::watch(h);
    updates.footprints_nest(h);
    full_is_the_source(&updates.full, source, snap);
    promises::<VertexPair>(&updates.base, source, error_in_force(h, |_| false));
    promises::<VertexPair>(&updates.full, source, h.floor_error());
    for round in 0..3 {
        wander(h, &updates, source, 3 * seed + round);
    }
    for kind in 0..4 {
        follow(h, source, kind, seed + kind as u64);
    }
    budgets(h, source, seed);
    replacements(h, &updates, source, seed);
    tolerances(h, source)
}

/// Without attributes and lossless; painted and on a coarse grid.
fn any_merges_pass(mut mesh: TriangleMesh, base_triangles: usize) {
    let columns = merge(&mesh, &Merging { bits: None, base_triangles, far: 6, seed: 4 });
    let h = VertexPair::new(columns.clone()).expect("merged soundly");
    assert_eq!(h.columns(), columns);
    println!("{} updates, {} hidden needs", h.len(), h.hidden_needs().len());
    check(&h, &Source::new(mesh.clone()), 0.0, 1);
    sample::paint(&mut mesh);
    let h = VertexPair::new(merge(&mesh, &Merging { bits: Some(12), base_triangles, far: 100, seed: 5 }));
    let h = h.expect("merged soundly");
    let snap = h.grid().expect("on a grid").step as f32 * 0.87;
    check(&h, &Source::new(mesh), snap, 2);
}

#[test]
fn any_merges_of_a_closed_surface() {
    any_merges_pass(sample::sphere(260), 20);
}

#[test]
fn any_merges_of_a_scan_with_holes() {
    any_merges_pass(sample::scan(300), 20);
}

#[test]
fn any_merges_of_several_components() {
    any_merges_pass(defects::several_components(300), 10);
}

#[test]
fn any_merges_of_three_sheets_on_one_edge() {
    any_merges_pass(defects::non_manifold_edge(300), 10);
}

#[test]
fn any_merges_of_two_fans_on_one_vertex() {
    any_merges_pass(defects::bow_tie(300), 10);
}

/// As built: without attributes and lossless; painted and on a coarse grid.
fn built_passes(mut mesh: TriangleMesh, base_triangles: usize) {
    let build = |mesh: &TriangleMesh, bits| {
        let options = VertexPairOptions { bits, base_triangles, ..VertexPairOptions::default() };
        let columns = vertex_pair_columns(mesh, &options, &()).expect("sample meshes are sound");
        let h = VertexPair::new(columns.clone()).expect("built soundly");
        assert_eq!(h.columns(), columns);
        println!("{} updates, {} hidden needs", h.len(), h.hidden_needs().len());
        assert!(h.base_mesh().triangles.len() < mesh.triangles.len() / 3, "there is something to refine");
        h
    };
    // Looser than where topology stays: points are measured against the star alone, however near another part is.
    let tight = |tightness: Option<f32>| assert!(tightness.is_none_or(|t| t > 0.3), "{tightness:?}");
    tight(check(&build(&mesh, None), &Source::new(mesh.clone()), 0.0, 1));
    sample::paint(&mut mesh);
    let h = build(&mesh, Some(12));
    let snap = h.grid().expect("on a grid").step as f32 * 0.87;
    tight(check(&h, &Source::new(mesh), snap, 2));
}

#[test]
fn closed() {
    built_passes(sample::sphere(500), 40);
}

#[test]
fn scan_with_holes() {
    built_passes(sample::scan(700), 40);
}

#[test]
fn several_components() {
    built_passes(defects::several_components(600), 20);
}

#[test]
fn three_sheets_on_one_edge() {
    built_passes(defects::non_manifold_edge(600), 60);
}

#[test]
fn two_fans_on_one_vertex() {
    built_passes(defects::bow_tie(600), 40);
}

/// Boxes of different sizes in rows, their sides cut in squares. They do not touch: to get coarser, they must join.
fn boxes() -> TriangleMesh {
    let mut random = Random::new(8);
    let mut mesh = TriangleMesh::default();
    for i in 0..6 {
        let center = vec3((i % 3) as f32, (i / 3) as f32, 0.0) + random.cube() * 0.1;
        let half = vec3(random.unit(), random.unit(), random.unit()) * 0.2 + 0.1;
        for side in 0..6 {
            let (axis, sign) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
            let point = |u: f32, v: f32| {
                let mut p = [sign; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u * sign, v);
                center + Vec3::from_array(p) * half
            };
            for (u, v) in [(-1.0, -1.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 0.0)] {
                let square = [[u, v], [u + 1.0, v], [u + 1.0, v + 1.0], [u, v + 1.0]].map(|[u, v]| point(u, v));
                let corners = square.map(|p| {
                    let known = mesh.positions.iter().position(|q| *q == p);
                    VertexId(known.unwrap_or_else(|| {
                        mesh.positions.push(p);
                        mesh.positions.len() - 1
                    }) as u32)
                });
                mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k: usize| corners[k])));
            }
        }
    }
    mesh
}

#[test]
fn an_assembly_of_boxes() {
    let mesh = boxes();
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (6 * 26, 6 * 48));
    built_passes(mesh.clone(), 20);
    any_merges_pass(mesh, 8);
}
