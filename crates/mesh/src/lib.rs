//! Meshes, and reading and writing them. No word of levels of detail here.

mod triangle_mesh;

pub mod sample;

pub use triangle_mesh::{Bounds, TriangleId, TriangleMesh, VertexColumns, VertexId};
