//! Merges of pairs of vertices, whether an edge joins them or not, recorded as a hierarchy (`elsana1999`).
//!
//! `virtual_edges` finds pairs that no edge joins; `merge` takes the cheapest pair, again and again, whatever that does to the
//! topology, and keeps a record; points of the source are followed through it, which gives the error of each update; `arrange`
//! sorts the record coarse to fine and numbers it.
//!
//! We differ from the paper in this: errors are measured; a triangle that would lie on another of the same orientation goes
//! with the merge that brings it there; and what is left of a part never vanishes into nothing, but only into what it was
//! joined to.

mod arrange;
mod merge;
mod samples;
mod trail;
mod virtual_edges;

use crate::measure::measure;
use crate::metrics::{Length, MetricChoice, Quadrics};
use crate::{BuildError, Progress, check};
use meshfront_hierarchies::VertexPair;
use meshfront_hierarchies::vertex_pair::{Columns, Grid};
use meshfront_mesh::{Bounds, TriangleMesh};

/// How to build.
#[derive(Clone, Debug)]
pub struct VertexPairOptions {
    /// Bits per coordinate, 10 to 24; `None` keeps positions as they are.
    pub bits: Option<u32>,
    /// Where to stop: the number of triangles of the base mesh.
    pub base_triangles: usize,
    /// What a merge costs.
    pub metric: MetricChoice,
    /// Which pairs go first.
    pub pairs: Pairs,
    /// Patches grow for as long as the mean normals of two neighbours differ by less, radians.
    pub patch_angle: f32,
    /// The longest virtual edge, as a share of the diagonal; 0: none.
    pub longest_virtual: f32,
}

/// How merges that change the topology stand to those that do not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pairs {
    /// First the geometry: for as long as there is an edge that may be collapsed without a change of topology, nothing else
    /// merges. Then the topology: all pairs that are left, by their cost.
    GeometryFirst,
    /// All pairs by their cost, whatever they do to the topology.
    #[default]
    Equal,
}

impl Default for VertexPairOptions {
    fn default() -> Self {
        VertexPairOptions {
            bits: Some(16),
            base_triangles: 20,
            metric: MetricChoice::Quadric,
            pairs: Pairs::Equal,
            patch_angle: 30f32.to_radians(),
            longest_virtual: 0.1,
        }
    }
}

/// Builds the hierarchy of any triangles: non-manifold ones too, of many objects.
///
/// # Errors
/// As [`vertex_pair_columns`], which is enough where the hierarchy is only written to a file.
pub fn vertex_pair(
    mesh: &TriangleMesh,
    options: &VertexPairOptions,
    progress: &dyn Progress,
) -> Result<VertexPair, BuildError> {
    let columns = vertex_pair_columns(mesh, options, progress)?;
    progress.phase("derive", "updates", columns.vertex.len() as u64);
    Ok(VertexPair::new(columns)?)
}

/// Builds what is stored of the hierarchy of any triangles, with its measured errors.
///
/// Uses rayon's current pool; the result does not depend on the number of threads. Pairs merge one after the other, so that is
/// done on one of them. Takes some 60 to 150 µs per source vertex, most on assemblies.
///
/// # Errors
/// An unusable mesh or option; or [`BuildError::Cancelled`].
pub fn vertex_pair_columns(
    mesh: &TriangleMesh,
    options: &VertexPairOptions,
    progress: &dyn Progress,
) -> Result<Columns, BuildError> {
    check(mesh, options.bits)?;
    let bounds = Bounds::of(&mesh.positions).ok_or(BuildError::Empty)?;
    let grid = options.bits.map(|bits| Grid::fit(bounds, bits));
    let record = match options.metric {
        MetricChoice::Quadric => merge::merge(mesh, grid, options, &Quadrics, progress)?,
        MetricChoice::Length => merge::merge(mesh, grid, options, &Length, progress)?,
    };
    let errors = measure(mesh, &record, progress)?;
    Ok(arrange::arrange(mesh, grid, record, errors))
}
