//! Three very different hierarchies: an explicit DAG, right-triangle terrain whose DAG is arithmetic, and a tree
//! whose dependencies are read off the live mesh. And a look at their meshes that does not ask the trait.
#![allow(dead_code)]

use glam::{Vec3, vec3};
use meshfront_refine::{Footprint, MultiTessellation, NormalCone, UpdateId};
use std::collections::{BTreeMap, HashSet};

pub struct Rng(pub u64);
impl Rng {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() >> 11) as usize % n
    }
    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u64 << 24) as f32
    }
    /// In [-1, 1)³.
    pub fn cube(&mut self) -> Vec3 {
        vec3(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// Looks at the mesh itself, never at the hierarchy's own dependency methods.
pub trait WellFormed: MultiTessellation {
    fn well_formed(&self, mesh: &Self::Mesh) -> Result<(), String>;
    /// The largest coordinate.
    fn span(&self) -> f32;
    /// What tells two live meshes apart.
    fn print(&self, mesh: &Self::Mesh) -> Vec<u32>;
}

/// Widens `f` until it holds `child`, and a little more, since the engine relies on nesting after rounding.
fn hold(f: &mut Footprint, child: &Footprint) {
    f.radius = f.radius.max((f.center.distance(child.center) + child.radius) * 1.00001);
    f.error = f.error.max(child.error);
    let half = |c: &NormalCone| c.sin.atan2(c.cos);
    let angle = half(&f.cone).max(f.cone.axis.angle_between(child.cone.axis) + half(&child.cone) + 1e-4);
    f.cone = if angle >= std::f32::consts::FRAC_PI_2 {
        NormalCone { cos: -1.0, sin: 0.0, ..f.cone }
    } else {
        NormalCone { cos: angle.cos(), sin: angle.sin(), ..f.cone }
    };
}

// 1. explicit DAG ------------------------------------------------------------
pub struct Explicit {
    pub up: Vec<Vec<UpdateId>>,
    pub down: Vec<Vec<UpdateId>>,
    pub foot: Vec<Footprint>,
}
#[derive(Clone)]
pub struct Applied {
    pub set: Vec<bool>,
    pub cells: usize,
}
impl Explicit {
    pub const BASE_CELLS: usize = 10;

    /// `n` updates, all but a few of which need one to three earlier ones that are near.
    pub fn random(n: usize, seed: u64) -> Explicit {
        let mut r = Rng(seed | 1);
        let (mut up, mut down) = (vec![vec![]; n], vec![vec![]; n]);
        let mut foot = Vec::<Footprint>::new();
        for i in 0..n {
            let center = r.cube() * 10.0;
            foot.push(Footprint {
                center,
                radius: 0.05 * r.unit(),
                error: 0.3 * r.unit() * r.unit() / (1 + i / 6) as f32,
                cone: NormalCone { axis: (center + r.cube() * 3.0).normalize(), sin: 0.0, cos: 1.0 },
            });
            if i > 5 {
                for _ in 0..1 + r.below(3) {
                    let near =
                        (0..25).map(|_| r.below(i)).min_by_key(|&p| (foot[p].center.distance(center) * 1e4) as u32);
                    let p = UpdateId(near.unwrap() as u32);
                    if !up[i].contains(&p) {
                        up[i].push(p);
                        down[p.ix()].push(UpdateId(i as u32));
                    }
                }
            }
        }
        for i in (0..n).rev() {
            let child = foot[i];
            for p in &up[i] {
                hold(&mut foot[p.ix()], &child);
            }
        }
        Explicit { up, down, foot }
    }
}
impl MultiTessellation for Explicit {
    type Mesh = Applied;
    fn len(&self) -> usize {
        self.up.len()
    }
    fn base(&self) -> Applied {
        Applied { set: vec![false; self.up.len()], cells: Explicit::BASE_CELLS }
    }
    fn footprint(&self, m: UpdateId) -> Footprint {
        self.foot[m.ix()]
    }
    fn roots(&self, visit: impl FnMut(UpdateId)) {
        (0..self.up.len()).filter(|&m| self.up[m].is_empty()).map(|m| UpdateId(m as u32)).for_each(visit)
    }
    fn children(&self, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.down[m.ix()].iter().copied().for_each(visit)
    }
    fn needs(&self, _: &Applied, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.up[m.ix()].iter().copied().for_each(visit)
    }
    fn needed_by(&self, _: &Applied, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.down[m.ix()].iter().copied().for_each(visit)
    }
    fn refine(&self, a: &mut Applied, m: UpdateId) {
        assert!(!std::mem::replace(&mut a.set[m.ix()], true));
        a.cells += self.cells_added(m);
    }
    fn coarsen(&self, a: &mut Applied, m: UpdateId) {
        assert!(std::mem::replace(&mut a.set[m.ix()], false));
        a.cells -= self.cells_added(m);
    }
    fn cells(&self, a: &Applied) -> usize {
        a.cells
    }
    fn cells_added(&self, m: UpdateId) -> usize {
        [2, 2, 2, 1, 3, 0][m.ix() % 6]
    }
}
impl WellFormed for Explicit {
    fn well_formed(&self, a: &Applied) -> Result<(), String> {
        for (i, ps) in self.up.iter().enumerate() {
            if let Some(p) = ps.iter().find(|p| a.set[i] && !a.set[p.ix()]) {
                return Err(format!("{i} applied before {p:?}"));
            }
        }
        Ok(())
    }
    fn span(&self) -> f32 {
        10.0
    }
    fn print(&self, a: &Applied) -> Vec<u32> {
        (0..a.set.len() as u32).filter(|&i| a.set[i as usize]).collect()
    }
}

// 2. right triangles: everything but the footprints is arithmetic on grid vertices ---
pub struct RightTriangles {
    n: i32,
    /// Ids are coarse to fine: the vertex of each, and the id of each vertex (none for the corners).
    vertices: Vec<(i32, i32)>,
    ids: Vec<Option<UpdateId>>,
    foot: Vec<Footprint>,
}
impl RightTriangles {
    fn id(&self, (x, y): (i32, i32)) -> Option<UpdateId> {
        let inside = x >= 0 && y >= 0 && x <= self.n && y <= self.n;
        inside.then(|| self.ids[(y * (self.n + 1) + x) as usize]).flatten()
    }
    /// Half the edge that the vertex splits, and whether that is a diagonal.
    fn step((x, y): (i32, i32)) -> (i32, bool) {
        let (lx, ly) = (x.trailing_zeros().min(30), y.trailing_zeros().min(30));
        (1 << lx.min(ly), lx == ly)
    }
    fn parents(&self, (x, y): (i32, i32), mut visit: impl FnMut(UpdateId)) {
        let (s, diagonal) = Self::step((x, y));
        let apexes = if diagonal {
            [(-s, -s), (s, -s), (-s, s), (s, s)]
                .map(|(dx, dy)| (x + dx, y + dy))
                .into_iter()
                // The corners of the square that are apexes of the triangles to split.
                .filter(|&(px, py)| ((px / (2 * s)) + (py / (2 * s))) & 1 == 1)
                .collect()
        } else if x % (2 * s) == 0 {
            vec![(x - s, y), (x + s, y)]
        } else {
            vec![(x, y - s), (x, y + s)]
        };
        apexes.into_iter().filter_map(|p| self.id(p)).for_each(&mut visit);
    }
    pub fn new(n: i32, height: impl Fn(i32, i32) -> f32) -> Self {
        let mut vertices: Vec<_> = (0..(n + 1) * (n + 1)).map(|i| (i % (n + 1), i / (n + 1))).collect();
        vertices.retain(|&(x, y)| x % n != 0 || y % n != 0);
        vertices.sort_by_key(|&v| {
            let (s, diagonal) = Self::step(v);
            std::cmp::Reverse(2 * s + diagonal as i32)
        });
        let mut ids = vec![None; ((n + 1) * (n + 1)) as usize];
        for (i, &(x, y)) in vertices.iter().enumerate() {
            ids[(y * (n + 1) + x) as usize] = Some(UpdateId(i as u32));
        }
        let foot = vertices.iter().map(|&(x, y)| Footprint {
            center: vec3(x as f32, y as f32, 0.0),
            radius: 0.0,
            error: height(x, y) * Self::step((x, y)).0 as f32,
            cone: NormalCone { axis: Vec3::Z, sin: 0.3, cos: 0.3f32.asin().cos() },
        });
        let mut t = RightTriangles { n, foot: foot.collect(), vertices, ids };
        for i in (0..t.foot.len()).rev() {
            let (child, mut up) = (t.foot[i], vec![]);
            t.parents(t.vertices[i], |p| up.push(p));
            for p in up {
                hold(&mut t.foot[p.ix()], &child);
            }
        }
        t
    }
}
impl MultiTessellation for RightTriangles {
    type Mesh = (HashSet<UpdateId>, usize);
    fn len(&self) -> usize {
        self.foot.len()
    }
    fn base(&self) -> Self::Mesh {
        (HashSet::new(), 2)
    }
    fn roots(&self, mut visit: impl FnMut(UpdateId)) {
        for (i, &v) in self.vertices.iter().enumerate() {
            let mut root = true;
            self.parents(v, |_| root = false);
            if root {
                visit(UpdateId(i as u32));
            }
        }
    }
    fn children(&self, m: UpdateId, mut visit: impl FnMut(UpdateId)) {
        let (x, y) = self.vertices[m.ix()];
        let (s, diagonal) = Self::step((x, y));
        let h = s / 2;
        let offsets = if diagonal { [(-s, 0), (s, 0), (0, -s), (0, s)] } else { [(-h, -h), (h, -h), (-h, h), (h, h)] };
        if !diagonal && h == 0 {
            return;
        }
        for c in offsets.map(|(dx, dy)| (x + dx, y + dy)) {
            if let Some(child) = self.id(c) {
                let mut mine = false;
                self.parents(c, |p| mine |= p == m);
                if mine {
                    visit(child);
                }
            }
        }
    }
    fn footprint(&self, m: UpdateId) -> Footprint {
        self.foot[m.ix()]
    }
    fn needs(&self, _: &Self::Mesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.parents(self.vertices[m.ix()], visit);
    }
    fn needed_by(&self, _: &Self::Mesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.children(m, visit);
    }
    fn refine(&self, a: &mut Self::Mesh, m: UpdateId) {
        assert!(a.0.insert(m));
        a.1 += self.cells_added(m);
    }
    fn coarsen(&self, a: &mut Self::Mesh, m: UpdateId) {
        assert!(a.0.remove(&m));
        a.1 -= self.cells_added(m);
    }
    fn cells(&self, a: &Self::Mesh) -> usize {
        a.1
    }
    fn cells_added(&self, m: UpdateId) -> usize {
        let (x, y) = self.vertices[m.ix()];
        if x % self.n == 0 || y % self.n == 0 { 1 } else { 2 }
    }
}
impl WellFormed for RightTriangles {
    fn well_formed(&self, (s, cells): &Self::Mesh) -> Result<(), String> {
        let n = self.n;
        let (mut used, mut edges, mut triangles) = (HashSet::new(), HashSet::new(), 0);
        let mut stack = vec![((0, 0), (n, n), (n, 0)), ((n, n), (0, 0), (0, n))];
        while let Some((a, b, c)) = stack.pop() {
            let m = ((a.0 + b.0) / 2, (a.1 + b.1) / 2);
            let splittable = (a.0 - c.0).abs() + (a.1 - c.1).abs() > 1;
            match self.id(m) {
                Some(id) if splittable && s.contains(&id) => {
                    used.insert(id);
                    stack.push((c, a, m));
                    stack.push((b, c, m));
                }
                _ => {
                    triangles += 1;
                    edges.extend([(a, b), (b, c), (c, a)]);
                }
            }
        }
        if used.len() != s.len() {
            return Err(format!("{} of {} applied vertices are in the mesh", used.len(), s.len()));
        }
        if triangles != *cells {
            return Err(format!("{triangles} triangles, {cells} counted"));
        }
        for &(a, b) in &edges {
            let border = (a.0 == b.0 && a.0 % n == 0) || (a.1 == b.1 && a.1 % n == 0);
            if !border && !edges.contains(&(b, a)) {
                return Err(format!("crack at {a:?}-{b:?}"));
            }
        }
        Ok(())
    }
    fn span(&self) -> f32 {
        self.n as f32
    }
    fn print(&self, (s, _): &Self::Mesh) -> Vec<u32> {
        let mut ids: Vec<u32> = s.iter().map(|m| m.0).collect();
        ids.sort();
        ids
    }
}

// 3. a tree over a polyline whose dependencies are read off the live neighbours -----
/// Leaves 0..2^depth of a polyline; node k of a binary heap covers a range and splits into 2k and 2k + 1. Update
/// k − 1 splits node k, which needs both live neighbours to be at most one level coarser than the halves: a balance
/// rule, looked up in the mesh.
pub struct LiveTree {
    pub depth: u32,
}
/// Start of range → node.
#[derive(Clone)]
pub struct Polyline {
    live: BTreeMap<u32, u32>,
}
impl LiveTree {
    fn level(k: u32) -> u32 {
        31 - k.leading_zeros()
    }
    fn start(&self, k: u32) -> u32 {
        (k - (1 << Self::level(k))) << (self.depth - Self::level(k))
    }
    fn is_live(&self, p: &Polyline, k: u32) -> bool {
        p.live.get(&self.start(k)) == Some(&k)
    }
    fn neighbours(&self, p: &Polyline, k: u32) -> impl Iterator<Item = u32> {
        let s = self.start(k);
        let e = s + (1 << (self.depth - Self::level(k)));
        let (left, right) = (p.live.range(..s).next_back(), p.live.range(e..).next());
        [left, right].into_iter().flatten().map(|(_, &v)| v).collect::<Vec<_>>().into_iter()
    }
    fn split(k: u32) -> UpdateId {
        UpdateId(k - 1)
    }
}
impl MultiTessellation for LiveTree {
    type Mesh = Polyline;
    const READS_MESH: bool = true;
    fn len(&self) -> usize {
        (1 << self.depth) - 1
    }
    fn base(&self) -> Polyline {
        Polyline { live: [(0, 1)].into() }
    }
    fn roots(&self, mut visit: impl FnMut(UpdateId)) {
        visit(UpdateId(0))
    }
    fn children(&self, m: UpdateId, visit: impl FnMut(UpdateId)) {
        let k = m.0 + 1;
        [2 * k, 2 * k + 1].into_iter().map(Self::split).filter(|c| c.ix() < self.len()).for_each(visit)
    }
    fn footprint(&self, m: UpdateId) -> Footprint {
        let k = m.0 + 1;
        let w = (1u32 << (self.depth - Self::level(k))) as f32;
        let center = vec3(self.start(k) as f32 + w / 2.0, 0.0, 0.0);
        Footprint { center, radius: w / 2.0, error: w * w / (1 << self.depth) as f32, cone: NormalCone::ALL }
    }
    fn needs(&self, p: &Polyline, m: UpdateId, mut visit: impl FnMut(UpdateId)) {
        let k = m.0 + 1;
        if !self.is_live(p, k) {
            return visit(Self::split(k / 2));
        }
        self.neighbours(p, k).filter(|&n| Self::level(n) < Self::level(k)).map(Self::split).for_each(visit);
    }
    fn needed_by(&self, p: &Polyline, m: UpdateId, mut visit: impl FnMut(UpdateId)) {
        let k = m.0 + 1;
        let mut halves = true;
        for c in [2 * k, 2 * k + 1] {
            if !self.is_live(p, c) {
                halves = false;
                visit(Self::split(c));
            }
        }
        if halves {
            // Neighbours two levels finer than the node stand on its halves.
            for c in [2 * k, 2 * k + 1] {
                self.neighbours(p, c)
                    .filter(|&n| Self::level(n) > Self::level(k) + 1)
                    .for_each(|n| visit(Self::split(n / 2)));
            }
        }
    }
    fn refine(&self, p: &mut Polyline, m: UpdateId) {
        let k = m.0 + 1;
        assert_eq!(p.live.insert(self.start(k), 2 * k), Some(k));
        assert_eq!(p.live.insert(self.start(2 * k + 1), 2 * k + 1), None);
    }
    fn coarsen(&self, p: &mut Polyline, m: UpdateId) {
        let k = m.0 + 1;
        assert_eq!(p.live.remove(&self.start(2 * k + 1)), Some(2 * k + 1));
        assert_eq!(p.live.insert(self.start(k), k), Some(2 * k));
    }
    fn cells(&self, p: &Polyline) -> usize {
        p.live.len()
    }
    fn cells_added(&self, _: UpdateId) -> usize {
        1
    }
}
impl WellFormed for LiveTree {
    fn well_formed(&self, p: &Polyline) -> Result<(), String> {
        let (mut at, mut last) = (0, None::<u32>);
        for (&s, &k) in &p.live {
            if s != at {
                return Err(format!("gap at {at}"));
            }
            at = s + (1 << (self.depth - Self::level(k)));
            if last.is_some_and(|l| Self::level(l).abs_diff(Self::level(k)) > 1) {
                return Err(format!("unbalanced at {s}"));
            }
            last = Some(k);
        }
        if at != 1 << self.depth { Err("does not cover".into()) } else { Ok(()) }
    }
    fn span(&self) -> f32 {
        (1 << self.depth) as f32
    }
    fn print(&self, p: &Polyline) -> Vec<u32> {
        p.live.values().copied().collect()
    }
}

/// Runs a test on each of the three.
#[macro_export]
macro_rules! on_each_hierarchy {
    ($test:ident) => {
        #[test]
        fn explicit() {
            for seed in 1..4 {
                $test(&$crate::common::Explicit::random(600, seed * 7919), seed);
            }
        }
        #[test]
        fn right_triangles() {
            let t = $crate::common::RightTriangles::new(32, |x, y| ((x * 7 + y * 13) % 11) as f32 * 0.02);
            for seed in 1..4 {
                $test(&t, seed * 77);
            }
        }
        #[test]
        fn live_tree() {
            for seed in 1..6 {
                $test(&$crate::common::LiveTree { depth: 9 }, seed * 31);
            }
        }
    };
}
