//! A camera path around and up to the model, timed frame by frame: the figure that compares a browser's worker
//! with the native `meshfront bench`.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use meshfront_hierarchies::AnySurface;
use meshfront_mesh::Bounds;
use meshfront_refine::{Camera, Request, ViewOptions, view};
use wasm_bindgen::prelude::*;

const FRAMES: usize = 600;

/// What a flight took. Means are per frame, times in milliseconds.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug, Default)]
pub struct FlyBy {
    /// Number of frames that were timed.
    pub frames: u32,
    /// Updates applied and undone.
    #[wasm_bindgen(js_name = updatesPerFrame)]
    pub updates_per_frame: f64,
    /// Triangles of the front.
    #[wasm_bindgen(js_name = activeTriangles)]
    pub active_triangles: f64,
    /// How often the criterion was asked.
    #[wasm_bindgen(js_name = evaluationsPerFrame)]
    pub evaluations_per_frame: f64,
    /// Mean time in the engine.
    #[wasm_bindgen(js_name = meanMs)]
    pub mean_ms: f64,
    /// Median.
    #[wasm_bindgen(js_name = p50Ms)]
    pub p50_ms: f64,
    /// 99th percentile.
    #[wasm_bindgen(js_name = p99Ms)]
    pub p99_ms: f64,
    /// Worst frame.
    #[wasm_bindgen(js_name = maxMs)]
    pub max_ms: f64,
}

/// The camera of a frame: that of `meshfront::fly_by`, which the native figure is measured with.
fn camera(bounds: Bounds, frame: usize) -> Camera {
    let (center, r) = (bounds.center().as_dvec3(), 0.5 * bounds.diagonal() as f64);
    let t = frame as f64 / (FRAMES - 1) as f64;
    let a = TAU * t;
    let d = r * (2.2 - 1.4 * (PI * t).sin().powi(2));
    Camera {
        eye: (center + DVec3::new(d * a.cos(), 0.35 * r * (2.0 * a).sin(), d * a.sin())).as_vec3(),
        target: (center + DVec3::new(0.0, 0.3 * r * a.sin(), 0.0)).as_vec3(),
        up: Vec3::Y,
        fov_y: 2.0 * 0.558f64.atan() as f32,
        width_px: 1024.0,
        height_px: 1024.0,
        near: 0.01 * r as f32,
    }
}

/// Flies with a front of its own, at one pixel, with frustum and orientation, without limits. `now` tells milliseconds.
/// The way from the base mesh to the first view is not timed.
pub fn run(surface: &dyn AnySurface, now: impl Fn() -> f64) -> FlyBy {
    let mut front = surface.another();
    let (bounds, request) = (front.bounds(), Request::tolerance(1.0));
    let criterion = |frame| view(&camera(bounds, frame), ViewOptions::default());
    while !front.adapt_to_view(&criterion(0), &request).settled {}
    front.buffers_mut().clear_changes();
    let mut times = Vec::with_capacity(FRAMES);
    let mut report = FlyBy { frames: FRAMES as u32, ..FlyBy::default() };
    let part = 1.0 / FRAMES as f64;
    for frame in 0..FRAMES {
        let criterion = criterion(frame);
        let start = now();
        let outcome = front.adapt_to_view(&criterion, &request);
        times.push(now() - start);
        front.buffers_mut().clear_changes();
        report.updates_per_frame += part * (outcome.refined + outcome.coarsened) as f64;
        report.active_triangles += part * outcome.cells as f64;
        report.evaluations_per_frame += part * outcome.evaluations as f64;
    }
    report.mean_ms = part * times.iter().sum::<f64>();
    times.sort_by(f64::total_cmp);
    let percentile = |p: usize| times[(FRAMES * p).div_ceil(100) - 1];
    FlyBy { p50_ms: percentile(50), p99_ms: percentile(99), max_ms: percentile(100), ..report }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A figure that is compared with another one must be flown along the same path.
    #[test]
    fn the_path_is_that_of_the_native_bench() {
        let bounds = Bounds { min: Vec3::new(-1.0, 2.0, -3.5), max: Vec3::new(4.0, 2.5, 7.0) };
        assert_eq!(FRAMES, meshfront::fly_by::FRAMES as usize);
        for frame in 0..FRAMES {
            assert_eq!(camera(bounds, frame), meshfront::fly_by::camera(bounds, frame as u32));
        }
    }
}
