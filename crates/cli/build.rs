//! Rebuilds the crate when the page that it embeds changes.

use std::path::Path;

fn main() {
    // Cargo looks at a missing path as changed every time: name the page only where it is, else where it would come.
    let watched = ["../../web/viewer/dist", "../../web/viewer", "build.rs"];
    let found = watched.into_iter().find(|path| Path::new(path).exists());
    println!("cargo:rerun-if-changed={}", found.unwrap_or("build.rs"));
}
