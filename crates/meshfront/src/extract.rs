//! Taking meshes out of a hierarchy.

use meshfront_hierarchies::{LiveMesh, TriangleModel};
use meshfront_mesh::TriangleMesh;
use meshfront_refine::{Criterion, Fingerprint, Footprint, Front, MultiTessellation, Outcome, Pose, Request, UpdateId};

/// A mesh, and how wrong it is.
#[derive(Clone, Debug)]
pub struct Extracted {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// No point of the original surface is farther than this from the mesh, mesh units: see [`promised_error`].
    pub error: f32,
    /// The same in the units of the criterion, for what the criterion sees.
    pub criterion_error: f32,
    /// What the engine did for it.
    pub outcome: Outcome,
}

/// The mesh that a criterion asks for, from the base mesh downwards: to the tolerance, or as far as `max_cells` allows,
/// the worst first. The same request gives the same mesh.
///
/// Takes less than a microsecond per update; [`Front`] is there for those who want more than one view.
pub fn extract<H: TriangleModel>(hierarchy: &H, criterion: &impl Criterion, request: &Request) -> Extracted {
    let mut front = Front::new(hierarchy);
    let outcome = if request.max_cells.is_some() || request.deadline_us.is_some() {
        front.interruptible(hierarchy, criterion, request)
    } else {
        front.top_down(hierarchy, criterion, request)
    };
    Extracted {
        mesh: front.mesh().buffers().to_mesh(),
        error: promised_error(hierarchy, &front),
        criterion_error: front.measure(hierarchy, criterion),
        outcome,
    }
}

/// The mesh of at most so many cells that is best on the whole: updates in order of [`TriangleModel::cost`], as far as they
/// fit. `criterion_error` is the error.
pub fn extract_cells<H: TriangleModel>(hierarchy: &H, most: usize) -> Extracted {
    let mut order: Vec<UpdateId> = hierarchy.updates().collect();
    // What an update needs costs no less and has a smaller number: in this order nothing is missing.
    order.sort_by(|&a, &b| hierarchy.cost(b).total_cmp(&hierarchy.cost(a)).then(a.cmp(&b)));
    let mut mesh = hierarchy.base();
    let fits = order
        .iter()
        .take_while(|&&m| {
            let fits = hierarchy.cells(&mesh) + hierarchy.cells_added(m) <= most;
            if fits {
                hierarchy.refine(&mut mesh, m);
            }
            fits
        })
        .count();
    let error = order[fits..].iter().map(|&m| hierarchy.footprint(m).error).fold(hierarchy.floor_error(), f32::max);
    let cells = hierarchy.cells(&mesh);
    Extracted {
        mesh: mesh.buffers().to_mesh(),
        error,
        criterion_error: error,
        outcome: Outcome { refined: fits as u32, cells, settled: fits == order.len(), ..Outcome::default() },
    }
}

/// Every update applied: the source, but for quantization and cleaning.
pub fn finest<H: TriangleModel>(hierarchy: &H) -> TriangleMesh {
    let mut front = Front::new(hierarchy);
    front.top_down(hierarchy, &Everything, &Request::tolerance(0.0));
    front.mesh().buffers().to_mesh()
}

/// How far the original surface is from a front's mesh at most, mesh units: the worst error of the updates that
/// are not applied, and what quantization costs everywhere. Looks at every update.
pub fn promised_error<H: MultiTessellation>(hierarchy: &H, front: &Front<H>) -> f32 {
    let waiting = hierarchy.updates().filter(|&m| !front.is_applied(m));
    waiting.fold(hierarchy.floor_error(), |worst, m| worst.max(hierarchy.footprint(m).error))
}

/// The criterion that wants every update, those without error too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Everything;

impl Criterion for Everything {
    fn pixels(&self, _: &Footprint) -> f32 {
        f32::INFINITY
    }
    fn slack(&self, _: &Footprint, _: f32) -> f32 {
        f32::INFINITY
    }
    fn pose(&self) -> Pose {
        Pose::new(Fingerprint::of("everything"))
    }
}
