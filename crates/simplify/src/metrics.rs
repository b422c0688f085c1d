//! What a merge of two vertices costs.

mod length;
pub mod quadric;

pub use length::Length;
pub use quadric::Quadrics;

use glam::Vec3;

/// Which [`Metric`] orders merges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MetricChoice {
    /// [`Quadrics`].
    #[default]
    Quadric,
    /// [`Length`].
    Length,
}

/// What merging two vertices costs, where the merged one goes, and what it remembers of what it stands for.
///
/// A cost is a squared length: about the square of how far the surface moves. It is a priority, never an error.
pub trait Metric: Sync {
    /// What a vertex remembers.
    type Memory: Copy + Send + Sync;
    /// Of a vertex of the source at `p`, given the other corners of its triangles, and the other ends of those of its edges
    /// that have other than two triangles, each with the normal of one of them, of any length.
    fn leaf(&self, p: Vec3, fan: &[[Vec3; 2]], rims: &[[Vec3; 2]]) -> Self::Memory;
    /// Where the merged vertex had best go.
    fn best(&self, u: End<Self::Memory>, v: End<Self::Memory>) -> Vec3;
    /// What it costs to put it there.
    fn cost(&self, u: End<Self::Memory>, v: End<Self::Memory>, at: Vec3) -> f32;
    /// What it remembers there.
    fn merged(&self, u: End<Self::Memory>, v: End<Self::Memory>, at: Vec3) -> Self::Memory;
}

/// One of a pair.
#[derive(Clone, Copy, Debug)]
pub struct End<M> {
    /// Where it is.
    pub at: Vec3,
    /// What it remembers.
    pub memory: M,
}
