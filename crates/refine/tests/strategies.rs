//! The three strategies, the calendar and the oracle agree on every hierarchy, wherever the view goes.

mod common;

use common::{Rng, WellFormed};
use glam::{Quat, Vec3, vec3};
use meshfront_refine::criteria::{Max, Min, OutsideCoarse, Region, Scale, ScreenSpace, Shape, Uniform};
use meshfront_refine::{
    AnyFront, Camera, Criterion, Footprint, Front, MultiTessellation, Owned, Pose, Request, Step, UpdateId,
    ViewOptions, oracle::Oracle, view,
};

/// A criterion that only knows its pixels: no slack at all.
struct Blind<C>(C);
impl<C: Criterion> Criterion for Blind<C> {
    fn pixels(&self, f: &Footprint) -> f32 {
        self.0.pixels(f)
    }
    fn pose(&self) -> Pose {
        self.0.pose()
    }
}

/// A walk: mostly small steps and turns, sometimes a jump, sometimes a pause.
struct Walk {
    r: Rng,
    span: f32,
    camera: Camera,
}
impl Walk {
    fn new(span: f32, seed: u64) -> Walk {
        let camera = Camera {
            eye: vec3(span, 0.5 * span, 0.3 * span),
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov_y: 0.9,
            width_px: 1200.0,
            height_px: 800.0,
            near: 0.01,
        };
        Walk { r: Rng((seed * 2654435761) | 1), span, camera }
    }
    fn step(&mut self) {
        let camera = &mut self.camera;
        match self.r.below(40) {
            0 | 1 => camera.eye = self.r.cube() * self.span * 1.5,
            7 => camera.target = self.r.cube() * self.span,
            2 => camera.fov_y = 0.3 + self.r.unit(),
            3 | 4 => {}
            // Right up to a place on the hierarchy.
            5 => camera.eye += (camera.target - camera.eye) * 0.7,
            6..=20 => {
                let turn = Quat::from_scaled_axis(self.r.cube() * 0.02);
                camera.target = camera.eye + turn * (camera.target - camera.eye);
            }
            _ => {
                let stride = camera.eye.length() * 0.01 * self.r.unit();
                camera.eye += self.r.cube() * stride;
            }
        }
    }
}

fn criteria(k: usize, camera: &Camera, span: f32) -> Box<dyn Criterion> {
    let screen = ScreenSpace::new(camera.eye, camera.fov_y, camera.height_px, camera.near);
    let ball = Shape::Sphere { center: Vec3::splat(span * 0.3), radius: span * 0.2 };
    match k {
        0 => Box::new(view(camera, ViewOptions::default())),
        1 => Box::new(view(camera, ViewOptions { outside: Some(8.0), ..ViewOptions::default() })),
        2 => Box::new(Blind(view(camera, ViewOptions::default()))),
        3 => Box::new(Region { shape: ball, inside: screen, outside: Scale { inner: screen, factor: 0.2 } }),
        4 => Box::new(Max(screen, Scale { inner: Uniform, factor: 300.0 })),
        _ => Box::new(OutsideCoarse {
            inner: Min(screen, Scale { inner: Uniform, factor: 1000.0 }),
            switch: meshfront_refine::criteria::Frustum::new(camera),
            factor: 3.0,
        }),
    }
}

fn applied<H: MultiTessellation>(f: &Front<H>) -> Vec<UpdateId> {
    f.applied().collect()
}

fn walk<H: WellFormed>(h: &H, seed: u64) {
    let mut changed = 0;
    for kind in 0..6 {
        let mut w = Walk::new(h.span(), seed + kind as u64);
        let mut front = Front::new(h);
        let (mut log, mut reused) = (vec![], Front::new(h));
        let mut request = Request::tolerance(4.0);
        for frame in 0..150 {
            w.step();
            if w.r.below(30) == 0 {
                request.tolerance = 0.5 * 400f32.powf(w.r.unit());
            }
            let c = criteria(kind, &w.camera, h.span());
            let outcome = front.adapt(h, &*c, &request);
            let steps = front.steps().to_vec();
            assert!(outcome.settled);
            assert_eq!(outcome.cells, h.cells(front.mesh()));
            assert_eq!((outcome.refined + outcome.coarsened) as usize, steps.len());
            h.well_formed(front.mesh()).unwrap();
            changed += (!steps.is_empty()) as usize;
            log.extend(steps);

            let mut oracle = Oracle::new(h);
            oracle.adapt(h, &c, request.tolerance);
            let mut expected: Vec<_> = oracle.applied.iter().copied().collect();
            expected.sort();
            assert_eq!(applied(&front), expected, "criterion {kind}, frame {frame}");
            assert_eq!(h.print(front.mesh()), h.print(&oracle.mesh));

            let again = front.adapt(h, &*c, &request);
            assert_eq!((again.refined, again.coarsened, again.evaluations), (0, 0, 0), "a second call does nothing");
            assert!(front.steps().is_empty());
            assert!(front.measure(h, &*c) <= request.tolerance.min(again.error_px) || again.error_px == 0.0);

            if frame % 10 == 0 {
                assert!(reused.top_down(h, &*c, &request).settled);
                assert_eq!(applied(&reused), expected, "top-down");
                w.step();
                let c = criteria(kind, &w.camera, h.span());
                reused.adapt(h, &*c, &request);
                front.adapt(h, &*c, &request);
                log.extend_from_slice(front.steps());
                assert_eq!(applied(&reused), applied(&front), "incremental after top-down");
                assert!(reused.interruptible(h, &*c, &request).settled);
                assert_eq!(applied(&reused), applied(&front), "interruptible");
            }
        }
        replay(h, &front, &log);
    }
    assert!(changed > 60, "the walk saw {changed} changes");
}

/// The log gives the same front from the base mesh, and backwards the base mesh from the front.
fn replay<H: WellFormed>(h: &H, front: &Front<H>, log: &[Step]) {
    let (mut mesh, mut set) = (h.base(), std::collections::HashSet::new());
    for step in log {
        match *step {
            Step::Refine(m) => {
                h.needs(&mesh, m, |n| assert!(set.contains(&n)));
                h.refine(&mut mesh, m);
                assert!(set.insert(m));
            }
            Step::Coarsen(m) => {
                h.needed_by(&mesh, m, |n| assert!(!set.contains(&n)));
                h.coarsen(&mut mesh, m);
                assert!(set.remove(&m));
            }
        }
        assert!(set.len() <= h.len());
    }
    assert_eq!(h.print(&mesh), h.print(front.mesh()));
    for step in log.iter().rev() {
        match *step {
            Step::Refine(m) => h.coarsen(&mut mesh, m),
            Step::Coarsen(m) => h.refine(&mut mesh, m),
        }
    }
    assert_eq!(h.print(&mesh), h.print(&h.base()));
}

on_each_hierarchy!(walk);

#[test]
fn one_loop_drives_every_model() {
    let mut fronts: Vec<Box<dyn AnyFront>> = vec![
        Box::new(Owned::new(common::RightTriangles::new(16, |_, _| 1.0).into())),
        Box::new(Owned::new(common::LiveTree { depth: 5 }.into())),
        Box::new(Owned::new(common::Explicit::random(50, 3).into())),
    ];
    for front in &mut fronts {
        assert!(front.adapt(&Scale { inner: Uniform, factor: 1e9 }, &Request::default()).refined > 0);
        assert_eq!(front.applied_count(), front.updates());
        assert_eq!(front.adapt(&Uniform, &Request::tolerance(f32::INFINITY)).coarsened as usize, front.updates());
    }
}

#[test]
fn an_empty_hierarchy_is_settled() {
    let h = common::Explicit { up: vec![], down: vec![], foot: vec![] };
    let outcome = Front::new(&h).adapt(&h, &Uniform, &Request::default());
    assert!(outcome.settled && outcome.error_px == 0.0 && outcome.cells == common::Explicit::BASE_CELLS);
}
