//! What can be wrong with a file, and where.

use std::fmt;
use std::io;
use std::path::PathBuf;

use super::Format;

/// A file could not be read. Its message is one line: file, place, what is wrong, what to do about it.
#[derive(Debug)]
pub struct ReadError {
    /// The path as given, or the name that the bytes were read under.
    pub name: String,
    /// Where in the file.
    pub place: Place,
    /// What is wrong there.
    pub kind: ReadErrorKind,
}

/// A place in a file; offsets and lines count in the decompressed text where the file is a `.gz`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text format; the first is 1.
    Line(u64),
    /// A byte of a binary format; the first is 0.
    Byte(u64),
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadErrorKind {
    /// The operating system would not give the bytes.
    #[error("cannot be read: {0}")]
    Io(#[source] io::Error),
    /// The name does not tell the format.
    #[error("{0}")]
    UnknownFormat(#[source] UnknownFormat),
    /// Something else stands where the format wants something.
    #[error("expected {expected}, found {found}")]
    Unexpected {
        /// What the format wants here.
        expected: String,
        /// What is there: a short quotation.
        found: String,
    },
    /// The file ends too early.
    #[error("the file ends where {expected} should be; it was probably cut short: copy, download or export it again")]
    Truncated {
        /// What should have followed.
        expected: String,
    },
    /// A coordinate or height is NaN, infinite or too large for 32-bit floating point.
    #[error("{what} is not a finite 32-bit number; clean or rescale the data in the program that made it")]
    NotFinite {
        /// Which coordinate or height.
        what: &'static str,
    },
    /// A reference to an element that is not there.
    #[error("{what} {index} does not exist: there are {count}{}", if *.first == 1 { ", counted from 1" } else { ", counted from 0" })]
    IndexOutOfRange {
        /// The kind of element.
        what: &'static str,
        /// The index as the file has it.
        index: i64,
        /// How many elements there are.
        count: u64,
        /// The index of the first element: 0 or 1.
        first: u8,
    },
    /// A count is higher than the rest of the file can hold.
    #[error(
        "{promised} {what} are promised, but the {remaining} bytes that follow can hold no more than {most}; \
         the file was cut short or its header is damaged: copy, download or export it again"
    )]
    CountTooLarge {
        /// The kind of element.
        what: String,
        /// The count in the file.
        promised: u64,
        /// Bytes after the count.
        remaining: u64,
        /// How many fit into those.
        most: u64,
    },
    /// A legal file that uses something we do not read.
    #[error("{what} cannot be read; {remedy}")]
    Unsupported {
        /// What the file uses.
        what: String,
        /// What the user can do.
        remedy: &'static str,
    },
    /// An image that its decoder gives up on.
    #[error("the {what} is damaged ({why}); copy, download or export it again")]
    Damaged {
        /// The format.
        what: &'static str,
        /// What the decoder says.
        why: String,
    },
    /// Compressed data that is damaged.
    #[error("the gzip data is damaged ({0}); copy or download it again")]
    Gzip(#[source] io::Error),
    /// Compressed data that grows beyond belief.
    #[error(
        "inflates to more than {limit} bytes, {} times its size; if that is right, decompress it with gunzip first",
        super::MOST_INFLATION
    )]
    InflatesTooMuch {
        /// The most bytes that a file of its size may inflate to.
        limit: u64,
    },
    /// More vertices or triangles than 32-bit ids can name.
    #[error("has more {0} than 32 bits can count; split it into parts")]
    TooMany(&'static str),
    /// A height field without heights.
    #[error("all of its {samples} samples are missing; check the value that stands for missing ones")]
    NoHeights {
        /// Samples in the file.
        samples: u64,
    },
    /// Nothing to show.
    #[error("holds {vertices} vertices but no triangle{}", if *.vertices > 0 { "; a point cloud must be meshed first" } else { "" })]
    NoTriangles {
        /// Vertices in the file.
        vertices: u64,
    },
}

impl std::error::Error for ReadError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        std::error::Error::source(&self.kind)
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Place::File => write!(f, "{}: {}", self.name, self.kind),
            Place::Line(n) => write!(f, "{}, line {n}: {}", self.name, self.kind),
            Place::Byte(n) => write!(f, "{}, byte {n}: {}", self.name, self.kind),
        }
    }
}

/// A name whose ending is not a format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownFormat {
    /// The name has no ending.
    #[error("the name has no ending that tells the format: it should be one of {}", Format::ENDINGS)]
    NoEnding,
    /// The ending is of none of our formats.
    #[error("the ending .{ending} is not a known format: known are {}", Format::ENDINGS)]
    Ending {
        /// The ending without its dot, in lower case.
        ending: String,
    },
}

/// A mesh could not be written. Whatever was at the path before is still there, and nothing else.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The name does not tell the format.
    #[error("{}: {cause}", path.display())]
    UnknownFormat {
        /// The path as given.
        path: PathBuf,
        /// What is wrong with the name.
        cause: UnknownFormat,
    },
    /// There is a file, and no leave to replace it.
    #[error("{} exists already; choose another name or allow overwriting", path.display())]
    Exists {
        /// The path as given.
        path: PathBuf,
    },
    /// There is something at the path that a mesh must not replace: a folder, a device.
    #[error("{} exists and is not an ordinary file; choose another name", path.display())]
    NotAFile {
        /// The path as given.
        path: PathBuf,
    },
    /// The format can be read but not written, or not with so many elements.
    #[error("{}: {what}; {remedy}", path.display())]
    Unsupported {
        /// The path as given.
        path: PathBuf,
        /// What cannot be written.
        what: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// The operating system refused.
    #[error("{} cannot be written: {cause}", path.display())]
    Io {
        /// The path as given.
        path: PathBuf,
        /// The refusal.
        #[source]
        cause: io::Error,
    },
}

/// A [`ReadError`] that does not know its file yet.
#[derive(Debug)]
pub(super) struct Fail {
    pub place: Place,
    pub kind: ReadErrorKind,
}

impl Fail {
    /// About the whole file.
    pub fn file(kind: ReadErrorKind) -> Fail {
        Fail { place: Place::File, kind }
    }
    /// At a byte of a binary file.
    pub fn byte(at: usize, kind: ReadErrorKind) -> Fail {
        Fail { place: Place::Byte(at as u64), kind }
    }
    /// At a byte of a text file; counts the lines up to it.
    pub fn line(text: &[u8], at: usize, kind: ReadErrorKind) -> Fail {
        let newlines = text[..at.min(text.len())].iter().filter(|&&b| b == b'\n').count();
        Fail { place: Place::Line(newlines as u64 + 1), kind }
    }
}

/// A few bytes as a quotation for a message: printable, at most 24 characters.
pub(super) fn quote(bytes: &[u8]) -> String {
    const MOST: usize = 24;
    if bytes.is_empty() {
        return "nothing".to_owned();
    }
    let text: String = bytes.iter().take(MOST).flat_map(|&b| std::ascii::escape_default(b)).map(char::from).collect();
    format!("`{text}{}`", if bytes.len() > MOST { "…" } else { "" })
}
