//! Work on independent items, on all cores.

/// A function of each item, in their order: the same for any number of threads.
#[cfg(feature = "experiments")]
pub(crate) fn map<T, R>(items: &[T], function: impl Fn(&T) -> R + Sync + Send) -> Vec<R>
where
    T: Sync,
    R: Send,
{
    use rayon::prelude::*;

    items.par_iter().map(function).collect()
}

/// A function of each item, in their order: a page in a browser has one thread.
#[cfg(not(feature = "experiments"))]
pub(crate) fn map<T, R>(items: &[T], function: impl Fn(&T) -> R) -> Vec<R> {
    items.iter().map(function).collect()
}
