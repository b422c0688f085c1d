//! Errors as numbers: in mesh units, or in pixels.

use super::safe_slack;
use crate::{Criterion, Fingerprint, Footprint, Pose};
use glam::Vec3;

/// The error itself, in mesh units, the same everywhere ("uniform LOD" of the Multi-Tessellation).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniform;

impl Criterion for Uniform {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        f.error
    }
    #[inline]
    fn slack(&self, _: &Footprint, _: f32) -> f32 {
        f32::INFINITY
    }
    fn pose(&self) -> Pose {
        Pose::new(Fingerprint::of("uniform"))
    }
}

/// Screen-space error (`hoppe1997`; the lecture's "when projected on the screen"): the error seen face on, in the
/// middle of the picture, from the nearest point of the footprint's sphere.
///
/// pixels = error · pixels_per_radian / max(|c − eye| − r, near)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenSpace {
    /// The eye.
    pub eye: Vec3,
    /// Pixels that a unit length covers at unit distance, in the middle of the picture: height / (2 tan(fov_y / 2)).
    pub pixels_per_radian: f32,
    /// Nothing is looked at from nearer than this; positive.
    pub near: f32,
}

impl ScreenSpace {
    /// From a vertical field of view in radians and a viewport height in pixels.
    pub fn new(eye: Vec3, fov_y: f32, height_px: f32, near: f32) -> ScreenSpace {
        ScreenSpace {
            eye,
            pixels_per_radian: height_px / (2.0 * (fov_y / 2.0).tan()),
            near: near.max(f32::MIN_POSITIVE),
        }
    }
}

impl Criterion for ScreenSpace {
    #[inline]
    fn pixels(&self, f: &Footprint) -> f32 {
        if f.error <= 0.0 {
            return 0.0;
        }
        f.error * self.pixels_per_radian / (f.center.distance(self.eye) - f.radius).max(self.near)
    }
    #[inline]
    fn slack(&self, f: &Footprint, tolerance: f32) -> f32 {
        self.score(f, tolerance).1
    }
    #[inline]
    fn score(&self, f: &Footprint, tolerance: f32) -> (f32, f32) {
        if f.error <= 0.0 {
            return (0.0, f32::INFINITY);
        }
        let reach = f.error * self.pixels_per_radian;
        let distance = f.center.distance(self.eye);
        let pixels = reach / (distance - f.radius).max(self.near);
        // Above the tolerance just where the sphere is nearer than `edge`; nowhere, if not even at `near`.
        let edge = reach / tolerance;
        let slack = if edge < self.near * 0.99999 {
            f32::INFINITY
        } else {
            safe_slack(distance - f.radius - edge, distance + f.radius + edge.min(f32::MAX))
        };
        (pixels, if slack.is_nan() { 0.0 } else { slack })
    }
    fn pose(&self) -> Pose {
        let settings = Fingerprint::of("screen space").f32(self.pixels_per_radian).f32(self.near);
        Pose::new(settings).with_point(self.eye)
    }
}
