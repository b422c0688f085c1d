//! Edge-collapse hierarchies pass the suite.

use glam::Vec3;
use meshfront_conformance::random::Random;
use meshfront_conformance::suite::{Updates, error_in_force, full_is_the_source, promises, wander};
use meshfront_conformance::{Source, check};
use meshfront_hierarchies::EdgeCollapse;
use meshfront_mesh::sample::{self, defects};
use meshfront_mesh::{TriangleMesh, VertexId};
use meshfront_simplify::{EdgeCollapseOptions, edge_collapse};
use std::collections::{HashMap, HashSet};

fn build(mesh: &TriangleMesh, bits: Option<u32>, base_triangles: usize) -> EdgeCollapse {
    edge_collapse(mesh, &EdgeCollapseOptions { bits, base_triangles }, &()).expect("sample meshes are sound")
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
fn several_components() {
    passes(defects::several_components(800), 60);
}

#[test]
fn three_sheets_on_one_edge() {
    passes(defects::non_manifold_edge(800), 60);
}

#[test]
fn two_fans_on_one_vertex() {
    passes(defects::bow_tie(800), 60);
}

/// Random triangles between few corners, each cut into 4³: seams where many sheets meet, their ends and
/// crossings, several fans around a corner, Möbius strips.
fn random_complex(seed: u64) -> TriangleMesh {
    let mut random = Random::new(seed);
    let corners: Vec<Vec3> = (0..5 + random.below(5)).map(|_| random.cube()).collect();
    let mut mesh = TriangleMesh { positions: corners, ..Default::default() };
    let mut seen = HashSet::new();
    for _ in 0..3 + random.below(12) {
        let t = [0; 3].map(|_| VertexId(random.below(mesh.positions.len()) as u32));
        let mut sorted = t;
        sorted.sort();
        if sorted[0] != sorted[1] && sorted[1] != sorted[2] && seen.insert(sorted) {
            mesh.triangles.push(t);
        }
    }
    for _ in 0..3 {
        let TriangleMesh { positions, triangles, .. } = &mut mesh;
        let mut middles = HashMap::new();
        let mut cut = vec![];
        for &[a, b, c] in triangles.iter() {
            let [x, y, z] = [[a, b], [b, c], [c, a]].map(|[a, b]| {
                *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    positions.push((positions[a.ix()] + positions[b.ix()]) * 0.5 + random.cube() * 0.01);
                    VertexId(positions.len() as u32 - 1)
                })
            });
            cut.extend([[a, x, z], [x, b, y], [z, y, c], [x, y, z]]);
        }
        *triangles = cut;
    }
    let mut used = vec![u32::MAX; mesh.positions.len()];
    let mut positions = vec![];
    for v in mesh.triangles.iter_mut().flatten() {
        if used[v.ix()] == u32::MAX {
            used[v.ix()] = positions.len() as u32;
            positions.push(mesh.positions[v.ix()]);
        }
        *v = VertexId(used[v.ix()]);
    }
    TriangleMesh { positions, ..mesh }
}

#[test]
fn whatever_is_glued_together() {
    for seed in 0..150 {
        let mesh = random_complex(seed);
        if mesh.triangles.is_empty() {
            continue;
        }
        let h = build(&mesh, None, 1);
        let source = Source::new(mesh);
        let updates = Updates::watch(&h);
        updates.footprints_nest(&h);
        full_is_the_source(&updates.full, &source, 0.0);
        promises::<EdgeCollapse>(&updates.base, &source, error_in_force(&h, |_| false));
        wander(&h, &updates, &source, seed);
    }
}

#[test]
fn a_base_that_is_the_source() {
    let mesh = defects::tetrahedron();
    check(&build(&mesh, None, 300), &Source::new(mesh), 0.0, 3);
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
