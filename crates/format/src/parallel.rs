//! Pages on all threads, where there are threads.

/// Maps every item, in order of the items, whatever the order of the work.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn map_all<T: Send, R: Send>(items: Vec<T>, map: impl Fn(T) -> R + Sync + Send) -> Vec<R> {
    use rayon::prelude::*;
    items.into_par_iter().map(map).collect()
}

/// Maps every item.
#[cfg(target_family = "wasm")]
pub(crate) fn map_all<T, R>(items: Vec<T>, map: impl Fn(T) -> R) -> Vec<R> {
    items.into_iter().map(map).collect()
}
