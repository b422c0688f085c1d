//! Work on all threads, where there are threads.

/// So many times the same. Memory that nobody has touched yet costs more than what is written there.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn filled<T: Copy + Send + Sync>(value: T, length: usize) -> Vec<T> {
    use rayon::prelude::*;
    (0..length).into_par_iter().map(|_| value).collect()
}

/// So many times the same.
#[cfg(target_family = "wasm")]
pub(crate) fn filled<T: Copy>(value: T, length: usize) -> Vec<T> {
    vec![value; length]
}

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
