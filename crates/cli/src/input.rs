//! Reading what a command is given: a hierarchy or a mesh, told apart by the first bytes.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, Result};
use meshfront::format;
use meshfront::mesh::io::height::{self, HeightSource, is_height_format};
use meshfront::mesh::io::{self, Phase, ReadOptions, Source};
use meshfront::simplify::Progress;
use meshfront::{Hierarchy, TriangleMesh, with_model};

use crate::progress::Phases;

/// Whether a file is a `.front`, by its content; a name that ends so is enough for the right error message.
pub fn is_front(path: &Path) -> Result<bool> {
    let mut start = Vec::new();
    File::open(path)
        .and_then(|file| file.take(format::MAGIC.len() as u64).read_to_end(&mut start))
        .with_context(|| format!("{}: cannot be read", path.display()))?;
    Ok(start == format::MAGIC || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("front")))
}

/// Reads a hierarchy.
pub fn hierarchy(path: &Path) -> Result<Hierarchy> {
    Ok(format::read(path)?)
}

/// How vertices that differ only in normal or colour are read.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Seams {
    /// As the file has them.
    Keep,
    /// As one: a simplified surface must not open along them.
    Weld,
}

/// Shows how far a reader is.
fn follow(phases: &Phases) -> impl FnMut(io::Progress) {
    let mut phase = None;
    move |at: io::Progress| {
        if phase.replace(at.phase) != Some(at.phase) {
            let name = match at.phase {
                Phase::Decompress => "decompress",
                Phase::Parse => "read",
                Phase::Clean => "clean",
            };
            phases.phase(name, "bytes", at.total);
        }
        phases.at(at.done);
    }
}

/// What names of height fields end with, for messages.
pub const HEIGHT_ENDINGS: &str = ".tif, .png, .dem or .asc";

/// Reads a height field.
pub fn heights(path: &Path, phases: &Phases) -> Result<HeightSource> {
    Ok(height::read_with(path, Some(&mut follow(phases)))?)
}

/// Reads a mesh.
pub fn mesh(path: &Path, seams: Seams, phases: &Phases) -> Result<Source> {
    let mut progress = follow(phases);
    Ok(io::read_with(
        path,
        ReadOptions { weld_seams: seams == Seams::Weld, progress: Some(&mut progress), ..ReadOptions::default() },
    )?)
}

/// Reads a mesh, the surface of a height field, or the finest mesh of a hierarchy.
pub fn any_mesh(path: &Path, phases: &Phases) -> Result<TriangleMesh> {
    if is_height_format(path) {
        return Ok(heights(path, phases)?.field.to_mesh(1.0));
    }
    if !is_front(path)? {
        return Ok(mesh(path, Seams::Keep, phases)?.mesh);
    }
    phases.start("read");
    Ok(with_model!(&hierarchy(path)?, h => meshfront::finest(h)))
}
