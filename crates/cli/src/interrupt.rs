//! Ctrl-C: what is being written is finished or not begun, what is temporary is removed, then the process ends.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What a shell reports for a command that SIGINT ended.
const INTERRUPTED: i32 = 130;

/// What the process exits with when it is interrupted.
static CODE: AtomicI32 = AtomicI32::new(INTERRUPTED);
/// Held while an output file is on its way to the disk.
static WRITING: Mutex<()> = Mutex::new(());
/// Files and folders to remove when the process is interrupted.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Answers SIGINT, SIGTERM and SIGHUP from now on. Outputs are written to a temporary file and renamed: waiting for a write
/// in progress leaves the whole file, and interrupting anything else leaves none.
pub fn install() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        let _finished = lock(&WRITING);
        for path in lock(&TEMPORARY).drain(..) {
            let _ = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        }
        std::process::exit(CODE.load(Ordering::Relaxed));
    })?;
    Ok(())
}

/// Writes something that must not be left half done.
pub fn uninterrupted<T>(write: impl FnOnce() -> T) -> T {
    let _writing = lock(&WRITING);
    write()
}

/// From now on an interruption is how the command is meant to end.
pub fn ends_well() {
    CODE.store(0, Ordering::Relaxed);
}

/// Removes a file or folder when the process is interrupted.
pub fn remove_when_interrupted(path: &Path) {
    lock(&TEMPORARY).push(path.to_path_buf());
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
