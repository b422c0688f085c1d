//! Vertex removal: coarse to fine, a vertex v is inserted into a polygon (`defloriani1997`), as a
//! Multi-Tessellation (`defloriani2002`): M⁻ triangulates the polygon, M⁺ is the fan of v.
//!
//! ```text
//!         M⁻                  M⁺
//!      o-----o             o-----o
//!     /|\     \           / \   / \
//!    o | \     o    ⇄    o---(v)---o      at a boundary v lies on it, and the fan is open there
//!     \|   \  /           \ /   \ /
//!      o-----o             o-----o
//! ```
//!
//! Cells never change: each is made by one update, or is in the base mesh, and goes with one update. So an update needs
//! just what made the cells of its M⁻ — the order of the tutorial, with no dependency more — and an error measured at build
//! time holds in all fronts. The vertices of all levels are those of the source.
//!
//! [`Columns`] is what is stored; [`VertexRemoval::new`] validates it by replaying all insertions, and
//! derives what follows from it: the cells of M⁻, children, bounding spheres, normal cones, vertex normals.

use crate::footprint::{Frame, PackedFootprint};
use crate::live::{Most, VertexLook, snorm16};
use crate::model::{Model, Progress, Stored, TriangleModel};
use crate::next::Next;
use crate::quantize::Places;
use glam::Vec3;
use meshfront_mesh::{Bounds, TriangleMesh, VertexId};
use meshfront_refine::{Footprint, MultiTessellation, UpdateId};

mod columns;
mod derive;
pub mod encode;
mod front_mesh;
mod polygon;

use crate::columns::base_bytes;
pub use crate::columns::{InvalidColumns, SourceCounts};
pub use crate::quantize::{Grid, Oct, round_error_up};
pub use columns::{Columns, Patch};
pub use encode::Connectivity;
pub use front_mesh::FrontMesh;
pub use polygon::{MOST_CORNERS, Triangles, Triangulation};

/// The hierarchy in memory: at most 80 bytes per update at 16 bits, all columns together, without source colours.
#[derive(Clone, Debug)]
pub struct VertexRemoval {
    base: TriangleMesh,
    base_normals: Vec<Oct>,
    insertions: Vec<Insertion>,
    /// Cells of M⁻ of all updates, end to end, in the order of the triangulation.
    minus: Vec<CellCorner>,
    places: Places,
    /// Per update: the lower halves of [`Insertion::place`]; empty where 16 bits do.
    fine_places: Vec<[u16; 3]>,
    grid: Option<Grid>,
    connectivity: Connectivity,
    source_normals: bool,
    colors: Vec<[u8; 4]>,
    costs: Vec<f32>,
    /// One more than there are updates: lists end where the next one's begin.
    nodes: Vec<Node>,
    frame: Frame,
    children: Vec<UpdateId>,
    roots: Vec<UpdateId>,
    floor_error: f32,
    source: SourceCounts,
    most: Most,
    /// By cell.
    next: Next,
}

/// What applying an update reads, besides its cells.
#[derive(Clone, Copy, Debug)]
struct Insertion {
    /// Of the vertex: the source's, or derived.
    normal: Oct,
    /// Where the vertex is, see [`Places`].
    place: [u16; 3],
    triangulation: Triangulation,
    /// See [`Patch::boundary`].
    boundary: bool,
    /// The length of the longest chain of needs, up to 255.
    level: u8,
}

impl Insertion {
    /// Number of cells of M⁺.
    #[inline]
    fn fan(&self) -> usize {
        self.triangulation.corners as usize - usize::from(self.boundary)
    }
}

/// What deciding on an update reads.
#[derive(Clone, Copy, Debug)]
struct Node {
    footprint: PackedFootprint,
    /// Where the lists of this update begin in `minus` and in `children`.
    minus: u32,
    children: u32,
}

/// A cell, and which of its corners is the first of its triangle in the triangulation.
#[derive(Clone, Copy, Debug)]
struct CellCorner(u32);

impl CellCorner {
    fn new(number: u32, first: u32) -> CellCorner {
        CellCorner(number << 2 | first)
    }
    #[inline]
    fn number(self) -> u32 {
        self.0 >> 2
    }
    #[inline]
    fn first(self) -> usize {
        self.0 as usize & 3
    }
}

impl VertexRemoval {
    /// Checks the columns by replaying every insertion, and derives what is not stored. Time and memory are linear
    /// in the number of updates (about a microsecond each).
    ///
    /// # Errors
    /// Any column that does not describe a hierarchy, with the update concerned. Never panics, whatever the content.
    pub fn new(columns: Columns) -> Result<VertexRemoval, InvalidColumns> {
        derive::derive(columns, &mut |_| {})
    }
    /// The same; `progress` is told which part of it is done, from 0 to 1.
    pub(crate) fn with_progress(columns: Columns, progress: Progress) -> Result<VertexRemoval, InvalidColumns> {
        derive::derive(columns, progress)
    }

    /// The columns as stored: `VertexRemoval::new(h.columns())` is `h` again.
    pub fn columns(&self) -> Columns {
        let updates = (0..self.insertions.len() as u32).map(UpdateId);
        let patch = |m: UpdateId| {
            let Insertion { triangulation, boundary, .. } = self.insertions[m.ix()];
            let root = self.minus_of(m)[0];
            Patch { cell: root.number(), edge: (root.first() as u8 + 2) % 3, boundary, triangulation }
        };
        Columns {
            grid: self.grid,
            base: self.base.clone(),
            patches: updates.clone().map(patch).collect(),
            positions: updates.clone().map(|m| self.place(m)).collect(),
            normals: if self.source_normals { self.insertions.iter().map(|s| s.normal).collect() } else { vec![] },
            colors: self.colors.clone(),
            errors: updates.map(|m| self.error(m)).collect(),
            floor_error: self.floor_error,
            source: self.source,
            connectivity: self.connectivity,
        }
    }
    /// How its file says which triangulations they are.
    pub fn connectivity(&self) -> Connectivity {
        self.connectivity
    }

    /// The base mesh Γ₀.
    pub fn base_mesh(&self) -> &TriangleMesh {
        &self.base
    }
    /// How positions are quantized; `None` where they are not.
    pub fn grid(&self) -> Option<Grid> {
        self.grid
    }
    /// Whether the source had normals of its own. Live meshes always have normals: derived ones else.
    pub fn has_source_normals(&self) -> bool {
        self.source_normals
    }
    /// The error of an update: see [`Footprint::error`].
    pub fn error(&self, m: UpdateId) -> f32 {
        self.nodes[m.ix()].footprint.error
    }
    /// Updates that need an update directly, ascending; those that need it through another one may be left out.
    pub fn children_of(&self, m: UpdateId) -> &[UpdateId] {
        &self.children[self.nodes[m.ix()].children as usize..self.nodes[m.ix() + 1].children as usize]
    }
    /// The polygon of each update: its triangulation M⁻, and whether its vertex lies on the boundary.
    pub fn triangulations(&self) -> impl Iterator<Item = (Triangulation, bool)> {
        self.insertions.iter().map(|s| (s.triangulation, s.boundary))
    }

    /// The vertex that an update inserts.
    fn vertex(&self, m: UpdateId) -> VertexId {
        VertexId(self.base.positions.len() as u32 + m.0)
    }
    #[inline]
    fn place(&self, m: UpdateId) -> Vec3 {
        self.places.join(self.insertions[m.ix()].place, || self.fine_places[m.ix()])
    }
    #[inline]
    fn first_cell(&self, m: UpdateId) -> u32 {
        Columns::first_cell(self.base.triangles.len(), m.0)
    }
    /// The update that makes a cell; `None` for a base triangle.
    #[inline]
    fn maker(&self, cell: CellCorner) -> Option<UpdateId> {
        Columns::cell_maker(self.base.triangles.len(), cell.number()).ok().map(|(m, _)| UpdateId(m))
    }
    #[inline]
    fn minus_of(&self, m: UpdateId) -> &[CellCorner] {
        &self.minus[self.nodes[m.ix()].minus as usize..self.nodes[m.ix() + 1].minus as usize]
    }
    fn vertex_look(&self, v: VertexId) -> VertexLook {
        match v.ix().checked_sub(self.base.positions.len()) {
            None => VertexLook {
                position: self.base.positions[v.ix()],
                normal: snorm16(self.base_normals[v.ix()].decode()),
                color: self.base.vertex.colors.get(v.ix()).copied(),
                level: 0,
            },
            Some(m) => VertexLook {
                position: self.place(UpdateId(m as u32)),
                normal: snorm16(self.insertions[m].normal.decode()),
                color: self.colors.get(m).copied(),
                level: self.insertions[m].level,
            },
        }
    }
}

impl MultiTessellation for VertexRemoval {
    type Mesh = FrontMesh;

    fn len(&self) -> usize {
        self.insertions.len()
    }
    fn base(&self) -> FrontMesh {
        FrontMesh::base(self)
    }
    #[inline]
    fn footprint(&self, m: UpdateId) -> Footprint {
        self.frame.unpack(&self.nodes[m.ix()].footprint)
    }
    fn roots(&self, visit: impl FnMut(UpdateId)) {
        self.roots.iter().copied().for_each(visit)
    }
    #[inline]
    fn children(&self, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.children_of(m).iter().copied().for_each(visit)
    }
    /// What made the cells of M⁻, an update perhaps more than once.
    #[inline]
    fn needs(&self, _: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.minus_of(m).iter().filter_map(|&cell| self.maker(cell)).for_each(visit)
    }
    #[inline]
    fn refine(&self, mesh: &mut FrontMesh, m: UpdateId) {
        mesh.refine(self, m)
    }
    #[inline]
    fn coarsen(&self, mesh: &mut FrontMesh, m: UpdateId) {
        mesh.coarsen(self, m)
    }
    fn cells(&self, mesh: &FrontMesh) -> usize {
        mesh.buffers.live_triangles()
    }
    #[inline]
    fn cells_added(&self, m: UpdateId) -> usize {
        2 - usize::from(self.insertions[m.ix()].boundary)
    }
    fn floor_error(&self) -> f32 {
        self.floor_error
    }
}

impl TriangleModel for VertexRemoval {
    const MODEL: Model = Model::VertexRemoval;

    fn stored(&self) -> Stored {
        Stored::VertexRemoval(self.columns())
    }
    fn source(&self) -> SourceCounts {
        self.source
    }
    fn next_at(&self, mesh: &FrontMesh, triangle: u32) -> Option<UpdateId> {
        let cell = mesh.cell(self, triangle)?;
        let cells = self.first_cell(UpdateId(self.insertions.len() as u32)) as usize;
        self.next.of(cell as usize, cells, |say| {
            let updates = (0..self.insertions.len() as u32).map(UpdateId);
            updates.for_each(|m| self.minus_of(m).iter().for_each(|cell| say(cell.number() as usize, m.0)));
        })
    }
    fn has_colors(&self) -> bool {
        !self.colors.is_empty() || !self.base.vertex.colors.is_empty()
    }
    fn bounds(&self) -> Bounds {
        self.frame.bounds()
    }
    fn cost(&self, m: UpdateId) -> f32 {
        self.costs[m.ix()]
    }
    fn memory_bytes(&self) -> usize {
        size_of_val(&self.minus[..])
            + size_of_val(&self.children[..])
            + size_of_val(&self.fine_places[..])
            + size_of_val(&self.insertions[..])
            + size_of_val(&self.colors[..])
            + size_of_val(&self.costs[..])
            + size_of_val(&self.nodes[..])
            + size_of_val(&self.roots[..])
            + size_of_val(&self.base_normals[..])
            + base_bytes(&self.base)
    }
    fn base_triangles(&self) -> usize {
        self.base.triangles.len()
    }
}
