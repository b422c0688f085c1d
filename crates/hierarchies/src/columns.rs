//! What the stored columns of every model have in common, and the checks of it that need no replay.

use crate::quantize::Grid;
use glam::Vec3;
use meshfront_mesh::{TriangleMesh, VertexColumns};

/// Numbers of the source, after cleaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SourceCounts {
    /// Vertices.
    pub vertices: u32,
    /// Triangles.
    pub triangles: u32,
}

/// Columns that do not describe a hierarchy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidColumns {
    /// A column is not as long as the others.
    #[error("column `{column}` has {found} entries, {expected} expected")]
    Length {
        /// Which column.
        column: &'static str,
        /// Its length.
        found: usize,
        /// The length of the others.
        expected: usize,
    },
    /// More updates or vertices than 32-bit ids can name.
    #[error("too many updates ({0}) for 32-bit ids")]
    TooMany(usize),
    /// The base mesh has an index out of range, a degenerate triangle or a bad number.
    #[error("base mesh: {0}")]
    Base(&'static str),
    /// An update that cannot be applied.
    #[error("update {update}: {reason}")]
    Update {
        /// Its id.
        update: u32,
        /// What is wrong with it.
        reason: &'static str,
    },
}

/// Memory of a base mesh, bytes.
pub(crate) fn base_bytes(base: &TriangleMesh) -> usize {
    let VertexColumns { normals, colors } = &base.vertex;
    size_of_val(&base.positions[..])
        + size_of_val(&base.triangles[..])
        + size_of_val(&normals[..])
        + size_of_val(&colors[..])
}

/// A column: its name, its length, the length of the others, and whether it may be missing.
pub(crate) type Length = (&'static str, usize, usize, bool);

pub(crate) fn check_lengths(columns: &[Length]) -> Result<(), InvalidColumns> {
    for &(column, found, expected, may_be_empty) in columns {
        if found != expected && !(may_be_empty && found == 0) {
            return Err(InvalidColumns::Length { column, found, expected });
        }
    }
    Ok(())
}

/// Ranges and finite numbers of all that is not per update.
pub(crate) fn check_base(base: &TriangleMesh, grid: Option<Grid>, floor_error: f32) -> Result<(), InvalidColumns> {
    if base.triangles.iter().flatten().any(|v| v.ix() >= base.positions.len()) {
        return Err(InvalidColumns::Base("a triangle names a vertex that does not exist"));
    }
    if base.triangles.iter().any(|t| t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
        return Err(InvalidColumns::Base("a triangle names a vertex twice"));
    }
    if !base.positions.iter().chain(&base.vertex.normals).all(|p| p.is_finite()) {
        return Err(InvalidColumns::Base("a coordinate is not a finite number"));
    }
    if !(floor_error.is_finite() && floor_error >= 0.0) {
        return Err(InvalidColumns::Base("the floor error is not a finite number"));
    }
    if grid.is_some_and(|g| !(g.origin.is_finite() && g.step.is_finite() && g.step > 0.0 && (1..=24).contains(&g.bits)))
    {
        return Err(InvalidColumns::Base("the grid of positions is not one"));
    }
    Ok(())
}

/// Finite numbers of one update, and positions on the grid.
pub(crate) fn check_update(
    update: usize,
    positions: &[Vec3],
    error: f32,
    grid: Option<Grid>,
) -> Result<(), InvalidColumns> {
    let invalid = |reason| Err(InvalidColumns::Update { update: update as u32, reason });
    if !positions.iter().all(|p| p.is_finite()) {
        return invalid("a coordinate is not a finite number");
    }
    if !(error.is_finite() && error >= 0.0) {
        return invalid("its error is not a finite number");
    }
    if grid.is_some_and(|g| positions.iter().any(|&p| g.snap(p) != p)) {
        return invalid("a position is not on the grid");
    }
    Ok(())
}
