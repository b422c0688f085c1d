//! A camera path around and up to the model, timed frame by frame: the figure that compares a browser's worker
//! with the native `meshfront bench`.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::Vec3;
use meshfront_hierarchies::EdgeCollapse;
use meshfront_mesh::Bounds;
use meshfront_refine::{AnyFront, Camera, Owned, Request, ViewOptions, view};
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

/// The camera at `t` in [0, 1]: one turn around the model, nearest at the middle. C and R are centre and half
/// diagonal of the box; 1024 × 1024 pixels.
fn camera(bounds: Bounds, t: f32) -> Camera {
    let (center, radius) = (bounds.center(), bounds.diagonal() / 2.0);
    let a = TAU * t;
    let d = radius * (2.2 - 1.4 * (PI * t).sin().powi(2));
    Camera {
        eye: center + Vec3::new(d * a.cos(), 0.35 * radius * (2.0 * a).sin(), d * a.sin()),
        target: center + Vec3::new(0.0, 0.3 * radius * a.sin(), 0.0),
        up: Vec3::Y,
        fov_y: 2.0 * 0.558f32.atan(),
        width_px: 1024.0,
        height_px: 1024.0,
        near: 1e-3 * radius,
    }
}

/// Flies with a front of its own, at one pixel, with frustum and orientation, without limits. `now` tells milliseconds.
/// The way from the base mesh to the first view is not timed.
pub fn run(hierarchy: &Arc<EdgeCollapse>, now: impl Fn() -> f64) -> FlyBy {
    let mut owned = Owned::new(hierarchy.clone());
    let (bounds, request) = (hierarchy.bounds(), Request::tolerance(1.0));
    owned.adapt(&view(&camera(bounds, 0.0), ViewOptions::default()), &request);
    let mut times = Vec::with_capacity(FRAMES);
    let mut report = FlyBy { frames: FRAMES as u32, ..FlyBy::default() };
    let part = 1.0 / FRAMES as f64;
    for frame in 0..FRAMES {
        let criterion = view(&camera(bounds, frame as f32 / (FRAMES - 1) as f32), ViewOptions::default());
        let start = now();
        let outcome = owned.adapt(&criterion, &request);
        times.push(now() - start);
        owned.front.mesh_mut().buffers.clear_changes();
        report.updates_per_frame += part * (outcome.refined + outcome.coarsened) as f64;
        report.active_triangles += part * outcome.cells as f64;
        report.evaluations_per_frame += part * outcome.evaluations as f64;
    }
    report.mean_ms = part * times.iter().sum::<f64>();
    times.sort_by(f64::total_cmp);
    let percentile = |p: usize| times[(FRAMES * p).div_ceil(100) - 1];
    FlyBy { p50_ms: percentile(50), p99_ms: percentile(99), max_ms: percentile(100), ..report }
}
