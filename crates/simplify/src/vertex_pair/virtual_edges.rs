//! Virtual edges: pairs of vertices that no edge joins, but that may merge (`elsana1999`).
//!
//! Patches of triangles grow over edges for as long as the mean normals of two neighbours differ by less than an angle. Where
//! patches end the shape turns, or the surface ends: vertices there are joined by a Delaunay triangulation, and its short
//! edges are kept.

use crate::delaunay;
use glam::Vec3;
use meshfront_mesh::TriangleMesh;
use rayon::prelude::*;

/// Pairs of vertices no farther apart than `longest`, each once, ascending; real edges may be among them.
pub(super) fn virtual_edges(source: &TriangleMesh, angle: f32, longest: f32) -> Vec<[u32; 2]> {
    let patches = patches(source, angle);
    let ends = ends(source, &patches);
    let points: Vec<Vec3> = ends.iter().map(|&v| source.positions[v as usize]).collect();
    // Ends ascend, so pairs stay in order.
    delaunay::edges(&points, longest).into_iter().map(|e| e.map(|i| ends[i as usize])).collect()
}

/// Per triangle: the patch that it belongs to, named by one of its triangles. Flat edges are crossed first.
fn patches(source: &TriangleMesh, angle: f32) -> Vec<u32> {
    let cross = |t: &[meshfront_mesh::VertexId; 3]| {
        let [a, b, c] = t.map(|v| source.positions[v.ix()]);
        (b - a).cross(c - a)
    };
    let own: Vec<Vec3> = source.triangles.par_iter().map(cross).collect();
    let cos = |a: Vec3, b: Vec3| a.normalize_or_zero().dot(b.normalize_or_zero());
    // Pairs of triangles on an edge, flattest first: bits of 2 - cos, which is positive.
    let mut sides: Vec<([u32; 2], u32)> = vec![];
    for (t, corners) in source.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[k].0, corners[(k + 1) % 3].0);
            sides.push(([a.min(b), a.max(b)], t as u32));
        }
    }
    sides.par_sort_unstable();
    let same_edge = sides.chunk_by(|a, b| a.0 == b.0);
    let pairs = same_edge.flat_map(|edge| edge.windows(2)).map(|w| [w[0].1, w[1].1]);
    let mut pairs: Vec<(u32, [u32; 2])> =
        pairs.map(|[a, b]| ((2.0 - cos(own[a as usize], own[b as usize])).to_bits(), [a, b])).collect();
    pairs.par_sort_unstable();
    let least = angle.cos();
    let mut patch: Vec<u32> = (0..own.len() as u32).collect();
    let mut sum = own;
    let root = |patch: &mut Vec<u32>, mut t: u32| {
        while patch[t as usize] != t {
            patch[t as usize] = patch[patch[t as usize] as usize];
            t = patch[t as usize];
        }
        t
    };
    for (_, pair) in pairs {
        let [a, b] = pair.map(|t| root(&mut patch, t));
        let [na, nb] = [a, b].map(|t| sum[t as usize]);
        // A triangle without area turns nowhere.
        if a != b && (cos(na, nb) >= least || na == Vec3::ZERO || nb == Vec3::ZERO) {
            let (low, high) = (a.min(b), a.max(b));
            patch[high as usize] = low;
            sum[low as usize] = na + nb;
        }
    }
    (0..patch.len() as u32).map(|t| root(&mut patch, t)).collect()
}

/// Vertices on more than one patch, or on an edge that has one triangle alone; ascending.
fn ends(source: &TriangleMesh, patches: &[u32]) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let mut patch = vec![NONE; source.positions.len()];
    let mut is_end = vec![false; source.positions.len()];
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * source.triangles.len());
    for (corners, &p) in source.triangles.iter().zip(patches) {
        for k in 0..3 {
            let (v, next) = (corners[k].0, corners[(k + 1) % 3].0);
            is_end[v as usize] |= patch[v as usize] != NONE && patch[v as usize] != p;
            patch[v as usize] = p;
            edges.push([v.min(next), v.max(next)]);
        }
    }
    edges.par_sort_unstable();
    for edge in edges.chunk_by(|a, b| a == b).filter(|uses| uses.len() == 1) {
        edge[0].iter().for_each(|&v| is_end[v as usize] = true);
    }
    (0..is_end.len() as u32).filter(|&v| is_end[v as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use meshfront_mesh::VertexId;
    use meshfront_mesh::sample::{self, defects};

    /// The surface of a box of so many squares along each side, corner at `at`, sides of 1.
    fn box_at(at: Vec3, n: usize) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        let point = |face: usize, i: usize, j: usize| {
            let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
            let axis = face / 2;
            let mut p = [u, v, 0.0];
            p[2] = (face % 2) as f32;
            p.rotate_right(axis);
            at + Vec3::from_array(p)
        };
        let mut number = std::collections::HashMap::new();
        let mut id = |p: Vec3| {
            let next = number.len() as u32;
            let v = *number.entry(p.to_array().map(f32::to_bits)).or_insert(next);
            if v == next {
                mesh.positions.push(p);
            }
            VertexId(v)
        };
        let mut triangles = vec![];
        for face in 0..6 {
            for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
                let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| id(point(face, i, j)));
                if face % 2 == 1 {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, c, b], [a, d, c]]);
                }
            }
        }
        mesh.triangles = triangles;
        mesh
    }

    fn join(a: TriangleMesh, b: TriangleMesh) -> TriangleMesh {
        let n = a.positions.len() as u32;
        TriangleMesh {
            positions: [a.positions, b.positions].concat(),
            triangles: [a.triangles, b.triangles.iter().map(|t| t.map(|v| VertexId(v.0 + n))).collect()].concat(),
            ..TriangleMesh::default()
        }
    }

    #[test]
    fn patches_are_the_faces_of_a_box_and_its_edges_their_ends() {
        let mesh = box_at(Vec3::ZERO, 8);
        let patches = patches(&mesh, 0.5);
        let mut all = patches.clone();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 6);
        for patch in all {
            let faces = mesh.triangles.iter().zip(&patches).filter(|(_, p)| **p == patch);
            let normals: Vec<Vec3> = faces
                .map(|(t, _)| {
                    let [a, b, c] = t.map(|v| mesh.positions[v.ix()]);
                    (b - a).cross(c - a).normalize()
                })
                .collect();
            assert_eq!(normals.len(), 128);
            assert!(normals.iter().all(|n| n.dot(normals[0]) > 0.999));
        }
        let inside = |p: Vec3| p.to_array().iter().filter(|x| **x > 0.0 && **x < 1.0).count() == 2;
        let ends = ends(&mesh, &patches);
        assert!(ends.iter().all(|&v| !inside(mesh.positions[v as usize])));
        assert_eq!(ends.len(), 8 + 12 * 7);
    }

    #[test]
    fn a_sphere_has_patches_too_and_a_sheet_its_rim() {
        let sphere = sample::sphere(2_000);
        let mut all = patches(&sphere, 0.6);
        all.sort_unstable();
        all.dedup();
        assert!((6..200).contains(&all.len()), "{} patches", all.len());
        let sheet = defects::open_sheet(800);
        let rim = ends(&sheet, &vec![0; sheet.triangles.len()]);
        assert_eq!(rim.len(), 4 * 20);
    }

    #[test]
    fn neighbouring_parts_are_joined_and_far_ones_are_not() {
        let gap = 0.1;
        let mesh = join(box_at(Vec3::ZERO, 4), box_at(Vec3::X * (1.0 + gap), 4));
        let first = mesh.positions.len() as u32 / 2;
        let between = |longest: f32| {
            let all = virtual_edges(&mesh, 0.5, longest);
            all.into_iter().filter(|[a, b]| *a < first && *b >= first).count()
        };
        assert_eq!(between(0.5 * gap), 0);
        // Each end on one of the faces that look at each other has its opposite.
        assert!(between(1.01 * gap) >= 16);
    }
}
