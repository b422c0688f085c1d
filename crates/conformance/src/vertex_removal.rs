//! Vertex-removal hierarchies: names are vertex ids.

use crate::Inspect;
use meshfront_hierarchies::VertexRemoval;
use meshfront_hierarchies::vertex_removal::FrontMesh;

impl Inspect for VertexRemoval {
    fn names(mesh: &FrontMesh) -> Vec<[u32; 3]> {
        mesh.corners().map(|corners| corners.map(|v| v.0)).collect()
    }
}
