//! `cargo xtask bench`: Meshfront beside its rivals.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use crate::step::{apt_install, cargo, command, is_fresh, on_path, output_of, root, run, run_quietly, say, target_dir};
use crate::web::{REGISTRY, Std};
use crate::{browser, demo, models, web};

/// Sets the rivals up, and measures; `meshes` are the dragon and a small bunny where none is named. The other arguments go
/// to the bench as they are.
pub fn bench(meshes: Vec<PathBuf>, arguments: &[String]) -> Result<()> {
    let meshes = if meshes.is_empty() { vec![models::bunny()?, models::dragon()?] } else { meshes };
    let python = python()?;
    web::web(Std::Auto)?;
    let meshfront = demo::release_binary()?;
    let chromium = browser::chromium()?;
    let work = target_dir().join("bench");
    let mut bench = cargo();
    bench.args(["run", "--quiet", "--release", "--manifest-path", "bench/Cargo.toml", "--"]);
    bench.arg("--meshfront").arg(&meshfront).arg("--python").arg(&python).arg("--rivals").arg("bench/rivals.py");
    bench
        .args(["--page", "xtask/page.mjs", "--chromium"])
        .arg(&chromium)
        .arg("--martini")
        .arg(models::martini()?)
        .args(["--martini-mjs", "bench/martini.mjs"])
        .arg("--work")
        .arg(&work)
        .args(["--results", "bench/results"]);
    say("rivals (meshopt is compiled from C++ once) and measurements");
    run(bench.args(arguments).args(&meshes), "it says why above")
}

/// The interpreter of `bench/.venv`, with the pinned rivals installed.
fn python() -> Result<PathBuf> {
    let venv = root().join("bench/.venv");
    let python = venv.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let requirements = root().join("bench/requirements.txt");
    // Written last, so that an interrupted install is done again.
    let done = venv.join("installed");
    if is_fresh(&done, &[&requirements]) {
        return Ok(python);
    }
    let Some(system) = ["python3", "python"].into_iter().find(|name| on_path(name).is_some()) else {
        bail!("no Python on the PATH: install Python 3.11 or newer");
    };
    say("bench/.venv with VTK, fast-simplification and MeshLab");
    let create =
        |system: &str| run_quietly(command(system).args(["-m", "venv"]).arg(&venv), "install Python's venv module");
    if create(system).is_err() {
        apt_install(&["python3-venv"], "Python's venv module", "install Python's venv module")?;
        create(system)?;
    }
    install(&python, &requirements)?;
    // MeshLab and VTK load the system's OpenGL even where nothing is drawn.
    if output_of(command(&python).args(["-c", "import vtk, pymeshlab, fast_simplification"])).is_none() {
        let remedy =
            "VTK or MeshLab does not load: install libGL (Debian: `apt-get install libgl1 libopengl0 libxrender1`)";
        apt_install(&["libgl1", "libopengl0", "libegl1", "libxrender1"], "what VTK and MeshLab load", remedy)?;
    }
    std::fs::write(done, "")?;
    Ok(python)
}

fn install(python: &Path, requirements: &Path) -> Result<()> {
    let mut pip = command(python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"]).arg(requirements);
    run_quietly(&mut pip, REGISTRY)
}
