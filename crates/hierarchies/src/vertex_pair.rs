//! Vertex pairs: a node s splits into two, u and v, whether an edge joins them or not (`elsana1999`).

mod columns;

pub use columns::Columns;
