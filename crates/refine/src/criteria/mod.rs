//! Criteria, and how they compose.
//!
//! Errors: [`Uniform`], [`ScreenSpace`]. Switches, which are infinite where they let pass and 0 where they do not:
//! [`Frustum`], [`Orientation`]. Places: [`Region`]. Combinators: [`Max`], [`Min`], [`Scale`], [`OutsideCoarse`];
//! the minimum of an error and a switch is the error where the switch lets pass. [`view()`] is the usual composition.
//!
//! Everything is in mesh space. The three view-dependent criteria are those of view-dependent progressive meshes
//! (`hoppe1997`), as in the lecture "Simplification II: Progressive meshes" (UBC).

mod combine;
mod error;
mod region;
mod view;
mod visibility;

pub use combine::{Max, Min, OutsideCoarse, Scale};
pub use error::{ScreenSpace, Uniform};
pub use region::{Region, Shape};
pub use view::{Camera, View, ViewOptions, view};
pub use visibility::{Frustum, Orientation};

/// What is left of a slack once rounding has had its share: `distance` is computed in `f32` from numbers of
/// magnitude `scale`, with a handful of roundings of 6e-8 each.
#[inline]
fn safe_slack(distance: f32, scale: f32) -> f32 {
    (distance.abs() * 0.9999 - scale.abs() * 2e-6).max(0.0)
}
