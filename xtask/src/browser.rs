//! Browsers to look at the page with.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Result, bail};

use crate::step::{apt_install, command, on_path, run_quietly, say};
use crate::web;

/// Names another browser than the first one found.
pub const CHROMIUM: &str = "MESHFRONT_CHROMIUM";

/// An installed Chromium or Chrome, or one that Playwright has fetched before; else it is installed.
pub fn chromium() -> Result<PathBuf> {
    if let Some(named) = std::env::var_os(CHROMIUM) {
        let named = PathBuf::from(named);
        if !named.is_file() {
            bail!("{CHROMIUM} names {}, which is not a file", named.display());
        }
        return Ok(named);
    }
    if let Some(found) = installed() {
        return Ok(found);
    }
    let remedy = format!("no Chromium or Chrome found: install one, or name one with {CHROMIUM}");
    if apt_install(&["chromium"], "a browser for the page's tests", &remedy).is_ok()
        && let Some(found) = installed()
    {
        return Ok(found);
    }
    say("npx playwright install chromium");
    web::packages()?;
    let mut playwright = command(web::NPX);
    playwright.current_dir(crate::step::root().join("web")).args(["playwright", "install", "chromium"]);
    run_quietly(&mut playwright, &remedy)?;
    match installed() {
        Some(found) => Ok(found),
        None => bail!("{remedy}"),
    }
}

/// Names another Firefox than the first one found.
pub const FIREFOX: &str = "MESHFRONT_FIREFOX";

/// An installed Firefox; else it is installed.
pub fn firefox() -> Result<PathBuf> {
    if let Some(named) = std::env::var_os(FIREFOX) {
        let named = PathBuf::from(named);
        if !named.is_file() {
            bail!("{FIREFOX} names {}, which is not a file", named.display());
        }
        return Ok(named);
    }
    let installed = || {
        let fixed =
            ["/Applications/Firefox.app/Contents/MacOS/firefox", "C:/Program Files/Mozilla Firefox/firefox.exe"];
        let anywhere = ["firefox-esr", "firefox"].iter().find_map(|name| on_path(name));
        anywhere.or_else(|| fixed.iter().map(PathBuf::from).find(|file| file.is_file()))
    };
    if let Some(found) = installed() {
        return Ok(found);
    }
    let remedy = format!("no Firefox found: install one, or name one with {FIREFOX}");
    apt_install(&["firefox-esr"], "a second browser for the page's tests", &remedy)?;
    match installed() {
        Some(found) => Ok(found),
        None => bail!("{remedy}"),
    }
}

/// A command on a screen: Firefox without one has no WebGL. Where there is none, Xvfb makes one up, and Mesa draws in software.
pub fn on_a_screen(command: Command) -> Result<Command> {
    let has_screen = ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    if has_screen || !cfg!(target_os = "linux") {
        return Ok(command);
    }
    if on_path("xvfb-run").is_none() {
        let remedy = "no screen for Firefox: run this in a desktop session, or install xvfb";
        apt_install(&["xvfb", "xauth", "libgl1-mesa-dri"], "a screen for Firefox", remedy)?;
    }
    let mut framed = crate::step::command("xvfb-run");
    framed.arg("-a").arg(command.get_program()).args(command.get_args());
    if let Some(folder) = command.get_current_dir() {
        framed.current_dir(folder);
    }
    for (name, value) in command.get_envs() {
        match value {
            Some(value) => framed.env(name, value),
            None => framed.env_remove(name),
        };
    }
    Ok(framed)
}

fn installed() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge"];
    let fixed = [
        "/Applications/Chromium.app/Contents/MacOS/Chromium",
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
        "C:/Program Files/Google/Chrome/Application/chrome.exe",
        "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
    ];
    let anywhere = names.iter().find_map(|name| on_path(name));
    anywhere.or_else(|| fixed.iter().map(PathBuf::from).find(|file| file.is_file())).or_else(playwrights)
}

/// Playwright keeps every version in a folder of its own: the newest one counts.
fn playwrights() -> Option<PathBuf> {
    let home = std::env::home_dir()?;
    let caches = [
        std::env::var_os("PLAYWRIGHT_BROWSERS_PATH").map(PathBuf::from),
        Some(home.join(".cache/ms-playwright")),
        Some(home.join("Library/Caches/ms-playwright")),
        std::env::var_os("LOCALAPPDATA").map(|local| PathBuf::from(local).join("ms-playwright")),
    ];
    let programs = [
        "chrome-linux64/chrome",
        "chrome-linux/chrome",
        "chrome-mac/Chromium.app/Contents/MacOS/Chromium",
        "chrome-mac-arm64/Google Chrome for Testing.app/Contents/MacOS/Google Chrome for Testing",
        "chrome-win64/chrome.exe",
        "chrome-win/chrome.exe",
    ];
    let version = |dir: &PathBuf| -> Option<u32> { dir.file_name()?.to_str()?.strip_prefix("chromium-")?.parse().ok() };
    let mut versions: Vec<PathBuf> = caches
        .into_iter()
        .flatten()
        .filter_map(|cache| cache.read_dir().ok())
        .flat_map(|entries| entries.flatten().map(|entry| entry.path()))
        .filter(|dir| version(dir).is_some())
        .collect();
    versions.sort_by_key(|dir| std::cmp::Reverse(version(dir)));
    versions.iter().flat_map(|dir| programs.iter().map(move |program| dir.join(program))).find(|file| file.is_file())
}
