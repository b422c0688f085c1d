//! Multiresolution models: one module each, with its columns and its implementation of the engine's trait.

pub mod edge_collapse;
pub mod live;
mod model;
mod parallel;
pub mod right_triangles;
mod slot_table;

pub use edge_collapse::EdgeCollapse;
pub use model::{AnySurface, Hierarchy, InvalidStored, LiveMesh, Model, SourceCounts, Stored, TriangleModel};
pub use right_triangles::RightTriangles;
