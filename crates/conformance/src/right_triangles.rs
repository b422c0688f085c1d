//! Right triangles: names are samples.

use crate::Inspect;
use meshfront_hierarchies::RightTriangles;
use meshfront_hierarchies::right_triangles::FrontMesh;

impl Inspect for RightTriangles {
    fn names(mesh: &FrontMesh) -> Vec<[u32; 3]> {
        let live = mesh.buffers.triangles.iter().filter(|t| **t != [0; 3]);
        live.map(|t| t.map(|slot| mesh.samples()[slot as usize])).collect()
    }
}
