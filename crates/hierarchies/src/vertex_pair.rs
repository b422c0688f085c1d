//! Vertex pairs: coarse to fine, a node s splits into two, u and v, whether an edge joins them or not (`elsana1999`; the
//! view-dependence trees of the tutorial `defloriani2002`). Any triangles go: non-manifold ones, many objects; parts join
//! and vanish as the mesh gets coarser.
//!
//! ```text
//!          M⁻                    M⁺
//!      o-------o             o-------o
//!       \     /               \     /
//!        \   /                 \   /          a forest of nodes; its leaves are the vertices of the source,
//!         (s)         ⇄         (u) (v)       its triangles are named by three leaves
//!        /   \                     /   \
//!       /     \                   /     \
//!      o-------o                 o-------o
//! ```
//!
//! In a front the corners of a triangle are the active ancestors of its three leaves. It comes with the update that
//! makes them three: the split of the deepest node that is above two of its leaves. Or with a later one, where it would lie on
//! another triangle. So how many triangles an update adds depends on nothing; and if none comes later, any cut of the
//! forest is a mesh.
//!
//! ## Implicit dependencies
//!
//! The paper numbers nodes as they are made, leaves first. A split is legal where the number of s is greater than
//! those of all its neighbours, a merge where the number of the *parent* s is less than those of the parents of all
//! neighbours of u and v. (The tutorial says "of the neighbours", whose numbers may well be those of leaves.) Here a
//! node goes by its *key*: the update that splits it, and for leaves what comes after all updates. Updates count
//! the merges backwards, so a split is legal where the key of s is *less* than those of its neighbours, and a merge where
//! all neighbours of u and v were made by updates before.
//!
//! Why that suffices: when the source was merged step by step, each node was there for a time, from the update that makes it to
//! its key. Neighbours in a front reached by legal steps have times that overlap: each legal step keeps it so. Three
//! times that overlap in pairs have a moment in common. So each cell of such a front is one that the sequence of merges
//! had; nothing is folded over that was not then, and the star of s at its split is the star that it had then: an error
//! measured at build time holds in all fronts.
//!
//! One thing the live triangles do not show. A split brings triangles with a corner w that is another node. It must be the
//! one that was there at the merge; but where no other triangle joins s and w, nobody sees that they are neighbours.
//! Such *hidden* needs are found by the replay and stored: the split needs what made w, and the split of w needs this one. On
//! surfaces whose topology stays there are none. The way back has no such case: what was split is live, and seen.
//!
//! [`Columns`] is what is stored; [`VertexPair::new`] validates it and derives what follows from it: the order of leaves,
//! bounding spheres, normal cones, hidden needs, vertex normals.

use crate::columns::base_bytes;
use crate::footprint::{Frame, PackedFootprint};
use crate::live::{Most, VertexLook, snorm16};
use crate::model::{Model, Progress, SourceCounts, Stored, TriangleModel};
use crate::quantize::Places;
use glam::Vec3;
use meshfront_mesh::{Bounds, TriangleMesh, VertexId};
use meshfront_refine::{Footprint, MultiTessellation, UpdateId};

mod columns;
mod derive;
mod forest;
mod front_mesh;
mod of_edges;
pub mod rules;

pub use crate::columns::InvalidColumns;
pub use crate::quantize::{Grid, Oct, round_error_up};
pub use columns::Columns;
pub use forest::Forest;
pub use front_mesh::FrontMesh;

/// The hierarchy in memory: 60 bytes per update at 16 bits and 12 per triangle of the source, which is 84 bytes per update on
/// surfaces, without source colours; 8 for each hidden need.
#[derive(Clone, Debug)]
pub struct VertexPair {
    base: TriangleMesh,
    base_normals: Vec<Oct>,
    roots: Vec<Root>,
    splits: Vec<Split>,
    /// By places of leaves; in the order of [`Columns::triangles`].
    triangles: Vec<[u32; 3]>,
    places: Places,
    /// Per update: the lower halves of [`Split::place`]; empty where 16 bits do.
    fine_places: Vec<[[u16; 3]; 2]>,
    grid: Option<Grid>,
    source_normals: bool,
    colors: Vec<[[u8; 4]; 2]>,
    costs: Vec<f32>,
    footprints: Vec<PackedFootprint>,
    frame: Frame,
    /// An update, and one that it needs though no live triangle shows it. Ascending.
    hidden: Vec<[UpdateId; 2]>,
    floor_error: f32,
    source: SourceCounts,
}

/// Who a node is: the update that splits it; for leaves the number of updates plus their place, which is their rank in
/// depth-first order.
pub type Key = u32;

/// A node of the base mesh.
#[derive(Clone, Copy, Debug)]
struct Root {
    key: Key,
    /// The place of the first leaf below it.
    first_leaf: u32,
}

/// What applying an update reads, besides its triangles.
#[derive(Clone, Copy, Debug)]
struct Split {
    /// The update that makes the node that this one splits, or [`Split::ROOT`] and the number of a base vertex.
    parent: u32,
    /// Of u and v.
    children: [Key; 2],
    /// The place of the first leaf below v: those of u lie before.
    middle: u32,
    /// Its first triangle. They end where the next update's begin.
    first: u32,
    /// Of u and v: the source's, or derived.
    normals: [Oct; 2],
    /// Where u and v are, see [`Places`].
    place: [[u16; 3]; 2],
}

impl Split {
    const ROOT: u32 = 1 << 31;
}

/// Where a node comes from.
#[derive(Clone, Copy, Debug)]
enum Origin {
    /// A vertex of the base mesh.
    Base(u32),
    /// Child 0 or 1 of an update.
    Child(UpdateId, usize),
}

impl VertexPair {
    /// Checks the columns, and derives what is not stored by undoing every split. Time is linear in the sizes of all
    /// stars (some two microseconds an update), memory in the number of updates and triangles.
    ///
    /// # Errors
    /// Any column that does not describe a hierarchy, with the update concerned. Never panics, whatever the content.
    pub fn new(columns: Columns) -> Result<VertexPair, InvalidColumns> {
        derive::derive(columns, &mut |_| {})
    }
    /// The same; `progress` is told which part of it is done, from 0 to 1.
    pub(crate) fn with_progress(columns: Columns, progress: Progress) -> Result<VertexPair, InvalidColumns> {
        derive::derive(columns, progress)
    }

    /// The columns as stored: `VertexPair::new(h.columns())` is `h` again.
    pub fn columns(&self) -> Columns {
        let updates = (0..self.splits.len() as u32).map(UpdateId);
        let node = |origin| match origin {
            Origin::Base(v) => VertexId(v),
            Origin::Child(m, which) => VertexId(self.base.positions.len() as u32 + 2 * m.0 + which as u32),
        };
        let mut leaves = vec![VertexId(0); self.base.positions.len() + self.splits.len()];
        let roots = self.roots.iter().enumerate().map(|(v, root)| (root.key, Origin::Base(v as u32)));
        let children = updates.clone().flat_map(|m| {
            let split = &self.splits[m.ix()];
            [0, 1].map(|which| (split.children[which], Origin::Child(m, which)))
        });
        for (key, origin) in roots.chain(children) {
            if let Some(place) = self.leaf(key) {
                leaves[place as usize] = node(origin);
            }
        }
        Columns {
            grid: self.grid,
            base: self.base.clone(),
            triangles: self.triangles.iter().map(|t| t.map(|place| leaves[place as usize])).collect(),
            added: updates.clone().map(|m| self.cells_added(m) as u32).collect(),
            vertex: updates.clone().map(|m| node(self.origin(m))).collect(),
            positions: updates.clone().map(|m| [0, 1].map(|which| self.place(m, which))).collect(),
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
        self.footprints[m.ix()].error
    }
    /// Needs that no live triangle shows: an update, and one that must be applied before. Ascending.
    pub fn hidden_needs(&self) -> &[[UpdateId; 2]] {
        &self.hidden
    }

    /// The place of a leaf; `None` for a node that is split.
    fn leaf(&self, key: Key) -> Option<u32> {
        key.checked_sub(self.splits.len() as u32)
    }
    /// The update that splits a node; `None` for a leaf.
    fn splitter(&self, key: Key) -> Option<UpdateId> {
        (key < self.splits.len() as u32).then_some(UpdateId(key))
    }
    /// Where the node that an update splits comes from.
    fn origin(&self, m: UpdateId) -> Origin {
        let parent = self.splits[m.ix()].parent;
        if parent & Split::ROOT != 0 {
            return Origin::Base(parent & !Split::ROOT);
        }
        let which = usize::from(self.splits[parent as usize].children[1] == m.0);
        Origin::Child(UpdateId(parent), which)
    }
    /// The update that makes the node that an update splits; `None` for nodes of the base mesh.
    fn parent(&self, m: UpdateId) -> Option<UpdateId> {
        let parent = self.splits[m.ix()].parent;
        (parent & Split::ROOT == 0).then_some(UpdateId(parent))
    }
    #[inline]
    fn place(&self, m: UpdateId, which: usize) -> Vec3 {
        self.places.join(self.splits[m.ix()].place[which], || self.fine_places[m.ix()][which])
    }
    /// The numbers of the triangles that an update adds.
    #[inline]
    fn added(&self, m: UpdateId) -> std::ops::Range<u32> {
        let end = self.splits.get(m.ix() + 1).map_or(self.triangles.len() as u32, |next| next.first);
        self.splits[m.ix()].first..end
    }
    fn look(&self, origin: Origin, level: u8) -> VertexLook {
        match origin {
            Origin::Base(v) => VertexLook {
                position: self.base.positions[v as usize],
                normal: snorm16(self.base_normals[v as usize].decode()),
                color: self.base.vertex.colors.get(v as usize).copied(),
                level,
            },
            Origin::Child(m, which) => VertexLook {
                position: self.place(m, which),
                normal: snorm16(self.splits[m.ix()].normals[which].decode()),
                color: self.colors.get(m.ix()).map(|c| c[which]),
                level,
            },
        }
    }
    fn most(&self) -> Most {
        Most { vertices: self.base.positions.len() + self.splits.len(), triangles: self.triangles.len() }
    }
}

impl MultiTessellation for VertexPair {
    type Mesh = FrontMesh;
    const READS_MESH: bool = true;

    fn len(&self) -> usize {
        self.splits.len()
    }
    fn base(&self) -> FrontMesh {
        FrontMesh::base(self)
    }
    #[inline]
    fn footprint(&self, m: UpdateId) -> Footprint {
        self.frame.unpack(&self.footprints[m.ix()])
    }
    fn roots(&self, visit: impl FnMut(UpdateId)) {
        self.roots.iter().filter_map(|root| self.splitter(root.key)).for_each(visit)
    }
    #[inline]
    fn children(&self, m: UpdateId, visit: impl FnMut(UpdateId)) {
        self.splits[m.ix()].children.iter().filter_map(|&key| self.splitter(key)).for_each(visit)
    }
    #[inline]
    fn needs(&self, mesh: &FrontMesh, m: UpdateId, mut visit: impl FnMut(UpdateId)) {
        let Some(s) = mesh.slot(m.0) else { return self.parent(m).into_iter().for_each(visit) };
        for t in mesh.star(s) {
            [t.after, t.before]
                .map(|x| mesh.key(x))
                .into_iter()
                .filter(|&x| x < m.0)
                .map(UpdateId)
                .for_each(&mut visit);
        }
        let hidden = self.hidden[self.hidden.partition_point(|pair| pair[0] < m)..].iter();
        hidden.take_while(|pair| pair[0] == m).for_each(|pair| visit(pair[1]));
    }
    #[inline]
    fn needed_by(&self, mesh: &FrontMesh, m: UpdateId, mut visit: impl FnMut(UpdateId)) {
        let children = self.splits[m.ix()].children;
        if let [Some(u), Some(v)] = children.map(|key| mesh.slot(key)) {
            for t in mesh.star(u).chain(mesh.star(v)) {
                [t.after, t.before].into_iter().filter_map(|x| mesh.maker(x)).filter(|&x| x > m).for_each(&mut visit);
            }
        } else {
            let split = children.into_iter().filter(|&key| mesh.slot(key).is_none());
            split.filter_map(|key| self.splitter(key)).for_each(&mut visit);
        }
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
        self.added(m).len()
    }
    fn floor_error(&self) -> f32 {
        self.floor_error
    }
}

impl TriangleModel for VertexPair {
    const MODEL: Model = Model::VertexPair;

    fn stored(&self) -> Stored {
        Stored::VertexPair(self.columns())
    }
    fn source(&self) -> SourceCounts {
        self.source
    }
    fn next_at(&self, mesh: &FrontMesh, triangle: u32) -> Option<UpdateId> {
        let corners = mesh.buffers.live_triangle(triangle)?;
        let splits = corners.into_iter().filter_map(|slot| self.splitter(mesh.key(slot)));
        splits.max_by(|&a, &b| self.error(a).total_cmp(&self.error(b)).then(b.cmp(&a)))
    }
    fn has_colors(&self) -> bool {
        !self.colors.is_empty() || !self.base.vertex.colors.is_empty()
    }
    fn bounds(&self) -> Bounds {
        self.frame.bounds()
    }
    /// Squared distance times area, of its own cells or of the worst update that needs it.
    fn cost(&self, m: UpdateId) -> f32 {
        self.costs[m.ix()]
    }
    fn memory_bytes(&self) -> usize {
        size_of_val(&self.roots[..])
            + size_of_val(&self.splits[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.fine_places[..])
            + size_of_val(&self.colors[..])
            + size_of_val(&self.costs[..])
            + size_of_val(&self.footprints[..])
            + size_of_val(&self.hidden[..])
            + size_of_val(&self.base_normals[..])
            + base_bytes(&self.base)
    }
    fn base_triangles(&self) -> usize {
        self.base.triangles.len()
    }
}
