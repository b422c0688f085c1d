//! The suite that every hierarchy of triangles passes.
//!
//! It looks at live meshes, never at what a hierarchy says about them: which cells an update replaces, and which
//! update therefore must come before which, is read off the mesh before and after. `needs` and `needed_by` only
//! choose where a random walk may go; where they are wrong, the walk meets a mesh that it should not.
//!
//! ```text
//!     Surface    a live mesh, with names of vertices that are the same in all fronts     surface.rs
//!     Topology   what no update may change: holes, parts, seams                          topology.rs
//!     Source     the original: samples of it, its boundary                               source.rs
//!     the suite  one function per group of promises; each panics where one is broken     suite.rs
//! ```
//!
//! A model joins by implementing [`Inspect`], where it says which promises it does not make.

use meshfront_hierarchies::LiveMesh;
use meshfront_refine::MultiTessellation;

mod edge_collapse;
pub mod merger;
pub mod random;
mod right_triangles;
pub mod source;
pub mod suite;
pub mod surface;
pub mod topology;
mod vertex_pair;
mod vertex_removal;

pub use source::Source;
pub use suite::check;
pub use surface::{Cell, Look, Surface};
pub use topology::Topology;

/// A hierarchy whose live meshes are triangle meshes that can be looked at.
pub trait Inspect: MultiTessellation<Mesh: LiveMesh> {
    /// Whether every front has the topology of the source. Where not, parts may join, go flat and vanish; distances,
    /// cells and exact inverses are promised all the same.
    const KEEPS_TOPOLOGY: bool = true;
    /// Whether an update replaces the same cells in all fronts. Where not, errors were measured on other cells and are no
    /// promise; exact inverses and the strategies are.
    const KEEPS_CELLS: bool = true;

    /// The names of each live triangle's corners, in slot order: a vertex has the same name in all fronts, and
    /// two vertices never share one.
    fn names(mesh: &Self::Mesh) -> Vec<[u32; 3]>;
}
