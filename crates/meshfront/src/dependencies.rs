//! The rules of dependency, compared: one forest of edge collapses, one flight, five rules.
//!
//! Every rule gets footprints that nest along its own order, from the same updates with the errors that were measured for each
//! by itself. So what a rule costs shows: what it forces is what is applied though nobody asked for it.

use crate::compare::Surface;
use crate::fly_by;
use glam::Vec3;
use meshfront_hierarchies::vertex_pair::rules::{Free, Implicit, Rule, Ruled, Sequence};
use meshfront_hierarchies::vertex_pair::{Columns, FrontMesh};
use meshfront_hierarchies::{EdgeCollapse, TriangleModel, VertexPair};
use meshfront_mesh::{TriangleId, TriangleMesh};
use meshfront_refine::criteria::Frustum;
use meshfront_refine::{Criterion, Footprint, Front, MultiTessellation, NormalCone, Request, UpdateId};
use meshfront_simplify::{BuildError, EdgeCollapseOptions, Progress, edge_collapse_with_own_errors};
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// How to compare.
#[derive(Clone, Debug)]
pub struct DependencyOptions {
    /// How the forest is built.
    pub build: EdgeCollapseOptions,
    /// The tolerance of the flight, pixels.
    pub tolerance_px: f32,
    /// One in so many frames is looked at closely.
    pub look_every: u32,
    /// The flight is flown this often, and the fastest run is reported: what other programs do only adds.
    pub runs: usize,
}

impl Default for DependencyOptions {
    fn default() -> Self {
        DependencyOptions {
            build: EdgeCollapseOptions::default(),
            tolerance_px: fly_by::TOLERANCE_PX,
            look_every: 30,
            runs: 7,
        }
    }
}

/// What a rule does on the flight. Means are over the frames that were looked at, but for time and steps.
#[derive(Clone, Debug, PartialEq)]
pub struct RuleFigures {
    /// What it is called.
    pub name: &'static str,
    /// Whose it is: a key of `docs/bibliography.bib`.
    pub paper: &'static str,
    /// Memory for dependencies alone, bytes per update.
    pub bytes_per_update: f64,
    /// Updates that are above the tolerance by themselves, in the mean.
    pub wanted: f64,
    /// Updates applied beside them, for each of them.
    pub forced_per_wanted: f64,
    /// Triangles, in the mean.
    pub triangles: f64,
    /// The greatest distance of a vertex of the source from the front, pixels; of those that are seen and face the eye.
    pub error_px_max: f64,
    /// The same in the mean.
    pub error_px_mean: f64,
    /// Share of such vertices that are farther than the tolerance.
    pub share_above: f64,
    /// Cells that no mesh of the sequence of collapses had, in the mean.
    pub foreign: f64,
    /// Cells turned away from the surface below their corners, in the mean.
    pub folded: f64,
    /// Of these such that no mesh of the sequence had.
    pub folded_foreign: f64,
    /// Updates applied or undone, for each frame.
    pub steps_per_frame: f64,
    /// Time of the engine for each step, nanoseconds.
    pub ns_per_step: f64,
}

/// All rules on one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependencies {
    /// Updates of the forest.
    pub updates: usize,
    /// Memory of the forest without dependencies, bytes per update.
    pub forest_bytes_per_update: f64,
    /// The tolerance, pixels.
    pub tolerance_px: f32,
    /// Frames of the flight, and those that were looked at closely.
    pub frames: [u32; 2],
    /// From the most order to none.
    pub rules: Vec<RuleFigures>,
}

/// Builds edge collapses, and flies over them under each rule. Takes some seconds per 100,000 vertices.
///
/// # Errors
/// An unusable mesh; or [`BuildError::Cancelled`].
pub fn dependencies(
    mesh: &TriangleMesh,
    options: &DependencyOptions,
    progress: &dyn Progress,
) -> Result<Dependencies, BuildError> {
    let (columns, errors) = edge_collapse_with_own_errors(mesh, &options.build, progress)?;
    progress.phase("derive", "updates", columns.vertex.len() as u64);
    let h = VertexPair::new(Columns::from(&EdgeCollapse::new(columns)?))?;
    let sequence = Sequence::of(&h);
    let (stars, faces) = (sequence.stars(), sequence.faces());
    let flight = Flight::new(mesh, &h, &sequence, &errors, options);
    progress.phase("fly", "rules", 5);
    let mut rules = vec![];
    let mut add = |figures: RuleFigures| {
        rules.push(figures);
        progress.at(rules.len() as u64);
        if progress.cancelled() { Err(BuildError::Cancelled) } else { Ok(()) }
    };
    add(flight.fly("explicit lists", "defloriani2002", sequence.stars(), &stars))?;
    add(flight.fly("neighbours at the merge", "xia1997", sequence.neighbours(), &stars))?;
    add(flight.fly("implicit numbers", "elsana1999", Implicit::new(&h), &stars))?;
    add(flight.fly("four faces", "hoppe1997", sequence.faces(), &faces))?;
    add(flight.fly("none", "kim2001", Free, &Free))?;
    let updates = h.len();
    let own = h.memory_bytes() - Implicit::new(&h).bytes();
    Ok(Dependencies {
        updates,
        forest_bytes_per_update: own as f64 / updates.max(1) as f64,
        tolerance_px: options.tolerance_px,
        frames: [fly_by::FRAMES, fly_by::FRAMES.div_ceil(options.look_every.max(1))],
        rules,
    })
}

/// What all rules have in common.
struct Flight<'a> {
    mesh: &'a TriangleMesh,
    h: &'a VertexPair,
    sequence: &'a Sequence,
    errors: &'a [f32],
    /// Of each update by itself.
    own: Vec<Footprint>,
    /// Of the vertices of the source, not of unit length.
    normals: Vec<Vec3>,
    options: &'a DependencyOptions,
}

/// What was seen in one frame.
#[derive(Default)]
struct Look {
    wanted: usize,
    forced: usize,
    triangles: usize,
    foreign: usize,
    folded: usize,
    folded_foreign: usize,
    distances: Distances,
}

/// Of vertices of the source, in pixels.
#[derive(Clone, Copy, Default)]
struct Distances {
    max: f64,
    sum: f64,
    above: usize,
    count: usize,
}

impl<'a> Flight<'a> {
    fn new(
        mesh: &'a TriangleMesh,
        h: &'a VertexPair,
        sequence: &'a Sequence,
        errors: &'a [f32],
        options: &'a DependencyOptions,
    ) -> Flight<'a> {
        let mut normals = vec![Vec3::ZERO; mesh.positions.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(TriangleId(t as u32));
            corners.iter().for_each(|v| normals[v.ix()] += (b - a).cross(c - a));
        }
        let own = h.updates().map(|m| sequence.own_footprint(h, errors, m)).collect();
        Flight { mesh, h, sequence, errors, own, normals, options }
    }

    fn fly<R: Rule>(&self, name: &'static str, paper: &'static str, rule: R, order: &impl Rule) -> RuleFigures {
        let bytes = rule.bytes();
        let ruled = Ruled::new(self.h, rule, order, self.sequence, self.errors);
        let mut least = Duration::MAX;
        let (mut steps, mut looks) = (0, vec![]);
        for run in 0..self.options.runs.max(1) {
            let mut front = Front::new(&ruled);
            self.adapt(&mut front, &ruled, 0);
            let mut time = Duration::ZERO;
            steps = 0;
            for frame in 0..fly_by::FRAMES {
                let start = Instant::now();
                self.adapt(&mut front, &ruled, frame);
                time += start.elapsed();
                steps += front.steps().len();
                front.mesh_mut().buffers.clear_changes();
                if run == 0 && frame % self.options.look_every.max(1) == 0 {
                    looks.push(self.look(&front, frame));
                }
            }
            least = least.min(time);
        }
        let mean = |of: &dyn Fn(&Look) -> usize| looks.iter().map(of).sum::<usize>() as f64 / looks.len() as f64;
        let (wanted, forced) = (mean(&|l| l.wanted), mean(&|l| l.forced));
        let seen = looks.iter().map(|l| l.distances.count).sum::<usize>().max(1) as f64;
        RuleFigures {
            name,
            paper,
            bytes_per_update: bytes as f64 / self.h.len().max(1) as f64,
            wanted,
            forced_per_wanted: forced / wanted.max(1.0),
            triangles: mean(&|l| l.triangles),
            error_px_max: looks.iter().map(|l| l.distances.max).fold(0.0, f64::max),
            error_px_mean: looks.iter().map(|l| l.distances.sum).sum::<f64>() / seen,
            share_above: looks.iter().map(|l| l.distances.above).sum::<usize>() as f64 / seen,
            foreign: mean(&|l| l.foreign),
            folded: mean(&|l| l.folded),
            folded_foreign: mean(&|l| l.folded_foreign),
            steps_per_frame: steps as f64 / fly_by::FRAMES as f64,
            ns_per_step: least.as_nanos() as f64 / steps.max(1) as f64,
        }
    }

    fn adapt<R: Rule>(&self, front: &mut Front<Ruled<'a, R>>, ruled: &Ruled<'a, R>, frame: u32) {
        let criterion = fly_by::criterion(self.h.bounds(), frame);
        front.adapt(ruled, &criterion, &Request::tolerance(self.options.tolerance_px));
    }

    fn look<R: Rule>(&self, front: &Front<Ruled<R>>, frame: u32) -> Look {
        let criterion = fly_by::criterion(self.h.bounds(), frame);
        let is_wanted = |f: &Footprint| criterion.pixels(f) > self.options.tolerance_px;
        let wanted: Vec<UpdateId> =
            self.h.updates().zip(&self.own).filter(|(_, f)| is_wanted(f)).map(|(m, _)| m).collect();
        let forced = front.applied_count() - wanted.iter().filter(|&&m| front.is_applied(m)).count();
        let mut look = Look { wanted: wanted.len(), forced, ..Look::default() };
        let mesh: &FrontMesh = front.mesh();
        let buffers = &mesh.buffers;
        let live = buffers.triangles.iter().filter(|t| t[0] != t[1]);
        for (t, (_, names)) in live.zip(mesh.numbered_triangles()) {
            let [a, b, c] = t.map(|slot| buffers.positions[slot as usize]);
            let below: Vec3 = t.iter().map(|&slot| vector(buffers.normals[slot as usize])).sum();
            let folded = (b - a).cross(c - a).dot(below) < 0.0;
            let foreign = !self.sequence.has(names);
            look.triangles += 1;
            look.folded += usize::from(folded);
            look.foreign += usize::from(foreign);
            look.folded_foreign += usize::from(folded && foreign);
        }
        look.distances = self.distances(&buffers.to_mesh(), frame);
        look
    }

    /// How far the vertices of the source that are seen, and face the eye, are from a mesh.
    fn distances(&self, mesh: &TriangleMesh, frame: u32) -> Distances {
        let Some(surface) = Surface::new(mesh) else { return Distances::default() };
        let camera = fly_by::camera(self.h.bounds(), frame);
        let frustum = Frustum::new(&camera);
        let per_length = camera.height_px as f64 / (2.0 * (camera.fov_y as f64 / 2.0).tan());
        let tolerance = self.options.tolerance_px as f64;
        let pixels = |(&p, n): (&Vec3, &Vec3)| {
            let point = Footprint { center: p, radius: 0.0, error: 0.0, cone: NormalCone::ALL };
            let seen = n.dot(camera.eye - p) > 0.0 && frustum.pixels(&point) > 0.0;
            seen.then(|| surface.distance(p) * per_length / camera.eye.distance(p) as f64)
        };
        let one = |px: f64| Distances { max: px, sum: px, above: usize::from(px > tolerance), count: 1 };
        let both = |a: Distances, b: Distances| Distances {
            max: a.max.max(b.max),
            sum: a.sum + b.sum,
            above: a.above + b.above,
            count: a.count + b.count,
        };
        let places = self.mesh.positions.par_iter().zip(&self.normals);
        places.filter_map(pixels).map(one).reduce(Distances::default, both)
    }
}

fn vector([x, y, z, _]: [i16; 4]) -> Vec3 {
    Vec3::new(x as f32, y as f32, z as f32)
}
