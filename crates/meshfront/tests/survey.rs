//! Counts against meshes whose topology is known.

use glam::Vec3;
use meshfront::mesh::{TriangleMesh, VertexId, sample};
use meshfront::survey;

fn mesh(vertices: u32, triangles: &[[u32; 3]]) -> TriangleMesh {
    let position = |i: u32| Vec3::new((i as f32).cos(), (i as f32).sin(), i as f32);
    TriangleMesh {
        positions: (0..vertices).map(position).collect(),
        triangles: triangles.iter().map(|t| t.map(VertexId)).collect(),
        ..Default::default()
    }
}

#[test]
fn a_sphere_is_closed_and_in_one_piece() {
    let s = survey(&sample::sphere(5_000));
    assert_eq!((s.components, s.boundary_edges, s.non_manifold_edges, s.non_manifold_vertices), (1, 0, 0, 0));
    assert_eq!(s.inconsistent_edges, 0);
    assert_eq!(s.vertices as i64 - s.edges as i64 + s.triangles as i64, 2);
    assert!((s.area - 4.0 * std::f64::consts::PI).abs() < 0.02, "{}", s.area);
}

#[test]
fn a_knot_is_a_torus_and_a_sheet_has_a_rim() {
    let knot = survey(&sample::knot(5_000));
    assert_eq!(knot.vertices as i64 - knot.edges as i64 + knot.triangles as i64, 0);
    let n = 20;
    let sheet = survey(&sample::terrain(2 * n * n));
    assert_eq!((sheet.triangles, sheet.boundary_edges, sheet.components), (2 * n * n, 4 * n, 1));
}

#[test]
fn what_is_no_surface_is_counted() {
    let separate = survey(&sample::defects::several_components(1_000));
    assert_eq!((separate.components, separate.boundary_edges), (4, 0));

    // Three triangles on the edge 0-1.
    let fin = survey(&mesh(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]));
    assert_eq!((fin.non_manifold_edges, fin.non_manifold_vertices, fin.boundary_edges), (1, 0, 6));

    // Two triangles that share vertex 2 alone.
    let bow_tie = survey(&mesh(5, &[[0, 1, 2], [2, 3, 4]]));
    assert_eq!((bow_tie.non_manifold_vertices, bow_tie.non_manifold_edges, bow_tie.components), (1, 0, 1));

    // The second is turned over: both run from 0 to 1.
    let turned = survey(&mesh(4, &[[0, 1, 2], [0, 1, 3]]));
    assert_eq!((turned.inconsistent_edges, turned.boundary_edges), (1, 4));
}

#[test]
fn vertices_without_triangles_are_no_components() {
    let s = survey(&mesh(5, &[[1, 2, 3]]));
    assert_eq!((s.vertices, s.components, s.edges, s.boundary_edges), (5, 1, 3, 3));
    let nothing = survey(&TriangleMesh::default());
    assert_eq!((nothing.components, nothing.edges, nothing.bounds), (0, 0, None));
}
