//! The engine on a hierarchy that is nothing but arithmetic: how to implement the trait, and what a frame costs when
//! there is no mesh. `cargo run --release -p meshfront-refine --example pyramid [LEVELS]`

use glam::{Vec3, vec3};
use meshfront_refine::{
    Camera, Footprint, Front, MultiTessellation, NormalCone, Request, UpdateId, ViewOptions, criteria::Uniform, view,
};
use std::time::Instant;

/// The unit square as a pyramid of squares: level l has 4^l of them, and cutting one needs its parent to be cut, and
/// the square that is the parent's neighbour on the side where it lies.
struct Pyramid {
    levels: u32,
}

/// Level, column, row.
type Square = (u32, u32, u32);

impl Pyramid {
    fn id((level, x, y): Square) -> UpdateId {
        UpdateId((4u32.pow(level) - 1) / 3 + (y << level) + x)
    }
    fn square(m: UpdateId) -> Square {
        let level = (3 * m.0 + 1).ilog2() / 2;
        let i = m.0 - (4u32.pow(level) - 1) / 3;
        (level, i & ((1 << level) - 1), i >> level)
    }
    fn parents((level, x, y): Square) -> [Option<UpdateId>; 2] {
        let Some(up) = level.checked_sub(1) else { return [None; 2] };
        let beside = if x & 1 == 0 { (x / 2).checked_sub(1) } else { Some(x / 2 + 1).filter(|&x| x < 1 << up) };
        [Some(Self::id((up, x / 2, y / 2))), beside.map(|x| Self::id((up, x, y / 2)))]
    }
}

impl MultiTessellation for Pyramid {
    /// The number of squares.
    type Mesh = usize;

    fn len(&self) -> usize {
        (4usize.pow(self.levels) - 1) / 3
    }
    fn base(&self) -> usize {
        1
    }
    fn footprint(&self, m: UpdateId) -> Footprint {
        let (level, x, y) = Self::square(m);
        let side = 0.5f32.powi(level as i32);
        Footprint {
            center: vec3((x as f32 + 0.5) * side, 0.0, (y as f32 + 0.5) * side),
            // A child's centre is at most 0.8 sides away, and its radius is half of this.
            radius: 2.0 * side,
            error: 0.1 * side,
            cone: NormalCone::ALL,
        }
    }
    fn roots(&self, mut visit: impl FnMut(UpdateId)) {
        visit(UpdateId(0));
    }
    fn children(&self, m: UpdateId, mut visit: impl FnMut(UpdateId)) {
        let (level, x, y) = Self::square(m);
        if level + 1 == self.levels {
            return;
        }
        // Its own four, and the nearer halves of its neighbours.
        let columns = (2 * x).saturating_sub(1)..=(2 * x + 2).min((2 << level) - 1);
        for (cx, cy) in columns.flat_map(|cx| [(cx, 2 * y), (cx, 2 * y + 1)]) {
            visit(Self::id((level + 1, cx, cy)));
        }
    }
    fn needs(&self, _: &usize, m: UpdateId, visit: impl FnMut(UpdateId)) {
        Self::parents(Self::square(m)).into_iter().flatten().for_each(visit);
    }
    fn needed_by(&self, _: &usize, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.children(m, visit);
    }
    fn refine(&self, squares: &mut usize, _: UpdateId) {
        *squares += 3;
    }
    fn coarsen(&self, squares: &mut usize, _: UpdateId) {
        *squares -= 3;
    }
    fn cells(&self, squares: &usize) -> usize {
        *squares
    }
    fn cells_added(&self, _: UpdateId) -> usize {
        3
    }
}

fn main() {
    let levels = std::env::args().nth(1).map_or(10, |n| n.parse().expect("LEVELS is a number")).clamp(1, 14);
    let h = Pyramid { levels };
    let mut front = Front::new(&h);
    for _ in 0..3 {
        let start = Instant::now();
        let outcome = front.top_down(&h, &Uniform, &Request::tolerance(0.0));
        println!("top-down: {} updates, {:.0} ns each", outcome.refined, ns(start) / outcome.refined as f64);
    }

    let mut front = Front::new(&h);
    let (mut times, mut evaluations, mut open, mut updates) = (vec![], 0u64, 0u64, 0u64);
    for frame in 0..600 {
        let a = frame as f32 * std::f32::consts::TAU / 600.0;
        let eye = vec3(0.5 + 0.4 * a.cos(), 0.1, 0.5 + 0.4 * a.sin());
        let camera = Camera {
            eye,
            target: eye + vec3(-a.sin(), -0.5, a.cos()),
            up: Vec3::Y,
            fov_y: 1.0,
            width_px: 1920.0,
            height_px: 1080.0,
            near: 0.001,
        };
        let start = Instant::now();
        let outcome = front.adapt(&h, &view(&camera, ViewOptions::default()), &Request::tolerance(1.0));
        if frame > 0 {
            times.push(ns(start) / 1e6);
            evaluations += outcome.evaluations as u64;
            open += outcome.open as u64;
            updates += (outcome.refined + outcome.coarsened) as u64;
        }
    }
    times.sort_by(f64::total_cmp);
    let n = times.len();
    println!(
        "flight: {:.3} ms a frame (p50), {:.3} (p99); {} updates, {} evaluations of {} open decisions a frame; {} squares",
        times[n / 2],
        times[n * 99 / 100],
        updates / n as u64,
        evaluations / n as u64,
        open / n as u64,
        h.cells(front.mesh()),
    );
}

fn ns(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e9
}
