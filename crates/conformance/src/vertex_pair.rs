//! Vertex-pair hierarchies: names are keys of nodes.

use crate::Inspect;
use meshfront_hierarchies::VertexPair;
use meshfront_hierarchies::vertex_pair::FrontMesh;

impl Inspect for VertexPair {
    const KEEPS_TOPOLOGY: bool = false;

    fn names(mesh: &FrontMesh) -> Vec<[u32; 3]> {
        mesh.numbered_triangles().map(|(_, corners)| corners).collect()
    }
}
