//! The merging of a whole mesh, cheapest pair first, and the record of it.

use super::samples::{Samples, distance};
use super::virtual_edges::virtual_edges;
use super::{Pairs, VertexPairOptions};
use crate::link::{Link, count_neighbours, fans};
use crate::metrics::{End, Metric};
use crate::nodes::Nodes;
use crate::queue::Queue;
use crate::{BuildError, Progress};
use arrayvec::ArrayVec;
use glam::Vec3;
use meshfront_hierarchies::vertex_pair::{Columns, Grid};
use meshfront_mesh::TriangleMesh;
use rayon::prelude::*;
use std::ops::Range;

/// What happened, fine to coarse.
///
/// A *node* is a vertex at one time: `0..n` are the source's vertices, `n + i` is what merge `i` makes. Triangles keep the
/// source's numbers while their corners change.
pub(super) struct Record {
    /// Number of source vertices n.
    pub leaves: u32,
    pub nodes: Nodes,
    pub merges: Vec<Merge>,
    /// Stars of the merged nodes, end to end. None is empty.
    pub star: Vec<StarTriangle>,
    /// Triangles that vanish, end to end.
    pub removed: Vec<Removed>,
    /// Per source vertex: whether it lies on an edge with other than two triangles.
    pub rim: Vec<bool>,
    /// The triangles that are left, with the nodes at their corners.
    pub base: Vec<(u32, [u32; 3])>,
}

/// Nodes `u` and `v` become node n + i.
#[derive(Clone, Copy)]
pub(super) struct Merge {
    pub u: u32,
    pub v: u32,
    /// End of its star in `Record::star`; it starts where the one before ends.
    star_end: u32,
    /// End in `Record::removed`.
    removed_end: u32,
}

/// A triangle (s, after, before) around the merged node s.
#[derive(Clone, Copy)]
pub(super) struct StarTriangle {
    pub triangle: u32,
    pub after: u32,
    pub before: u32,
}

/// A triangle that vanishes: it had both nodes as corners, or came to lie on another.
#[derive(Clone, Copy)]
pub(super) struct Removed {
    pub triangle: u32,
    /// Before the merge.
    pub corners: [u32; 3],
}

impl Record {
    pub fn star_of(&self, i: usize) -> Range<usize> {
        let start = if i == 0 { 0 } else { self.merges[i - 1].star_end };
        start as usize..self.merges[i].star_end as usize
    }
    pub fn removed_of(&self, i: usize) -> &[Removed] {
        let start = if i == 0 { 0 } else { self.merges[i - 1].removed_end };
        &self.removed[start as usize..self.merges[i].removed_end as usize]
    }
}

const NONE: u32 = u32::MAX;
/// More triangles than this are not brought together in one star: what a split costs a viewer grows with it.
const MOST_STAR: usize = 512;
const _: () = assert!(MOST_STAR <= Columns::MAX_STAR);

/// What a triangle that stays must keep.
#[derive(Clone, Copy)]
struct Guard {
    /// Its normal may turn by at most the angle of this cosine; that of a sliver, whose own normal says little, may be
    /// off the mean normal around by as much.
    cos: f32,
    /// Its |cross product| over the sum of its squared edges (0.289 when equilateral) may fall to this.
    shape: f32,
    /// What a pair costs more that waits for this guard, as a share of its squared length.
    fine: f32,
}

/// Strict first. A pair that keeps no guard waits, dearer each time; the last lets all through.
const GUARDS: [Guard; 4] = [
    Guard { cos: 0.2, shape: 0.005, fine: 0.0 },
    Guard { cos: 0.0, shape: 0.001, fine: 0.02 },
    Guard { cos: -0.5, shape: 0.0, fine: 0.2 },
    Guard { cos: -1.0, shape: 0.0, fine: 1.0 },
];
/// By what factor a squared distance may be above what is due.
const PATIENCE: f32 = 1.05;
/// How many times its squared distance counts where a merge takes no triangle away. Joining parts pays only later, when
/// triangles between them vanish: from 1 to 64, an assembly of 200 parts has half as many triangles at an error of 2 % of the
/// diagonal, and a third at 4 %; above 64 nothing changes.
const FRUITLESS: f32 = 64.0;
/// Below this, a triangle's shape makes it a sliver.
const SLIVER: f32 = 0.06;

/// A pair that waits.
struct Waiting {
    /// What it costs, or how far it would move points of the source, squared.
    due: f32,
    /// Index of its guard.
    guard: u8,
    pair: [u32; 2],
}

impl Queue<Waiting> {
    fn wait(&mut self, pair: Waiting) {
        self.push(pair.due, pair);
    }
}

/// Merges pairs until so few triangles are left, or nothing may be merged without leaving points of the surface without a cell.
pub(super) fn merge<M: Metric>(
    source: &TriangleMesh,
    grid: Option<Grid>,
    options: &VertexPairOptions,
    metric: &M,
    progress: &dyn Progress,
) -> Result<Record, BuildError> {
    let count = source.triangles.len();
    progress.phase("simplify", "triangles", count as u64);
    let mut mesh = Mesh::new(source, grid, metric);
    let diagonal = source.bounds().map_or(0.0, |b| b.diagonal());
    mesh.join(virtual_edges(source, options.patch_angle, options.longest_virtual * diagonal));
    if progress.cancelled() {
        return Err(BuildError::Cancelled);
    }
    let first = mesh.pairs();
    let first: Vec<Waiting> = first.into_par_iter().map(|[u, v]| mesh.waiting(u, v, 0)).collect();
    let mut queue = Queue::new(f32::INFINITY);
    first.into_iter().for_each(|w| queue.wait(w));
    let mut keeps_topology = options.pairs == Pairs::GeometryFirst;
    // Pairs that may not merge yet; what stands in their way may go.
    let mut refused: Vec<[u32; 2]> = vec![];
    let mut progressed = false;
    let mut step = Step::default();
    let mut near = vec![];
    let mut told = mesh.alive;
    while mesh.alive > options.base_triangles {
        let Some(Waiting { due, guard, pair: [u, v] }) = queue.pop() else {
            if !std::mem::take(&mut progressed) && !std::mem::take(&mut keeps_topology) {
                break;
            }
            let again = std::mem::take(&mut refused);
            let again = again.into_iter().filter(|e| mesh.live(*e)).map(|[u, v]| mesh.waiting(u, v, 0));
            again.for_each(|w| queue.wait(w));
            continue;
        };
        if !mesh.live([u, v]) {
            continue;
        }
        if !step.gather(&mesh, u, v) || keeps_topology && !step.keeps_topology(&mesh, u, v) {
            refused.push([u, v]);
            continue;
        }
        let places = step.places(&mesh, u, v, GUARDS[guard as usize]);
        // A merge waits until it is due to move points of the source as far as it would.
        let weight = if step.gone.is_empty() { FRUITLESS } else { 1.0 };
        let due = due * PATIENCE / weight;
        let point = match step.nearest_place(&mesh, &places, due) {
            None => {
                queue.wait(mesh.waiting(u, v, guard + 1));
                continue;
            }
            Some((far, _)) if far > due => {
                queue.wait(Waiting { due: far * weight, guard, pair: [u, v] });
                continue;
            }
            Some((_, point)) => point,
        };
        let mut s = mesh.apply(&step, u, v, point);
        // Who lost all triangles goes to where they went.
        for w in std::mem::take(&mut step.orphans) {
            let at = mesh.record.nodes.positions[s as usize];
            step.gather(&mesh, s, w);
            s = mesh.apply(&step, s, w, at);
        }
        progressed = true;
        mesh.neighbours(s, &step.ring, &mut near);
        near.iter().for_each(|&x| queue.wait(mesh.waiting(s, x, 0)));
        if told - mesh.alive >= 4096 {
            progress.at((count - mesh.alive) as u64);
            if progress.cancelled() {
                return Err(BuildError::Cancelled);
            }
            told = mesh.alive;
        }
    }
    Ok(mesh.finish())
}

struct Mesh<'a, M: Metric> {
    metric: &'a M,
    grid: Option<Grid>,
    /// Per node.
    memory: Vec<M::Memory>,
    /// Per node: what it was merged into.
    parent: Vec<u32>,
    /// Per node: those that it may merge with though no edge joins them, maybe since merged with others.
    virtual_edges: Vec<Vec<u32>>,
    /// Per triangle: the nodes at its corners; `NONE` where it is gone.
    triangles: Vec<[u32; 3]>,
    /// Triangles of the source's vertices, end to end.
    around: Vec<u32>,
    /// Per source vertex: where its triangles begin; one more at the end.
    first: Vec<u32>,
    /// Number of triangles that are left.
    alive: usize,
    samples: Samples,
    record: Record,
}

impl<'a, M: Metric> Mesh<'a, M> {
    fn new(source: &TriangleMesh, grid: Option<Grid>, metric: &'a M) -> Mesh<'a, M> {
        let n = source.positions.len();
        let triangles: Vec<[u32; 3]> = source.triangles.iter().map(|t| t.map(|v| v.0)).collect();
        let mut first = vec![0u32; n + 1];
        triangles.iter().flatten().for_each(|&v| first[v as usize + 1] += 1);
        (0..n).for_each(|v| first[v + 1] += first[v]);
        let mut at = first.clone();
        let mut around = vec![0; 3 * triangles.len()];
        for (t, corners) in triangles.iter().enumerate() {
            for &v in corners {
                around[at[v as usize] as usize] = t as u32;
                at[v as usize] += 1;
            }
        }
        let points: Vec<Vec3> = source.positions.par_iter().map(|&p| grid.map_or(p, |g| g.snap(p))).collect();
        let record = Record {
            leaves: n as u32,
            nodes: Nodes::of(source, &points),
            merges: Vec::with_capacity(n),
            star: Vec::with_capacity(7 * n),
            removed: Vec::with_capacity(triangles.len()),
            rim: vec![],
            base: vec![],
        };
        let alive = triangles.len();
        let parent = vec![NONE; n];
        let virtual_edges = vec![vec![]; n];
        let samples = Samples::new(&source.positions, &triangles);
        let mut mesh = Mesh {
            metric,
            grid,
            memory: vec![],
            parent,
            virtual_edges,
            triangles,
            around,
            first,
            alive,
            samples,
            record,
        };
        let leaves = (0..n as u32).into_par_iter().map(|v| mesh.leaf(&source.positions, v));
        (mesh.memory, mesh.record.rim) = leaves.unzip();
        mesh
    }

    /// What a source vertex remembers, and whether it lies on an edge with other than two triangles.
    fn leaf(&self, points: &[Vec3], v: u32) -> (M::Memory, bool) {
        let at = |v: u32| points[v as usize];
        let others: Vec<[u32; 2]> = self.triangles_of(v).map(|t| self.others(t, v)).collect();
        let fan: Vec<[Vec3; 2]> = others.iter().map(|o| o.map(at)).collect();
        let mut rims = vec![];
        for ends in &others {
            for &x in ends {
                if others.iter().filter(|o| o.contains(&x)).count() != 2 {
                    let [a, b] = ends.map(at);
                    rims.push([at(x), (a - at(v)).cross(b - at(v))]);
                }
            }
        }
        (self.metric.leaf(at(v), &fan, &rims), !rims.is_empty())
    }

    fn triangles_of(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let (leaf, merged) = match v.checked_sub(self.record.leaves) {
            None => (self.first[v as usize] as usize..self.first[v as usize + 1] as usize, 0..0),
            Some(i) => (0..0, self.record.star_of(i as usize)),
        };
        let merged = self.record.star[merged].iter().map(|s| s.triangle);
        let all = self.around[leaf].iter().copied().chain(merged);
        all.filter(|&t| self.triangles[t as usize][0] != NONE)
    }

    /// [after, before]: the other corners of a triangle of `v`, in its orientation.
    #[inline]
    fn others(&self, t: u32, v: u32) -> [u32; 2] {
        let [a, b, c] = self.triangles[t as usize];
        if a == v {
            [b, c]
        } else if b == v {
            [c, a]
        } else {
            [a, b]
        }
    }

    fn live(&self, pair: [u32; 2]) -> bool {
        pair.iter().all(|&v| self.parent[v as usize] == NONE)
    }

    fn at(&self, v: u32) -> Vec3 {
        self.record.nodes.positions[v as usize]
    }

    fn end(&self, v: u32) -> End<M::Memory> {
        End { at: self.at(v), memory: self.memory[v as usize] }
    }

    /// Takes in virtual edges between the source's vertices, given ascending.
    fn join(&mut self, edges: Vec<[u32; 2]>) {
        for [u, v] in edges {
            self.virtual_edges[u as usize].push(v);
            self.virtual_edges[v as usize].push(u);
        }
    }

    /// All pairs of source vertices that may merge, each once, in a fixed order.
    fn pairs(&self) -> Vec<[u32; 2]> {
        let more = |v: u32| {
            let edges = self.triangles_of(v).flat_map(|t| self.others(t, v));
            let both = edges.chain(self.virtual_edges[v as usize].iter().copied());
            let mut more: Vec<u32> = both.filter(|&x| x > v).collect();
            more.sort_unstable();
            more.dedup();
            more.into_iter().map(move |x| [v, x])
        };
        (0..self.record.leaves).into_par_iter().flat_map_iter(more).collect()
    }

    /// What a node was merged into, itself where it lives.
    fn root(&mut self, mut v: u32) -> u32 {
        while self.parent[v as usize] != NONE {
            let up = self.parent[v as usize];
            if self.parent[up as usize] != NONE {
                self.parent[v as usize] = self.parent[up as usize];
            }
            v = up;
        }
        v
    }

    /// Tells with whom a new node may merge: those of its ring, and those that its two had as virtual neighbours.
    fn neighbours(&mut self, s: u32, ring: &[u32], near: &mut Vec<u32>) {
        let mut list = std::mem::take(&mut self.virtual_edges[s as usize]);
        list.iter_mut().for_each(|x| *x = self.root(*x));
        list.sort_unstable();
        list.dedup();
        list.retain(|&x| x != s && ring.binary_search(&x).is_err());
        near.clear();
        near.extend(ring.iter().chain(&list));
        self.virtual_edges[s as usize] = list;
    }

    /// A pair with what it costs under a guard.
    fn waiting(&self, u: u32, v: u32, guard: u8) -> Waiting {
        let [a, b] = [u, v].map(|x| self.end(x));
        let cost = self.metric.cost(a, b, self.metric.best(a, b));
        let fine = GUARDS[guard as usize].fine * a.at.distance_squared(b.at);
        Waiting { due: cost + fine, guard, pair: [u.min(v), u.max(v)] }
    }

    /// Merges two nodes as gathered and logs it.
    fn apply(&mut self, step: &Step, u: u32, v: u32, point: Vec3) -> u32 {
        let s = self.record.nodes.positions.len() as u32;
        let [a, b] = [u, v].map(|x| self.end(x));
        self.memory.push(self.metric.merged(a, b, point));
        self.parent.push(NONE);
        for x in [u, v] {
            self.parent[x as usize] = s;
        }
        for &(triangle, [after, before], old) in &step.stay {
            let corners = &mut self.triangles[triangle as usize];
            corners.iter_mut().filter(|c| **c == old).for_each(|c| *c = s);
            self.record.star.push(StarTriangle { triangle, after, before });
        }
        let mut list = std::mem::take(&mut self.virtual_edges[u as usize]);
        list.append(&mut self.virtual_edges[v as usize]);
        // What was an edge stays a pair.
        list.extend(step.gone.iter().flat_map(|&t| self.triangles[t as usize]));
        self.virtual_edges.push(list);
        for &triangle in &step.gone {
            let corners = std::mem::replace(&mut self.triangles[triangle as usize], [NONE; 3]);
            self.record.removed.push(Removed { triangle, corners });
        }
        self.alive -= step.gone.len();
        self.share(step, point);
        self.record.nodes.merge([u, v], point);
        self.record.merges.push(Merge {
            u,
            v,
            star_end: self.record.star.len() as u32,
            removed_end: self.record.removed.len() as u32,
        });
        s
    }

    /// Hands the samples around a pair on to the triangles that stay.
    fn share(&mut self, step: &Step, point: Vec3) {
        let cells: Vec<[Vec3; 3]> = step.cells(self, point).collect();
        let all: Vec<u32> = step.triangles().flat_map(|t| self.samples.of(t)).collect();
        let mut on = vec![vec![]; cells.len()];
        for v in all {
            let p = self.samples.at(v);
            let far = cells.iter().enumerate().map(|(k, cell)| (distance(p, *cell), k));
            let (far, k) = far.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a star is not empty");
            on[k].push((far, v));
        }
        for (mut on, stay) in on.into_iter().zip(&step.stay) {
            self.samples.put(stay.0, &mut on);
        }
    }

    fn finish(self) -> Record {
        let mut record = self.record;
        let left = self.triangles.iter().enumerate().filter(|(_, corners)| corners[0] != NONE);
        record.base = left.map(|(t, &corners)| (t as u32, corners)).collect();
        record
    }
}

/// Scratch of one attempt.
#[derive(Default)]
struct Step {
    /// Triangles that stay: triangle, its other corners, and which of the two nodes it had.
    stay: Vec<(u32, [u32; 2], u32)>,
    /// Triangles that vanish.
    gone: Vec<u32>,
    /// Neighbours of the merged node.
    ring: Vec<u32>,
    /// Nodes that lose all triangles.
    orphans: Vec<u32>,
}

impl Step {
    /// Collects what is around a pair; `false` where its merged star would be empty or too large.
    fn gather<M: Metric>(&mut self, mesh: &Mesh<M>, u: u32, v: u32) -> bool {
        let Step { stay, gone, ring, orphans } = self;
        stay.clear();
        gone.clear();
        ring.clear();
        orphans.clear();
        for [x, other] in [[u, v], [v, u]] {
            for t in mesh.triangles_of(x) {
                let others = mesh.others(t, x);
                if !others.contains(&other) {
                    stay.push((t, others, x));
                } else if x == u {
                    gone.push(t);
                    orphans.extend(others.into_iter().filter(|&w| w != v));
                }
            }
        }
        // Of triangles with the same corners in the same turn one stays, that of least number.
        stay.sort_unstable_by_key(|&(t, others, _)| (others, t));
        stay.dedup_by(|other, kept| {
            let same = other.1 == kept.1;
            if same {
                gone.push(other.0);
            }
            same
        });
        if stay.is_empty() || stay.len() > MOST_STAR {
            return false;
        }
        stay.sort_unstable_by_key(|s| s.0);
        ring.extend(stay.iter().flat_map(|s| s.1));
        ring.sort_unstable();
        ring.dedup();
        orphans.sort_unstable();
        orphans.dedup();
        orphans.retain(|&w| mesh.triangles_of(w).all(|t| gone.contains(&t)));
        true
    }

    /// Whether merging the pair as gathered would keep the topology as it is.
    fn keeps_topology<M: Metric>(&self, mesh: &Mesh<M>, u: u32, v: u32) -> bool {
        let mut shared = vec![];
        let (mut stay, mut near) = ([vec![], vec![]], [vec![], vec![]]);
        let mut ties = [false; 2];
        for (k, x, other) in [(0, u, v), (1, v, u)] {
            let mut edges = vec![];
            for t in mesh.triangles_of(x) {
                let [after, before] = mesh.others(t, x);
                if after != other && before != other {
                    stay[k].push((t, after, before));
                } else if k == 0 {
                    shared.push(if after == v { (t, before, true) } else { (t, after, false) });
                }
                edges.push([after, before]);
                count_neighbours(&mut near[k], (after, before));
            }
            ties[k] = fans(&mut edges) > 1;
        }
        let [stay_u, stay_v] = &stay;
        let [near_u, near_v] = &near;
        let link = Link { pair: [u, v], stay: [stay_u, stay_v], shared: &shared, near: [near_u, near_v], ties };
        link.merges().is_some()
    }

    /// All triangles around a pair as gathered.
    fn triangles(&self) -> impl Iterator<Item = u32> {
        self.stay.iter().map(|s| s.0).chain(self.gone.iter().copied())
    }

    /// The triangles that stay, as they would be.
    fn cells<M: Metric>(&self, mesh: &Mesh<M>, point: Vec3) -> impl Iterator<Item = [Vec3; 3]> {
        self.stay.iter().map(move |&(_, [a, b], _)| [point, mesh.at(a), mesh.at(b)])
    }

    /// The squared distance from the triangles that stay of the farthest of the samples around, if the pair merged there.
    fn farthest<M: Metric>(&self, mesh: &Mesh<M>, point: Vec3) -> f32 {
        let cells: Vec<[Vec3; 3]> = self.cells(mesh, point).collect();
        let mut most = 0.0;
        for (i, t) in self.triangles().enumerate() {
            // Own first: mostly that is near enough.
            let own = if i < cells.len() { i } else { 0 };
            for v in mesh.samples.of(t) {
                let p = mesh.samples.at(v);
                let mut least = f32::INFINITY;
                for k in std::iter::once(own).chain(0..cells.len()) {
                    least = least.min(distance(p, cells[k]));
                    if least <= most {
                        break;
                    }
                }
                most = most.max(least);
            }
        }
        most
    }

    /// The places under which no triangle that stays flips or becomes a worse sliver than a guard allows, cheapest first;
    /// with the last guard all.
    fn places<M: Metric>(&self, mesh: &Mesh<M>, u: u32, v: u32, guard: Guard) -> ArrayVec<Vec3, 4> {
        let snap = |p: Vec3| mesh.grid.map_or(p, |g| g.snap(p));
        let [a, b] = [u, v].map(|x| mesh.end(x));
        let mut others = [(a.at + b.at) * 0.5, a.at, b.at].map(|p| (mesh.metric.cost(a, b, p), p));
        others.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all = std::iter::once(mesh.metric.best(a, b)).chain(others.map(|o| o.1)).map(snap);
        all.filter(|&p| guard.cos <= -1.0 || self.keeps_shape(mesh, p, guard)).collect()
    }

    /// The first place that moves no point of the source farther than what is due, or else that which moves them least; with
    /// the squared distance.
    fn nearest_place<M: Metric>(&self, mesh: &Mesh<M>, places: &[Vec3], due: f32) -> Option<(f32, Vec3)> {
        let mut least = None;
        for &p in places {
            let far = self.farthest(mesh, p);
            if far <= due {
                return Some((far, p));
            }
            if least.is_none_or(|(l, _)| far < l) {
                least = Some((far, p));
            }
        }
        least
    }

    fn keeps_shape<M: Metric>(&self, mesh: &Mesh<M>, point: Vec3, guard: Guard) -> bool {
        let cross = |p: Vec3, [a, b]: [u32; 2]| (mesh.at(a) - p).cross(mesh.at(b) - p);
        let shape = |p: Vec3, area: f32, others: [u32; 2]| {
            let [a, b] = others.map(|x| mesh.at(x));
            area / ((a - p).length_squared() + (b - p).length_squared() + (a - b).length_squared())
        };
        let mut mean = None;
        self.stay.iter().all(|&(_, others, x)| {
            let old = mesh.at(x);
            let (before, after) = (cross(old, others), cross(point, others));
            let (area_before, area_after) = (before.length(), after.length());
            if area_before == 0.0 {
                return true;
            }
            let shape_before = shape(old, area_before, others);
            let shape_after = shape(point, area_after, others);
            if shape_after < guard.shape && shape_after < shape_before {
                return false;
            }
            let upright = if shape_before < SLIVER {
                let all = || self.stay.iter().map(|&(_, others, x)| cross(mesh.at(x), others)).sum::<Vec3>();
                *mean.get_or_insert_with(|| all().normalize_or_zero())
            } else {
                before / area_before
            };
            after.dot(upright) >= guard.cos * area_after
        })
    }
}
