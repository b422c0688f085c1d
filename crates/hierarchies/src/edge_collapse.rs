//! Edge collapse: coarse to fine, a vertex s splits into two, u and v (`hoppe1996`), as a
//! Multi-Tessellation (`defloriani2002`): M⁻ is the whole star of s, M⁺ the stars of u and v.
//!
//! ```text
//!        M⁻                M⁺
//!     o-----w             o-----w
//!    / \   / \           / \   /|\
//!   o---(s)---o   ⇄     o--(u)  |(v)--o     the triangles (u, w, v) and (v, w', u) come and go,
//!    \ /   \ /           \ /   \|/         the others keep their number and change a corner
//!     o-----w'            o-----w'
//! ```
//!
//! Where Hoppe's vertex hierarchy asks for four faces, here *all* ring vertices must be live: a cell
//! then has the same three corners in every front, so that an error measured at build time holds
//! in all fronts, whatever the order of updates. The price is more dependencies.
//!
//! [`Columns`] is what is stored; [`EdgeCollapse::new`] validates it by replaying all splits, and
//! derives what follows from it: needs, children, bounding spheres, normal cones, vertex normals.

use crate::counts::Needed;
use crate::footprint::{Frame, PackedFootprint};
use crate::live::{Most, VertexLook, snorm16};
use crate::model::{Model, Progress, SourceCounts, Stored, TriangleModel};
use crate::next::Next;
use crate::quantize::Places;
use glam::Vec3;
use meshfront_mesh::{Bounds, TriangleMesh, VertexId};
use meshfront_refine::{Around, Footprint, MultiTessellation, UpdateId};

mod columns;
mod derive;
mod encode;
mod front_mesh;

pub use crate::columns::InvalidColumns;
use crate::columns::base_bytes;
pub use crate::quantize::{Grid, Oct, round_error_up};
pub use columns::{AddedTriangle, Columns, ExplicitSplit};
pub use encode::{EncodedSplit, StarTriangle, encode_split};
pub use front_mesh::FrontMesh;

/// The hierarchy in memory: at most 80 bytes per update at 16 bits, all columns together, without
/// source normals or colours.
#[derive(Clone, Debug)]
pub struct EdgeCollapse {
    base: TriangleMesh,
    base_normals: Vec<Oct>,
    splits: Vec<Split>,
    explicit: Vec<ExplicitSplit>,
    /// First triangle number of an explicit split's third added triangle, parallel to `explicit`.
    explicit_extra: Vec<u32>,
    places: Places,
    /// Per update: the lower halves of [`Split::place`]; empty where 16 bits do.
    fine_places: Vec<[[u16; 3]; 2]>,
    grid: Option<Grid>,
    source_normals: bool,
    colors: Vec<[[u8; 4]; 2]>,
    costs: Vec<f32>,
    /// One more than there are updates: lists end where the next one's begin.
    nodes: Vec<Node>,
    frame: Frame,
    /// Per update, ascending: what it needs, and then what needs it.
    neighbours: Vec<UpdateId>,
    needed: Needed,
    roots: Vec<UpdateId>,
    floor_error: f32,
    source: SourceCounts,
    /// Of the front with everything applied.
    most: Most,
    /// By vertex.
    next: Next,
}

/// What applying an update reads, in half a cache line.
#[derive(Clone, Copy, Debug)]
struct Split {
    /// See [`Columns::vertex`].
    vertex: VertexId,
    /// See [`Columns::sides`].
    sides: u32,
    /// Of u and v: the source's, or derived.
    normals: [Oct; 2],
    /// Where u and v are, see [`Places`].
    place: [[u16; 3]; 2],
    /// How many splits lie above the vertex, up to 255.
    level: u8,
    /// How many triangles the update adds.
    added: u8,
    /// Where they follow from the sides: indices in the star of those that end at a gap, see [`gaps`](front_mesh::gaps).
    gaps: [u8; 2],
}

/// What deciding on an update reads.
#[derive(Clone, Copy, Debug)]
struct Node {
    footprint: PackedFootprint,
    /// Where the lists of this update begin in `neighbours`.
    first: u32,
    /// How many it needs.
    needs: u8,
}

impl EdgeCollapse {
    /// Checks the columns by replaying every split, and derives what is not stored. Time and memory are linear
    /// in the number of updates (about a microsecond each).
    ///
    /// # Errors
    /// Any column that does not describe a hierarchy, with the update concerned. Never panics, whatever the content.
    pub fn new(columns: Columns) -> Result<EdgeCollapse, InvalidColumns> {
        derive::derive(columns, &mut |_| {})
    }
    /// The same; `progress` is told which part of it is done, from 0 to 1.
    pub(crate) fn with_progress(columns: Columns, progress: Progress) -> Result<EdgeCollapse, InvalidColumns> {
        derive::derive(columns, progress)
    }

    /// The columns as stored: `EdgeCollapse::new(h.columns())` is `h` again.
    pub fn columns(&self) -> Columns {
        let updates = (0..self.splits.len() as u32).map(UpdateId);
        Columns {
            grid: self.grid,
            base: self.base.clone(),
            vertex: self.splits.iter().map(|s| s.vertex).collect(),
            sides: self.splits.iter().map(|s| s.sides).collect(),
            explicit: self.explicit.clone(),
            positions: updates.clone().map(|m| self.places(m)).collect(),
            normals: if self.source_normals { self.splits.iter().map(|s| s.normals).collect() } else { vec![] },
            colors: self.colors.clone(),
            errors: updates.map(|m| self.error(m)).collect(),
            floor_error: self.floor_error,
            source: self.source,
        }
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
    /// Direct needs of an update, ascending; what follows by transitivity may be left out. And the updates that need it
    /// directly, ascending.
    #[inline]
    fn neighbours_of(&self, m: UpdateId) -> (&[UpdateId], &[UpdateId]) {
        let [node, next] = [&self.nodes[m.ix()], &self.nodes[m.ix() + 1]];
        self.neighbours[node.first as usize..next.first as usize].split_at(node.needs.into())
    }

    /// Where u and v are.
    fn places(&self, m: UpdateId) -> [Vec3; 2] {
        [0, 1].map(|which| self.place(m.ix(), which))
    }
    #[inline]
    fn place(&self, m: usize, which: usize) -> Vec3 {
        self.places.join(self.splits[m].place[which], || self.fine_places[m][which])
    }
    fn base_vertices(&self) -> u32 {
        self.base.positions.len() as u32
    }
    /// The update whose split makes a vertex; `None` for a base vertex.
    fn maker(&self, v: VertexId) -> Option<UpdateId> {
        v.0.checked_sub(self.base_vertices()).map(|k| UpdateId(k / 2))
    }
    /// Child 0 or 1 of an update.
    fn child(&self, m: UpdateId, which: u32) -> VertexId {
        VertexId(self.base_vertices() + 2 * m.0 + which)
    }
    /// Index into `explicit`, where the update's added triangles are listed.
    fn explicit_index(&self, m: UpdateId) -> Option<usize> {
        if self.splits[m.ix()].sides & Columns::EXPLICIT == 0 {
            return None;
        }
        self.explicit.binary_search_by_key(&m, |e| e.update).ok()
    }
    /// Number of the `j`-th triangle that an update adds.
    fn added_number(&self, m: UpdateId, explicit: Option<usize>, j: usize) -> u32 {
        match (explicit, j) {
            (Some(e), 2..) => self.explicit_extra[e] + (j - 2) as u32,
            _ => self.base.triangles.len() as u32 + 2 * m.0 + j as u32,
        }
    }
    fn vertex_look(&self, v: VertexId, level: u8) -> VertexLook {
        match self.maker(v) {
            None => VertexLook {
                position: self.base.positions[v.ix()],
                normal: snorm16(self.base_normals[v.ix()].decode()),
                color: self.base.vertex.colors.get(v.ix()).copied(),
                level,
            },
            Some(m) => {
                let which = ((v.0 - self.base_vertices()) & 1) as usize;
                VertexLook {
                    position: self.place(m.ix(), which),
                    normal: snorm16(self.splits[m.ix()].normals[which].decode()),
                    color: self.colors.get(m.ix()).map(|c| c[which]),
                    level,
                }
            }
        }
    }
}

impl MultiTessellation for EdgeCollapse {
    type Mesh = FrontMesh;

    fn len(&self) -> usize {
        self.splits.len()
    }
    fn base(&self) -> FrontMesh {
        FrontMesh::base(self)
    }
    fn reset(&self, mesh: &mut FrontMesh) {
        mesh.reset(self);
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
        self.neighbours_of(m).1.iter().copied().for_each(visit)
    }
    #[inline]
    fn needs(&self, _: &FrontMesh, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.neighbours_of(m).0.iter().copied().for_each(visit)
    }
    #[inline]
    fn refine(&self, mesh: &mut FrontMesh, m: UpdateId) {
        mesh.refine(self, m, |_| ())
    }
    #[inline]
    fn coarsen(&self, mesh: &mut FrontMesh, m: UpdateId) {
        mesh.coarsen(self, m, |_| ())
    }
    #[inline]
    fn refine_around(
        &self,
        mesh: &mut FrontMesh,
        m: UpdateId,
        _: impl Fn(UpdateId) -> bool,
        around: impl FnMut(Around),
    ) {
        mesh.refine(self, m, around)
    }
    #[inline]
    fn coarsen_around(
        &self,
        mesh: &mut FrontMesh,
        m: UpdateId,
        _: impl Fn(UpdateId) -> bool,
        around: impl FnMut(Around),
    ) {
        mesh.coarsen(self, m, around)
    }
    fn cells(&self, mesh: &FrontMesh) -> usize {
        mesh.buffers.live_triangles()
    }
    #[inline]
    fn cells_added(&self, m: UpdateId) -> usize {
        self.splits[m.ix()].added as usize
    }
    fn floor_error(&self) -> f32 {
        self.floor_error
    }
}

impl TriangleModel for EdgeCollapse {
    const MODEL: Model = Model::EdgeCollapse;

    fn stored(&self) -> Stored {
        Stored::EdgeCollapse(self.columns())
    }

    fn source(&self) -> SourceCounts {
        self.source
    }
    fn next_at(&self, mesh: &FrontMesh, triangle: u32) -> Option<UpdateId> {
        let corners = mesh.buffers.live_triangle(triangle)?;
        let vertices = self.base.positions.len() + 2 * self.splits.len();
        let splits = corners.into_iter().filter_map(|slot| {
            self.next.of(mesh.id(slot).ix(), vertices, |say| {
                self.splits.iter().zip(0..).for_each(|(split, m)| say(split.vertex.ix(), m));
            })
        });
        splits.max_by(|&a, &b| self.error(a).total_cmp(&self.error(b)).then(b.cmp(&a)))
    }
    fn has_colors(&self) -> bool {
        !self.colors.is_empty() || !self.base.vertex.colors.is_empty()
    }
    fn bounds(&self) -> Bounds {
        self.frame.bounds()
    }
    /// Squared distance times area, of its own cells or of the worst update that needs it. Where the error says how far
    /// the worst point is, this says which of two updates does more for the mean.
    fn cost(&self, m: UpdateId) -> f32 {
        self.costs[m.ix()]
    }
    fn memory_bytes(&self) -> usize {
        let explicit: usize =
            self.explicit.iter().map(|e| size_of::<ExplicitSplit>() + size_of_val(&e.added[..]) + 4).sum();
        explicit
            + size_of_val(&self.neighbours[..])
            + self.needed.memory_bytes()
            + size_of_val(&self.fine_places[..])
            + size_of_val(&self.splits[..])
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
