//! The decimation of a whole mesh: rounds of blocks, and the record of all collapses.

use super::block::{Block, DEAD, Limits, StarTriangle};
use crate::metrics::quadric::Quadric;
use crate::nodes::Nodes;
use crate::{BuildError, Progress};
use glam::Vec3;
use meshfront_hierarchies::edge_collapse::Grid;
use meshfront_mesh::TriangleMesh;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// What happened, fine to coarse.
///
/// Each change of a vertex makes a new *version* of it: `0..n` are the source's vertices, `n + i` is what collapse
/// `i` makes. Triangles keep the source's numbers while their corners change.
pub(super) struct Record {
    /// Number of source vertices n.
    pub leaves: u32,
    /// The versions.
    pub nodes: Nodes,
    pub collapses: Vec<Collapse>,
    /// Stars of the new versions, end to end, each in the order of a fan as far as it is one.
    pub star: Vec<StarTriangle>,
    /// Triangles that vanish, end to end.
    pub removed: Vec<Removed>,
    /// Per source vertex: whether it lies on an edge with other than two triangles.
    pub rim: Vec<bool>,
    /// The triangles that are left, with the versions of their corners.
    pub base: Vec<(u32, [u32; 3])>,
}

/// Versions `u` and `v` become version n + i.
#[derive(Clone, Copy)]
pub(super) struct Collapse {
    pub u: u32,
    pub v: u32,
    /// End of its star in `Record::star`; it starts where the one before ends.
    pub star_end: u32,
    /// End in `Record::removed`.
    pub removed_end: u32,
}

/// A triangle (u, w, v) that vanishes; (v, w, u) where `flipped`.
#[derive(Clone, Copy)]
pub(super) struct Removed {
    pub triangle: u32,
    pub w: u32,
    pub flipped: bool,
}

impl Record {
    pub fn star_of(&self, i: usize) -> std::ops::Range<usize> {
        let start = if i == 0 { 0 } else { self.collapses[i - 1].star_end };
        start as usize..self.collapses[i].star_end as usize
    }
    pub fn removed_of(&self, i: usize) -> &[Removed] {
        let start = if i == 0 { 0 } else { self.collapses[i - 1].removed_end };
        &self.removed[start as usize..self.collapses[i].removed_end as usize]
    }
}

/// Vertices per block: what a core's second-level cache holds.
const BLOCK: usize = 8192;
/// With no more triangles than this there is one block.
const ONE_BLOCK: usize = 60_000;
/// A round collapses edges up to this quantile of all costs at its start.
const ROUND_QUANTILE: f64 = 0.5;

/// The mesh between rounds, in the source's numbers.
struct Whole {
    points: Vec<Vec3>,
    quadrics: Vec<Quadric>,
    triangles: Vec<[u32; 3]>,
    bow_tie: Vec<bool>,
    rim: Vec<bool>,
    /// Version that lives in each vertex; `DEAD` where it has been merged away.
    version: Vec<u32>,
    live_vertices: Vec<u32>,
    live_triangles: Vec<u32>,
}

/// A block with the whole's numbers of its vertices and triangles.
#[derive(Default)]
struct Part {
    vertices: Vec<u32>,
    triangles: Vec<u32>,
    corners: Vec<[u32; 3]>,
    rim: Vec<u32>,
    block: Block,
    edges: Vec<(f32, [u32; 2])>,
}

/// Decimates in rounds. In a round the mesh is cut into blocks, and each is decimated on its own, in its core's
/// cache, up to a cost that is the same for all; what lies along the cuts waits for the next round, which cuts
/// elsewhere. So the order of collapses stays close to that of one queue. The last round has one block and no
/// limit. Nothing depends on the number of threads.
pub(super) fn collapse(
    source: &TriangleMesh,
    grid: Option<Grid>,
    base_triangles: usize,
    progress: &dyn Progress,
) -> Result<Record, BuildError> {
    let count = source.triangles.len();
    progress.phase("simplify", "triangles", count as u64);
    let mut whole = Whole::new(source, grid);
    let mut record = Record::new(source, &whole.points);
    let gone = AtomicUsize::new(0);
    let tell = |vanished: usize| {
        progress.at((gone.fetch_add(vanished, Relaxed) + vanished) as u64);
        progress.cancelled()
    };
    let mut stuck = false;
    for round in 0.. {
        let last = stuck || whole.live_triangles.len() <= ONE_BLOCK;
        let mut parts = whole.cut(if last { usize::MAX } else { BLOCK }, round);
        let limits = if last {
            Limits { cost: f32::INFINITY, triangles: base_triangles }
        } else {
            Limits { cost: cost_quantile(&parts, ROUND_QUANTILE), triangles: 0 }
        };
        parts.par_iter_mut().for_each(|p| p.block.decimate(&p.edges, limits, grid, tell));
        if progress.cancelled() {
            return Err(BuildError::Cancelled);
        }
        for part in &parts {
            whole.merge(part, &mut record);
        }
        let before = whole.live_triangles.len();
        whole.forget_dead();
        if last {
            break;
        }
        // A round that achieved little is not worth another cut.
        stuck = whole.live_triangles.len() > before - before / 20;
    }
    let corners = |t: u32| whole.triangles[t as usize].map(|v| whole.version[v as usize]);
    record.rim = std::mem::take(&mut whole.rim);
    record.base = whole.live_triangles.iter().map(|&t| (t, corners(t))).collect();
    Ok(record)
}

impl Whole {
    fn new(source: &TriangleMesh, grid: Option<Grid>) -> Whole {
        let n = source.positions.len() as u32;
        let points: Vec<Vec3> = source.positions.par_iter().map(|&p| grid.map_or(p, |g| g.snap(p))).collect();
        let triangles: Vec<[u32; 3]> = source.triangles.iter().map(|t| t.map(|v| v.0)).collect();
        let all = Block::new(points.clone(), triangles.clone());
        let first = (0..n).into_par_iter().map(|v| all.first_quadric(&source.positions, v));
        let (quadrics, (bow_tie, rim)): (Vec<_>, (Vec<_>, Vec<_>)) = first.map(|(q, tie, rim)| (q, (tie, rim))).unzip();
        let mut used = vec![false; n as usize];
        triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        Whole {
            points,
            quadrics,
            live_triangles: (0..triangles.len() as u32).collect(),
            live_vertices: (0..n).filter(|&v| used[v as usize]).collect(),
            triangles,
            bow_tie,
            rim,
            version: (0..n).collect(),
        }
    }

    /// Cuts into blocks of at most `most` vertices, at places that differ from round to round.
    fn cut(&mut self, most: usize, round: usize) -> Vec<Part> {
        // Off the middle by another amount in each round.
        let fraction = [0.5, 0.41, 0.57, 0.46, 0.38, 0.6][round % 6];
        let mut ranges = vec![];
        split(&self.points, &mut self.live_vertices, most, fraction, &mut ranges);
        let mut owner = vec![(0u32, 0u32); self.points.len()];
        let mut parts: Vec<Part> = vec![];
        let mut rest = &mut self.live_vertices[..];
        for len in ranges {
            let (vertices, tail) = rest.split_at_mut(len);
            rest = tail;
            // In the source's order, which is mostly a good one for the cache.
            vertices.sort_unstable();
            for (local, &v) in vertices.iter().enumerate() {
                owner[v as usize] = (parts.len() as u32, local as u32);
            }
            parts.push(Part { vertices: vertices.to_vec(), ..Part::default() });
        }
        for &t in &self.live_triangles {
            let owners = self.triangles[t as usize].map(|v| owner[v as usize]);
            if owners[0].0 == owners[1].0 && owners[1].0 == owners[2].0 {
                let part = &mut parts[owners[0].0 as usize];
                part.triangles.push(t);
                part.corners.push(owners.map(|o| o.1));
            } else {
                for (part, local) in owners {
                    parts[part as usize].rim.push(local);
                }
            }
        }
        parts.par_iter_mut().for_each(|part| {
            let all = |v: &u32| *v as usize;
            let points = part.vertices.iter().map(|v| self.points[all(v)]).collect();
            part.block = Block::new(points, std::mem::take(&mut part.corners));
            part.block.quadrics = part.vertices.iter().map(|v| self.quadrics[all(v)]).collect();
            part.block.bow_tie = part.vertices.iter().map(|v| self.bow_tie[all(v)]).collect();
            for &local in &part.rim {
                part.block.locked[local as usize] = true;
            }
            part.edges = part.block.edges();
        });
        parts
    }

    /// Takes over what a block did.
    fn merge(&mut self, part: &Part, record: &mut Record) {
        let (block, log) = (&part.block, &part.block.log);
        let n = part.vertices.len() as u32;
        let first = record.leaves + record.collapses.len() as u32;
        let before: Vec<u32> = part.vertices.iter().map(|&v| self.version[v as usize]).collect();
        let version = |local: u32| if local < n { before[local as usize] } else { first + local - n };
        let triangle = |local: u32| part.triangles[local as usize];
        let (star_start, removed_start) = (record.star.len() as u32, record.removed.len() as u32);
        record.star.extend(log.star.iter().map(|s| StarTriangle {
            triangle: triangle(s.triangle),
            after: version(s.after),
            before: version(s.before),
            on_v: s.on_v,
        }));
        record.removed.extend(log.removed.iter().map(|&(t, w, flipped)| Removed {
            triangle: triangle(t),
            w: version(w),
            flipped,
        }));
        for c in &log.collapses {
            let [u, v] = c.versions.map(version);
            record.nodes.merge([u, v], c.point);
            record.collapses.push(Collapse {
                u,
                v,
                star_end: star_start + c.star_end,
                removed_end: removed_start + c.removed_end,
            });
        }
        for (local, &v) in part.vertices.iter().enumerate() {
            let v = v as usize;
            self.version[v] = match block.version[local] {
                DEAD => DEAD,
                alive => version(alive),
            };
            (self.points[v], self.quadrics[v], self.bow_tie[v]) =
                (block.points[local], block.quadrics[local], block.bow_tie[local]);
        }
        for (local, &t) in part.triangles.iter().enumerate() {
            self.triangles[t as usize] = match block.triangles[local] {
                [DEAD, ..] => [DEAD; 3],
                corners => corners.map(|c| part.vertices[c as usize]),
            };
        }
    }

    fn forget_dead(&mut self) {
        let Whole { version, triangles, live_vertices, live_triangles, .. } = self;
        live_vertices.retain(|&v| version[v as usize] != DEAD);
        live_triangles.retain(|&t| triangles[t as usize][0] != DEAD);
    }
}

/// Sorts vertices into boxes of at most `most`, end to end, by cutting the longest side again and again.
fn split(points: &[Vec3], vertices: &mut [u32], most: usize, fraction: f64, lengths: &mut Vec<usize>) {
    if vertices.len() <= most {
        lengths.push(vertices.len());
        return;
    }
    let mut min = Vec3::INFINITY;
    let mut max = Vec3::NEG_INFINITY;
    for &v in vertices.iter() {
        (min, max) = (min.min(points[v as usize]), max.max(points[v as usize]));
    }
    let axis = (max - min).max_position();
    let middle = ((vertices.len() as f64 * fraction) as usize).clamp(1, vertices.len() - 1);
    // Ties go by number: the same cut on every machine.
    let key = |&v: &u32| (order(points[v as usize][axis]), v);
    vertices.select_nth_unstable_by_key(middle, key);
    let (low, high) = vertices.split_at_mut(middle);
    split(points, low, most, fraction, lengths);
    split(points, high, most, fraction, lengths);
}

/// An integer that sorts as a finite number does.
fn order(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    bits ^ ((bits >> 31) as u32 >> 1) as i32
}

fn cost_quantile(parts: &[Part], quantile: f64) -> f32 {
    let mut costs: Vec<f32> = parts.iter().flat_map(|p| p.edges.iter().map(|e| e.0)).collect();
    if costs.is_empty() {
        return 0.0;
    }
    let k = ((costs.len() - 1) as f64 * quantile) as usize;
    *costs.select_nth_unstable_by(k, f32::total_cmp).1
}

impl Record {
    fn new(source: &TriangleMesh, points: &[Vec3]) -> Record {
        let n = points.len();
        Record {
            leaves: n as u32,
            nodes: Nodes::of(source, points),
            collapses: Vec::with_capacity(n),
            star: Vec::with_capacity(7 * n),
            removed: Vec::with_capacity(source.triangles.len()),
            rim: vec![],
            base: vec![],
        }
    }
}
