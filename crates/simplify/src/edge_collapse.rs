//! Edge collapses, in order of quadric error, recorded as a hierarchy (`garland1997`, `hoppe1996`).
//!
//! Three steps, each in its file: `collapse` decimates and keeps a record; `measure` follows points of the
//! source through the record and finds how far each update's coarse cells are from it; `arrange` sorts the
//! record coarse to fine and numbers it.
//!
//! We differ from the papers in this: all collapses go down to the base mesh, non-manifold spots take part under
//! the link condition of complexes (`dey1999`), and errors are measured, not estimated from quadrics.

mod arrange;
mod block;
mod collapse;
mod measure;

use crate::{BuildError, Progress};
use meshfront_hierarchies::EdgeCollapse;
use meshfront_hierarchies::edge_collapse::{Columns, Grid};
use meshfront_mesh::{Bounds, TriangleMesh};

/// How to build.
#[derive(Clone, Debug)]
pub struct EdgeCollapseOptions {
    /// Bits per coordinate, 10 to 24; `None` keeps positions as they are.
    pub bits: Option<u32>,
    /// Where to stop: the number of triangles of the base mesh. Topology may stop it earlier.
    pub base_triangles: usize,
}

impl Default for EdgeCollapseOptions {
    fn default() -> Self {
        EdgeCollapseOptions { bits: Some(16), base_triangles: 300 }
    }
}

/// Builds the hierarchy of a mesh: any polygon soup of triangles without degenerate ones.
///
/// # Errors
/// As [`edge_collapse_columns`], which is enough where the hierarchy is only written to a file.
pub fn edge_collapse(
    mesh: &TriangleMesh,
    options: &EdgeCollapseOptions,
    progress: &dyn Progress,
) -> Result<EdgeCollapse, BuildError> {
    let columns = edge_collapse_columns(mesh, options, progress)?;
    progress.phase("derive", "updates", columns.vertex.len() as u64);
    Ok(EdgeCollapse::new(columns)?)
}

/// Builds what is stored of the hierarchy of a mesh, with its measured errors.
///
/// Uses rayon's current pool; the result does not depend on the number of threads. Takes some 9 µs and 0.7 kB per
/// source vertex at the peak.
///
/// # Errors
/// An unusable mesh or option; or [`BuildError::Cancelled`].
pub fn edge_collapse_columns(
    mesh: &TriangleMesh,
    options: &EdgeCollapseOptions,
    progress: &dyn Progress,
) -> Result<Columns, BuildError> {
    check(mesh, options)?;
    let bounds = Bounds::of(&mesh.positions).ok_or(BuildError::Empty)?;
    let grid = options.bits.map(|bits| Grid::fit(bounds, bits));
    let record = collapse::collapse(mesh, grid, options.base_triangles, progress)?;
    let errors = measure::measure(mesh, &record, progress)?;
    Ok(arrange::arrange(mesh, grid, record, errors))
}

/// Squares of squares of lengths must fit into an `f32`.
const MOST_COORDINATE: f32 = 1e9;

fn check(mesh: &TriangleMesh, options: &EdgeCollapseOptions) -> Result<(), BuildError> {
    if let Some(bits) = options.bits.filter(|b| !(10..=24).contains(b)) {
        return Err(BuildError::Bits(bits));
    }
    if mesh.triangles.is_empty() {
        return Err(BuildError::Empty);
    }
    if mesh.triangles.len() > 1 << 27 || mesh.positions.len() > 1 << 26 {
        return Err(BuildError::TooLarge(mesh.triangles.len()));
    }
    let usable = |c: &f32| c.abs() < MOST_COORDINATE;
    if let Some(v) = mesh.positions.iter().position(|p| !p.as_ref().iter().all(usable)) {
        return Err(BuildError::NotFinite(v as u32));
    }
    let n = mesh.positions.len();
    let bad = |t: &[meshfront_mesh::VertexId; 3]| {
        t.iter().any(|v| v.ix() >= n) || t[0] == t[1] || t[1] == t[2] || t[2] == t[0]
    };
    match mesh.triangles.iter().position(bad) {
        Some(t) => Err(BuildError::BadTriangle(t as u32)),
        None => Ok(()),
    }
}
