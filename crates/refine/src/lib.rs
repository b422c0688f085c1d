//! The selective-refinement engine. It sees updates and their footprints, never cells.

mod hierarchy;

pub use hierarchy::{Footprint, MultiTessellation, NormalCone, Step, UpdateId};
