//! One criterion within a place, another one outside of it.

use crate::{Criterion, Fingerprint, Footprint, Pose};
use glam::Vec3;

/// A place in mesh space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Its middle.
        center: Vec3,
        /// Its radius.
        radius: f32,
    },
    /// A box along the axes.
    Box {
        /// Least corner.
        min: Vec3,
        /// Greatest corner.
        max: Vec3,
    },
}

impl Shape {
    /// Whether something of a ball may lie inside, and whether something of it may lie outside.
    #[inline]
    fn sides(&self, c: Vec3, r: f32) -> (bool, bool) {
        match *self {
            Shape::Sphere { center, radius } => {
                let d = c.distance(center);
                (d <= radius + r, d + r > radius)
            }
            Shape::Box { min, max } => {
                let inside = (c - min).min(max - c).min_element();
                (c.distance(c.clamp(min, max.max(min))) <= r, inside < r)
            }
        }
    }
    fn fingerprint(&self) -> Fingerprint {
        match *self {
            Shape::Sphere { center, radius } => Fingerprint::of("sphere").vec3(center).f32(radius),
            Shape::Box { min, max } => Fingerprint::of("box").vec3(min).vec3(max),
        }
    }
}

/// `inside` for what lies in the shape, `outside` for the rest, and the larger of the two for footprints that
/// have a share in both ("region of interest" of the Multi-Tessellation). Monotone where both parts are.
///
/// Different tolerances: [`Scale`](super::Scale) the parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region<A, B> {
    /// Where.
    pub shape: Shape,
    /// Asked about what lies in the shape.
    pub inside: A,
    /// Asked about what does not.
    pub outside: B,
}

impl<A: Criterion, B: Criterion> Criterion for Region<A, B> {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        match self.shape.sides(f.center, f.radius) {
            (true, false) => self.inside.pixels(f),
            (false, _) => self.outside.pixels(f),
            (true, true) => self.inside.pixels(f).max(self.outside.pixels(f)),
        }
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.score(f, tolerance).1
    }
    #[inline]
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        match self.shape.sides(f.center, f.radius) {
            (true, false) => self.inside.score(f, tolerance),
            (false, _) => self.outside.score(f, tolerance),
            (true, true) => super::Max(&self.inside, &self.outside).score(f, tolerance),
        }
    }
    fn pose(&self) -> Pose {
        Pose::new(self.shape.fingerprint()).and(self.inside.pose()).and(self.outside.pose())
    }
}
