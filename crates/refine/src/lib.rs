//! The selective-refinement engine. It sees updates and their footprints, never cells.
//!
//! A [`MultiTessellation`] is the immutable hierarchy; a [`Front`] is one viewer's state; a [`Criterion`] says
//! how many pixels wrong an update's coarse side looks; [`Front::adapt`] moves the front from the view of the
//! last frame to this one. [`oracle`] is the same in its clearest form.

mod any;
mod bits;
mod calendar;
pub mod criteria;
mod criterion;
mod front;
mod hierarchy;
pub mod oracle;
mod request;

pub use any::{AnyFront, Owned};
pub use criteria::{Camera, ViewOptions, view};
pub use criterion::{Criterion, Fingerprint, Plane, Pose};
pub use front::{Front, Member, Viewed, adapt_together};
pub use hierarchy::{Around, Footprint, MultiTessellation, NormalCone, Step, UpdateId};
pub use request::{Outcome, Request};
