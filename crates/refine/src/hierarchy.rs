//! The Multi-Tessellation as the engine sees it: updates, their dependencies and their footprints
//! (`defloriani2002`, "The Multi-Tessellation").

use glam::Vec3;

/// One update M = (M⁻, M⁺) of a hierarchy, `0..len`, ordered coarse to fine: an update's id is
/// greater than the ids of all it needs.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
#[repr(transparent)]
pub struct UpdateId(pub u32);

impl UpdateId {
    /// The id as an index.
    #[inline]
    pub fn ix(self) -> usize {
        self.0 as usize
    }
}

/// One change of a front. The log of steps is what renderers, streams and tests read.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Step {
    /// M⁻ was replaced by M⁺.
    Refine(UpdateId),
    /// M⁺ was replaced by M⁻.
    Coarsen(UpdateId),
}

/// What a criterion may look at, in mesh space and mesh units.
///
/// Footprints nest along the order: the sphere and the cone of an update hold those of every update
/// that needs it, and its error is no smaller. Criteria that grow with a footprint are therefore
/// monotone, and the set of updates above a tolerance is closed by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Centre of a sphere around all cells of the update and of all that need it.
    pub center: Vec3,
    /// Radius of that sphere.
    pub radius: f32,
    /// Distance of the original surface from the cells of M⁻: what remains wrong while the update is not applied.
    pub error: f32,
    /// The normals of all original cells below the update.
    pub cone: NormalCone,
}

/// All unit vectors within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalCone {
    /// Unit vector in the middle.
    pub axis: Vec3,
    /// Sine of the half angle.
    pub sin: f32,
    /// Cosine of the half angle; a cone with a half angle of 90° or more has `cos <= 0` and culls nothing.
    pub cos: f32,
}

impl NormalCone {
    /// The cone of all directions: culls nothing.
    pub const ALL: NormalCone = NormalCone { axis: Vec3::Z, sin: 0.0, cos: -1.0 };
}

/// What applying or undoing an update does to a decision next to it. A decision is open where it may be taken: to apply an
/// update all of whose needs are applied, or to undo one that nothing applied needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Around {
    /// The decision is open now, and was not before.
    Opened(UpdateId),
    /// The decision is not open any more. It may not have been open before, either.
    Closed(UpdateId),
}

/// A base mesh, updates, and a dependency order: the one trait that every model implements.
///
/// Immutable and shared; all state of one viewer is in `Mesh` and in the engine's `Front`.
pub trait MultiTessellation {
    /// The live mesh Γ_S of one front.
    type Mesh;

    /// Whether `needs` and `needed_by` read the live mesh (implicit dependencies: vertex hierarchies, balance rules).
    ///
    /// Where this is `false` the dependencies are stored or arithmetic: `needs` visits every update that `m` needs,
    /// `needed_by` and `children` every update that needs `m`, whatever is applied, and neither looks at the mesh.
    const READS_MESH: bool = false;

    /// Ids are `0..len`.
    fn len(&self) -> usize;
    /// Whether there is no update at all.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The updates, ascending. Where ids are arithmetic some may stand for nothing: no root leads to them, and only
    /// [`footprint`](MultiTessellation::footprint) may be asked about them, whose error is then no more than the floor.
    fn updates(&self) -> impl Iterator<Item = UpdateId> {
        (0..self.len() as u32).map(UpdateId)
    }
    /// Least and greatest corner of a box that holds the centres of all footprints. Looks at all of them, unless the
    /// model knows better.
    fn centers(&self) -> (Vec3, Vec3) {
        let centers = self.updates().map(|m| self.footprint(m).center);
        centers.fold((Vec3::MAX, Vec3::MIN), |(min, max), c| (min.min(c), max.max(c)))
    }
    /// The base mesh Γ₀, with no update applied.
    fn base(&self) -> Self::Mesh;
    /// Makes a live mesh the base mesh again. Models that hold much memory keep it.
    fn reset(&self, mesh: &mut Self::Mesh) {
        *mesh = self.base();
    }
    /// The footprint of an update.
    fn footprint(&self, m: UpdateId) -> Footprint;
    /// Visits every update that needs nothing. Where dependencies read the mesh: every one that is nobody's child; what else
    /// it needs is asked when it is wanted.
    fn roots(&self, visit: impl FnMut(UpdateId));
    /// Visits the updates that may become legal once `m` is applied. It depends on nothing live.
    fn children(&self, m: UpdateId, visit: impl FnMut(UpdateId));
    /// Applies a legal update, and says what that changes around it. `applied` does not say so of `m` itself. Asked only where
    /// dependencies do not read the mesh; a model that finds or counts all of it does better than this does step by step.
    #[inline]
    fn refine_around(
        &self,
        mesh: &mut Self::Mesh,
        m: UpdateId,
        applied: impl Fn(UpdateId) -> bool,
        mut around: impl FnMut(Around),
    ) {
        self.refine(mesh, m);
        self.needs(mesh, m, |n| around(Around::Closed(n)));
        self.children(m, |child| {
            let mut all = true;
            self.needs(mesh, child, |n| all &= n == m || applied(n));
            if all {
                around(Around::Opened(child));
            }
        });
    }
    /// Undoes an update that nothing applied needs, and says what that changes around it; otherwise as
    /// [`refine_around`](MultiTessellation::refine_around).
    #[inline]
    fn coarsen_around(
        &self,
        mesh: &mut Self::Mesh,
        m: UpdateId,
        applied: impl Fn(UpdateId) -> bool,
        mut around: impl FnMut(Around),
    ) {
        self.coarsen(mesh, m);
        self.children(m, |child| around(Around::Closed(child)));
        self.needs(mesh, m, |n| {
            let mut leaf = true;
            self.children(n, |child| leaf &= !applied(child));
            if leaf {
                around(Around::Opened(n));
            }
        });
    }
    /// Visits updates that must be applied before `m`. May visit applied ones too (the engine looks at its
    /// own set S); reads the live mesh only where the model's dependencies are implicit.
    fn needs(&self, mesh: &Self::Mesh, m: UpdateId, visit: impl FnMut(UpdateId));
    /// Visits updates that must be undone before `m`. May visit unapplied ones too. Where dependencies do not read the
    /// mesh these are the children.
    #[inline]
    fn needed_by(&self, _mesh: &Self::Mesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        const { assert!(!Self::READS_MESH, "a model that reads the mesh says what stands on an update there") };
        self.children(m, visit)
    }
    /// Applies a legal update: M⁻ becomes M⁺.
    fn refine(&self, mesh: &mut Self::Mesh, m: UpdateId);
    /// Undoes an applied update that nothing applied needs: the exact inverse of `refine`.
    fn coarsen(&self, mesh: &mut Self::Mesh, m: UpdateId);
    /// Number of cells of the live mesh.
    fn cells(&self, mesh: &Self::Mesh) -> usize;
    /// How many cells applying `m` adds (|M⁺| − |M⁻|). It depends on nothing live.
    fn cells_added(&self, m: UpdateId) -> usize;
    /// The error of the front with every update applied, in mesh units: 0 unless positions were quantized.
    fn floor_error(&self) -> f32 {
        0.0
    }
}
