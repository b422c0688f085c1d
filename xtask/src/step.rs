//! Child processes, one line to the reader for each, and one sentence when it fails.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};

use anyhow::{Context, Result, bail};

/// The project's folder, whatever the current one is.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the project's folder")
}

/// The folder that cargo builds into.
pub fn target_dir() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(dir) => root().join(dir),
        None => root().join("target"),
    }
}

/// Says what is going on.
pub fn say(what: &str) {
    eprintln!("xtask: {what}");
}

/// A command that runs in the project's folder.
pub fn command(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// The cargo that started us.
pub fn cargo() -> Command {
    command(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// A [`Command`] with its arguments, as a person would type it.
pub fn line_of(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name().unwrap_or(command.get_program());
    let words = std::iter::once(program).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

/// Runs to the end with our own output streams; an unsuccessful end is an error that names `remedy`.
pub fn run(command: &mut Command, remedy: &str) -> Result<()> {
    let line = line_of(command);
    let status = command.status().with_context(|| format!("cannot start `{line}`: {remedy}"))?;
    if !status.success() {
        bail!("`{line}` failed ({status}): {remedy}");
    }
    Ok(())
}

/// As [`run`], for installers that talk a lot: what they say is shown only when they fail.
pub fn run_quietly(command: &mut Command, remedy: &str) -> Result<()> {
    let line = line_of(command);
    let output = capture(command).with_context(|| format!("cannot start `{line}`: {remedy}"))?;
    if !output.status.success() {
        let said = [output.stdout, output.stderr].concat();
        bail!("{}\n`{line}` failed ({}): {remedy}", String::from_utf8_lossy(&said).trim_end(), output.status);
    }
    Ok(())
}

fn capture(command: &mut Command) -> std::io::Result<Output> {
    command.stdin(Stdio::null()).output()
}

/// What a successful command printed, trimmed; `None` where it is missing or fails.
pub fn output_of(command: &mut Command) -> Option<String> {
    let output = capture(command).ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Whether the command ends well within `limit`; it is killed at the limit. What it prints is dropped.
pub fn succeeds_within(command: &mut Command, limit: Duration) -> bool {
    let Ok(mut child) = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn() else {
        return false;
    };
    let start = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return status.success(),
            Ok(None) if start.elapsed() < limit => std::thread::sleep(Duration::from_millis(50)),
            _ => {
                // A child that has ended by itself in between is as good as killed.
                let _ = child.kill();
                let _ = child.wait();
                return false;
            }
        }
    }
}

/// Whether `program` is on the PATH.
pub fn on_path(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|dir| dir.join(program)).find(|file| file.is_file())
}

/// Installs Debian packages, as root or by sudo; `why` says what for. Errs with `remedy` where that is not possible.
pub fn apt_install(packages: &[&str], why: &str, remedy: &str) -> Result<()> {
    if on_path("apt-get").is_none() {
        bail!("{remedy}");
    }
    let is_root = output_of(command("id").arg("-u")).as_deref() == Some("0");
    if !is_root && !succeeds_within(command("sudo").args(["-n", "true"]), Duration::from_secs(5)) {
        bail!("{remedy} (apt-get needs root: run `sudo apt-get install {}` yourself)", packages.join(" "));
    }
    let apt = || {
        let mut apt = command(if is_root { "apt-get" } else { "sudo" });
        if !is_root {
            apt.args(["-n", "apt-get"]);
        }
        apt.env("DEBIAN_FRONTEND", "noninteractive");
        apt
    };
    say(&format!("apt-get install {} ({why})", packages.join(" ")));
    run_quietly(apt().args(["update", "-q"]), remedy)?;
    run_quietly(apt().args(["install", "-q", "-y", "--no-install-recommends"]).args(packages), remedy)
}

/// The time of the last change of a file, or of anything below a folder; what is missing is older than all.
/// Build outputs and installed packages below it do not count.
pub fn newest(path: &Path) -> SystemTime {
    let Ok(metadata) = path.metadata() else { return SystemTime::UNIX_EPOCH };
    if !metadata.is_dir() {
        return metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
    }
    let Ok(entries) = path.read_dir() else { return SystemTime::UNIX_EPOCH };
    let outputs = ["node_modules", "dist", "target", "test-results", "playwright-report"];
    entries
        .flatten()
        .filter(|entry| !outputs.iter().any(|name| entry.file_name() == *name))
        .map(|entry| newest(&entry.path()))
        .max()
        .unwrap_or(SystemTime::UNIX_EPOCH)
}

/// Whether `output` exists and nothing among `inputs` is newer.
pub fn is_fresh<P: AsRef<Path>>(output: &Path, inputs: &[P]) -> bool {
    output.exists() && inputs.iter().all(|input| newest(input.as_ref()) <= newest(output))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, File};

    #[test]
    fn an_output_is_stale_once_something_below_its_input_is_newer_but_not_an_installed_package() {
        let dir = target_dir().join(format!("xtask-test-{}", std::process::id()));
        fs::create_dir_all(dir.join("src/node_modules")).unwrap();
        let at = |name: &str, seconds: u64| {
            let file = File::create(dir.join(name)).unwrap();
            file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds)).unwrap();
        };
        let fresh = || is_fresh(&dir.join("output"), &[dir.join("src")]);
        at("src/input", 100);
        assert!(!fresh(), "there is no output");
        at("output", 200);
        at("src/node_modules/package", 300);
        assert!(fresh());
        at("src/input", 400);
        assert!(!fresh());
        fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn failures_name_the_command_and_the_remedy() {
        let error = run(&mut command("no-such-program"), "install it").unwrap_err().to_string();
        assert_eq!(error, "cannot start `no-such-program`: install it");
    }
}
