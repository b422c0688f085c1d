//! Chunks on all threads, where there are threads.

/// Calls `work` for every chunk of a slice, with the chunk's number.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn for_chunks<T: Send>(items: &mut [T], chunk: usize, work: impl Fn(usize, &mut [T]) + Sync + Send) {
    use rayon::prelude::*;
    items.par_chunks_mut(chunk).enumerate().for_each(|(i, items)| work(i, items));
}

/// Calls `work` for every chunk of a slice, with the chunk's number.
#[cfg(target_family = "wasm")]
pub(crate) fn for_chunks<T>(items: &mut [T], chunk: usize, work: impl Fn(usize, &mut [T])) {
    items.chunks_mut(chunk).enumerate().for_each(|(i, items)| work(i, items));
}
