//! Multiresolution models: one module each, with its columns and its implementation of the engine's trait.

mod columns;
pub mod edge_collapse;
mod footprint;
mod lists;
pub mod live;
mod quantize;
mod slot_table;
pub mod vertex_removal;

pub use edge_collapse::EdgeCollapse;
pub use vertex_removal::VertexRemoval;
