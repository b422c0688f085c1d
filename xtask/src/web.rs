//! `cargo xtask web`: the engine as WebAssembly, its JavaScript glue, and the page that the binary embeds.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Result, bail};
use clap::ValueEnum;

use crate::step::{
    apt_install, cargo, command, is_fresh, on_path, output_of, root, run, run_quietly, say, succeeds_within, target_dir,
};

const TARGET: &str = "wasm32-unknown-unknown";
/// Every browser with WebGL 2 that still gets updates has 128-bit vectors.
const RUSTFLAGS: &str = "-C target-feature=+simd128";
/// Debian packages with a compiler, the standard library's source and a cargo that know [`TARGET`].
const DEBIAN: [&str; 3] = ["rustc-web", "rust-web-src", "cargo-web"];
/// npm and npx as the system calls them.
pub const NPM: &str = if cfg!(windows) { "npm.cmd" } else { "npm" };
pub const NPX: &str = if cfg!(windows) { "npx.cmd" } else { "npx" };
pub const NODE: &str = "install Node.js 20 or newer with npm (nodejs.org, or your package manager)";
pub const REGISTRY: &str = "is the package registry reachable from here?";

/// Where the standard library for WebAssembly comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Std {
    /// What is installed; else rustup; else Debian.
    #[default]
    Auto,
    /// `rustup target add`.
    Rustup,
    /// Debian's `rustc-web`, which builds the standard library along.
    Debian,
}

/// Builds what is out of date of: module, glue, npm packages, page.
pub fn web(std: Std) -> Result<()> {
    let module = wasm(std)?;
    glue(&module)?;
    packages()?;
    page()
}

/// The engine as a WebAssembly module; returns its path.
pub fn wasm(std: Std) -> Result<PathBuf> {
    let with_rustup = match std {
        Std::Auto => has_target() || add_target(),
        Std::Rustup => has_target() || add_target() || bail_rustup()?,
        Std::Debian => false,
    };
    let mut build = if with_rustup { cargo() } else { debian_cargo()? };
    say("engine to WebAssembly");
    build
        .args(["build", "--quiet", "--package", "meshfront-wasm", "--lib", "--profile", "wasm", "--target", TARGET])
        .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", RUSTFLAGS);
    run(&mut build, "the compiler says why above")?;
    Ok(target_dir().join(TARGET).join("wasm/meshfront_wasm.wasm"))
}

fn has_target() -> bool {
    let libraries = output_of(command("rustc").args(["--print", "target-libdir", "--target", TARGET]));
    libraries.is_some_and(|dir| Path::new(&dir).read_dir().is_ok_and(|mut files| files.next().is_some()))
}

/// Where rustup's server cannot be reached the download hangs instead of failing, so it gets a limit.
fn add_target() -> bool {
    say(&format!("rustup target add {TARGET}"));
    on_path("rustup").is_some()
        && succeeds_within(command("rustup").args(["target", "add", TARGET]), Duration::from_secs(20))
        && has_target()
}

fn bail_rustup() -> Result<bool> {
    bail!("`rustup target add {TARGET}` did not succeed in 20 seconds: run it by hand to see why");
}

/// Debian's cargo for the web, told to build the standard library with the engine (about a minute, once).
fn debian_cargo() -> Result<Command> {
    let rustc = Path::new("/usr/bin/rustc");
    let source = Path::new("/usr/lib/rustlib/src/rust/library");
    let ready = rustc.exists() && Path::new("/usr/bin/cargo").exists() && source.exists();
    if !ready {
        let remedy = format!(
            "no standard library for {TARGET}: run `rustup target add {TARGET}`, or on Debian `apt-get install {}`",
            DEBIAN.join(" ")
        );
        apt_install(&DEBIAN, "a Rust that can build for WebAssembly", &remedy)?;
    }
    say("the target is not installed: Debian's Rust builds the standard library for WebAssembly");
    let mut cargo = command("/usr/bin/cargo");
    // Our own cargo may have been started by rustup, whose choices must not reach this one.
    for key in ["RUSTUP_TOOLCHAIN", "CARGO", "RUSTC_WRAPPER", "RUSTC_WORKSPACE_WRAPPER", "RUSTDOC"] {
        cargo.env_remove(key);
    }
    cargo
        .arg("-Zbuild-std=std,panic_abort")
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTC", rustc)
        .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", linker()?);
    Ok(cargo)
}

/// The linker for WebAssembly lies beside the toolchain's own libraries.
fn linker() -> Result<PathBuf> {
    let host = |rustc: &str| {
        let sysroot = PathBuf::from(output_of(command(rustc).args(["--print", "sysroot"]))?);
        let version = output_of(command(rustc).arg("-vV"))?;
        let host = version.lines().find_map(|line| line.strip_prefix("host: "))?.to_owned();
        let linker = sysroot.join("lib/rustlib").join(host).join("bin/rust-lld");
        linker.exists().then_some(linker)
    };
    match host("rustc")
        .or_else(|| host("/usr/bin/rustc"))
        .or_else(|| on_path("wasm-ld"))
        .or_else(|| on_path("rust-lld"))
    {
        Some(linker) => Ok(linker),
        None => bail!("no linker for WebAssembly: install one with `apt-get install lld`"),
    }
}

/// JavaScript glue beside a copy of the module, where the page's build looks for it.
fn glue(module: &Path) -> Result<()> {
    let out = root().join("web/core/wasm");
    let made = out.join("meshfront_wasm_bg.wasm");
    if is_fresh(&made, &[module, &root().join("xtask/bindgen")]) {
        return Ok(());
    }
    say("JavaScript glue (its generator takes a while to compile, once)");
    let mut bindgen = cargo();
    bindgen
        .args(["run", "--quiet", "--profile", "tools", "--package", "xtask-bindgen", "--"])
        .args([module, &out])
        .arg("meshfront_wasm");
    run(&mut bindgen, "is the version of wasm-bindgen the same for the engine and for the generator in Cargo.toml?")
}

/// npm packages, exactly those of the lock file.
pub fn packages() -> Result<()> {
    let web = root().join("web");
    let installed = web.join("node_modules/.package-lock.json");
    if is_fresh(&installed, &[web.join("package-lock.json")]) {
        return Ok(());
    }
    if on_path(NPM).is_none() {
        bail!("no npm on the PATH: {NODE}");
    }
    say("npm ci in web/");
    run_quietly(npm().args(["ci", "--no-audit", "--no-fund"]), REGISTRY)?;
    // npm leaves the file's time alone when nothing had to change.
    std::fs::File::options().append(true).open(&installed)?.set_modified(std::time::SystemTime::now())?;
    Ok(())
}

/// npm, run in `web/`.
pub fn npm() -> Command {
    let mut npm = command(NPM);
    npm.current_dir(root().join("web"));
    npm
}

fn page() -> Result<()> {
    let web = root().join("web");
    let page = web.join("viewer/dist/index.html");
    let sources = ["core", "three", "viewer", "package-lock.json", "package.json"].map(|name| web.join(name));
    if is_fresh(&page, &sources) {
        return Ok(());
    }
    say("the page: npm run build in web/");
    run_quietly(npm().args(["run", "build"]), "the compiler says why above")
}
