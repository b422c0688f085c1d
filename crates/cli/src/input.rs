//! Reading what a command is given: a hierarchy or a mesh, told apart by the first bytes.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, Result};
use meshfront::format;
use meshfront::mesh::io::{self, Phase, ReadOptions, Source};
use meshfront::simplify::Progress;
use meshfront::{EdgeCollapse, TriangleMesh};

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
pub fn hierarchy(path: &Path) -> Result<EdgeCollapse> {
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

/// Reads a mesh.
pub fn mesh(path: &Path, seams: Seams, phases: &Phases) -> Result<Source> {
    let mut phase = None;
    let mut progress = |at: io::Progress| {
        if phase.replace(at.phase) != Some(at.phase) {
            let name = match at.phase {
                Phase::Decompress => "decompress",
                Phase::Parse => "read",
                Phase::Clean => "clean",
            };
            phases.phase(name, "bytes", at.total);
        }
        phases.at(at.done);
    };
    Ok(io::read_with(
        path,
        ReadOptions { weld_seams: seams == Seams::Weld, progress: Some(&mut progress), ..ReadOptions::default() },
    )?)
}

/// Reads a mesh, or the finest mesh of a hierarchy.
pub fn any_mesh(path: &Path, phases: &Phases) -> Result<TriangleMesh> {
    if !is_front(path)? {
        return Ok(mesh(path, Seams::Keep, phases)?.mesh);
    }
    phases.start("read");
    Ok(meshfront::finest(&hierarchy(path)?))
}
