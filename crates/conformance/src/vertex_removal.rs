//! Vertex-removal hierarchies: names are vertex ids.

use crate::Inspect;
use meshfront_hierarchies::VertexRemoval;
use meshfront_hierarchies::live::TriangleBuffers;
use meshfront_hierarchies::vertex_removal::FrontMesh;

impl Inspect for VertexRemoval {
    fn buffers(mesh: &FrontMesh) -> &TriangleBuffers {
        &mesh.buffers
    }
    fn clear_changes(mesh: &mut FrontMesh) {
        mesh.buffers.clear_changes();
    }
    fn names(mesh: &FrontMesh) -> Vec<[u32; 3]> {
        mesh.corners().map(|corners| corners.map(|v| v.0)).collect()
    }
}
