//! The others, each called as its own users call it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use meshopt::{SimplifyOptions, VertexDataAdapter};
use serde_json::Value;

use crate::ply::{self, Mesh};

/// Where the commands are.
pub struct Tools {
    pub meshfront: PathBuf,
    pub python: PathBuf,
    pub rivals_py: PathBuf,
}

/// One simplified mesh.
pub struct Simplified {
    pub triangles: usize,
    /// Of the call alone.
    pub seconds: f64,
}

/// Those that `rivals.py` knows. VTK is first: its face count is the one that the others get.
pub const PYTHON: [&str; 3] = ["vtk", "fast-simplification", "pymeshlab"];

/// The seconds of `meshopt_simplify` alone, on the indexed mesh, with no limit of error; and its result.
pub fn meshopt(mesh: &Mesh, triangles: usize) -> Result<(Mesh, f64)> {
    let bytes: Vec<u8> = mesh.positions.iter().flatten().flat_map(|x| x.to_ne_bytes()).collect();
    let vertices = VertexDataAdapter::new(&bytes, 12, 0)?;
    let start = Instant::now();
    let indices = meshopt::simplify(&mesh.indices, &vertices, triangles * 3, f32::MAX, SimplifyOptions::empty(), None);
    Ok((Mesh { positions: mesh.positions.clone(), indices }, start.elapsed().as_secs_f64()))
}

impl Tools {
    /// The JSON that a subcommand of `rivals.py` prints.
    pub fn python(&self, arguments: &[&str]) -> Result<Value> {
        json_of(Command::new(&self.python).arg(&self.rivals_py).args(arguments))
    }

    /// The JSON that a subcommand of `meshfront` prints.
    pub fn meshfront_json(&self, arguments: &[&str]) -> Result<Value> {
        json_of(Command::new(&self.meshfront).args(arguments).args(["--json", "--quiet"]))
    }

    pub fn meshfront(&self, arguments: &[&str]) -> Result<()> {
        output_of(Command::new(&self.meshfront).args(arguments).arg("--quiet")).map(drop)
    }

    /// Simplifies the file `source` with the named rival, to the file `out`.
    pub fn simplify(&self, name: &str, mesh: &Mesh, source: &Path, out: &Path, triangles: usize) -> Result<Simplified> {
        if name == "meshopt" {
            let (simple, seconds) = meshopt(mesh, triangles)?;
            ply::write(out, &simple)?;
            return Ok(Simplified { triangles: simple.triangles(), seconds });
        }
        let said = self.python(&["simplify", name, path(source), path(out), &triangles.to_string()])?;
        let triangles = said["triangles"].as_u64().context("rivals.py says no triangles")? as usize;
        Ok(Simplified { triangles, seconds: number(&said, "/seconds")? })
    }
}

/// Paths here are made of mesh names and our own folders.
pub fn path(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// The number at a JSON pointer.
pub fn number(value: &Value, pointer: &str) -> Result<f64> {
    value.pointer(pointer).and_then(Value::as_f64).with_context(|| format!("no number at {pointer} in {value}"))
}

pub fn json_of(command: &mut Command) -> Result<Value> {
    let said = output_of(command)?;
    serde_json::from_str(&said).with_context(|| format!("{command:?} did not print JSON but {said:?}"))
}

fn output_of(command: &mut Command) -> Result<String> {
    let output = command.output().with_context(|| format!("cannot start {command:?}"))?;
    if !output.status.success() {
        bail!("{command:?} failed: {}", String::from_utf8_lossy(&output.stderr).trim_end());
    }
    Ok(String::from_utf8(output.stdout)?)
}
