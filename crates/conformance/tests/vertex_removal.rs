//! Vertex-removal hierarchies pass the suite.

use meshfront_conformance::random::Random;
use meshfront_conformance::{Inspect, Source, Topology, check};
use meshfront_hierarchies::VertexRemoval;
use meshfront_hierarchies::live::TriangleBuffers;
use meshfront_mesh::TriangleMesh;
use meshfront_mesh::sample::{self, defects};
use meshfront_refine::{MultiTessellation, UpdateId};
use meshfront_simplify::{BuildError, VertexRemovalOptions, vertex_removal};

fn build(mesh: &TriangleMesh, bits: Option<u32>, base_triangles: usize) -> VertexRemoval {
    vertex_removal(mesh, &VertexRemovalOptions { bits, base_triangles, connectivity: Default::default() }, &())
        .expect("sample meshes are manifolds")
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

/// As coarse as the topology allows: the guards have let everything through.
#[test]
fn to_the_last_triangle() {
    for mesh in [sample::sphere(100), sample::knot(300), sample::terrain(100), defects::several_components(150)] {
        let h = build(&mesh, None, 1);
        println!("{} triangles left of {}", h.base_mesh().triangles.len(), mesh.triangles.len());
        check(&h, &Source::new(mesh), 0.0, 4);
    }
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

/// Undone and applied again, an update takes the same slots, in meshes of any history.
#[test]
fn slots_come_back() {
    let h = build(&sample::scan(800), Some(12), 60);
    let live = |b: &TriangleBuffers| {
        let triangles: Vec<_> = b.triangles.iter().copied().enumerate().filter(|(_, t)| *t != [0; 3]).collect();
        let points: Vec<_> = triangles.iter().map(|(_, t)| t.map(|v| (v, b.positions[v as usize]))).collect();
        (triangles, points)
    };
    let mut random = Random::new(9);
    let mut mesh = h.base();
    let mut applied = vec![false; h.len()];
    for _ in 0..20 * h.len() {
        let m = UpdateId(random.below(h.len()) as u32);
        let (mut ready, mut leaf) = (!applied[m.ix()], applied[m.ix()]);
        h.needs(&mesh, m, |n| ready &= applied[n.ix()]);
        h.needed_by(&mesh, m, |n| leaf &= !applied[n.ix()]);
        let before = live(&mesh.buffers);
        if ready {
            h.refine(&mut mesh, m);
            let after = live(&mesh.buffers);
            h.coarsen(&mut mesh, m);
            assert_eq!(live(&mesh.buffers), before, "{m:?}");
            h.refine(&mut mesh, m);
            assert_eq!(live(&mesh.buffers), after, "{m:?}");
            applied[m.ix()] = true;
        } else if leaf && random.below(3) == 0 {
            h.coarsen(&mut mesh, m);
            let after = live(&mesh.buffers);
            h.refine(&mut mesh, m);
            assert_eq!(live(&mesh.buffers), before, "{m:?}");
            h.coarsen(&mut mesh, m);
            assert_eq!(live(&mesh.buffers), after, "{m:?}");
            applied[m.ix()] = false;
        }
    }
    assert!(applied.contains(&true) && applied.contains(&false));
}

/// Where the source has no normals, those of all vertices look away from the surface.
#[test]
fn derived_normals_point_outwards() {
    let h = build(&sample::sphere(500), None, 30);
    let mut mesh = h.base();
    (0..h.len() as u32).for_each(|m| h.refine(&mut mesh, UpdateId(m)));
    for (p, n) in mesh.buffers.positions.iter().zip(&mesh.buffers.normals) {
        let n = glam::Vec3::new(n[0] as f32, n[1] as f32, n[2] as f32) / 32767.0;
        assert!(n.dot(*p) > 0.95, "{p} {n}");
    }
}

/// Columns that something happened to are refused with the update, or are another hierarchy whose meshes are sound; stored
/// columns give the same hierarchy again.
#[test]
fn damaged_columns_do_no_harm() {
    let source = Source::new(sample::scan(600));
    let columns = build(&source.mesh, Some(16), 100).columns();
    assert_eq!(VertexRemoval::new(columns.clone()).expect("as built").columns(), columns);
    let mut random = Random::new(5);
    let (mut refused, mut accepted) = (0, 0);
    for _ in 0..2000 {
        let mut damaged = columns.clone();
        let m = random.below(damaged.patches.len());
        let patch = &mut damaged.patches[m];
        match random.below(6) {
            0 => patch.cell = random.below(20 * columns.patches.len()) as u32,
            1 => patch.edge = random.below(4) as u8,
            2 => patch.boundary = !patch.boundary,
            3 => patch.triangulation.corners = random.below(14) as u8,
            4 => patch.triangulation.index = random.below(50) as u16,
            _ => damaged.errors[m] = f32::from_bits(random.below(1 << 32) as u32),
        }
        if damaged == columns {
            continue;
        }
        match VertexRemoval::new(damaged) {
            Err(_) => refused += 1,
            Ok(h) => {
                accepted += 1;
                let mut mesh = h.base();
                for m in 0..h.len() as u32 {
                    h.refine(&mut mesh, UpdateId(m));
                }
                assert!(Topology::of(&VertexRemoval::names(&mesh)).is_that_of(&source.topology));
            }
        }
    }
    assert!(refused > 1000 && accepted > 0, "{refused} refused, {accepted} accepted");
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
