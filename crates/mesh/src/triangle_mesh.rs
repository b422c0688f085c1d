//! The triangle mesh: plain columns and indices.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Index of a vertex in the columns of one mesh or one hierarchy.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct VertexId(pub u32);

/// Index of a triangle in the columns of one mesh.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct TriangleId(pub u32);

impl VertexId {
    /// The id as an index.
    #[inline]
    pub fn ix(self) -> usize {
        self.0 as usize
    }
}

impl TriangleId {
    /// The id as an index.
    #[inline]
    pub fn ix(self) -> usize {
        self.0 as usize
    }
}

/// A triangle mesh in mesh units: any polygon soup, manifold or not.
///
/// Every id in `triangles` is below `positions.len()`; coordinates are finite. Readers guarantee both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// One point per vertex.
    pub positions: Vec<Vec3>,
    /// Corners, counter-clockwise seen from outside.
    pub triangles: Vec<[VertexId; 3]>,
    /// Attributes per vertex.
    pub vertex: VertexColumns,
}

/// Attribute columns per vertex. A column is empty (absent) or as long as `positions`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexColumns {
    /// Unit normals, in mesh space.
    pub normals: Vec<Vec3>,
    /// Colours: red, green, blue, alpha as the file gave them (no colour-space conversion).
    pub colors: Vec<[u8; 4]>,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub min: Vec3,
    /// Greatest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The box of some points; `None` where there are none.
    pub fn of(points: &[Vec3]) -> Option<Bounds> {
        Bounds::over(points.iter().copied())
    }
    /// The same, of points from anywhere.
    pub fn over(mut points: impl Iterator<Item = Vec3>) -> Option<Bounds> {
        let first = points.next()?;
        let start = Bounds { min: first, max: first };
        Some(points.fold(start, |b, p| Bounds { min: b.min.min(p), max: b.max.max(p) }))
    }
    /// The middle of the box.
    pub fn center(&self) -> Vec3 {
        self.min + (self.max - self.min) * 0.5
    }
    /// Length of the space diagonal: what relative errors are relative to.
    pub fn diagonal(&self) -> f32 {
        (self.max - self.min).length()
    }
}

impl TriangleMesh {
    /// The box of all vertices; `None` for a mesh without vertices.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(&self.positions)
    }
    /// The corners of a triangle as points.
    #[inline]
    pub fn corners(&self, t: TriangleId) -> [Vec3; 3] {
        self.triangles[t.ix()].map(|v| self.positions[v.ix()])
    }
}
