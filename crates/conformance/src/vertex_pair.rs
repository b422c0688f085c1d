//! Vertex-pair hierarchies, also under other rules of dependency: names are keys of nodes.

use crate::Inspect;
use meshfront_hierarchies::VertexPair;
use meshfront_hierarchies::vertex_pair::FrontMesh;
use meshfront_hierarchies::vertex_pair::rules::{Rule, Ruled};

impl Inspect for VertexPair {
    const KEEPS_TOPOLOGY: bool = false;

    fn names(mesh: &FrontMesh) -> Vec<[u32; 3]> {
        mesh.numbered_triangles().map(|(_, corners)| corners).collect()
    }
}

impl<R: Rule> Inspect for Ruled<'_, R> {
    const KEEPS_TOPOLOGY: bool = false;
    const KEEPS_CELLS: bool = R::KEEPS_CELLS;

    fn names(mesh: &FrontMesh) -> Vec<[u32; 3]> {
        VertexPair::names(mesh)
    }
}
