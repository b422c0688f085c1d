//! What a collapse costs.

pub mod quadric;
