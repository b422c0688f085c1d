//! `cargo xtask test`: everything that must hold before a change lands, on a machine that has nothing set up.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};

use crate::step::{cargo, on_path, output_of, root, run, run_quietly, say, succeeds_within};
use crate::web::{Std, npm};
use crate::{browser, demo, fuzz, models, web};

/// How a step ended.
enum Outcome {
    Passed,
    Skipped(String),
    Failed(String),
}

/// The steps so far, in order.
#[derive(Default)]
struct Steps(Vec<(&'static str, Outcome, Duration)>);

impl Steps {
    /// Runs one; the next ones follow even if it fails, so that one run tells all.
    fn run(&mut self, name: &'static str, work: impl FnOnce() -> Result<Outcome>) -> bool {
        eprintln!("\n── {name}");
        let start = Instant::now();
        let outcome = work().unwrap_or_else(|error| Outcome::Failed(format!("{error:#}")));
        if let Outcome::Failed(why) | Outcome::Skipped(why) = &outcome {
            say(why);
        }
        let failed = matches!(outcome, Outcome::Failed(_));
        self.0.push((name, outcome, start.elapsed()));
        !failed
    }

    /// A step that needs an earlier one to have passed.
    fn run_after(&mut self, ready: bool, name: &'static str, work: impl FnOnce() -> Result<Outcome>) -> bool {
        self.run(name, || if ready { work() } else { Ok(Outcome::Skipped("a step that it needs failed".into())) })
            && ready
    }

    fn finish(self) -> Result<()> {
        let (mut passed, mut failed, mut skipped) = (0, 0, 0);
        println!();
        for (name, outcome, time) in &self.0 {
            let verdict = match outcome {
                Outcome::Passed => "passed".to_owned(),
                Outcome::Skipped(why) => format!("skipped: {why}"),
                Outcome::Failed(_) => "FAILED".to_owned(),
            };
            match outcome {
                Outcome::Passed => passed += 1,
                Outcome::Skipped(_) => skipped += 1,
                Outcome::Failed(_) => failed += 1,
            }
            println!("{name:<22}{:>5} s  {verdict}", time.as_secs());
        }
        println!("steps: {passed} passed, {failed} failed, {skipped} skipped");
        if failed > 0 {
            bail!("{failed} of {} steps failed: each says why where it ran", self.0.len());
        }
        Ok(())
    }
}

const SAYS_WHY: &str = "it says why above";
/// The glue generator is not ours to test, and by far the slowest to compile.
const OURS: [&str; 3] = ["--workspace", "--exclude", "xtask-bindgen"];
/// In the names of browser tests that take long.
const LONG: &str = "@long";
/// Per fuzz target in the long run.
const FUZZ_SECONDS: u32 = 20;

/// Runs the checks; `all` adds the ones that take long.
pub fn test(all: bool) -> Result<()> {
    let mut steps = Steps::default();
    steps.run("format", format);
    let page = steps.run("web", || web::web(Std::Auto).map(passed));
    // The binary embeds the page, so the compiler wants it first.
    steps.run_after(page, "clippy", || {
        run(
            cargo().args(["clippy", "--locked", "--quiet", "--all-targets"]).args(OURS).args(["--", "-D", "warnings"]),
            SAYS_WHY,
        )
        .map(passed)
    });
    steps.run_after(page, "cargo test", || {
        run(cargo().args(["test", "--locked", "--no-fail-fast"]).args(OURS), SAYS_WHY).map(passed)
    });
    steps.run_after(page, "vitest", || {
        run(npm().args(["run", "check"]), SAYS_WHY)?;
        run(npm().args(["test"]), SAYS_WHY).map(passed)
    });
    // The binary of the tests: a release of it takes minutes to build, and shows the same page.
    steps.run_after(page, "page in a browser", || {
        page_in_a_browser(&if all { demo::release_binary()? } else { demo::tested_binary()? }, all)
    });
    steps.run("cargo deny", || deny(all));
    if all {
        steps.run_after(page, "page in Firefox", || page_in_firefox(&demo::release_binary()?));
        steps.run_after(page, "long tests", || {
            let mut long = cargo();
            long.args(["test", "--locked", "--release"]).args(OURS).args(["--", "--ignored"]);
            // Ignored because it writes, not because it takes long.
            long.args(["--skip", "make_fixtures"]);
            run(long.env(models::DRAGON, models::dragon()?), SAYS_WHY).map(passed)
        });
        steps.run("documentation", || {
            let mut doc = cargo();
            doc.args(["doc", "--locked", "--quiet", "--no-deps"]).args(OURS).env("RUSTDOCFLAGS", "-D warnings");
            run(&mut doc, SAYS_WHY).map(passed)
        });
        steps.run("fuzz", || match fuzz::missing() {
            Some(why) => Ok(Outcome::Skipped(why)),
            None => fuzz::fuzz(None, FUZZ_SECONDS).map(passed),
        });
    }
    steps.finish()
}

fn passed((): ()) -> Outcome {
    Outcome::Passed
}

fn format() -> Result<Outcome> {
    for workspace in [".", "bench", "fuzz"] {
        let manifest = root().join(workspace).join("Cargo.toml");
        if manifest.exists() {
            run(cargo().args(["fmt", "--all", "--check", "--manifest-path"]).arg(manifest), "run `cargo fmt`")?;
        }
    }
    Ok(Outcome::Passed)
}

fn page_in_a_browser(meshfront: &Path, all: bool) -> Result<Outcome> {
    let chromium = browser::chromium()?;
    let mut playwright = npm();
    playwright.args(["run", "test:e2e"]).env(browser::CHROMIUM, chromium).env("MESHFRONT_BIN", meshfront);
    if !all {
        playwright.args(["--", "--grep-invert", LONG]);
    }
    run(&mut playwright, "screenshots are in target/screenshots").map(passed)
}

/// Not everywhere can it be installed: then the step is skipped, and says why.
fn page_in_firefox(meshfront: &Path) -> Result<Outcome> {
    let firefox = match browser::firefox() {
        Ok(firefox) => firefox,
        // One that was named has to be there.
        Err(why) if std::env::var_os(browser::FIREFOX).is_some() => return Err(why),
        Err(why) => return Ok(Outcome::Skipped(format!("{why:#}"))),
    };
    let mut playwright = npm();
    playwright.args(["run", "test:firefox"]).env(browser::FIREFOX, firefox).env("MESHFRONT_BIN", meshfront);
    match browser::on_a_screen(playwright) {
        Ok(mut framed) => run(&mut framed, "screenshots are in target/screenshots").map(passed),
        Err(why) => Ok(Outcome::Skipped(format!("{why:#}"))),
    }
}

/// Licences, sources and duplicates of what we depend on; with `all` also known vulnerabilities.
fn deny(all: bool) -> Result<Outcome> {
    let installed = || output_of(cargo().args(["deny", "--version"])).is_some();
    if !installed() {
        if !all {
            return Ok(Outcome::Skipped(
                "cargo-deny is not installed (`--all` installs it, which takes minutes)".into(),
            ));
        }
        say("cargo install cargo-deny");
        run_quietly(
            cargo().args(["install", "--locked", "--quiet", "cargo-deny"]),
            "is the package registry reachable?",
        )?;
    }
    run(cargo().args(["deny", "--workspace", "check", "bans", "licenses", "sources"]), SAYS_WHY)?;
    if all && on_path("git").is_some() {
        // The database of advisories is fetched from a host that not every machine reaches.
        if !succeeds_within(cargo().args(["deny", "fetch", "db"]), Duration::from_secs(60)) {
            say("the database of advisories cannot be reached: known vulnerabilities were not looked for");
            return Ok(Outcome::Passed);
        }
        run(cargo().args(["deny", "--workspace", "check", "advisories"]), SAYS_WHY)?;
    }
    Ok(Outcome::Passed)
}
