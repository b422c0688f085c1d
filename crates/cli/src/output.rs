//! Where results go: checked before the work, written whole or not at all.

use std::path::Path;

use anyhow::{Context, Result};
use meshfront::TriangleMesh;
use meshfront::mesh::HeightField;
use meshfront::mesh::io::{self, Format, height};

use crate::interrupt;

/// The command line makes no sense, for a reason that only shows when looking at the files that it names.
#[derive(Debug)]
pub struct Usage(pub String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// Refuses, before any work is done, what could not be written after it.
pub fn check(output: &Path, inputs: &[&Path], force: bool) -> Result<()> {
    let name = output.display();
    for input in inputs {
        if same_file(output, input) {
            return Err(Usage(format!("{name}: is the input; choose another output")).into());
        }
    }
    if output.is_dir() {
        return Err(Usage(format!("{name}: is a folder; name a file in it")).into());
    }
    if !force && output.symlink_metadata().is_ok() {
        anyhow::bail!("{name}: exists already; choose another name, or replace it with --force");
    }
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        anyhow::bail!("{name}: there is no folder {}; make it first", folder.display());
    }
    Ok(())
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Refuses a name that does not say which format of mesh to write.
pub fn check_mesh_name(output: &Path) -> Result<()> {
    if matches!(Format::from_path(output), Ok(format) if format != Format::Gltf) {
        return Ok(());
    }
    let name = output.display();
    Err(Usage(format!("{name}: name the output .ply, .obj, .stl, .off or .glb, that says what to write")).into())
}

/// Writes a mesh.
pub fn write_mesh(output: &Path, mesh: &TriangleMesh, overwrite: bool) -> Result<u64> {
    interrupt::uninterrupted(|| io::write(output, mesh, io::WriteOptions { overwrite }))?;
    length(output)
}

/// Writes a height field.
pub fn write_heights(output: &Path, field: &HeightField, overwrite: bool) -> Result<u64> {
    interrupt::uninterrupted(|| height::write(output, field, io::WriteOptions { overwrite }))?;
    length(output)
}

fn length(output: &Path) -> Result<u64> {
    Ok(output.metadata().with_context(|| format!("{}: vanished", output.display()))?.len())
}
