//! One block of the mesh, decimated on its own: cheapest edge first, every collapse written down.

use crate::link::{Link, count_neighbours, fans};
use crate::metrics::quadric::Quadric;
use crate::queue::Queue;
use glam::Vec3;
use meshfront_hierarchies::edge_collapse::{Columns, Grid};

/// Weight of the planes that hold boundaries and non-manifold edges in place, against the weight of the surface.
const RIM_WEIGHT: f64 = 3.0;
/// Cost of length where the quadric sees none, relative to the weight: flat regions collapse short edges first.
const LENGTH_COST: f64 = 1e-9;
/// How much of a merged vertex's quadric is that of the triangles around it as they are, not the sum over the source
/// (`lindstrom1998`: a metric without memory). The mean distance falls with it and the largest rises: from 0 to 0.6, the mean
/// by 10 % (dragon) to 14 % (bunny). Rims remember all.
const FORGET: f64 = 0.5;
/// What a triangle that stays must keep.
#[derive(Clone, Copy)]
struct Guard {
    /// Its normal may turn by at most the angle of this cosine; that of a sliver, whose own normal says little, may be
    /// off the mean normal around by as much.
    cos: f32,
    /// Its |cross product| over the sum of its squared edges (0.289 when equilateral) may fall to this.
    shape: f32,
}

/// Strict first; when nothing is left that keeps the guard, the next one lets through what blocks the rest.
const GUARDS: [Guard; 3] =
    [Guard { cos: 0.2, shape: 0.005 }, Guard { cos: 0.0, shape: 0.001 }, Guard { cos: -0.5, shape: 0.0 }];
/// Below this, a triangle's shape makes it a sliver.
const SLIVER: f32 = 0.06;

pub(super) const DEAD: u32 = u32::MAX;
/// Bit of a queued edge's first version: its best point was refused, it waits with the cost of the next best.
const SECOND_CHOICE: u32 = 1 << 31;

/// Triangles of one vertex: a span of `Block::around`.
#[derive(Clone, Copy, Default)]
struct Span {
    start: u32,
    len: u32,
}

/// Vertices and triangles with numbers of their own. Versions count from here too: `0..n` are the vertices as the
/// block got them, `n + i` is what its collapse `i` makes.
#[derive(Default)]
pub(super) struct Block {
    pub points: Vec<Vec3>,
    pub quadrics: Vec<Quadric>,
    pub triangles: Vec<[u32; 3]>,
    /// Vertices where fans meet that share no edge.
    pub bow_tie: Vec<bool>,
    /// Vertices with triangles outside of the block: they stay.
    pub locked: Vec<bool>,
    /// Version that lives in each vertex; `DEAD` where it has been merged away.
    pub version: Vec<u32>,
    /// Lists of triangles per vertex; a collapse appends the new vertex's list. Dead triangles stay in.
    around: Vec<u32>,
    spans: Vec<Span>,
    pub log: Log,
}

/// What happened in a block, in its own numbers.
#[derive(Default)]
pub(super) struct Log {
    pub collapses: Vec<LocalCollapse>,
    /// The stars, end to end, each in the order of a fan as far as it is one.
    pub star: Vec<StarTriangle>,
    /// (triangle, version w, reads (v, w, u)) of the triangles that vanished, end to end.
    pub removed: Vec<(u32, u32, bool)>,
}

/// Versions u and v became one, in u's vertex.
#[derive(Clone, Copy)]
pub(super) struct LocalCollapse {
    pub versions: [u32; 2],
    pub vertex: u32,
    pub point: Vec3,
    pub star_end: u32,
    pub removed_end: u32,
}

/// A triangle (s, after, before) around the new version s; its corner s was v where `on_v`, u else.
#[derive(Clone, Copy)]
pub(super) struct StarTriangle {
    pub triangle: u32,
    pub after: u32,
    pub before: u32,
    pub on_v: bool,
}

/// Where to stop.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// No edge that costs more is collapsed.
    pub cost: f32,
    /// Nor any when this few triangles are left.
    pub triangles: usize,
}

impl Block {
    /// A block with lists of triangles; nothing locked, nothing merged.
    pub fn new(points: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Block {
        let n = points.len();
        let mut spans = vec![Span::default(); n];
        for &v in triangles.iter().flatten() {
            spans[v as usize].len += 1;
        }
        let mut end = 0;
        for s in &mut spans {
            s.start = end;
            end += s.len;
            s.len = 0;
        }
        let mut around = vec![0; end as usize];
        for (t, corners) in triangles.iter().enumerate() {
            for &v in corners {
                let s = &mut spans[v as usize];
                around[(s.start + s.len) as usize] = t as u32;
                s.len += 1;
            }
        }
        let (locked, bow_tie) = (vec![false; n], vec![false; n]);
        let version = (0..n as u32).collect();
        Block { points, triangles, around, spans, version, locked, bow_tie, ..Block::default() }
    }

    /// Collapses what the limits allow. `tell` hears how many triangles vanished, and says whether to give up.
    pub fn decimate(
        &mut self,
        edges: &[(f32, [u32; 2])],
        limits: Limits,
        grid: Option<Grid>,
        tell: impl Fn(usize) -> bool,
    ) {
        let snap = |p: Vec3| grid.map_or(p, |g| g.snap(p));
        let mut queue = Queue::new(limits.cost);
        for &(cost, edge) in edges {
            queue.push(cost, edge);
        }
        let mut alive = self.triangles.len();
        let mut told = alive;
        // Edges that were refused; what stands in their way may go.
        let mut refused: Vec<[u32; 2]> = vec![];
        let mut progressed = false;
        let mut guards = GUARDS.into_iter();
        let mut guard = guards.next().expect("there is a strictest");
        let mut step = Step::default();
        while alive > limits.triangles {
            let Some([first, second]) = queue.pop() else {
                if limits.cost < f32::INFINITY {
                    break; // a later round looks at what was refused
                }
                if !std::mem::take(&mut progressed) {
                    match guards.next() {
                        Some(weaker) => guard = weaker,
                        None => break, // nothing that is left may go
                    }
                }
                for edge in std::mem::take(&mut refused) {
                    if let Some([u, v]) = self.live(edge) {
                        queue.push(self.cost(u, v).0, edge);
                    }
                }
                continue;
            };
            let edge = [first & !SECOND_CHOICE, second];
            let Some([u, v]) = self.live(edge) else { continue };
            if !step.gather(self, u, v) {
                refused.push(edge);
                continue;
            }
            let first_choice = (first & SECOND_CHOICE == 0).then(|| snap(self.cost(u, v).1));
            let point = match first_choice.filter(|&p| step.keeps_shape(self, u, v, p, guard)) {
                Some(point) => point,
                None => {
                    let keeps = |&(_, p): &(f32, Vec3)| step.keeps_shape(self, u, v, snap(p), guard);
                    match self.second_choices(u, v).find(keeps) {
                        None => {
                            refused.push(edge);
                            continue;
                        }
                        Some((cost, _)) if first_choice.is_some() => {
                            queue.push(cost, [edge[0] | SECOND_CHOICE, edge[1]]);
                            continue;
                        }
                        Some((_, p)) => snap(p),
                    }
                }
            };
            alive -= step.apply(self, u, v, point);
            progressed = true;
            for &x in step.ring.iter().filter(|&&x| !self.locked[x as usize]) {
                let edge = [self.version[u as usize], self.version[x as usize]];
                queue.push(self.cost(u, x).0, edge);
            }
            if told - alive >= 4096 {
                if tell(told - alive) {
                    return;
                }
                told = alive;
            }
        }
        tell(told - alive);
    }

    fn triangles_of(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let s = self.spans[v as usize];
        let list = &self.around[s.start as usize..(s.start + s.len) as usize];
        list.iter().copied().filter(|&t| self.triangles[t as usize][0] != DEAD)
    }

    /// (after, before): the other corners of a triangle of `v`, in its orientation.
    #[inline]
    fn others(&self, t: u32, v: u32) -> (u32, u32) {
        let [a, b, c] = self.triangles[t as usize];
        if a == v {
            (b, c)
        } else if b == v {
            (c, a)
        } else {
            (a, b)
        }
    }

    /// A source vertex's quadric, whether it is a bow tie, and whether it lies on an edge with other than two triangles.
    pub fn first_quadric(&self, points: &[Vec3], v: u32) -> (Quadric, bool, bool) {
        let mut q = Quadric::default();
        let mut rim = false;
        let mut edges: Vec<[u32; 2]> = vec![];
        let at = |v: u32| points[v as usize].as_dvec3();
        let p = at(v);
        for t in self.triangles_of(v) {
            let (a, b) = self.others(t, v);
            edges.push([a, b]);
            let cross = (at(a) - p).cross(at(b) - p);
            let area = 0.5 * cross.length();
            if area > 0.0 {
                let n = cross / (2.0 * area);
                q += Quadric::plane(n, -n.dot(p), area / 3.0);
            }
        }
        for t in self.triangles_of(v) {
            let (a, b) = self.others(t, v);
            for x in [a, b] {
                let uses = edges.iter().filter(|e| e.contains(&x)).count();
                rim |= uses != 2;
                let edge = at(x) - p;
                let normal = (at(a) - p).cross(at(b) - p);
                let plane = edge.cross(normal);
                if uses != 2 && plane.length_squared() > 0.0 {
                    let n = plane.normalize();
                    q += Quadric::plane(n, -n.dot(p), RIM_WEIGHT * edge.length_squared() / uses as f64);
                }
            }
        }
        (q, fans(&mut edges) > 1, rim)
    }

    /// All edges between vertices that are not locked, with their costs, in a fixed order.
    pub fn edges(&self) -> Vec<(f32, [u32; 2])> {
        let mut edges = Vec::with_capacity(3 * self.points.len());
        let mut more: Vec<u32> = vec![];
        for v in (0..self.points.len() as u32).filter(|&v| !self.locked[v as usize]) {
            more.clear();
            let others = self.triangles_of(v).flat_map(|t| <[u32; 2]>::from(self.others(t, v)));
            more.extend(others.filter(|&x| x > v && !self.locked[x as usize]));
            more.sort_unstable();
            more.dedup();
            edges.extend(more.iter().map(|&x| (self.cost(v, x).0, [v, x])));
        }
        edges
    }

    /// What it costs to merge two vertices, and where the merged one goes.
    #[inline]
    fn cost(&self, u: u32, v: u32) -> (f32, Vec3) {
        let q = self.quadrics[u as usize] + self.quadrics[v as usize];
        let (pu, pv) = (self.points[u as usize].as_dvec3(), self.points[v as usize].as_dvec3());
        let length_squared = pu.distance_squared(pv);
        let x = q.between(pu, pv);
        let cost = q.at(x);
        let weight = q.a[0] + q.a[3] + q.a[5];
        ((cost.max(0.0) + LENGTH_COST * weight * length_squared) as f32, x.as_vec3())
    }

    /// Middle and ends of an edge with their costs, cheapest first.
    fn second_choices(&self, u: u32, v: u32) -> impl Iterator<Item = (f32, Vec3)> {
        let q = self.quadrics[u as usize] + self.quadrics[v as usize];
        let (pu, pv) = (self.points[u as usize], self.points[v as usize]);
        let mut choices = [(pu + pv) * 0.5, pu, pv].map(|p| (q.at(p.as_dvec3()).max(0.0) as f32, p));
        choices.sort_by(|a, b| a.0.total_cmp(&b.0));
        choices.into_iter()
    }

    /// The vertices of a queued edge, where both versions still live.
    #[inline]
    fn live(&self, edge: [u32; 2]) -> Option<[u32; 2]> {
        let slot = |version: u32| match version.checked_sub(self.version.len() as u32) {
            None => version,
            Some(i) => self.log.collapses[i as usize].vertex,
        };
        let [u, v] = edge.map(slot);
        (self.version[u as usize] == edge[0] && self.version[v as usize] == edge[1]).then_some([u, v])
    }
}

/// Puts each triangle next to the one that begins where it ends.
fn sort_fan(star: &mut [StarTriangle]) {
    let opens = |t: &StarTriangle| !star.iter().any(|o| o.before == t.after);
    let first = star.iter().position(opens).unwrap_or(0);
    star.swap(0, first);
    for i in 1..star.len() {
        let end = star[i - 1].before;
        if let Some(next) = star[i..].iter().position(|t| t.after == end) {
            star.swap(i, i + next);
        }
    }
}

/// Scratch of one attempt.
#[derive(Default)]
struct Step {
    /// Triangles that stay, around u and around v: (triangle, after, before).
    stay_u: Vec<(u32, u32, u32)>,
    stay_v: Vec<(u32, u32, u32)>,
    /// Triangles on the edge: (triangle, third corner, whether it reads (v, w, u)).
    shared: Vec<(u32, u32, bool)>,
    /// Neighbours of u and of v, with the number of triangles on the edge to them.
    near_u: Vec<(u32, u32)>,
    near_v: Vec<(u32, u32)>,
    /// Neighbours of the merged vertex.
    ring: Vec<u32>,
    /// Whether the merged vertex lies on a rim.
    on_rim: bool,
}

impl Step {
    /// Collects both stars; `false` where merging would change the topology or exceed what a split may hold.
    fn gather(&mut self, mesh: &Block, u: u32, v: u32) -> bool {
        let Step { stay_u, stay_v, shared, near_u, near_v, ring, on_rim } = self;
        for list in [&mut *stay_u, &mut *stay_v] {
            list.clear();
        }
        shared.clear();
        near_u.clear();
        near_v.clear();
        ring.clear();
        for t in mesh.triangles_of(u) {
            let (after, before) = mesh.others(t, u);
            if after == v {
                shared.push((t, before, true)); // (u, v, w) reads (v, w, u)
            } else if before == v {
                shared.push((t, after, false)); // (u, w, v)
            } else {
                stay_u.push((t, after, before));
            }
            count_neighbours(near_u, (after, before));
            if stay_u.len() > Columns::MAX_STAR {
                return false;
            }
        }
        for t in mesh.triangles_of(v) {
            let (after, before) = mesh.others(t, v);
            if after != u && before != u {
                stay_v.push((t, after, before));
            }
            count_neighbours(near_v, (after, before));
            if stay_u.len() + stay_v.len() > Columns::MAX_STAR {
                return false;
            }
        }
        if shared.is_empty() || stay_u.len() + stay_v.len() == 0 {
            return false;
        }
        let is_third = |x: u32| shared.iter().any(|&(_, w, _)| w == x);
        let ties = [u, v].map(|x| mesh.bow_tie[x as usize]);
        let pair = Link { pair: [u, v], stay: [stay_u, stay_v], shared, near: [near_u, near_v], ties };
        match pair.merges() {
            Some(rim) => *on_rim = rim,
            None => return false,
        }
        ring.extend(near_u.iter().map(|e| e.0).filter(|&x| x != v));
        ring.extend(near_v.iter().map(|e| e.0).filter(|&x| x != u && !is_third(x)));
        true
    }

    /// Whether no triangle that stays flips or becomes a worse sliver.
    fn keeps_shape(&self, mesh: &Block, u: u32, v: u32, point: Vec3, guard: Guard) -> bool {
        let at = |x: u32| mesh.points[x as usize];
        let cross = |p: Vec3, t: &(u32, u32, u32)| (at(t.1) - p).cross(at(t.2) - p);
        let shape = |p: Vec3, area: f32, &(_, a, b): &(u32, u32, u32)| {
            let (a, b) = (at(a), at(b));
            area / ((a - p).length_squared() + (b - p).length_squared() + (a - b).length_squared())
        };
        let (at_u, at_v) = (at(u), at(v));
        let stay = || self.stay_u.iter().map(|t| (at_u, t)).chain(self.stay_v.iter().map(|t| (at_v, t)));
        let mean = stay().map(|(old, t)| cross(old, t)).sum::<Vec3>().normalize_or_zero();
        stay().all(|(old, t)| {
            let (before, after) = (cross(old, t), cross(point, t));
            let (area_before, area_after) = (before.length(), after.length());
            if area_before == 0.0 {
                return true;
            }
            let shape_before = shape(old, area_before, t);
            let shape_after = shape(point, area_after, t);
            if shape_after < guard.shape && shape_after < shape_before {
                return false;
            }
            let upright = if shape_before < SLIVER { mean } else { before / area_before };
            after.dot(upright) >= guard.cos * area_after
        })
    }

    /// The quadric of the triangles that stay, as they are now.
    fn fresh_quadric(&self, mesh: &Block, point: Vec3) -> Quadric {
        let p = point.as_dvec3();
        let mut q = Quadric::default();
        for &(_, a, b) in self.stay_u.iter().chain(&self.stay_v) {
            let [a, b] = [a, b].map(|x| mesh.points[x as usize].as_dvec3());
            let cross = (a - p).cross(b - p);
            let area = 0.5 * cross.length();
            if area > 0.0 {
                let n = cross / (2.0 * area);
                q += Quadric::plane(n, -n.dot(p), area / 3.0);
            }
        }
        q
    }

    /// Merges v into u's vertex and logs it; returns how many triangles vanished.
    fn apply(&mut self, mesh: &mut Block, u: u32, v: u32, point: Vec3) -> usize {
        let versions = [mesh.version[u as usize], mesh.version[v as usize]];
        let start = mesh.around.len() as u32;
        let first = mesh.log.star.len();
        for (list, on_v) in [(&self.stay_u, false), (&self.stay_v, true)] {
            for &(triangle, after, before) in list {
                mesh.around.push(triangle);
                let [after, before] = [after, before].map(|x| mesh.version[x as usize]);
                mesh.log.star.push(StarTriangle { triangle, after, before, on_v });
            }
        }
        sort_fan(&mut mesh.log.star[first..]);
        for &(t, _, _) in &self.stay_v {
            for corner in &mut mesh.triangles[t as usize] {
                if *corner == v {
                    *corner = u;
                }
            }
        }
        for &(t, w, flipped) in &self.shared {
            mesh.triangles[t as usize] = [DEAD; 3];
            mesh.log.removed.push((t, mesh.version[w as usize], flipped));
        }
        mesh.log.collapses.push(LocalCollapse {
            versions,
            vertex: u,
            point,
            star_end: mesh.log.star.len() as u32,
            removed_end: mesh.log.removed.len() as u32,
        });
        mesh.spans[u as usize] = Span { start, len: mesh.around.len() as u32 - start };
        mesh.points[u as usize] = point;
        mesh.version[u as usize] = (mesh.version.len() + mesh.log.collapses.len() - 1) as u32;
        mesh.version[v as usize] = DEAD;
        let remembered = mesh.quadrics[u as usize] + mesh.quadrics[v as usize];
        mesh.quadrics[u as usize] = if self.on_rim {
            remembered
        } else {
            remembered * (1.0 - FORGET) + self.fresh_quadric(mesh, point) * FORGET
        };
        let tie = mesh.bow_tie[v as usize];
        mesh.bow_tie[u as usize] |= tie;
        self.shared.len()
    }
}
