//! From a source mesh to a multiresolution hierarchy: one module per model, costs in [`metrics`].

mod delaunay;
pub mod edge_collapse;
mod link;
mod measure;
pub mod metrics;
mod nodes;
mod order;
mod queue;
pub mod right_triangles;
pub mod vertex_pair;
pub mod vertex_removal;

pub use edge_collapse::{EdgeCollapseOptions, edge_collapse, edge_collapse_columns, edge_collapse_with_own_errors};
pub use right_triangles::{RightTrianglesOptions, right_triangles, right_triangles_columns};
pub use vertex_pair::{Pairs, VertexPairOptions, vertex_pair, vertex_pair_columns};
pub use vertex_removal::{VertexRemovalOptions, vertex_removal, vertex_removal_columns};

use meshfront_mesh::{TriangleMesh, VertexId};

/// Who wants to know how far a build is, and may stop it.
pub trait Progress: Sync {
    /// A phase starts; it counts up to `total` of `unit`.
    fn phase(&self, name: &'static str, unit: &'static str, total: u64);
    /// `done` of the phase's total are done.
    fn at(&self, done: u64);
    /// Whether to give up; the build then returns [`BuildError::Cancelled`].
    fn cancelled(&self) -> bool {
        false
    }
}

/// Nobody wants to know.
impl Progress for () {
    fn phase(&self, _: &'static str, _: &'static str, _: u64) {}
    fn at(&self, _: u64) {}
}

/// Why no hierarchy was built.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// There is nothing to draw.
    #[error("the mesh has no triangles; a hierarchy needs at least one")]
    Empty,
    /// A coordinate is NaN, infinite or too large to compute with.
    #[error("vertex {0} has a coordinate that is not a number below 1e9; clean or rescale the mesh first")]
    NotFinite(u32),
    /// A triangle names a vertex that does not exist, or one vertex twice.
    #[error("triangle {0} names a vertex that does not exist, or the same vertex twice; clean the mesh first")]
    BadTriangle(u32),
    /// Bits outside of 10 to 24.
    #[error("{0} bits per coordinate: choose 10 to 24, or lossless")]
    Bits(u32),
    /// More vertices or triangles than 32-bit ids leave room for.
    #[error("{0} triangles: at most 2^27, with 2^26 vertices, fit into one hierarchy; split the mesh")]
    TooLarge(usize),
    /// The model takes 2-manifolds only.
    #[error(
        "vertex {0}: its triangles do not form one fan, all turned the same way; vertex removal takes 2-manifolds only: \
         build with edge collapse, which takes any triangles"
    )]
    NonManifold(u32),
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// An exaggeration that is not a positive number.
    #[error("{0} times too high: the exaggeration is a positive number, and 1 leaves heights as they are")]
    Exaggeration(f32),
    /// Heights that are no terrain.
    #[error("{0}")]
    Heights(#[from] meshfront_hierarchies::right_triangles::InvalidHeights),
    /// The record does not replay: a bug in the simplifier.
    #[error("internal: the recorded updates do not replay ({0}); please report this with the mesh")]
    Replay(#[from] meshfront_hierarchies::edge_collapse::InvalidColumns),
}

/// Squares of squares of lengths must fit into an `f32`.
const MOST_COORDINATE: f32 = 1e9;

/// Whether a mesh and a number of bits can be built from, whatever the model.
fn check(mesh: &TriangleMesh, bits: Option<u32>) -> Result<(), BuildError> {
    if let Some(bits) = bits.filter(|b| !(10..=24).contains(b)) {
        return Err(BuildError::Bits(bits));
    }
    if mesh.triangles.is_empty() {
        return Err(BuildError::Empty);
    }
    if mesh.triangles.len() > 1 << 27 || mesh.positions.len() > 1 << 26 {
        return Err(BuildError::TooLarge(mesh.triangles.len()));
    }
    let usable = |c: &f32| c.abs() < MOST_COORDINATE;
    if let Some(v) = mesh.positions.iter().position(|p| !p.as_ref().iter().all(usable)) {
        return Err(BuildError::NotFinite(v as u32));
    }
    let n = mesh.positions.len();
    let bad = |t: &[VertexId; 3]| t.iter().any(|v| v.ix() >= n) || t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    match mesh.triangles.iter().position(bad) {
        Some(t) => Err(BuildError::BadTriangle(t as u32)),
        None => Ok(()),
    }
}
