//! The stored columns: what the simplifier makes and the file holds.

use super::front_mesh::{Added, Star};
use crate::SourceCounts;
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
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

/// A uniform grid of positions: the same step on all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Bits per coordinate, 10 to 24.
    pub bits: u32,
    /// Mesh-space point of grid index (0, 0, 0).
    pub origin: DVec3,
    /// Mesh units between neighbouring grid points.
    pub step: f64,
}

impl Grid {
    /// The grid that holds a box with `bits` bits on its longest side.
    pub fn fit(bounds: meshfront_mesh::Bounds, bits: u32) -> Grid {
        let extent = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_element();
        let top = ((1u64 << bits) - 1) as f64;
        let step = if extent > 0.0 { extent / top } else { 1.0 };
        Grid { bits, origin: bounds.min.as_dvec3(), step }
    }
    /// Index of the nearest grid point, clamped to the grid.
    #[inline]
    pub fn index(&self, p: Vec3) -> [u32; 3] {
        let top = ((1u64 << self.bits) - 1) as f64;
        let q = ((p.as_dvec3() - self.origin) / self.step).round().clamp(DVec3::ZERO, DVec3::splat(top));
        [q.x as u32, q.y as u32, q.z as u32]
    }
    /// The mesh-space point of an index: the same bits on every machine.
    #[inline]
    pub fn point(&self, index: [u32; 3]) -> Vec3 {
        (self.origin + DVec3::new(index[0] as f64, index[1] as f64, index[2] as f64) * self.step).as_vec3()
    }
    /// The nearest grid point, in mesh space. `snap(snap(p)) == snap(p)`.
    #[inline]
    pub fn snap(&self, p: Vec3) -> Vec3 {
        self.point(self.index(p))
    }
}

/// A unit vector in octahedral encoding, two signed 16-bit numbers (Cigolle et al. 2014).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Oct(pub [i16; 2]);

impl Oct {
    /// Encodes a vector of any length but zero.
    pub fn encode(v: Vec3) -> Oct {
        let s = v.x.abs() + v.y.abs() + v.z.abs();
        if s.is_nan() || s <= 0.0 {
            return Oct([0, 0]);
        }
        let (mut x, mut y) = (v.x / s, v.y / s);
        if v.z < 0.0 {
            (x, y) = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
        }
        Oct([(x * 32767.0).round() as i16, (y * 32767.0).round() as i16])
    }
    /// The unit vector.
    #[inline]
    pub fn decode(self) -> Vec3 {
        let (x, y) = (self.0[0] as f32 / 32767.0, self.0[1] as f32 / 32767.0);
        let z = 1.0 - x.abs() - y.abs();
        let t = (-z).max(0.0);
        Vec3::new(x - t.copysign(x), y - t.copysign(y), z).normalize_or(Vec3::Z)
    }
}

/// Columns that do not describe a hierarchy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidColumns {
    /// A column is not as long as the others.
    #[error("column `{column}` has {found} entries, {expected} expected")]
    Length {
        /// Which column.
        column: &'static str,
        /// Its length.
        found: usize,
        /// The length of the others.
        expected: usize,
    },
    /// More updates or vertices than 32-bit ids can name.
    #[error("too many updates ({0}) for 32-bit ids")]
    TooMany(usize),
    /// The base mesh has an index out of range, a degenerate triangle or a bad number.
    #[error("base mesh: {0}")]
    Base(&'static str),
    /// An update that cannot be applied.
    #[error("update {update}: {reason}")]
    Update {
        /// Its id.
        update: u32,
        /// What is wrong with it.
        reason: &'static str,
    },
}

/// Rounds an error up to the numbers that a file holds: sixteen to an octave. Idempotent and monotone.
pub fn round_error_up(error: f32) -> f32 {
    // An f32 with 4 bits of mantissa. The carry into the exponent is what rounding up across an octave means.
    let bits = error.to_bits();
    f32::from_bits((bits + ((1 << 19) - 1)) & !((1 << 19) - 1))
}
