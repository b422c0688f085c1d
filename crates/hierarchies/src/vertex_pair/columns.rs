//! The stored columns: what the simplifier makes and the file holds.

use crate::SourceCounts;
use crate::quantize::{Grid, Oct};
use glam::Vec3;
use meshfront_mesh::{TriangleMesh, VertexId};

/// What is stored of a vertex-pair hierarchy: a forest of nodes, and the triangles of the source over its leaves.
///
/// Nodes are numbered as in an edge-collapse hierarchy: roots `0..B`, then update `m` makes the nodes `B + 2m` (child
/// 0, "u") and `B + 2m + 1` (child 1, "v") out of `vertex[m]` ("s"), a node with a smaller number that no other update
/// splits. A node that is never split is a leaf: a vertex of the source. Updates are in the reverse order of the
/// merges that they undo, so that their numbers are El-Sana and Varshney's ids, counted from the other end.
///
/// A triangle is named by three leaves. In a front its corners are their ancestors that are active. It is live from
/// the update on that adds it, and at that moment its corners are three different nodes, u or v among them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// How positions are quantized; `None`: lossless `f32`.
    pub grid: Option<Grid>,
    /// The base mesh Γ₀: the roots, with their attributes, and the triangles that no update adds, in terms of roots.
    pub base: TriangleMesh,
    /// All triangles in terms of leaves, in the orientation of the source: first those of `base.triangles`, in that order,
    /// then those that update 0 adds, those that update 1 adds, and so on.
    pub triangles: Vec<[VertexId; 3]>,
    /// Per update: how many triangles it adds. May be 0.
    pub added: Vec<u32>,
    /// Per update: the node that splits.
    pub vertex: Vec<VertexId>,
    /// Per update: where u and v are. On the grid, where there is one.
    pub positions: Vec<[Vec3; 2]>,
    /// Per update: normals of u and v; empty where the source had none.
    pub normals: Vec<[Oct; 2]>,
    /// Per update: colours of u and v; empty where the source had none.
    pub colors: Vec<[[u8; 4]; 2]>,
    /// Per update: distance of the original surface from the cells of M⁻ (the star of s), mesh units; never smaller
    /// than that of an update that needs it.
    pub errors: Vec<f32>,
    /// The error of the front with all updates applied (quantization alone).
    pub floor_error: f32,
    /// Sizes of the mesh that the hierarchy was built from.
    pub source: SourceCounts,
}

impl Columns {
    /// The largest star that an update may split: bounds the time that a hierarchy takes to check.
    pub const MAX_STAR: usize = 4096;
}
