//! What all models of triangle meshes have in common, and which of them there are.

pub use crate::columns::SourceCounts;
use crate::live::TriangleBuffers;
use crate::{EdgeCollapse, RightTriangles, VertexPair, VertexRemoval};
use crate::{edge_collapse, right_triangles, vertex_pair, vertex_removal};
use glam::Vec3;
use meshfront_mesh::Bounds;
use meshfront_refine::criteria::View;
use meshfront_refine::{
    AnyFront, Footprint, Member, MultiTessellation, Outcome, Owned, Request, UpdateId, Viewed, adapt_together,
};
use std::sync::Arc;

/// The models, by the name that they have everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Model {
    /// [`EdgeCollapse`]
    EdgeCollapse,
    /// [`RightTriangles`]
    RightTriangles,
    /// [`VertexRemoval`]
    VertexRemoval,
    /// [`VertexPair`]
    VertexPair,
}

impl Model {
    /// All of them.
    pub const ALL: [Model; 4] = [Model::EdgeCollapse, Model::RightTriangles, Model::VertexRemoval, Model::VertexPair];

    /// As on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Model::EdgeCollapse => "edge_collapse",
            Model::RightTriangles => "right_triangles",
            Model::VertexRemoval => "vertex_removal",
            Model::VertexPair => "vertex_pair",
        }
    }
    /// The model of such a name.
    pub fn of_name(name: &str) -> Option<Model> {
        Model::ALL.into_iter().find(|model| model.name() == name)
    }
}

/// The live mesh of a front.
pub trait LiveMesh {
    /// What is drawn.
    fn buffers(&self) -> &TriangleBuffers;
    /// The same, to clear its record of changes.
    fn buffers_mut(&mut self) -> &mut TriangleBuffers;
    /// Memory held, bytes: capacities, not sizes; without the list of changes, which lives for one frame.
    fn memory_bytes(&self) -> usize;
}

/// What every model of triangle meshes offers beside what the engine asks for.
pub trait TriangleModel: MultiTessellation<Mesh: LiveMesh> {
    /// Which one it is.
    const MODEL: Model;
    /// Sizes of the source.
    fn source(&self) -> SourceCounts;
    /// The box of all vertices of all levels.
    fn bounds(&self) -> Bounds;
    /// Triangles of the base mesh Γ₀.
    fn base_triangles(&self) -> usize;
    /// Whether vertices have colours.
    fn has_colors(&self) -> bool;
    /// Which way is up. Meshes do not say: as most scanners and modellers have it.
    fn up(&self) -> Vec3 {
        Vec3::Y
    }
    /// What leaving an update out costs the mesh as a whole, in the order that a mesh of a given number of cells takes
    /// them. What an update needs costs no less.
    fn cost(&self, m: UpdateId) -> f32;
    /// The update that would replace a live triangle: of those whose M⁻ it lies in, the one with the greatest error. That error
    /// is the one in force there. `None` where the triangle is one of the source's; a free slot has none either.
    ///
    /// The first call may take a pass over all updates, and keeps at most twelve bytes for each.
    fn next_at(&self, mesh: &Self::Mesh, triangle: u32) -> Option<UpdateId>;
    /// Memory of all columns, bytes; without what [`next_at`](TriangleModel::next_at) keeps.
    fn memory_bytes(&self) -> usize;
    /// What is to be stored of it.
    fn stored(&self) -> Stored;
}

/// A hierarchy of any model. [`with_model!`](crate::with_model) says what to do with whichever it is.
#[derive(Clone, Debug)]
pub enum Hierarchy {
    /// See [`EdgeCollapse`].
    EdgeCollapse(EdgeCollapse),
    /// See [`RightTriangles`].
    RightTriangles(RightTriangles),
    /// See [`VertexRemoval`].
    VertexRemoval(VertexRemoval),
    /// See [`VertexPair`].
    VertexPair(VertexPair),
}

/// What is stored of a hierarchy of any model.
#[derive(Clone, Debug, PartialEq)]
pub enum Stored {
    /// See [`edge_collapse::Columns`].
    EdgeCollapse(edge_collapse::Columns),
    /// See [`right_triangles::Columns`].
    RightTriangles(right_triangles::Columns),
    /// See [`vertex_removal::Columns`].
    VertexRemoval(vertex_removal::Columns),
    /// See [`vertex_pair::Columns`].
    VertexPair(vertex_pair::Columns),
}

/// Is told which part of the work is done, from 0 to 1.
pub type Progress<'a> = &'a mut dyn FnMut(f32);

/// After every so many updates of a replay, the greater part of the work of opening, it is told how far it is.
#[inline]
pub(crate) fn replayed(progress: Progress, m: usize, updates: usize) {
    if m.is_multiple_of(1 << 13) {
        progress(0.9 * m as f32 / updates as f32);
    }
}

/// Why stored columns are no hierarchy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidStored {
    /// Of a hierarchy of a mesh.
    #[error(transparent)]
    Mesh(#[from] edge_collapse::InvalidColumns),
    /// Of a terrain.
    #[error(transparent)]
    RightTriangles(#[from] right_triangles::InvalidHeights),
}

/// One expression for hierarchies of all models: it is compiled for each.
///
/// ```
/// # use meshfront_hierarchies::{Hierarchy, TriangleModel, with_model};
/// fn triangles(hierarchy: &Hierarchy) -> u32 {
///     with_model!(hierarchy, h => h.source().triangles)
/// }
/// ```
#[macro_export]
macro_rules! with_model {
    ($hierarchy:expr, $h:pat => $body:expr) => {
        match $hierarchy {
            $crate::Hierarchy::EdgeCollapse($h) => $body,
            $crate::Hierarchy::RightTriangles($h) => $body,
            $crate::Hierarchy::VertexRemoval($h) => $body,
            $crate::Hierarchy::VertexPair($h) => $body,
        }
    };
}

impl Stored {
    /// Which model it is.
    pub fn model(&self) -> Model {
        match self {
            Stored::EdgeCollapse(_) => Model::EdgeCollapse,
            Stored::RightTriangles(_) => Model::RightTriangles,
            Stored::VertexRemoval(_) => Model::VertexRemoval,
            Stored::VertexPair(_) => Model::VertexPair,
        }
    }
}

impl Hierarchy {
    /// Checks columns, and derives what is not stored.
    ///
    /// # Errors
    /// Columns that do not describe a hierarchy. Never panics, whatever the content.
    pub fn new(stored: Stored) -> Result<Hierarchy, InvalidStored> {
        Hierarchy::with_progress(stored, &mut |_| {})
    }
    /// The same; `progress` is told which part of it is done.
    ///
    /// # Errors
    /// As [`Hierarchy::new`].
    pub fn with_progress(stored: Stored, progress: Progress) -> Result<Hierarchy, InvalidStored> {
        Ok(match stored {
            Stored::EdgeCollapse(columns) => Hierarchy::EdgeCollapse(EdgeCollapse::with_progress(columns, progress)?),
            Stored::RightTriangles(columns) => {
                Hierarchy::RightTriangles(RightTriangles::with_progress(columns, progress)?)
            }
            Stored::VertexRemoval(columns) => {
                Hierarchy::VertexRemoval(VertexRemoval::with_progress(columns, progress)?)
            }
            Stored::VertexPair(columns) => Hierarchy::VertexPair(VertexPair::with_progress(columns, progress)?),
        })
    }
    /// The columns as stored.
    pub fn stored(&self) -> Stored {
        with_model!(self, h => h.stored())
    }
    /// Which model it is.
    pub fn model(&self) -> Model {
        fn of<H: TriangleModel>(_: &H) -> Model {
            H::MODEL
        }
        with_model!(self, h => of(h))
    }
    /// A front at the base mesh, that owns the hierarchy.
    pub fn into_front(self) -> Box<dyn AnySurface> {
        with_model!(self, h => Box::new(Owned::new(Arc::new(h))))
    }
    /// See [`TriangleModel::source`].
    pub fn source(&self) -> SourceCounts {
        with_model!(self, h => h.source())
    }
    /// See [`TriangleModel::bounds`].
    pub fn bounds(&self) -> Bounds {
        with_model!(self, h => h.bounds())
    }
    /// See [`TriangleModel::base_triangles`].
    pub fn base_triangles(&self) -> usize {
        with_model!(self, h => h.base_triangles())
    }
    /// See [`TriangleModel::has_colors`].
    pub fn has_colors(&self) -> bool {
        with_model!(self, h => h.has_colors())
    }
    /// See [`TriangleModel::up`].
    pub fn up(&self) -> Vec3 {
        with_model!(self, h => h.up())
    }
    /// See [`TriangleModel::memory_bytes`].
    pub fn memory_bytes(&self) -> usize {
        with_model!(self, h => TriangleModel::memory_bytes(h))
    }
    /// See [`MultiTessellation::floor_error`].
    pub fn floor_error(&self) -> f32 {
        with_model!(self, h => h.floor_error())
    }
    /// The greatest error of all updates, mesh units: that of the base mesh.
    pub fn base_error(&self) -> f32 {
        with_model!(self, h => base_error(h))
    }
    /// Number of updates. Looks at all ids.
    pub fn update_count(&self) -> usize {
        with_model!(self, h => h.updates().count())
    }
}

/// A front whose model is not known at compile time, with its mesh and what there is to know of its hierarchy.
pub trait AnySurface: AnyFront {
    /// What is drawn.
    fn buffers(&self) -> &TriangleBuffers;
    /// The same, to clear its record of changes.
    fn buffers_mut(&mut self) -> &mut TriangleBuffers;
    /// Memory of the front, bytes: its mesh and the engine's part.
    fn memory_bytes(&self) -> usize;
    /// As [`AnyFront::viewed_as`], for the criterion of a camera: compiled for it, without a virtual call per decision.
    fn viewed<'a>(&'a mut self, view: &'a View) -> Box<dyn Member + 'a>;
    /// As [`AnyFront::adapt`], for the criterion of a camera.
    fn adapt_to_view(&mut self, view: &View, request: &Request) -> Outcome {
        let mut me = self.viewed(view);
        adapt_together(&mut [&mut *me], request);
        me.outcome()
    }
    /// Another front of the same hierarchy, at the base mesh.
    fn another(&self) -> Box<dyn AnySurface>;
    /// Which model it is.
    fn model(&self) -> Model;
    /// See [`TriangleModel::source`].
    fn source(&self) -> SourceCounts;
    /// See [`TriangleModel::bounds`].
    fn bounds(&self) -> Bounds;
    /// See [`TriangleModel::base_triangles`].
    fn base_triangles(&self) -> usize;
    /// See [`TriangleModel::has_colors`].
    fn has_colors(&self) -> bool;
    /// See [`TriangleModel::up`].
    fn up(&self) -> Vec3;
    /// See [`MultiTessellation::floor_error`].
    fn floor_error(&self) -> f32;
    /// The greatest error of all updates, mesh units: that of the base mesh.
    fn base_error(&self) -> f32;
    /// Memory of the hierarchy, which other fronts may share, bytes.
    fn hierarchy_bytes(&self) -> usize;
    /// See [`TriangleModel::next_at`].
    fn next_at(&self, triangle: u32) -> Option<UpdateId>;
    /// See [`MultiTessellation::footprint`].
    fn footprint(&self, m: UpdateId) -> Footprint;
}

/// See [`Hierarchy::base_error`].
fn base_error<H: TriangleModel>(h: &H) -> f32 {
    // Errors never grow downwards.
    let mut worst = h.floor_error();
    h.roots(|m| worst = worst.max(h.footprint(m).error));
    worst
}

impl<H: TriangleModel + 'static> AnySurface for Owned<H> {
    fn buffers(&self) -> &TriangleBuffers {
        self.front.mesh().buffers()
    }
    fn buffers_mut(&mut self) -> &mut TriangleBuffers {
        self.front.mesh_mut().buffers_mut()
    }
    fn memory_bytes(&self) -> usize {
        self.front.memory() + self.front.mesh().memory_bytes()
    }
    fn viewed<'a>(&'a mut self, view: &'a View) -> Box<dyn Member + 'a> {
        Box::new(Viewed::new(&mut self.front, &*self.hierarchy, view))
    }
    fn another(&self) -> Box<dyn AnySurface> {
        Box::new(Owned::new(self.hierarchy.clone()))
    }
    fn model(&self) -> Model {
        H::MODEL
    }
    fn source(&self) -> SourceCounts {
        self.hierarchy.source()
    }
    fn bounds(&self) -> Bounds {
        self.hierarchy.bounds()
    }
    fn base_triangles(&self) -> usize {
        self.hierarchy.base_triangles()
    }
    fn has_colors(&self) -> bool {
        self.hierarchy.has_colors()
    }
    fn up(&self) -> Vec3 {
        self.hierarchy.up()
    }
    fn floor_error(&self) -> f32 {
        self.hierarchy.floor_error()
    }
    fn base_error(&self) -> f32 {
        base_error(&*self.hierarchy)
    }
    fn hierarchy_bytes(&self) -> usize {
        TriangleModel::memory_bytes(&*self.hierarchy)
    }
    fn next_at(&self, triangle: u32) -> Option<UpdateId> {
        self.hierarchy.next_at(self.front.mesh(), triangle)
    }
    fn footprint(&self, m: UpdateId) -> Footprint {
        self.hierarchy.footprint(m)
    }
}
