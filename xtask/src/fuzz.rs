//! `cargo xtask fuzz`: random bytes for everything that reads bytes.

use anyhow::{Result, bail};

use crate::step::{command, output_of, root, run, run_quietly, say};

/// Why fuzzing is not possible here, if it is not.
pub fn missing() -> Option<String> {
    let nightly = output_of(command("cargo").args(["+nightly", "--version"])).is_some();
    (!nightly).then(|| "fuzzing needs a nightly compiler: run `rustup toolchain install nightly`".to_owned())
}

/// Runs one target, or each in turn, for `seconds`.
pub fn fuzz(target: Option<&str>, seconds: u32) -> Result<()> {
    if let Some(why) = missing() {
        bail!("{why}");
    }
    let known = targets()?;
    let chosen = match target {
        None => known,
        Some(name) if known.iter().any(|known| known == name) => vec![name.to_owned()],
        Some(name) => bail!("no fuzz target is called {name}: there are {}", known.join(", ")),
    };
    if output_of(command("cargo").args(["fuzz", "--version"])).is_none() {
        say("cargo install cargo-fuzz");
        run_quietly(
            command("cargo").args(["install", "--locked", "--quiet", "cargo-fuzz"]),
            "is the package registry reachable from here?",
        )?;
    }
    for name in chosen {
        say(&format!("{name} for {seconds} s"));
        let mut fuzz = command("cargo");
        // The compiler that started us has a say in these; cargo-fuzz must find its own.
        for key in ["CARGO", "RUSTC", "RUSTUP_TOOLCHAIN"] {
            fuzz.env_remove(key);
        }
        fuzz.args(["+nightly", "fuzz", "run", &name, "--", &format!("-max_total_time={seconds}")]);
        // A reader that asks for more memory than this for an input of a few kilobytes is a finding.
        fuzz.args(["-rss_limit_mb=2048", "-malloc_limit_mb=512", "-print_final_stats=1"]);
        run(&mut fuzz, "the input that did it is in fuzz/artifacts")?;
    }
    Ok(())
}

fn targets() -> Result<Vec<String>> {
    let folder = root().join("fuzz/fuzz_targets");
    let mut names: Vec<String> = match folder.read_dir() {
        Ok(entries) => entries
            .flatten()
            .filter_map(|entry| Some(entry.file_name().to_str()?.strip_suffix(".rs")?.to_owned()))
            .collect(),
        Err(error) => bail!("{} cannot be read: {error}", folder.display()),
    };
    names.sort();
    Ok(names)
}
