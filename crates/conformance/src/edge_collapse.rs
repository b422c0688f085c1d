//! Edge-collapse hierarchies: names are vertex ids.

use crate::Inspect;
use meshfront_hierarchies::EdgeCollapse;
use meshfront_hierarchies::edge_collapse::FrontMesh;

impl Inspect for EdgeCollapse {
    fn names(mesh: &FrontMesh) -> Vec<[u32; 3]> {
        mesh.numbered_triangles().map(|(_, corners)| corners.map(|v| v.0)).collect()
    }
}
