//! The `.front` file: bytes to validated hierarchy and back.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use meshfront_format::{WriteOptions, read, write};
//! let hierarchy = read("dragon.front")?;
//! write("copy.front", &hierarchy, &WriteOptions { overwrite: true })?;
//! # Ok(()) }
//! ```
//!
//! Without the feature `write` (a browser reads only) what is left compiles to
//! wasm: [`decode`] and [`inspect`] take bytes from anywhere. The layout is in `docs/format.md`.

mod container;
mod edge_collapse;
mod error;
mod file;
mod parallel;
mod rans;

pub use container::{Codec, MAGIC, VERSION};
#[cfg(feature = "write")]
pub use edge_collapse::encode;
pub use edge_collapse::{ColumnInfo, Info, MODEL, PAGE_UPDATES, PageInfo, SectionInfo, decode, inspect};
pub use error::ReadError;
#[cfg(feature = "write")]
pub use error::{EncodeError, WriteError};
#[cfg(feature = "write")]
pub use file::{WriteOptions, Written, write, write_columns};
pub use file::{inspect_file, read};
pub use meshfront_hierarchies::edge_collapse::round_error_up;
