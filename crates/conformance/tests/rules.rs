//! Every rule of dependency passes what it promises of the suite, and those that promise the same cells let the same
//! fronts through.

use glam::Vec3;
use meshfront_conformance::Source;
use meshfront_conformance::merger::{Merging, merge};
use meshfront_conformance::random::Random;
use meshfront_conformance::suite::{Updates, budgets, error_in_force, follow, promises, tolerances, wander};
use meshfront_hierarchies::VertexPair;
use meshfront_hierarchies::vertex_pair::rules::{Free, Implicit, Rule, Ruled, Sequence};
use meshfront_hierarchies::vertex_pair::{Columns, FrontMesh};
use meshfront_mesh::TriangleMesh;
use meshfront_mesh::sample::{self, defects};
use meshfront_refine::{MultiTessellation, UpdateId};
use meshfront_simplify::{EdgeCollapseOptions, edge_collapse};

fn of_edges(mesh: &TriangleMesh, base_triangles: usize) -> VertexPair {
    let h = edge_collapse(mesh, &EdgeCollapseOptions { bits: Some(14), base_triangles }, &()).expect("sound");
    let columns = Columns::from(&h);
    assert_eq!((&columns.vertex, &columns.positions), (&h.columns().vertex, &h.columns().positions));
    VertexPair::new(columns).expect("the same hierarchy")
}

fn errors(h: &VertexPair) -> Vec<f32> {
    h.updates().map(|m| h.error(m)).collect()
}

fn keeps_promises<R: Rule>(ruled: &Ruled<R>, source: &Source, seed: u64) {
    let updates = Updates::watch(ruled);
    if R::KEEPS_CELLS {
        updates.footprints_nest(ruled);
    }
    promises::<Ruled<R>>(&updates.base, source, error_in_force(ruled, |_| false));
    promises::<Ruled<R>>(&updates.full, source, ruled.floor_error());
    wander(ruled, &updates, source, seed);
    for kind in 0..4 {
        follow(ruled, source, kind, seed + kind as u64);
    }
    budgets(ruled, source, seed);
    tolerances(ruled, source);
}

fn all_rules(h: &VertexPair, source: &Source) {
    let (sequence, errors) = (Sequence::of(h), errors(h));
    let stars = sequence.stars();
    keeps_promises(&Ruled::new(h, Implicit::new(h), &stars, &sequence, &errors), source, 1);
    keeps_promises(&Ruled::new(h, sequence.neighbours(), &stars, &sequence, &errors), source, 2);
    keeps_promises(&Ruled::new(h, sequence.stars(), &stars, &sequence, &errors), source, 3);
    keeps_promises(&Ruled::new(h, sequence.faces(), &sequence.faces(), &sequence, &errors), source, 4);
    keeps_promises(&Ruled::new(h, Free, &Free, &sequence, &errors), source, 5);
}

#[test]
fn a_scan_with_holes() {
    let mesh = sample::scan(500);
    all_rules(&of_edges(&mesh, 40), &Source::new(mesh));
}

#[test]
fn three_sheets_on_one_edge() {
    let mesh = defects::non_manifold_edge(400);
    all_rules(&of_edges(&mesh, 40), &Source::new(mesh));
}

/// Random legal steps under one rule; each must be legal under the other, and the other way round.
fn same_fronts<A: Rule, B: Rule>(h: &VertexPair, a: &A, b: &B, seed: u64) -> usize {
    let mut random = Random::new(seed);
    let mut mesh = h.base();
    let mut applied = vec![false; h.len()];
    fn legal(rule: &impl Rule, h: &VertexPair, mesh: &FrontMesh, applied: &[bool], m: UpdateId) -> bool {
        let mut legal = true;
        match applied[m.ix()] {
            false => rule.needs(h, mesh, m, |n| legal &= applied[n.ix()]),
            true => rule.needed_by(h, mesh, m, |n| legal &= !applied[n.ix()]),
        }
        legal
    }
    let mut most = 0;
    for _ in 0..40 * h.len() {
        let m = UpdateId(random.below(h.len()) as u32);
        let may = legal(a, h, &mesh, &applied, m);
        assert_eq!(may, legal(b, h, &mesh, &applied, m), "{m:?}, applied: {}", applied[m.ix()]);
        if may && (!applied[m.ix()] || random.below(30) == 0) {
            if applied[m.ix()] {
                h.coarsen(&mut mesh, m)
            } else {
                h.refine(&mut mesh, m)
            }
            applied[m.ix()] = !applied[m.ix()];
        }
        most = most.max(applied.iter().filter(|&&a| a).count());
    }
    most
}

#[test]
fn numbers_neighbours_and_lists_are_one_order() {
    let any = |mesh: &TriangleMesh, far| {
        let columns = merge(mesh, &Merging { bits: None, base_triangles: 6, far, seed: 11 });
        VertexPair::new(columns).expect("merged soundly")
    };
    for (i, h) in [
        of_edges(&sample::sphere(600), 20),
        of_edges(&sample::scan(600), 20),
        any(&sample::scan(300), 8),
        any(&defects::several_components(300), 3),
        any(&defects::non_manifold_edge(300), 50),
    ]
    .iter()
    .enumerate()
    {
        let sequence = Sequence::of(h);
        let most = same_fronts(h, &Implicit::new(h), &sequence.stars(), i as u64);
        assert!(most > 20, "walked far: {most} of {}", h.len());
        same_fronts(h, &Implicit::new(h), &sequence.neighbours(), 100 + i as u64);
        assert!(Implicit::new(h).bytes() < sequence.stars().bytes() / 4);
    }
}

/// No rule that keeps cells shows one that the sequence of merges did not have, however the front came about; without any
/// rule there are others, and some of them are folded over.
#[test]
fn fronts_have_the_cells_of_the_sequence() {
    let mesh = sample::scan(900);
    let h = of_edges(&mesh, 30);
    let sequence = Sequence::of(&h);
    let foreign = |applied: &dyn Fn(UpdateId) -> bool| {
        let mut front = h.base();
        h.updates().filter(|&m| applied(m)).for_each(|m| h.refine(&mut front, m));
        let folded = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|slot| front.buffers.positions[slot as usize]);
            let mean: Vec3 = t.iter().map(|&slot| normal(front.buffers.normals[slot as usize])).sum();
            (b - a).cross(c - a).dot(mean) < 0.0
        };
        let live = front.buffers.triangles.iter().filter(|t| t[0] != t[1]);
        let named = front.numbered_triangles().map(|(_, t)| t).zip(live);
        let foreign: Vec<_> = named.filter(|(cell, _)| !sequence.has(*cell)).map(|(_, t)| t).collect();
        (foreign.len(), foreign.iter().filter(|t| folded(t)).count())
    };
    let (mut others, mut turned) = (0, 0);
    for seed in 0..30 {
        for free in [false, true] {
            let mut random = Random::new(seed);
            let mut applied = vec![false; h.len()];
            let mut mesh = h.base();
            for _ in 0..10 * h.len() {
                let m = UpdateId(random.below(h.len()) as u32);
                let mut ready = !applied[m.ix()];
                let visit = |n: UpdateId| ready &= applied[n.ix()];
                if free {
                    Free.needs(&h, &mesh, m, visit)
                } else {
                    h.needs(&mesh, m, visit)
                }
                if ready && random.below(4) == 0 {
                    h.refine(&mut mesh, m);
                    applied[m.ix()] = true;
                }
            }
            let (cells, folded) = foreign(&|m| applied[m.ix()]);
            if free {
                (others, turned) = (others + cells, turned + folded);
            } else {
                assert_eq!(cells, 0);
            }
        }
    }
    assert!(others > 0 && turned > 0, "{others} cells of no mesh of the sequence, {turned} folded over");
}

fn normal([x, y, z, _]: [i16; 4]) -> Vec3 {
    Vec3::new(x as f32, y as f32, z as f32) / 32767.0
}
