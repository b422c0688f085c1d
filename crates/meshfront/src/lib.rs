//! Multiresolution meshes. A mesh too large to draw becomes one *hierarchy*; every viewer and every frame takes from
//! it the small mesh that looks the same from there, and the hierarchy says how wrong it is.
//!
//! ```
//! use meshfront::{EdgeCollapseOptions, Request, Uniform, edge_collapse, extract, mesh::sample};
//!
//! let source = sample::knot(5_000); // or mesh::read("scan.ply")?.mesh
//! let hierarchy = edge_collapse(&source, &EdgeCollapseOptions::default(), &())?;
//! let coarse = extract(&hierarchy, &Uniform, &Request::tolerance(0.02));
//! assert!(coarse.mesh.triangles.len() < source.triangles.len() / 2);
//! assert!(coarse.error <= 0.02); // mesh units, measured when the hierarchy was built
//! # Ok::<(), meshfront::simplify::BuildError>(())
//! ```
//!
//! The rooms, in the order of the data: [`mesh`] reads and writes, [`simplify`] makes a hierarchy, [`hierarchies`] holds
//! it, [`mod@format`] stores it, [`refine`] follows a viewer through it. This crate adds what is done with all of them:
//! [`extract()`] a mesh, [`compare()`] surfaces, [`survey()`] a mesh, and the [`fly_by`] that engines are measured on.

pub use meshfront_format as format;
pub use meshfront_hierarchies as hierarchies;
pub use meshfront_mesh as mesh;
pub use meshfront_refine as refine;
#[cfg(feature = "simplify")]
pub use meshfront_simplify as simplify;

#[cfg(feature = "compare")]
pub mod compare;
#[cfg(all(feature = "compare", feature = "simplify"))]
pub mod dependencies;
pub mod extract;
pub mod fly_by;
pub mod survey;

#[cfg(feature = "compare")]
pub use compare::{CompareOptions, Comparison, compare};
pub use extract::{Everything, Extracted, extract, extract_cells, finest, promised_error};
pub use survey::{Survey, survey};

pub use meshfront_hierarchies::{
    AnySurface, EdgeCollapse, Hierarchy, LiveMesh, Model, RightTriangles, Stored, TriangleModel, VertexPair, with_model,
};
pub use meshfront_mesh::{HeightField, TriangleMesh};
pub use meshfront_refine::criteria::Uniform;
pub use meshfront_refine::{Camera, Front, Outcome, Request, Step, ViewOptions, view};
#[cfg(feature = "simplify")]
pub use meshfront_simplify::{
    EdgeCollapseOptions, RightTrianglesOptions, VertexPairOptions, edge_collapse, right_triangles, vertex_pair,
};
