//! The stored columns: what the simplifier makes and the file holds.

use super::front_mesh::{Added, Star};
use crate::SourceCounts;
use crate::quantize::{Grid, Oct};
use glam::Vec3;
use meshfront_mesh::{TriangleMesh, VertexId};
use meshfront_refine::UpdateId;

/// What is stored of an edge-collapse hierarchy.
///
/// Vertices are numbered: base vertices `0..B`, then update `m` makes vertices `B + 2m` (child 0, "u") and
/// `B + 2m + 1` (child 1, "v") out of `vertex[m]` ("s"). Triangles are numbered: base triangles `0..F`, then
/// update `m` adds `F + 2m` and `F + 2m + 1` (a number may stay unused); an explicit split that adds more
/// continues after `F + 2U`, in order of update.
///
/// A triangle keeps its number while its corners change. The star of s, sorted by triangle number, is what
/// bit i of `sides[m]` speaks of: 0, the i-th triangle's corner s becomes u; 1, it becomes v.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// How positions are quantized; `None`: lossless `f32`.
    pub grid: Option<Grid>,
    /// The base mesh Γ₀, with its attributes.
    pub base: TriangleMesh,
    /// Per update: the vertex that splits.
    pub vertex: Vec<VertexId>,
    /// Per update: bits 0..31 as above; bit 31 (`EXPLICIT`): the added triangles are listed in `explicit`.
    pub sides: Vec<u32>,
    /// Sorted by update: splits whose added triangles do not follow from `sides` (ears, non-manifold spots).
    pub explicit: Vec<ExplicitSplit>,
    /// Per update: where u and v are. On the grid, where there is one.
    pub positions: Vec<[Vec3; 2]>,
    /// Per update: normals of u and v; empty where the source had none.
    pub normals: Vec<[Oct; 2]>,
    /// Per update: colours of u and v; empty where the source had none.
    pub colors: Vec<[[u8; 4]; 2]>,
    /// Per update: distance of the original surface from the cells of M⁻, mesh units; never smaller than that of
    /// an update that needs it.
    pub errors: Vec<f32>,
    /// The error of the front with all updates applied (quantization alone).
    pub floor_error: f32,
    /// Sizes of the mesh that the hierarchy was built from.
    pub source: SourceCounts,
}

impl Columns {
    /// Bit of `sides` that says that the added triangles are listed.
    pub const EXPLICIT: u32 = 1 << 31;
    /// The largest star that a split may have.
    pub const MAX_STAR: usize = 31;
}

/// A split whose added triangles are listed one by one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExplicitSplit {
    /// The update.
    pub update: UpdateId,
    /// The triangles that it adds.
    pub added: Vec<AddedTriangle>,
}

/// A triangle (u, w, v) or (v, w, u) that a split adds, w being a neighbour of s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AddedTriangle {
    /// Which triangle of the sorted star holds w.
    pub star: u8,
    /// Which of that triangle's corners w is: `false`, the one after s in its orientation; `true`, the one before.
    pub before: bool,
    /// `false`: (u, w, v); `true`: (v, w, u).
    pub flipped: bool,
}

impl AddedTriangle {
    /// With the vertex slot that it speaks of.
    pub(super) fn of(&self, star: &Star) -> Added {
        let t = &star[self.star as usize];
        Added { w: if self.before { t.before } else { t.after }, flipped: self.flipped }
    }
}
