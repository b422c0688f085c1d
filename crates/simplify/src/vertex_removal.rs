//! Vertex removals, in order of quadric error, recorded as a hierarchy (`defloriani1997`, `klein1998`).
//!
//! `rings` turns a 2-manifold into rings of neighbours; `choose` finds the best of the triangulations of the polygon that a
//! vertex would leave, for the `samples` of what was there before; `remove` takes vertices away in rounds of independent sets
//! and keeps a record; points of the source are followed through it, which gives the error of each update; `arrange` sorts the
//! record coarse to fine and numbers it.
//!
//! We differ from the papers in this: surfaces in space, not over a plane; the triangulation is chosen for all that was removed
//! before, not for angles; boundaries are simplified too; and errors are measured.

mod arrange;
mod choose;
mod remove;
mod rings;
mod samples;

use crate::measure::measure;
use crate::{BuildError, Progress, check};
use meshfront_hierarchies::VertexRemoval;
use meshfront_hierarchies::vertex_removal::{Columns, Connectivity, Grid};
use meshfront_mesh::{Bounds, TriangleMesh};

/// How to build.
#[derive(Clone, Debug)]
pub struct VertexRemovalOptions {
    /// Bits per coordinate, 10 to 24; `None` keeps positions as they are.
    pub bits: Option<u32>,
    /// Where to stop: the number of triangles of the base mesh. Topology may stop it earlier.
    pub base_triangles: usize,
    /// How a file says which triangulations the polygons have.
    pub connectivity: Connectivity,
}

impl Default for VertexRemovalOptions {
    fn default() -> Self {
        VertexRemovalOptions { bits: Some(16), base_triangles: 300, connectivity: Connectivity::default() }
    }
}

/// Builds the hierarchy of a 2-manifold, with or without boundary, whose triangles are all turned the same way.
///
/// # Errors
/// As [`vertex_removal_columns`], which is enough where the hierarchy is only written to a file.
pub fn vertex_removal(
    mesh: &TriangleMesh,
    options: &VertexRemovalOptions,
    progress: &dyn Progress,
) -> Result<VertexRemoval, BuildError> {
    let columns = vertex_removal_columns(mesh, options, progress)?;
    progress.phase("derive", "updates", columns.patches.len() as u64);
    Ok(VertexRemoval::new(columns)?)
}

/// Builds what is stored of the hierarchy of a mesh, with its measured errors.
///
/// Uses rayon's current pool; the result does not depend on the number of threads. Takes some 35 µs per source vertex on two
/// cores, more than half of it to measure errors.
///
/// # Errors
/// An unusable mesh or option; [`BuildError::NonManifold`]; or [`BuildError::Cancelled`].
pub fn vertex_removal_columns(
    mesh: &TriangleMesh,
    options: &VertexRemovalOptions,
    progress: &dyn Progress,
) -> Result<Columns, BuildError> {
    check(mesh, options.bits)?;
    let bounds = Bounds::of(&mesh.positions).ok_or(BuildError::Empty)?;
    let grid = options.bits.map(|bits| Grid::fit(bounds, bits));
    let record = remove::remove(mesh, grid, options.base_triangles, progress)?;
    let errors = measure(mesh, &record, progress)?;
    Ok(Columns { connectivity: options.connectivity, ..arrange::arrange(mesh, grid, record, errors) })
}
