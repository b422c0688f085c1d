//! Multiresolution models: one module each, with its columns and its implementation of the engine's trait.

mod columns;
mod corner_lists;
mod counts;
pub mod edge_collapse;
mod footprint;
mod lists;
pub mod live;
mod model;
mod next;
mod parallel;
mod quantize;
pub mod right_triangles;
mod slot_table;
pub mod vertex_pair;
pub mod vertex_removal;

pub use edge_collapse::EdgeCollapse;
pub use model::{AnySurface, Hierarchy, InvalidStored, LiveMesh, Model, Progress, SourceCounts, Stored, TriangleModel};
pub use right_triangles::RightTriangles;
pub use vertex_pair::VertexPair;
pub use vertex_removal::VertexRemoval;
