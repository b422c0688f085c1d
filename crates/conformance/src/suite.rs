//! The promises, checked from outside. Every function panics where one is broken.

use crate::Inspect;
use crate::random::Random;
use crate::source::{Source, Target};
use crate::surface::{Cell, Surface};
use crate::topology::{Topology, edges};
use glam::{DVec3, Quat, Vec3, vec3};
use meshfront_hierarchies::live::TriangleBuffers;
use meshfront_hierarchies::{LiveMesh, TriangleModel};
use meshfront_refine::criteria::{Region, Scale, ScreenSpace, Shape, Uniform};
use meshfront_refine::oracle::Oracle;
use meshfront_refine::{Camera, Criterion, Footprint, Front, Request, Step, UpdateId, ViewOptions, view};
use std::collections::HashMap;

/// All promises, on one hierarchy. `snap` is how far a vertex of the full front may be from the source's.
pub fn check<H: Inspect + TriangleModel>(h: &H, source: &Source, snap: f32, seed: u64) {
    let updates = Updates::watch(h);
    updates.footprints_nest(h);
    full_is_the_source(&updates.full, source, snap);
    promises::<H>(&updates.base, source, error_in_force(h, |_| false));
    promises::<H>(&updates.full, source, h.floor_error());
    for round in 0..3 {
        wander(h, &updates, source, 3 * seed + round);
    }
    if let Some(tightness) = tolerances(h, source) {
        assert!(tightness >= 0.4, "promises are idly loose: the median of measured / promised is {tightness}");
    }
    for kind in 0..4 {
        follow(h, source, kind, seed + kind as u64);
    }
    budgets(h, source, seed);
    replacements(h, &updates, source, seed);
}

/// What each update replaces, as seen when all are applied in order of id.
pub struct Updates {
    /// The updates, ascending.
    pub all: Vec<UpdateId>,
    /// M⁻ and M⁺ of each update, ascending.
    pub cells: Vec<[Vec<Cell>; 2]>,
    /// Which update makes a cell; those of the base mesh are not in it.
    pub maker: HashMap<Cell, UpdateId>,
    /// The corners of M⁻ and M⁺ of each update.
    pub places: Vec<Vec<Vec3>>,
    /// The front with nothing applied.
    pub base: Surface,
    /// The front with everything applied.
    pub full: Surface,
}

impl Updates {
    /// Applies everything, and watches. Costs a look at the whole mesh for each update.
    pub fn watch<H: Inspect>(h: &H) -> Updates {
        let mut mesh = h.base();
        let base = Surface::of::<H>(&mesh);
        let mut updates = Updates {
            all: h.updates().collect(),
            cells: vec![[vec![], vec![]]; h.len()],
            maker: HashMap::new(),
            places: vec![vec![]; h.len()],
            base: base.clone(),
            full: base,
        };
        for m in updates.all.clone() {
            h.needs(&mesh, m, |n| assert!(n < m, "{m:?} needs {n:?}, which has a greater id"));
            let cells = h.cells(&mesh);
            h.refine(&mut mesh, m);
            let after = Surface::of::<H>(&mesh);
            let (minus, plus) = updates.full.difference(&after);
            assert!(!H::KEEPS_TOPOLOGY || !minus.is_empty() && !plus.is_empty(), "{m:?}: {minus:?} becomes {plus:?}");
            assert_eq!(h.cells(&mesh), after.cells.len(), "cells counts live triangles");
            assert_eq!(h.cells(&mesh) - cells, h.cells_added(m), "cells_added of {m:?}");
            for &cell in &plus {
                // Sheets may fall together; then one update makes the cell of both.
                let other = updates.maker.insert(cell, m).filter(|&other| H::KEEPS_TOPOLOGY || other != m);
                assert_eq!(other, None, "{cell:?} is made by two updates");
            }
            let corners = minus.iter().map(|&c| (&updates.full, c)).chain(plus.iter().map(|&c| (&after, c)));
            updates.places[m.ix()] = corners.flat_map(|(surface, cell)| surface.corners(cell)).collect();
            updates.cells[m.ix()] = [minus, plus];
            updates.full = after;
        }
        updates
    }

    /// An update's sphere holds its cells; its sphere, cone and error hold those of every update that takes away a
    /// cell that it made; its cone holds the normals of the full surface below it.
    pub fn footprints_nest<H: Inspect>(&self, h: &H) {
        for &m in &self.all {
            let f = h.footprint(m);
            for p in &self.places[m.ix()] {
                assert!(p.distance(f.center) <= f.radius * (1.0 + 1e-5), "{m:?}: a cell leaves the sphere");
            }
            for maker in self.cells[m.ix()][0].iter().filter_map(|cell| self.maker.get(cell)) {
                assert!(holds(&h.footprint(*maker), &f), "the footprint of {maker:?} does not hold that of {m:?}");
            }
        }
        for cell in &self.full.cells {
            let Some(&maker) = self.maker.get(cell) else { continue };
            let [a, b, c] = self.full.corners(*cell).map(Vec3::as_dvec3);
            let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
            let cone = h.footprint(maker).cone;
            // Half a degree for slivers, whose corners were rounded.
            if cone.cos > 0.0 && normal != Vec3::ZERO {
                let angle = normal.dot(cone.axis).clamp(-1.0, 1.0).acos();
                assert!(angle <= cone.cos.min(1.0).acos() + 0.01, "{maker:?}: a normal leaves the cone");
            }
        }
    }

    /// Applies or undoes an update, and sees that exactly its cells were replaced.
    fn step<H: Inspect>(&self, h: &H, mesh: &mut H::Mesh, surface: &mut Surface, step: Step) {
        let m = match step {
            Step::Refine(m) => {
                h.refine(mesh, m);
                m
            }
            Step::Coarsen(m) => {
                h.coarsen(mesh, m);
                m
            }
        };
        let after = Surface::of::<H>(mesh);
        let (gone, come) = surface.difference(&after);
        let [minus, plus] = &self.cells[m.ix()];
        let expected = if matches!(step, Step::Refine(_)) { (minus, plus) } else { (plus, minus) };
        if H::KEEPS_CELLS {
            assert_eq!((&gone, &come), expected, "{step:?} replaced other cells than in order of id");
        }
        *surface = after;
    }
}

/// Whether a footprint holds another one.
fn holds(outer: &Footprint, inner: &Footprint) -> bool {
    let sphere = outer.center.as_dvec3().distance(inner.center.as_dvec3()) + inner.radius as f64
        <= outer.radius as f64 * (1.0 + 1e-5);
    let half = |f: &Footprint| f64::from(f.cone.cos.clamp(-1.0, 1.0)).acos();
    let apart = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b));
    let cone = outer.cone.cos <= 0.0
        || inner.cone.cos > 0.0
            && apart(outer.cone.axis.as_dvec3(), inner.cone.axis.as_dvec3()) + half(inner) <= half(outer) + 1e-3;
    sphere && cone && outer.error >= inner.error
}

/// The greatest error of the updates that are not applied.
pub fn error_in_force<H: Inspect>(h: &H, applied: impl Fn(UpdateId) -> bool) -> f32 {
    let open = h.updates().filter(|&m| !applied(m));
    open.map(|m| h.footprint(m).error).fold(h.floor_error(), f32::max)
}

/// The full front has the source's triangles, as they are oriented, and its attributes.
pub fn full_is_the_source(full: &Surface, source: &Source, snap: f32) {
    assert_eq!(full.cells.len(), source.mesh.triangles.len());
    assert_eq!(full.looks.len(), source.mesh.positions.len());
    let mesh = &source.mesh;
    let mut vertex_of = HashMap::new();
    for (&name, look) in &full.looks {
        let away = |v: &usize| mesh.positions[*v].distance_squared(look.position());
        let v = (0..mesh.positions.len()).min_by(|a, b| away(a).total_cmp(&away(b))).expect("a source has vertices");
        assert!(away(&v).sqrt() <= snap, "vertex {name} is {} from the nearest of the source", away(&v).sqrt());
        vertex_of.insert(name, v as u32);
        if let Some(n) = mesh.vertex.normals.get(v) {
            let [x, y, z, _] = look.normal.map(|c| c as f32 / 32767.0);
            assert!(vec3(x, y, z).distance(*n) < 2e-4, "the normal of vertex {name}");
        }
        assert_eq!(look.color, mesh.vertex.colors.get(v).copied(), "the colour of vertex {name}");
    }
    let sorted = |cells: &mut dyn Iterator<Item = [u32; 3]>| {
        let mut cells: Vec<_> = cells.map(crate::surface::cell).collect();
        cells.sort_unstable();
        cells
    };
    assert_eq!(
        sorted(&mut full.cells.iter().map(|c| c.map(|name| vertex_of[&name]))),
        sorted(&mut mesh.triangles.iter().map(|t| t.map(|v| v.0))),
        "the full front has the triangles of the source"
    );
}

/// No crack, no hole, no pinch; nothing turned over: where the model promises that.
fn is_sound<H: Inspect>(surface: &Surface, source: &Source) {
    if !H::KEEPS_TOPOLOGY {
        let twice = surface.cells.iter().find(|[a, b, c]| a == b || b == c || c == a);
        return assert_eq!(twice, None, "a cell has a corner twice");
    }
    let (found, expected) = (Topology::of(&surface.cells), &source.topology);
    assert!(found.is_that_of(expected), "an update changed the topology: {found:?} instead of {expected:?}");
}

/// What holds in every front: the source is as near as promised, and where topology stays no crack, no hole, no pinch,
/// nothing turned over. Gives the measured distance.
pub fn promises<H: Inspect>(surface: &Surface, source: &Source, error: f32) -> f32 {
    is_sound::<H>(surface, source);
    let units = |look: &crate::Look| {
        let [x, y, z, w] = look.normal.map(|c| c as f32 / 32767.0);
        assert!((vec3(x, y, z).length() - 1.0).abs() < 1e-3 && w == 0.0, "normals have unit length");
    };
    surface.looks.values().for_each(units);
    if !H::KEEPS_CELLS {
        return 0.0;
    }
    let triangles = surface.triangles();
    // Coordinates are rounded to single precision.
    let error = error + 1e-6 * source.diagonal;
    let measured = Target::new(&triangles).farthest(&source.samples);
    assert!(measured <= error, "a place of the source is {measured} away, {error} is promised");

    if !H::KEEPS_TOPOLOGY {
        return measured;
    }
    let boundary = |(&[a, b], _): (&[u32; 2], _)| [a, b].map(|name| surface.looks[&name].position());
    let rim: Vec<[Vec3; 2]> = edges(&surface.cells).iter().filter(|&(_, &count)| count == 1).map(boundary).collect();
    let middles: Vec<Vec3> = rim.iter().map(|[a, b]| (*a + *b) * 0.5).collect();
    let off = Target::new(&source.rim).farthest(&middles);
    assert!(off <= RIM * error, "a boundary edge is {off} from the source's boundary, {error} is promised");

    // Parts that are smaller than the error may go flat.
    if error < FINE * source.diagonal {
        let area = |t: &[Vec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length() as f64;
        let original =
            (0..source.mesh.triangles.len() as u32).map(|t| source.mesh.corners(meshfront_mesh::TriangleId(t)));
        let ratio = triangles.iter().map(area).sum::<f64>() / original.map(|t| area(&t)).sum::<f64>();
        assert!((0.6..1.2).contains(&ratio), "the front has {ratio} times the area of the source");
    }
    measured
}

/// How many times the promised error a boundary edge may be off the source's boundary: the promise is about the
/// distance of the source from the front; the way back may be longer where a boundary is jagged.
const RIM: f32 = 3.0;
/// Below this error, relative to the diagonal, the area is near that of the source.
const FINE: f32 = 0.02;

/// Random legal moves, with no criterion: nesting cannot hide a missing dependency here. Then back to the base.
pub fn wander<H: Inspect>(h: &H, updates: &Updates, source: &Source, seed: u64) {
    let mut random = Random::new(seed);
    let mut mesh = h.base();
    let mut surface = updates.base.clone();
    let mut applied = vec![false; h.len()];
    let leaf = |mesh: &H::Mesh, applied: &[bool], m: UpdateId| {
        let mut leaf = applied[m.ix()];
        h.needed_by(mesh, m, |n| leaf &= !applied[n.ix()]);
        leaf
    };
    let all = &updates.all;
    for round in 0..all.len() {
        let m = all[random.below(all.len())];
        if leaf(&mesh, &applied, m) {
            updates.step(h, &mut mesh, &mut surface, Step::Coarsen(m));
            applied[m.ix()] = false;
        } else if !applied[m.ix()] && random.below(3) == 0 {
            let mut stack = vec![m];
            while let Some(&top) = stack.last() {
                let waiting = stack.len();
                if !applied[top.ix()] {
                    h.needs(&mesh, top, |n| stack.extend((!applied[n.ix()]).then_some(n)));
                }
                if stack.len() > waiting {
                    continue;
                }
                stack.pop();
                if !applied[top.ix()] {
                    let before = surface.clone();
                    updates.step(h, &mut mesh, &mut surface, Step::Refine(top));
                    if random.below(4) == 0 {
                        let after = surface.clone();
                        updates.step(h, &mut mesh, &mut surface, Step::Coarsen(top));
                        assert_eq!(surface, before, "coarsen undoes refine: {top:?}");
                        updates.step(h, &mut mesh, &mut surface, Step::Refine(top));
                        assert_eq!(surface, after, "refine undoes coarsen: {top:?}");
                    }
                    applied[top.ix()] = true;
                }
            }
        }
        if round % (all.len() / 4 + 1) == 3 {
            promises::<H>(&surface, source, error_in_force(h, |m| applied[m.ix()]));
            // Only what is applied counts, not the way that led here.
            let mut fresh = h.base();
            for &m in all.iter().filter(|m| applied[m.ix()]) {
                h.needs(&fresh, m, |n| assert!(applied[n.ix()], "{m:?} is applied, {n:?} is not"));
                h.refine(&mut fresh, m);
            }
            assert_eq!(Surface::of::<H>(&fresh), surface, "the same set of updates gives the same mesh");
        }
    }
    while applied.contains(&true) {
        let first = random.below(all.len());
        let mut leaves = all[first..].iter().chain(&all[..first]).copied();
        let m = leaves.find(|&m| leaf(&mesh, &applied, m)).expect("a closed set has a leaf");
        updates.step(h, &mut mesh, &mut surface, Step::Coarsen(m));
        applied[m.ix()] = false;
    }
    assert_eq!(surface, updates.base);
    is_base_again(mesh.buffers(), h.base().buffers());
}

/// The base mesh is where it was, bit for bit, and all other slots are free.
fn is_base_again(b: &TriangleBuffers, base: &TriangleBuffers) {
    let bits = |points: &[Vec3]| points.iter().map(|p| p.to_array().map(f32::to_bits)).collect::<Vec<_>>();
    let (n, t) = (base.positions.len(), base.triangles.len());
    assert_eq!(bits(&b.positions[..n]), bits(&base.positions));
    assert_eq!(b.normals[..n], base.normals);
    assert_eq!(b.colors[..base.colors.len()], base.colors);
    assert_eq!(b.levels[..n], base.levels);
    assert_eq!(b.triangles[..t], base.triangles);
    assert!(b.triangles[t..].iter().all(|t| *t == [0; 3]), "slots that the base does not use are free");
}

/// The same tolerance everywhere: the promise holds. How tight it is: the median of measured / promised; `None` where all
/// updates were applied throughout.
pub fn tolerances<H: Inspect>(h: &H, source: &Source) -> Option<f32> {
    let mut front = Front::new(h);
    let mut tightness = vec![];
    for k in 0..12 {
        let tolerance = source.diagonal * 1e-4 * 100f32.powf(k as f32 / 11.0);
        front.adapt(h, &Uniform, &Request::tolerance(tolerance));
        let promised = error_in_force(h, |m| front.is_applied(m));
        assert!(promised <= tolerance.max(h.floor_error()));
        let measured = promises::<H>(&Surface::of::<H>(front.mesh()), source, promised);
        if front.applied_count() < h.updates().count() {
            tightness.push(measured / promised);
        }
    }
    tightness.sort_by(f32::total_cmp);
    tightness.get(tightness.len() / 2).copied()
}

/// At every triangle of several fronts the update that would replace it is the one that takes its cell away when all are
/// applied; at those of the source there is none.
pub fn replacements<H: Inspect + TriangleModel>(h: &H, updates: &Updates, source: &Source, seed: u64) {
    let mut takers: HashMap<Cell, Vec<UpdateId>> = HashMap::new();
    for &m in &updates.all {
        for &cell in &updates.cells[m.ix()][0] {
            takers.entry(cell).or_default().push(m);
        }
    }
    let mut random = Random::new(seed);
    let mut front = Front::new(h);
    let mut checked = [0, 0];
    for round in 0..12 {
        // Everything; then fine in a ball and coarse around it, for cells of all levels side by side.
        let tolerance = if round == 0 { 0.0 } else { source.diagonal * 1e-4 * 300f32.powf(random.unit()) };
        let place = source.mesh.positions[random.below(source.mesh.positions.len())];
        let shape = Shape::Sphere { center: place, radius: 0.3 * source.diagonal * random.unit() };
        let outside = Scale { inner: Uniform, factor: if round == 0 { 1.0 } else { 0.03 } };
        front.adapt(h, &Region { shape, inside: Uniform, outside }, &Request::tolerance(tolerance));
        let mesh = front.mesh();
        let slots = mesh.buffers().triangles.iter().enumerate();
        let live = slots.clone().filter(|(_, t)| **t != [0; 3]).map(|(slot, _)| slot as u32);
        for (slot, names) in live.zip(H::names(mesh)) {
            let takers = takers.get(&crate::surface::cell(names)).map_or(&[][..], |takers| takers);
            match h.next_at(mesh, slot) {
                Some(m) => {
                    assert!(takers.contains(&m), "{m:?} is to replace {names:?}, which {takers:?} take away");
                    assert!(!front.is_applied(m), "{m:?} is to replace {names:?}, and is applied");
                    checked[0] += 1;
                }
                None => {
                    assert!(takers.is_empty(), "nothing is to replace {names:?}, which {takers:?} take away");
                    checked[1] += 1;
                }
            }
        }
        for (slot, _) in slots.filter(|(_, t)| **t == [0; 3]) {
            assert_eq!(h.next_at(mesh, slot as u32), None, "a free slot");
        }
    }
    assert!(
        updates.all.len() < 30 || checked.iter().all(|&n| n > 0),
        "there were coarse and full triangles: {checked:?}"
    );
}

/// The renderer's copy: follows the live mesh by uploading what is said to have changed.
struct Mirror(TriangleBuffers);

impl Mirror {
    fn follow<H: Inspect>(&mut self, mesh: &mut H::Mesh) {
        let (b, copy) = (mesh.buffers(), &mut self.0);
        copy.positions.resize(b.positions.len(), Vec3::ZERO);
        copy.normals.resize(b.normals.len(), [0; 4]);
        copy.colors.resize(b.colors.len(), [0; 4]);
        copy.levels.resize(b.levels.len(), 0);
        copy.triangles.resize(b.triangles.len(), [0; 3]);
        for v in b.changes.vertices.iter().map(|&v| v as usize) {
            copy.positions[v] = b.positions[v];
            copy.normals[v] = b.normals[v];
            copy.levels[v] = b.levels[v];
            if !b.colors.is_empty() {
                copy.colors[v] = b.colors[v];
            }
        }
        for t in b.changes.triangles.iter().map(|&t| t as usize) {
            copy.triangles[t] = b.triangles[t];
        }
        assert_eq!(copy.triangles, b.triangles, "every triangle slot that changed is listed");
        for v in b.triangles.iter().flatten().map(|&v| v as usize) {
            let seen = (copy.positions[v], copy.normals[v], copy.levels[v], copy.colors.get(v));
            assert_eq!(seen, (b.positions[v], b.normals[v], b.levels[v], b.colors.get(v)), "vertex slot {v}");
        }
        mesh.buffers_mut().clear_changes();
    }
}

/// A camera that mostly moves a little and sometimes jumps.
struct Walk {
    random: Random,
    center: Vec3,
    size: f32,
    camera: Camera,
}

impl Walk {
    fn new(source: &Source, seed: u64) -> Walk {
        let (center, size) = (source.mesh.bounds().expect("a source has vertices").center(), source.diagonal);
        let camera = Camera {
            eye: center + vec3(0.3, 0.5, 1.2) * size,
            target: center,
            up: Vec3::Y,
            fov_y: 0.9,
            width_px: 1200.0,
            height_px: 800.0,
            near: 1e-3 * size,
        };
        Walk { random: Random::new(seed), center, size, camera }
    }
    fn step(&mut self) {
        let (random, camera) = (&mut self.random, &mut self.camera);
        match random.below(12) {
            0 => camera.eye = self.center + random.cube() * self.size,
            1 => camera.target = self.center + random.cube() * self.size * 0.3,
            2 => camera.eye += (camera.target - camera.eye) * 0.7,
            3..=6 => {
                let turn = Quat::from_scaled_axis(random.cube() * 0.05);
                camera.target = camera.eye + turn * (camera.target - camera.eye);
            }
            _ => camera.eye += random.cube() * self.size * 0.03,
        }
    }
    fn criterion(&self, kind: usize) -> Box<dyn Criterion> {
        let c = &self.camera;
        let screen = ScreenSpace::new(c.eye, c.fov_y, c.height_px, c.near);
        let ball = Shape::Sphere { center: self.center, radius: self.size * 0.2 };
        match kind {
            0 => Box::new(view(c, ViewOptions::default())),
            1 => Box::new(view(c, ViewOptions { outside: Some(8.0), ..ViewOptions::default() })),
            2 => Box::new(Region { shape: ball, inside: screen, outside: Scale { inner: screen, factor: 0.2 } }),
            _ => Box::new(screen),
        }
    }
}

/// Follows a camera: what is wanted is applied, a second call does nothing, the strategies and the oracle agree, the
/// log replays, the renderer's copy follows.
pub fn follow<H: Inspect>(h: &H, source: &Source, kind: usize, seed: u64) {
    let mut walk = Walk::new(source, seed);
    let (mut front, mut other, mut oracle) = (Front::new(h), Front::new(h), Oracle::new(h));
    let (mut log, mut mirror) = (vec![], Mirror(TriangleBuffers::default()));
    mirror.0.clone_from(front.mesh().buffers());
    let mut request = Request::tolerance(2.0);
    for frame in 0..40 {
        walk.step();
        if walk.random.below(10) == 0 {
            request.tolerance = 0.3 * 60f32.powf(walk.random.unit());
        }
        let c = walk.criterion(kind);
        let outcome = front.adapt(h, &*c, &request);
        log.extend_from_slice(front.steps());
        mirror.follow::<H>(front.mesh_mut());
        let surface = Surface::of::<H>(front.mesh());
        assert!(outcome.settled);
        assert_eq!(outcome.cells, surface.cells.len());
        for m in h.updates().filter(|&m| c.pixels(&h.footprint(m)) > request.tolerance) {
            assert!(front.is_applied(m), "wanted and not applied: {m:?}, frame {frame}");
        }
        oracle.adapt(h, &*c, request.tolerance);
        for m in h.updates() {
            assert_eq!(front.is_applied(m), oracle.applied.contains(&m), "{m:?} and the oracle, frame {frame}");
        }
        assert_eq!(surface, Surface::of::<H>(&oracle.mesh), "the oracle's mesh, frame {frame}");

        front.adapt(h, &*c, &request);
        assert!(front.steps().is_empty(), "a second call moves nothing");
        other.top_down(h, &*c, &request);
        assert_eq!(Surface::of::<H>(other.mesh()), surface, "top-down, frame {frame}");
        other.interruptible(h, &*c, &request);
        assert_eq!(Surface::of::<H>(other.mesh()), surface, "interruptible, frame {frame}");
        if frame % 10 == 9 {
            promises::<H>(&surface, source, error_in_force(h, |m| front.is_applied(m)));
        }
    }
    let mut mesh = h.base();
    for &step in &log {
        match step {
            Step::Refine(m) => h.refine(&mut mesh, m),
            Step::Coarsen(m) => h.coarsen(&mut mesh, m),
        }
    }
    assert_eq!(Surface::of::<H>(&mesh), Surface::of::<H>(front.mesh()), "the log replays");
    for &step in log.iter().rev() {
        match step {
            Step::Refine(m) => h.coarsen(&mut mesh, m),
            Step::Coarsen(m) => h.refine(&mut mesh, m),
        }
    }
    is_base_again(mesh.buffers(), h.base().buffers());
}

/// With a budget or no time at all, every call leaves a sound mesh.
pub fn budgets<H: Inspect>(h: &H, source: &Source, seed: u64) {
    let mut walk = Walk::new(source, seed);
    let (mut front, base) = (Front::new(h), h.cells(&h.base()));
    for frame in 0..20 {
        walk.step();
        let max_cells = base + walk.random.below(source.mesh.triangles.len());
        let deadline_us = (frame % 3 == 2).then_some(0);
        let request = Request { max_cells: Some(max_cells), deadline_us, ..Request::tolerance(0.5) };
        let outcome = front.adapt(h, &*walk.criterion(frame % 4), &request);
        let surface = Surface::of::<H>(front.mesh());
        assert_eq!(outcome.cells, surface.cells.len());
        assert!(outcome.cells <= max_cells || deadline_us.is_some(), "{} of {max_cells} cells", outcome.cells);
        is_sound::<H>(&surface, source);
        if frame % 5 == 4 {
            promises::<H>(&surface, source, error_in_force(h, |m| front.is_applied(m)));
        }
    }
}
