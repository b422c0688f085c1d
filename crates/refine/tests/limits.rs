//! Budgets and deadlines: legal at every stop, never over, and in the end where it belongs.

mod common;

use common::{Rng, WellFormed};
use glam::{Vec3, vec3};
use meshfront_refine::criteria::{Max, Scale, ScreenSpace, Uniform};
use meshfront_refine::{Criterion, Front, MultiTessellation, Request, UpdateId, oracle::Oracle};
use std::cell::Cell;

thread_local! {
    static NOW: Cell<u64> = const { Cell::new(0) };
}
/// A clock on which every look at it takes 10 µs.
fn clock() -> u64 {
    NOW.set(NOW.get() + 10);
    NOW.get()
}

fn screen(eye: Vec3) -> ScreenSpace {
    ScreenSpace::new(eye, 0.9, 800.0, 0.01)
}

fn eye(r: &mut Rng, span: f32) -> Vec3 {
    r.cube() * span * 1.2 + vec3(0.0, 0.0, 0.1)
}

fn oracle<H: MultiTessellation>(h: &H, c: &impl Criterion, tolerance: f32) -> Vec<UpdateId> {
    let mut oracle = Oracle::new(h);
    oracle.adapt(h, c, tolerance);
    let mut set: Vec<_> = oracle.applied.into_iter().collect();
    set.sort();
    set
}

/// Updates that could be undone, and that could be applied, next.
fn around<H: MultiTessellation>(h: &H, front: &Front<H>) -> (Vec<UpdateId>, Vec<UpdateId>) {
    let (mut leaves, mut ready) = (vec![], vec![]);
    for m in (0..h.len() as u32).map(UpdateId) {
        let mut free = true;
        if front.is_applied(m) {
            h.needed_by(front.mesh(), m, |n| free &= !front.is_applied(n));
            leaves.extend(free.then_some(m));
        } else {
            h.needs(front.mesh(), m, |n| free &= front.is_applied(n));
            ready.extend(free.then_some(m));
        }
    }
    (leaves, ready)
}

fn budget<H: WellFormed>(h: &H, seed: u64) {
    let mut r = Rng(seed * 31 + 7);
    // Some fronts within the budget, some not.
    let tolerance = if H::READS_MESH { 0.02 } else { 3.0 };
    let mut front = Front::new(h);
    let base = h.cells(&h.base());
    let full = base + (0..h.len()).map(|m| h.cells_added(UpdateId(m as u32))).sum::<usize>();
    let (mut at, mut limit, mut bound, mut free) = (eye(&mut r, h.span()), full / 3, 0, 0);
    for _ in 0..120 {
        match r.below(8) {
            0 => at = eye(&mut r, h.span()),
            1 | 2 => limit = r.below(full),
            _ => at += r.cube() * h.span() * 0.02,
        }
        let request = Request { tolerance, max_cells: Some(limit), ..Request::default() };
        let c = Max(screen(at), Scale { inner: Uniform, factor: 0.001 });
        let pixels = |m: UpdateId| c.pixels(&h.footprint(m));
        let outcome = front.adapt(h, &c, &request);
        h.well_formed(front.mesh()).unwrap();
        assert!(outcome.settled);
        assert!(outcome.cells <= limit.max(base), "{} cells, {limit} allowed", outcome.cells);

        let again = front.adapt(h, &c, &request);
        assert_eq!((again.refined, again.coarsened, again.evaluations), (0, 0, 0), "a second call moves nothing");
        // Nor does a look at everything with the same result.
        let fresh = front.adapt(h, &Scale { inner: &c, factor: 1.0 }, &request);
        assert_eq!((fresh.refined, fresh.coarsened), (0, 0), "the front does not oscillate");

        let (leaves, ready) = around(h, &front);
        let missing = ready.iter().any(|&m| pixels(m) > tolerance);
        bound += missing as usize;
        free += !missing as usize;
        assert!(outcome.budget_bound || !missing);
        if !missing {
            assert_eq!(front.applied().collect::<Vec<_>>(), oracle(h, &c, tolerance));
        }
        for &m in &leaves {
            assert!(pixels(m) > tolerance, "{m:?} is a leaf that nothing wants");
        }
        if !H::READS_MESH && missing {
            // The worst that waits does not fit, not even in the place of a better leaf.
            let worst = ready.iter().copied().max_by(|&a, &b| pixels(a).total_cmp(&pixels(b)).then(b.cmp(&a))).unwrap();
            assert!(outcome.error_px == pixels(worst));
            let cells = outcome.cells + h.cells_added(worst);
            assert!(cells > limit);
            for &m in leaves.iter().filter(|&&m| pixels(m) < pixels(worst)) {
                assert!(cells - h.cells_added(m) > limit, "{m:?} should make room for {worst:?}");
            }
        }
    }
    assert!(bound > 10 && free > 10, "{bound} bound, {free} free");
}

fn worst_first<H: WellFormed>(h: &H, seed: u64) {
    let mut r = Rng(seed + 99);
    let mut front = Front::new(h);
    for k in 0..20 {
        let c = screen(eye(&mut r, h.span()));
        let request = if k % 2 == 0 {
            Request { tolerance: 0.0, max_cells: Some(h.len() / 2), ..Request::default() }
        } else {
            Request { tolerance: 0.0, deadline_us: Some(30), clock, ..Request::default() }
        };
        front.interruptible(h, &c, &request);
        let pixels = |m: &UpdateId| c.pixels(&h.footprint(*m));
        let worst = around(h, &front).1.iter().map(pixels).fold(0.0, f32::max);
        if !H::READS_MESH {
            for m in front.applied() {
                assert!(pixels(&m) >= worst, "{m:?} was applied before one of {worst} px");
            }
        }
        h.well_formed(front.mesh()).unwrap();
        if h.cells(front.mesh()) + 3 < h.len() / 2 || k % 2 == 1 {
            front.adapt(h, &c, &Request::tolerance(0.0));
            assert_eq!(front.applied().collect::<Vec<_>>(), oracle(h, &c, 0.0));
        }
    }
}

fn deadline<H: WellFormed>(h: &H, seed: u64) {
    let mut r = Rng(seed + 5);
    let mut front = Front::new(h);
    let mut unsettled = 0;
    for round in 0..40 {
        let mut at = eye(&mut r, h.span());
        let tolerance = 0.3 * 100f32.powf(r.unit());
        let max_cells = (round % 3 == 0).then(|| r.below(2 * h.len()));
        let us = [25, 15, 60][round % 3];
        for call in 1.. {
            // The view goes on moving for a while.
            if call < 15 {
                at += r.cube() * h.span() * 0.01;
            }
            let before = h.cells(front.mesh());
            let c = screen(at);
            NOW.set(0);
            let request = Request { tolerance, max_cells, deadline_us: Some(us), clock };
            let outcome = front.adapt(h, &c, &request);
            h.well_formed(front.mesh()).unwrap();
            // Every look at the clock stands for at most 64 looks at a decision or 8 updates, and a few in the turns
            // between contraction and expansion; the one that finds time up is the last of its phase.
            assert!(NOW.get() <= us as u64 + 40, "{} µs of {us}", NOW.get());
            if !H::READS_MESH {
                assert!(outcome.evaluations < 2000 && outcome.refined + outcome.coarsened < 300, "{outcome:?}");
            }
            if let Some(limit) = max_cells {
                assert!(outcome.cells <= limit.max(before), "cells grow beyond the budget");
            }
            unsettled += !outcome.settled as usize;
            if outcome.settled && call > 15 {
                if !outcome.budget_bound {
                    assert_eq!(front.applied().collect::<Vec<_>>(), oracle(h, &c, tolerance));
                }
                break;
            }
            assert!(call < 500, "does not converge: {outcome:?}");
        }
    }
    assert!(unsettled > 20, "time was up only {unsettled} times");
}

mod budgets {
    use super::*;
    on_each_hierarchy!(budget);
}
mod interruptions {
    use super::*;
    on_each_hierarchy!(worst_first);
}
mod deadlines {
    use super::*;
    on_each_hierarchy!(deadline);
}
