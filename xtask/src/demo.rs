//! `cargo xtask demo`: the Stanford dragon in a page.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use crate::models::{ACKNOWLEDGEMENT, CREDIT};
use crate::step::{cargo, command, is_fresh, root, run, say, target_dir};
use crate::web::Std;
use crate::{browser, models, web};

/// How the demo ends.
pub enum End {
    /// The page is served until Ctrl-C.
    View {
        /// Start a browser too.
        open: bool,
        /// 0 takes any free one.
        port: u16,
    },
    /// A headless browser looks at the page once and writes a picture.
    Check,
}

/// Builds everything and shows the dragon.
pub fn demo(end: End) -> Result<()> {
    web::web(Std::Auto)?;
    let meshfront = release_binary()?;
    let front = dragon_front(&meshfront)?;
    eprintln!("\n{ACKNOWLEDGEMENT}\n");
    match end {
        End::View { open, port } => {
            let mut view = command(&meshfront);
            view.arg("view").arg(&front).args(["--port", &port.to_string(), "--credit", CREDIT]);
            if !open {
                view.arg("--no-open");
            }
            run(&mut view, "another --port may be free")
        }
        End::Check => {
            let picture = target_dir().join("demo/dragon.png");
            let mut page = page_script(&meshfront)?;
            page.args(["--credit", CREDIT, "--screenshot"]).arg(&picture).arg(&front);
            say("the page in a headless browser");
            run(&mut page, "the page says why above")?;
            say(&format!("the page settled: {}", picture.display()));
            Ok(())
        }
    }
}

/// `target/release/meshfront`, with the page of now inside.
pub fn release_binary() -> Result<PathBuf> {
    say("release binary");
    let mut build = cargo();
    build.args(["build", "--quiet", "--locked", "--release", "--package", "meshfront-cli"]);
    run(&mut build, "the compiler says why above")?;
    Ok(binary("release"))
}

/// `target/debug/meshfront`, which `cargo test` builds for the tests of the command line. Built alone it would be built
/// with other features of what it depends on, and take minutes.
pub fn tested_binary() -> Result<PathBuf> {
    let binary = binary("debug");
    ensure!(binary.exists(), "{} is missing: `cargo test --package meshfront-cli` builds it", binary.display());
    Ok(binary)
}

fn binary(profile: &str) -> PathBuf {
    target_dir().join(profile).join("meshfront").with_extension(std::env::consts::EXE_EXTENSION)
}

/// The dragon's hierarchy; made again when the binary is newer.
pub fn dragon_front(meshfront: &Path) -> Result<PathBuf> {
    let source = models::dragon()?;
    let front = target_dir().join("demo/dragon.front");
    if !is_fresh(&front, &[meshfront, &source]) {
        say("the dragon's hierarchy, from 871,414 triangles");
        std::fs::create_dir_all(target_dir().join("demo"))?;
        let mut build = command(meshfront);
        build.arg("build").arg(&source).arg("-o").arg(&front).arg("--force");
        run(&mut build, "meshfront says why above")?;
    }
    Ok(front)
}

/// `xtask/page.mjs` with all but its last arguments.
fn page_script(meshfront: &Path) -> Result<Command> {
    let chromium = browser::chromium()?;
    let mut node = command("node");
    node.arg(root().join("xtask/page.mjs")).arg("--meshfront").arg(meshfront).arg("--chromium").arg(chromium);
    Ok(node)
}
