//! Right triangles: terrain over a regular grid by bisection of longest edges (`evans2001`, `lindstrom2002`), as a
//! Multi-Tessellation (`defloriani2002`, "Hierarchy of right triangles"): M⁻ are the one or two triangles that share a
//! hypotenuse, M⁺ the two or four that a cut at its middle makes.
//!
//! ```text
//!      M⁻             M⁺
//!     o-----o       o-----o
//!     | \   |       | \ / |     The middle v of the hypotenuse has the height of a
//!     |   \ |   ⇄   |  v  |     sample. Needs and children are arithmetic: the two
//!     |     \       | / \ |     right angles, and the middles of the four new
//!     o-----o       o-----o     hypotenuses.
//! ```
//!
//! Errors are the true vertical distance of the surface from M⁻, found by looking at every sample in it, and hold in all
//! fronts, since a triangle is the same in all. Any grid will do: the base mesh is cut where a border or a missing
//! sample would lie inside a triangle, so both are exact in every front, and nothing is resampled.
//!
//! Mesh space: x metres to the east of the south-western sample, y to the north, z up, times the exaggeration.

use crate::live::Most;
use crate::model::{Model, Progress, SourceCounts, Stored, TriangleModel};
use glam::{DVec2, Vec2, Vec3};
use meshfront_mesh::{Bounds, Unit};
use meshfront_refine::{Around, Footprint, MultiTessellation, NormalCone, UpdateId};
use std::collections::HashMap;

mod base;
mod derive;
mod front_mesh;
mod lattice;
mod record;

pub use front_mesh::FrontMesh;

use lattice::NOWHERE;
pub use lattice::{Lattice, Site, Spot};
use record::Record;

/// What is stored of a terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Samples from west to east, 2 to 65537.
    pub columns: u32,
    /// Samples from south to north, 2 to 65537; at most 2²⁹ samples together.
    pub rows: u32,
    /// Mesh units between neighbouring columns and rows.
    pub spacing: DVec2,
    /// Heights in mesh units, row by row from the south, each from the west. NaN is missing: there is no surface.
    pub heights: Vec<f32>,
    /// How heights are quantized; `None`: they are not.
    pub steps: Option<Steps>,
    /// What quantization did to heights, mesh units.
    pub floor_error: f32,
    /// Where the terrain is.
    pub place: Place,
}

impl Columns {
    /// Sizes and numbers: all that can be checked without looking at triangles.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), InvalidHeights> {
        self.check_shape()?;
        let samples = self.columns as usize * self.rows as usize;
        if self.heights.len() != samples {
            return Err(InvalidHeights::Length { found: self.heights.len(), expected: samples });
        }
        match self.heights.iter().position(|h| !h.is_nan() && h.abs() >= MOST) {
            Some(i) => Err(InvalidHeights::Height(i)),
            None => Ok(()),
        }
    }

    /// As [`Columns::check`], without a look at the heights.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check_shape(&self) -> Result<(), InvalidHeights> {
        let Columns { columns, rows, spacing, steps, floor_error, .. } = *self;
        let side = |n| (2..=MOST_SIDE).contains(&n);
        if !side(columns) || !side(rows) || columns as u64 * rows as u64 > MOST_SAMPLES {
            return Err(InvalidHeights::Size { columns, rows });
        }
        let positive = |x: f64| x < MOST as f64 && x as f32 >= f32::MIN_POSITIVE;
        if !(positive(spacing.x) && positive(spacing.y)) {
            return Err(InvalidHeights::Spacing);
        }
        if !(floor_error.is_finite() && floor_error >= 0.0) {
            return Err(InvalidHeights::Floor);
        }
        match steps {
            Some(steps) if !(steps.zero.is_finite() && positive(steps.step)) => Err(InvalidHeights::Steps),
            _ => Ok(()),
        }
    }
}

/// Of samples along one side: x and y are numbers of 16 bits and one more.
const MOST_SIDE: u32 = (1 << 16) + 1;
/// Slots of triangles are looked up by four times an id.
const MOST_SAMPLES: u64 = 1 << 29;
/// Squares of squares of lengths must fit into an `f32`.
const MOST: f32 = 1e9;

/// Heights are `zero + step · i` for whole i.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// Mesh units.
    pub zero: f64,
    /// Mesh units; positive.
    pub step: f64,
}

impl Steps {
    /// The height of a step.
    #[inline]
    pub fn height(&self, i: i64) -> f32 {
        (self.zero + self.step * i as f64) as f32
    }
    /// The nearest step.
    #[inline]
    pub fn nearest(&self, height: f32) -> i64 {
        let i = (height as f64 - self.zero) / self.step;
        (i + 0.5f64.copysign(i)) as i64
    }
}

/// How mesh space lies in the coordinates of the source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Easting and northing (longitude and latitude) of the mesh's origin, the south-western sample.
    pub origin: DVec2,
    /// What `origin` is measured in.
    pub horizontal: Unit,
    /// Source units between neighbouring columns and rows.
    pub spacing: DVec2,
    /// What the source's heights are measured in; in the mesh they are metres, times `exaggeration`.
    pub vertical: Unit,
    /// How many times too high the mesh is.
    pub exaggeration: f32,
}

/// Why heights are no terrain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidHeights {
    /// Too few or too many samples.
    #[error("{columns} × {rows} samples: a terrain has 2 to 65,537 along each side, and at most 2^29 of them")]
    Size {
        /// Columns.
        columns: u32,
        /// Rows.
        rows: u32,
    },
    /// A column of another length.
    #[error("{found} heights where there should be {expected}")]
    Length {
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// Distances between samples that cannot be computed with.
    #[error("the distance between samples is not a positive number below 1e9")]
    Spacing,
    /// A height that cannot be computed with.
    #[error("height {0} is not a number below 1e9")]
    Height(usize),
    /// An unusable quantization.
    #[error("the steps of heights are not positive finite numbers")]
    Steps,
    /// An unusable floor error.
    #[error("the floor error is not a finite number")]
    Floor,
    /// A height between steps.
    #[error("height {0} is not a whole number of steps: quantize heights, or store them lossless")]
    OffStep(usize),
    /// No four neighbouring samples that make a triangle.
    #[error("there is no triangle: nearly all samples are missing")]
    Empty,
}

/// The hierarchy in memory: twelve bytes per sample.
#[derive(Clone, Debug)]
pub struct RightTriangles {
    lattice: Lattice,
    /// Per id.
    records: Vec<Record>,
    /// All ids are updates, and what is there of M⁻ is a matter of borders.
    regular: bool,
    /// Vertices of the base mesh.
    corners: Vec<Corner>,
    /// The base mesh: indices of `corners`.
    base: Vec<[u32; 3]>,
    /// Which base triangle has its right angle at a sample and its hypotenuse in a direction.
    base_slots: HashMap<([i32; 2], usize), u32>,
    mesh_spacing: DVec2,
    spacing: Vec2,
    /// Sine and cosine per packed half angle.
    cones: Vec<[f32; 2]>,
    bounds: Bounds,
    /// Samples that are there.
    vertices: u32,
    /// Of the full front.
    triangles: u32,
    steps: Option<Steps>,
    floor_error: f32,
    place: Place,
}

#[derive(Clone, Copy, Debug)]
struct Corner {
    sample: [u32; 2],
    record: Record,
}

impl RightTriangles {
    /// Finds the error of every update by looking at every sample in its triangles: some 24 levels for a grid of
    /// 4097 × 4097, on all threads of rayon's current pool. Twelve bytes per sample, and four more on the way where some
    /// are missing.
    ///
    /// # Errors
    /// Columns that are no terrain.
    pub fn new(columns: Columns) -> Result<RightTriangles, InvalidHeights> {
        derive::derive(columns, &mut |_| {})
    }
    /// The same; `progress` is told which part of it is done, from 0 to 1.
    pub(crate) fn with_progress(columns: Columns, progress: Progress) -> Result<RightTriangles, InvalidHeights> {
        derive::derive(columns, progress)
    }

    /// The columns as stored.
    pub fn columns(&self) -> Columns {
        let Lattice { columns, rows, .. } = self.lattice;
        let mut heights = vec![f32::NAN; columns as usize * rows as usize];
        let mut at = |x: i32, y: i32, height| heights[y as usize * columns as usize + x as usize] = height;
        for (id, record) in self.records.iter().enumerate() {
            let site = self.lattice.site(id as u32);
            at(site.x, site.y, record.height);
        }
        for corner in &self.corners {
            at(corner.sample[0] as i32, corner.sample[1] as i32, corner.record.height);
        }
        Columns {
            columns: columns as u32,
            rows: rows as u32,
            spacing: self.mesh_spacing,
            heights,
            steps: self.steps,
            floor_error: self.floor_error,
            place: self.place,
        }
    }

    /// Samples from west to east, and from south to north.
    pub fn samples(&self) -> [u32; 2] {
        [self.lattice.columns as u32, self.lattice.rows as u32]
    }
    /// How heights are quantized.
    pub fn steps(&self) -> Option<Steps> {
        self.steps
    }
    /// Where the terrain is.
    pub fn place(&self) -> Place {
        self.place
    }

    fn most(&self) -> Most {
        Most { vertices: self.vertices as usize, triangles: self.triangles as usize }
    }
    fn position(&self, x: i32, y: i32, height: f32) -> Vec3 {
        (Vec2::new(x as f32, y as f32) * self.spacing).extend(height)
    }
    /// Whether an id is an update.
    #[inline]
    fn is_update(&self, id: u32) -> bool {
        self.regular || self.records[id as usize].is_update()
    }
    /// The update of one of the lattice's ids, if there is one.
    #[inline]
    fn update(&self, id: u32) -> Option<UpdateId> {
        (id != NOWHERE && self.is_update(id)).then_some(UpdateId(id))
    }
    #[inline]
    fn visit(&self, x: i32, y: i32, visit: &mut impl FnMut(UpdateId)) {
        if let Some(id) = self.lattice.id(x, y).filter(|&id| self.is_update(id)) {
            visit(UpdateId(id));
        }
    }
}

impl MultiTessellation for RightTriangles {
    type Mesh = FrontMesh;

    fn len(&self) -> usize {
        self.lattice.len()
    }
    fn updates(&self) -> impl Iterator<Item = UpdateId> {
        (0..self.lattice.len() as u32).filter(|&id| self.is_update(id)).map(UpdateId)
    }
    fn centers(&self) -> (Vec3, Vec3) {
        (self.bounds.min, self.bounds.max)
    }
    fn base(&self) -> FrontMesh {
        FrontMesh::base(self)
    }
    fn reset(&self, mesh: &mut FrontMesh) {
        mesh.reset(self);
    }
    #[inline]
    fn footprint(&self, m: UpdateId) -> Footprint {
        let site = self.lattice.site(m.0);
        let record = &self.records[m.ix()];
        let [sin, cos] = self.cones[record.cone()];
        Footprint {
            center: self.position(site.x, site.y, record.height),
            radius: record.radius(),
            error: record.error() + self.floor_error,
            cone: NormalCone { axis: record.normal(), sin, cos },
        }
    }
    fn roots(&self, mut visit: impl FnMut(UpdateId)) {
        // Those whose triangles are all of the base mesh; an apex that is an update makes them a child of it.
        let mut seen = std::collections::HashSet::new();
        for triangle in &self.base {
            let [a, b, _] = triangle.map(|i| self.corners[i as usize].sample.map(|c| c as i32));
            if (a[0] + b[0]) % 2 != 0 || (a[1] + b[1]) % 2 != 0 {
                continue;
            }
            self.visit((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, &mut |m| {
                let mut is_root = true;
                self.for_needs(m, |_| is_root = false);
                if is_root && seen.insert(m) {
                    visit(m);
                }
            });
        }
    }
    #[inline]
    fn children(&self, m: UpdateId, mut visit: impl FnMut(UpdateId)) {
        let middles = self.lattice.middles(&self.lattice.spot(m.0));
        middles.into_iter().filter_map(|id| self.update(id)).for_each(&mut visit);
    }
    #[inline]
    fn refine_around(
        &self,
        mesh: &mut FrontMesh,
        m: UpdateId,
        applied: impl Fn(UpdateId) -> bool,
        mut around: impl FnMut(Around),
    ) {
        let spot = self.lattice.spot(m.0);
        let apexes = self.lattice.apexes(&spot);
        mesh.refine(self, m, &spot, apexes);
        apexes.into_iter().filter_map(|id| self.update(id)).for_each(|m| around(Around::Closed(m)));
        // The middle of a new hypotenuse; what it needs besides m is as far beyond it as m is before it.
        for (middle, beyond) in self.lattice.middles(&spot).into_iter().zip(self.lattice.beyond_middles(&spot)) {
            let Some(middle) = self.update(middle) else { continue };
            if self.update(beyond).is_none_or(&applied) {
                around(Around::Opened(middle));
            }
        }
    }
    #[inline]
    fn needs(&self, _: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.for_needs(m, visit);
    }
    #[inline]
    fn refine(&self, mesh: &mut FrontMesh, m: UpdateId) {
        let spot = self.lattice.spot(m.0);
        mesh.refine(self, m, &spot, self.lattice.apexes(&spot));
    }
    #[inline]
    fn coarsen(&self, mesh: &mut FrontMesh, m: UpdateId) {
        mesh.coarsen(self, m);
    }
    fn cells(&self, mesh: &FrontMesh) -> usize {
        mesh.buffers.live_triangles()
    }
    #[inline]
    fn cells_added(&self, m: UpdateId) -> usize {
        let [a, b] = self.records[m.ix()].sides();
        usize::from(a) + usize::from(b)
    }
    fn floor_error(&self) -> f32 {
        self.floor_error
    }
}

impl RightTriangles {
    #[inline]
    fn for_needs(&self, m: UpdateId, mut visit: impl FnMut(UpdateId)) {
        let apexes = self.lattice.apexes(&self.lattice.spot(m.0));
        apexes.into_iter().filter_map(|id| self.update(id)).for_each(&mut visit);
    }
}

impl TriangleModel for RightTriangles {
    const MODEL: Model = Model::RightTriangles;

    fn stored(&self) -> Stored {
        Stored::RightTriangles(self.columns())
    }

    fn source(&self) -> SourceCounts {
        SourceCounts { vertices: self.vertices, triangles: self.triangles }
    }
    fn base_triangles(&self) -> usize {
        self.base.len()
    }
    fn bounds(&self) -> Bounds {
        self.bounds
    }
    fn memory_bytes(&self) -> usize {
        size_of_val(&self.records[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.base[..])
            + self.base_slots.capacity() * (size_of::<([i32; 2], usize)>() + 5)
    }
    /// The one in the middle of the hypotenuse.
    fn next_at(&self, mesh: &FrontMesh, triangle: u32) -> Option<UpdateId> {
        let [a, b, _] = mesh.buffers.live_triangle(triangle)?;
        let columns = self.lattice.columns as u32;
        let [a, b] =
            [a, b].map(|slot| mesh.samples()[slot as usize]).map(|sample| [sample % columns, sample / columns]);
        let [x, y] = [a[0] + b[0], a[1] + b[1]];
        let middle = if x % 2 == 0 && y % 2 == 0 { self.lattice.id(x as i32 / 2, y as i32 / 2) } else { None };
        middle.filter(|&id| self.is_update(id)).map(UpdateId)
    }
    fn has_colors(&self) -> bool {
        false
    }
    fn up(&self) -> Vec3 {
        Vec3::Z
    }
    /// The error: what counts on terrain is how high it is wrong.
    fn cost(&self, m: UpdateId) -> f32 {
        self.records[m.ix()].error()
    }
}
