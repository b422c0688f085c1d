//! What can go wrong, by cause.

use std::path::PathBuf;

use meshfront_hierarchies::InvalidStored;
#[cfg(feature = "write")]
use meshfront_hierarchies::edge_collapse::InvalidColumns;
#[cfg(feature = "write")]
use meshfront_hierarchies::right_triangles::InvalidHeights;

/// Why a `.front` file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The operating system did not give the bytes.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file does not start as a `.front` file does.
    #[error("{file}: not a .front file; `meshfront build {file} -o OUT.front` makes one from a mesh")]
    NotFront {
        /// The file.
        file: String,
    },
    /// The file is of a version that this reader does not know.
    #[error("{file}: .front version {found}, this program reads up to version {known}; update Meshfront to read it")]
    NewerVersion {
        /// The file.
        file: String,
        /// The file's version.
        found: u32,
        /// The newest version that is known here.
        known: u32,
    },
    /// The file holds a hierarchy of another model.
    #[error("{file}: holds a hierarchy of model `{model}`, this program knows {known}; update Meshfront to read it")]
    UnknownModel {
        /// The file.
        file: String,
        /// The file's model.
        model: String,
        /// The models that are known here.
        known: String,
    },
    /// The file needs an ability that this reader does not have: a section, a codec or a flag.
    #[error("{file}: section `{section}` needs {what}, which this program does not know; update Meshfront to read it")]
    UnknownPart {
        /// The file.
        file: String,
        /// Four letters of the section, or `header`.
        section: String,
        /// What is unknown about it.
        what: String,
    },
    /// The file is shorter or longer than it says.
    #[error("{file}: {found} bytes long, {expected} expected; it was cut off or added to: copy or build it again")]
    Length {
        /// The file.
        file: String,
        /// Its length.
        found: u64,
        /// The length that its header tells, or the least that a file has.
        expected: u64,
    },
    /// A byte is not as it was written, or was never right.
    #[error("{file}: section `{section}`, byte {offset}: {reason}; the file is damaged: copy or build it again")]
    Damaged {
        /// The file.
        file: String,
        /// Four letters of the section, or `header`.
        section: &'static str,
        /// Where in the file the damaged part starts.
        offset: u64,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The columns are whole, but do not describe a hierarchy.
    #[error("{file}: {source}; the program that wrote this file made a mistake: build it again")]
    Hierarchy {
        /// The file.
        file: String,
        /// The column or update concerned.
        source: InvalidStored,
    },
}

/// Why columns cannot be stored.
#[cfg(feature = "write")]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EncodeError {
    /// The columns do not describe a hierarchy.
    #[error(transparent)]
    Columns(#[from] InvalidColumns),
    /// The heights are no terrain.
    #[error(transparent)]
    Heights(#[from] InvalidHeights),
    /// The grid cannot hold any position.
    #[error("grid: {0}")]
    Grid(&'static str),
    /// A position is not a point of the grid.
    #[error("vertex {vertex} does not lie on the grid: snap positions with `Grid::snap`, or store them lossless")]
    OffGrid {
        /// The vertex.
        vertex: u32,
    },
}

/// Why a `.front` file could not be written.
#[cfg(feature = "write")]
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// There is such a file already, and it was not asked to be replaced.
    #[error("{}: exists already; choose another name, or ask for it to be replaced (--force)", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The operating system did not take the bytes.
    #[error("{}: cannot be written: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The hierarchy cannot be stored.
    #[error(transparent)]
    Encode(#[from] EncodeError),
}

/// A damaged place, before it is known which file it is in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fault {
    pub(crate) section: &'static str,
    pub(crate) offset: usize,
    pub(crate) reason: &'static str,
}

impl Fault {
    pub(crate) fn in_file(self, file: &str) -> ReadError {
        let Fault { section, offset, reason } = self;
        ReadError::Damaged { file: file.to_owned(), section, offset: offset as u64, reason }
    }
}
