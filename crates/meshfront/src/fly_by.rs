//! A fixed flight around a model and up to it: what engines are measured on, here and in the browser.

use glam::Vec3;
use meshfront_mesh::Bounds;
use meshfront_refine::criteria::View;
use meshfront_refine::{Camera, ViewOptions, view};

/// Frames of the flight.
pub const FRAMES: u32 = 600;
/// The tolerance that it is flown with.
pub const TOLERANCE_PX: f32 = 1.0;

/// The camera of a frame, `0..FRAMES`: once around, from 2.2 half diagonals down to 0.8 and back, swinging up and down.
///
/// With C the centre and R the half diagonal of the bounding box, t from 0 to 1 and a = 2πt: eye
/// C + (d cos a, 0.35 R sin 2a, d sin a) at d = R (2.2 − 1.4 sin² πt), target C + (0, 0.3 R sin a, 0), up +y; 1024 × 1024
/// pixels, the tangent of half the field of view 0.558.
pub fn camera(bounds: Bounds, frame: u32) -> Camera {
    use std::f64::consts::{PI, TAU};
    let (center, r) = (bounds.center().as_dvec3(), 0.5 * bounds.diagonal() as f64);
    let t = frame as f64 / (FRAMES - 1) as f64;
    let a = TAU * t;
    let d = r * (2.2 - 1.4 * (PI * t).sin().powi(2));
    Camera {
        eye: (center + glam::DVec3::new(d * a.cos(), 0.35 * r * (2.0 * a).sin(), d * a.sin())).as_vec3(),
        target: (center + glam::DVec3::new(0.0, 0.3 * r * a.sin(), 0.0)).as_vec3(),
        up: Vec3::Y,
        fov_y: 2.0 * 0.558f64.atan() as f32,
        width_px: 1024.0,
        height_px: 1024.0,
        near: 0.01 * r as f32,
    }
}

/// What is wanted at a frame: screen-space error within the frustum, on what faces the eye.
pub fn criterion(bounds: Bounds, frame: u32) -> View {
    view(&camera(bounds, frame), ViewOptions { frustum: true, orientation: true, outside: None })
}
