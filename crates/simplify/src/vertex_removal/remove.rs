//! The decimation of a whole mesh: rounds of independent sets, and the record of all removals.

use super::choose::{Around, Choice, GUARDS, Guard, is_free};
use super::rings::{NONE, Rings, Spoke};
use super::samples::Samples;
use crate::measure::{Trail, Way, Ways, nearest};
use crate::metrics::quadric::Quadric;
use crate::{BuildError, Progress};
use arrayvec::ArrayVec;
use glam::Vec3;
use meshfront_hierarchies::vertex_removal::{Grid, MOST_CORNERS, Triangulation};
use meshfront_mesh::{TriangleMesh, VertexId};
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;

/// What happened, fine to coarse. Cells are the source's triangles, then those of `coarse`.
pub(super) struct Record {
    /// Number of source triangles.
    pub triangles: u32,
    /// Per vertex, on the grid where there is one.
    pub positions: Vec<Vec3>,
    pub removals: Vec<Removal>,
    /// The rings of removed vertices, end to end, with the cells of their fans.
    pub rings: Vec<Spoke>,
    /// The cells that came in the place of fans, end to end, in the order of each triangulation.
    pub coarse: Vec<[u32; 3]>,
    /// Per vertex: whether it lies on a boundary.
    pub rim: Vec<bool>,
    /// What is left: cell and corners.
    pub base: Vec<(u32, [u32; 3])>,
}

/// A vertex that went.
#[derive(Clone, Copy)]
pub(super) struct Removal {
    pub vertex: u32,
    /// Of the polygon whose corner 0 is the first of the ring.
    pub triangulation: Triangulation,
    /// End of its ring in `Record::rings`; it starts where the one before ends.
    ring_end: u32,
    /// End of its coarse cells in `Record::coarse`.
    coarse_end: u32,
}

impl Record {
    pub fn ring_of(&self, i: usize) -> &[Spoke] {
        let start = if i == 0 { 0 } else { self.removals[i - 1].ring_end };
        &self.rings[start as usize..self.removals[i].ring_end as usize]
    }
    pub fn coarse_of(&self, i: usize) -> Range<usize> {
        let start = if i == 0 { 0 } else { self.removals[i - 1].coarse_end };
        start as usize..self.removals[i].coarse_end as usize
    }
}

/// Weight of the planes that hold boundaries in place, against the weight of the surface.
const RIM_WEIGHT: f64 = 3.0;
/// A round removes vertices up to this quantile of all costs at its start, as far as they are independent: fewer, and the
/// order of removals comes close to that of one queue; more, and the order of dependency is less deep.
const ROUND_QUANTILE: f64 = 0.2;

/// Removes vertices in rounds. In a round no two neighbours go, the cheapest go first, and none costs more than a bound that
/// rises from round to round. Choosing is done in parallel; nothing depends on the number of threads.
pub(super) fn remove(
    source: &TriangleMesh,
    grid: Option<Grid>,
    base_triangles: usize,
    progress: &dyn Progress,
) -> Result<Record, BuildError> {
    let count = source.triangles.len();
    progress.phase("simplify", "triangles", count as u64);
    let mut mesh = Mesh::new(source, grid)?;
    let mut guards = GUARDS.into_iter();
    let mut guard = guards.next().expect("there is a strictest");
    let mut dirty: Vec<u32> = mesh.live.clone();
    loop {
        mesh.choose(&dirty, guard);
        if progress.cancelled() {
            return Err(BuildError::Cancelled);
        }
        if mesh.cells <= base_triangles {
            break;
        }
        let Some(order) = mesh.cheapest() else {
            match guards.next() {
                Some(weaker) => guard = weaker,
                None => break, // nothing that is left may go
            }
            dirty.clone_from(&mesh.live);
            continue;
        };
        mesh.round += 1;
        dirty.clear();
        for v in order {
            if mesh.cells <= base_triangles {
                break;
            }
            if mesh.touched[v as usize] == mesh.round {
                continue;
            }
            if is_free(&mesh.rings, v, mesh.choices[v as usize].triangulation) {
                mesh.remove(v);
            } else {
                dirty.push(v);
            }
        }
        let Mesh { live, gone, touched, round, .. } = &mut mesh;
        live.retain(|&v| !gone[v as usize]);
        dirty.extend(live.iter().filter(|&&v| touched[v as usize] == *round));
        progress.at((count - mesh.cells) as u64);
    }
    Ok(mesh.into_record())
}

struct Mesh {
    rings: Rings,
    samples: Samples,
    /// Per boundary vertex: what holds it in place.
    rims: HashMap<u32, Quadric>,
    choices: Vec<Choice>,
    /// Last round in which the ring of a vertex changed.
    touched: Vec<u32>,
    round: u32,
    gone: Vec<bool>,
    live: Vec<u32>,
    /// Number of live cells.
    cells: usize,
    record: Record,
    /// Scratch.
    ring: Vec<Spoke>,
}

impl Mesh {
    fn new(source: &TriangleMesh, grid: Option<Grid>) -> Result<Mesh, BuildError> {
        let rings = Rings::of(source)?;
        let n = source.positions.len();
        let vertices = || (0..n as u32).into_par_iter();
        let live: Vec<u32> = (0..n as u32).filter(|&v| !rings.of_vertex(v).is_empty()).collect();
        let record = Record {
            triangles: source.triangles.len() as u32,
            positions: source.positions.par_iter().map(|&p| grid.map_or(p, |g| g.snap(p))).collect(),
            removals: Vec::with_capacity(n),
            rings: Vec::with_capacity(6 * n),
            coarse: Vec::with_capacity(4 * n),
            rim: vertices().map(|v| rings.is_open(v)).collect(),
            base: vec![],
        };
        Ok(Mesh {
            samples: Samples::new(&source.positions, &rings, source.triangles.len()),
            rims: (0..n as u32)
                .filter(|&v| rings.is_open(v))
                .map(|v| (v, rim_quadric(&rings, &source.positions, v)))
                .collect(),
            choices: vec![Choice::STAY; n],
            touched: vec![0; n],
            round: 0,
            gone: vec![false; n],
            live,
            cells: source.triangles.len(),
            rings,
            record,
            ring: vec![],
        })
    }

    fn choose(&mut self, dirty: &[u32], guard: Guard) {
        let around =
            Around { rings: &self.rings, points: &self.record.positions, samples: &self.samples, rims: &self.rims };
        let chosen: Vec<Choice> = dirty.par_iter().map(|&v| around.choose(v, guard)).collect();
        for (&v, choice) in dirty.iter().zip(chosen) {
            self.choices[v as usize] = choice;
        }
    }

    /// The vertices that may go in a round, cheapest first; `None` where none may.
    fn cheapest(&self) -> Option<Vec<u32>> {
        let cost = |v: u32| self.choices[v as usize].cost;
        let mut order: Vec<(f32, u32)> =
            self.live.iter().map(|&v| (cost(v), v)).filter(|c| c.0 < f32::INFINITY).collect();
        let last = (order.len().checked_sub(1)? as f64 * ROUND_QUANTILE) as usize;
        let by_cost = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        order.select_nth_unstable_by(last, by_cost);
        order.truncate(last + 1);
        order.par_sort_unstable_by(by_cost);
        Some(order.into_iter().map(|c| c.1).collect())
    }

    /// Takes a vertex away, puts its triangulation in its place, and logs it.
    fn remove(&mut self, v: u32) {
        let triangulation = self.choices[v as usize].triangulation;
        let ring: ArrayVec<Spoke, MOST_CORNERS> = self.rings.of_vertex(v).iter().copied().collect();
        let n = ring.len();
        let open = ring[n - 1].cell == NONE;
        let triangles = triangulation.triangles();
        let first = self.record.triangles + self.record.coarse.len() as u32;
        self.record.coarse.extend(triangles.iter().map(|t| t.map(|c| ring[c as usize].vertex)));
        self.record.rings.extend_from_slice(&ring);
        self.record.removals.push(Removal {
            vertex: v,
            triangulation,
            ring_end: self.record.rings.len() as u32,
            coarse_end: self.record.coarse.len() as u32,
        });
        for c in 0..n {
            self.rejoin(v, &ring, c, open, &triangles, first);
        }
        self.share(v, &ring, open, &triangles);
        self.rings.set(v, &[]);
        self.gone[v as usize] = true;
        self.cells -= 2 - usize::from(open);
        for s in &ring {
            self.touched[s.vertex as usize] = self.round;
        }
    }

    /// Replaces `v` in the ring of the polygon's corner `c` by what the new triangles join `c` with.
    fn rejoin(&mut self, v: u32, polygon: &[Spoke], c: usize, open: bool, triangles: &[[u8; 3]], first: u32) {
        let n = polygon.len();
        // Around c, from the next corner of the polygon to the one before: each triangle as the spoke that it begins at.
        let mut fan = ArrayVec::<(usize, Spoke), MOST_CORNERS>::new();
        for (t, corners) in triangles.iter().enumerate() {
            if let Some(k) = corners.iter().position(|&corner| corner as usize == c) {
                let after = corners[(k + 1) % 3] as usize;
                let spoke = Spoke { vertex: polygon[after].vertex, cell: first + t as u32 };
                fan.push(((after + n - c) % n, spoke));
            }
        }
        fan.sort_unstable_by_key(|s| s.0);
        let old = self.rings.of_vertex(polygon[c].vertex);
        let at = old.iter().position(|s| s.vertex == v).expect("neighbours know each other");
        self.ring.clear();
        // The spoke to the next corner is there already, before v, but where c is the last corner at a boundary.
        let known = !(open && c == n - 1);
        let keep = if known && at == 0 {
            self.ring.extend_from_slice(&old[1..old.len() - 1]);
            &[][..]
        } else {
            self.ring.extend_from_slice(&old[..at - usize::from(known)]);
            &old[at + 1..]
        };
        self.ring.extend(fan.iter().map(|s| s.1));
        if open && c == 0 {
            self.ring.push(Spoke { vertex: polygon[n - 1].vertex, cell: NONE });
        }
        self.ring.extend_from_slice(keep);
        self.rings.set(polygon[c].vertex, &self.ring);
    }

    /// Hands the samples of a fan on to the triangles that replace it, and what a boundary vertex remembers to the ends of the
    /// new edge.
    fn share(&mut self, v: u32, ring: &[Spoke], open: bool, triangles: &[[u8; 3]]) {
        let at = |c: u8| self.record.positions[ring[c as usize].vertex as usize];
        let cells: ArrayVec<[Vec3; 3], MOST_CORNERS> = triangles.iter().map(|t| t.map(at)).collect();
        let mut on = [const { vec![] }; MOST_CORNERS];
        let fan = ring.iter().filter(|s| s.cell != NONE);
        for sample in fan.flat_map(|s| self.samples.of(s.cell)).chain([v]) {
            let p = self.samples.points[sample as usize];
            let distance = |k: &usize| nearest(cells[*k].map(|c| c - p));
            let k =
                (0..cells.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a polygon has triangles");
            on[k].push(sample);
        }
        for on in on.into_iter().take(cells.len()) {
            self.samples.push(on);
        }
        if open {
            let q = self.rims.remove(&v).unwrap_or_default() * 0.5;
            for end in [ring[0], ring[ring.len() - 1]] {
                *self.rims.entry(end.vertex).or_default() += q;
            }
        }
    }

    fn into_record(self) -> Record {
        let mut record = self.record;
        for &v in &self.live {
            let ring = self.rings.of_vertex(v);
            for (i, s) in ring.iter().enumerate().filter(|(_, s)| s.cell != NONE) {
                let next = ring[(i + 1) % ring.len()].vertex;
                // Each cell is seen from three vertices: it is taken from the least.
                if v < s.vertex && v < next {
                    record.base.push((s.cell, [v, s.vertex, next]));
                }
            }
        }
        record
    }
}

/// Planes through the boundary edges of a source vertex, across the surface.
fn rim_quadric(rings: &Rings, points: &[Vec3], v: u32) -> Quadric {
    let ring = rings.of_vertex(v);
    let at = |i: usize| points[ring[i].vertex as usize].as_dvec3() - points[v as usize].as_dvec3();
    let n = ring.len();
    let mut q = Quadric::default();
    for (end, inner) in [(0, 1), (n - 1, n - 2)] {
        let plane = at(end).cross(at(end).cross(at(inner)));
        if plane.length_squared() > 0.0 {
            let normal = plane.normalize();
            let offset = -normal.dot(points[v as usize].as_dvec3());
            q += Quadric::plane(normal, offset, RIM_WEIGHT * at(end).length_squared());
        }
    }
    q
}

/// Coarse cells are the triangulations.
impl Trail for Record {
    type Word = u32;
    const FAN: bool = false;
    const KEEPS_VERTICES: bool = true;
    const EVEN: bool = true;

    fn steps(&self) -> usize {
        self.removals.len()
    }
    fn position(&self, vertex: VertexId) -> Vec3 {
        self.positions[vertex.ix()]
    }
    fn on_rim(&self, vertex: VertexId) -> bool {
        self.rim[vertex.ix()]
    }
    #[inline]
    fn coarse(&self, step: usize) -> Range<usize> {
        self.coarse_of(step)
    }
    #[inline]
    fn corners(&self, _: usize, cell: usize) -> [Vec3; 3] {
        self.coarse[cell].map(|v| self.positions[v as usize])
    }
    fn gone(&self, step: usize) -> impl Iterator<Item = Vec3> {
        std::iter::once(self.positions[self.removals[step].vertex as usize])
    }

    fn ways(&self, triangles: usize) -> Ways<u32> {
        let mut first = vec![Way::NONE; triangles];
        let mut next = vec![Way::NONE; self.coarse.len()];
        for i in 0..self.removals.len() {
            let (ring, cells) = (self.ring_of(i), &self.coarse[self.coarse_of(i)]);
            for (j, s) in ring.iter().enumerate().filter(|(_, s)| s.cell != NONE) {
                let after = ring[(j + 1) % ring.len()].vertex;
                let near = cells.iter().position(|t| t.contains(&s.vertex) && t.contains(&after)).unwrap_or(0);
                let way = match s.cell.checked_sub(self.triangles) {
                    None => &mut first[s.cell as usize],
                    Some(e) => &mut next[e as usize],
                };
                *way = Way::vanishes(i, near);
            }
        }
        Ways { first, next }
    }
}
