//! The `.front` file: bytes to validated hierarchy and back, for hierarchies of any model.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use meshfront_format::{WriteOptions, read, write};
//! let hierarchy = read("dragon.front")?;
//! write("copy.front", &hierarchy.stored(), &WriteOptions { overwrite: true })?;
//! # Ok(()) }
//! ```
//!
//! Without the feature `write` (a browser reads only) what is left compiles to
//! wasm: [`decode`] and [`inspect`] take bytes from anywhere. The layout is in `docs/format.md`; each model has a module
//! for its sections.

use meshfront_hierarchies::{Model, Stored};
use meshfront_mesh::TriangleMesh;

mod container;
pub mod edge_collapse;
mod error;
mod file;
mod info;
mod parallel;
mod rans;
pub mod right_triangles;
pub mod vertex_pair;
pub mod vertex_removal;

pub use container::{Codec, MAGIC, VERSION};
pub use error::ReadError;
#[cfg(feature = "write")]
pub use error::{EncodeError, WriteError};
#[cfg(feature = "write")]
pub use file::{WriteOptions, Written, write};
pub use file::{inspect_file, read};
pub use info::{ColumnInfo, Info, PageInfo, SectionInfo};
pub use meshfront_hierarchies::edge_collapse::round_error_up;

/// What is stored of a hierarchy, as the bytes of a file, whole.
///
/// # Errors
/// Columns that cannot be stored; see the modules of the models.
#[cfg(feature = "write")]
pub fn encode(stored: &Stored) -> Result<Vec<u8>, EncodeError> {
    match stored {
        Stored::EdgeCollapse(columns) => edge_collapse::encode(columns),
        Stored::RightTriangles(columns) => right_triangles::encode(columns),
        Stored::VertexRemoval(columns) => vertex_removal::encode(columns),
        Stored::VertexPair(columns) => vertex_pair::encode(columns),
    }
}

/// The columns of a file that lies in memory. `file` is what errors call it.
///
/// Every byte is covered by a checksum, and every number is checked before it is used or allocated for. Whether the
/// columns are a hierarchy is for `Hierarchy::new` to check.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn decode(bytes: &[u8], file: &str) -> Result<Stored, ReadError> {
    Ok(match model(bytes, file)? {
        Model::EdgeCollapse => Stored::EdgeCollapse(edge_collapse::decode(bytes, file)?),
        Model::RightTriangles => Stored::RightTriangles(right_triangles::decode(bytes, file)?),
        Model::VertexRemoval => Stored::VertexRemoval(vertex_removal::decode(bytes, file)?),
        Model::VertexPair => Stored::VertexPair(vertex_pair::decode(bytes, file)?),
    })
}

/// A surface from the first bytes of a file, to be shown while the rest arrives: the base mesh, which hierarchies of meshes have within
/// some tens of kilobytes, with a checksum of its own; of a terrain, whose base is little more than its corners, the heights that
/// come first, up to 16,384 of them.
///
/// `None` as long as the bytes do not reach, and where anything is wrong: [`decode`] tells what.
pub fn base(start: &[u8]) -> Option<TriangleMesh> {
    let (name, sections) = container::start(start, &["META", "MASK", "BASE", "BNRM", "BCOL", "HTAB"])?;
    match Model::of_name(name)? {
        Model::RightTriangles => right_triangles::base_of(&sections, container::start_of(start, "HGTS")?),
        Model::EdgeCollapse | Model::VertexPair => edge_collapse::base_of(&sections, 0),
        Model::VertexRemoval => edge_collapse::base_of(&sections, vertex_removal::CONNECTIVITY),
    }
}

/// The model of a file, from its first bytes.
pub fn model_of(start: &[u8]) -> Option<Model> {
    container::start(start, &[]).and_then(|(name, _)| Model::of_name(name))
}

/// What a file that lies in memory holds. `file` is what errors call it.
///
/// Every checksum is compared, so a file that is not as it was written gives an error; pages are not unpacked.
///
/// # Errors
/// [`ReadError`], with section and offset.
pub fn inspect(bytes: &[u8], file: &str) -> Result<Info, ReadError> {
    match model(bytes, file)? {
        Model::EdgeCollapse => edge_collapse::inspect(bytes, file),
        Model::RightTriangles => right_triangles::inspect(bytes, file),
        Model::VertexRemoval => vertex_removal::inspect(bytes, file),
        Model::VertexPair => vertex_pair::inspect(bytes, file),
    }
}

/// Which module reads a file.
fn model(bytes: &[u8], file: &str) -> Result<Model, ReadError> {
    let (name, _) = container::open_header(bytes, file)?;
    Model::of_name(name).ok_or_else(|| ReadError::UnknownModel {
        file: file.into(),
        model: name.into(),
        known: Model::ALL.map(Model::name).join(", "),
    })
}
