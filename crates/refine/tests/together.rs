//! Several fronts under one budget: never over it, and no front has what another one needs more.

mod common;

use common::{Explicit, LiveTree, RightTriangles, Rng, WellFormed};
use glam::{Vec3, vec3};
use meshfront_refine::criteria::{Max, Scale, ScreenSpace, Uniform};
use meshfront_refine::{
    Criterion, Front, Member, MultiTessellation, Outcome, Request, UpdateId, Viewed, adapt_together, oracle::Oracle,
};
use std::cell::Cell;

/// Error on the screen, and a little everywhere.
fn criterion(eye: Vec3) -> impl Criterion {
    Max(ScreenSpace::new(eye, 0.9, 800.0, 0.01), Scale { inner: Uniform, factor: 0.001 })
}

fn wanted<H: MultiTessellation>(h: &H, c: &impl Criterion, tolerance: f32) -> Vec<UpdateId> {
    let mut oracle = Oracle::new(h);
    oracle.adapt(h, c, tolerance);
    let mut set: Vec<_> = oracle.applied.into_iter().collect();
    set.sort();
    set
}

/// Pixels and cells of what could be undone, and of what could be applied, next.
type Decisions = [Vec<(f32, usize)>; 2];

fn decisions<H: MultiTessellation>(h: &H, front: &Front<H>, c: &impl Criterion) -> Decisions {
    let mut decisions = Decisions::default();
    for m in h.updates() {
        let (mut free, applied) = (true, front.is_applied(m));
        if applied {
            h.needed_by(front.mesh(), m, |n| free &= !front.is_applied(n));
        } else {
            h.needs(front.mesh(), m, |n| free &= front.is_applied(n));
        }
        if free {
            decisions[!applied as usize].push((c.pixels(&h.footprint(m)), h.cells_added(m)));
        }
    }
    decisions
}

fn full<H: MultiTessellation>(h: &H) -> [usize; 2] {
    let base = h.cells(&h.base());
    [base, base + h.updates().map(|m| h.cells_added(m)).sum::<usize>()]
}

#[test]
fn the_worst_of_all_comes_first() {
    let (a, b) = (Explicit::random(500, 5), Explicit::random(300, 11));
    let t = RightTriangles::new(32, |x, y| ((x * 7 + y * 13) % 11) as f32 * 0.02);
    let (mut fa, mut fb, mut ft) = (Front::new(&a), Front::new(&b), Front::new(&t));
    let [base, all] = [0, 1].map(|i| full(&a)[i] + full(&b)[i] + full(&t)[i]);
    let mut r = Rng(99);
    let (mut eyes, mut limit, mut bound, mut free) = ([Vec3::Z; 3], all / 3, 0, 0);
    for round in 0..200 {
        match r.below(6) {
            0 => eyes = [a.span(), b.span(), t.span()].map(|span| r.cube() * span * 1.2 + vec3(0.0, 0.0, 0.1)),
            1 | 2 => limit = r.below(all + all / 4),
            // One of them moves, the others stay.
            n => eyes[n - 3] += r.cube() * 0.05,
        }
        let [ca, cb, ct] = eyes.map(criterion);
        let request = Request { tolerance: 3.0, max_cells: Some(limit), ..Request::default() };
        let mut adapt = || -> [Outcome; 3] {
            let (mut va, mut vb, mut vt) =
                (Viewed::new(&mut fa, &a, &ca), Viewed::new(&mut fb, &b, &cb), Viewed::new(&mut ft, &t, &ct));
            adapt_together(&mut [&mut va, &mut vb, &mut vt], &request);
            [va.outcome(), vb.outcome(), vt.outcome()]
        };
        let outcomes = adapt();
        let again = adapt();
        assert!(
            again.iter().all(|o| (o.refined, o.coarsened, o.evaluations) == (0, 0, 0)),
            "a second call moves nothing"
        );
        assert!(outcomes.iter().all(|o| o.settled), "{round}");
        for (front, h) in [(&fa, &a), (&fb, &b)] {
            h.well_formed(front.mesh()).unwrap();
        }
        t.well_formed(ft.mesh()).unwrap();

        let cells: usize = outcomes.iter().map(|o| o.cells).sum();
        assert_eq!(cells, a.cells(fa.mesh()) + b.cells(fb.mesh()) + t.cells(ft.mesh()));
        assert!(cells <= limit.max(base), "{cells} cells, {limit} allowed");
        let each = [decisions(&a, &fa, &ca), decisions(&b, &fb, &cb), decisions(&t, &ft, &ct)];
        let waiting = each.iter().flat_map(|d| &d[1]).copied().filter(|d| d.0 > 3.0);
        match waiting.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((worst, added)) => {
                bound += 1;
                assert!(outcomes.iter().all(|o| o.budget_bound));
                assert!(outcomes.iter().any(|o| o.error_px == worst));
                for &(pixels, freed) in each.iter().flat_map(|d| &d[0]) {
                    assert!(
                        pixels >= worst || cells + added - freed > limit,
                        "{pixels} px make no room for {worst} px"
                    );
                }
            }
            None => {
                free += 1;
                assert_eq!(fa.applied().collect::<Vec<_>>(), wanted(&a, &ca, 3.0));
                assert_eq!(fb.applied().collect::<Vec<_>>(), wanted(&b, &cb, 3.0));
                assert_eq!(ft.applied().collect::<Vec<_>>(), wanted(&t, &ct, 3.0));
            }
        }
    }
    assert!(bound > 40 && free > 40, "{bound} rounds with too little, {free} with enough");
}

thread_local! {
    static NOW: Cell<u64> = const { Cell::new(0) };
}
/// A clock on which every look at it takes 10 µs.
fn clock() -> u64 {
    NOW.set(NOW.get() + 10);
    NOW.get()
}

#[test]
fn one_deadline_is_for_all_and_dependencies_may_be_read_off_the_mesh() {
    let (tree, t) = (LiveTree { depth: 9 }, RightTriangles::new(32, |x, y| ((x * 7 + y * 13) % 11) as f32 * 0.02));
    let (mut fl, mut ft) = (Front::new(&tree), Front::new(&t));
    let mut r = Rng(3);
    let mut unsettled = 0;
    for round in 0..30 {
        let eyes = [tree.span(), t.span()].map(|span| r.cube() * span * 1.2 + vec3(0.0, 0.0, 0.1));
        let [cl, ct] = eyes.map(criterion);
        let max_cells = (round % 2 == 0).then(|| 300 + r.below(1500));
        for call in 0.. {
            NOW.set(0);
            let request = Request { tolerance: 1.0, max_cells, deadline_us: Some(60), clock };
            let (mut vl, mut vt) = (Viewed::new(&mut fl, &tree, &cl), Viewed::new(&mut ft, &t, &ct));
            let members: &mut [&mut dyn Member] = &mut [&mut vl, &mut vt];
            adapt_together(members, &request);
            let outcomes = members.iter().map(|m| m.outcome()).collect::<Vec<_>>();
            tree.well_formed(fl.mesh()).unwrap();
            t.well_formed(ft.mesh()).unwrap();
            assert!(NOW.get() <= 110, "{} µs of 60", NOW.get());
            if outcomes.iter().all(|o| o.settled) {
                if !outcomes[0].budget_bound {
                    assert_eq!(fl.applied().collect::<Vec<_>>(), wanted(&tree, &cl, 1.0));
                    assert_eq!(ft.applied().collect::<Vec<_>>(), wanted(&t, &ct, 1.0));
                }
                break;
            }
            unsettled += 1;
            assert!(call < 500, "does not converge: {outcomes:?}");
        }
    }
    assert!(unsettled > 20, "time was up only {unsettled} times");
}

#[test]
fn who_leaves_makes_room() {
    let (a, b) = (Explicit::random(500, 5), Explicit::random(300, 11));
    let (mut fa, mut fb) = (Front::new(&a), Front::new(&b));
    let (ca, cb) = (criterion(Vec3::Z * 2.0), criterion(Vec3::X * 2.0));
    let limit = full(&a)[1];
    let request = Request { tolerance: 0.0, max_cells: Some(limit), ..Request::default() };
    let (mut va, mut vb) = (Viewed::new(&mut fa, &a, &ca), Viewed::new(&mut fb, &b, &cb));
    adapt_together(&mut [&mut va, &mut vb], &request);
    assert!(va.outcome().budget_bound && va.outcome().cells < limit);
    adapt_together(&mut [&mut va], &request);
    assert_eq!(va.outcome().cells, limit, "nothing is missing any more");
}
