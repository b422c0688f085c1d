//! Meshes, and reading and writing them. No word of levels of detail here.
//!
//! With the feature `io` (default): [`io`] reads and writes OFF, OBJ, PLY, STL and glTF, [`io::height`] the height fields
//! of GeoTIFF, PNG, USGS DEM and ESRI ASCII grids, [`triangulate`] cuts polygons and [`clean`] welds and drops. Without it the crate is plain columns and [`sample`] meshes, and compiles anywhere.
//!
//! ```
//! # #[cfg(feature = "io")] {
//! use meshfront_mesh::{io, sample};
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("ball.ply.gz");
//! io::write(&path, &sample::sphere(1_000), io::WriteOptions::default())?;
//! let source = io::read(&path)?;
//! assert_eq!(source.report.to_string(), "PLY with 486 vertices and 968 faces: 486 vertices, 968 triangles");
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod height_field;
mod triangle_mesh;

#[cfg(feature = "io")]
pub mod clean;
#[cfg(feature = "io")]
pub mod io;
pub mod sample;
#[cfg(feature = "io")]
pub mod triangulate;

pub use height_field::{HeightField, Unit};
pub use triangle_mesh::{Bounds, TriangleId, TriangleMesh, VertexColumns, VertexId};

/// A count with a comma between thousands.
#[cfg(feature = "io")]
struct Thousands(u64);

#[cfg(feature = "io")]
impl std::fmt::Display for Thousands {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = self.0.to_string();
        for (i, digit) in digits.chars().enumerate() {
            if i > 0 && (digits.len() - i).is_multiple_of(3) {
                f.write_str(",")?;
            }
            write!(f, "{digit}")?;
        }
        Ok(())
    }
}
