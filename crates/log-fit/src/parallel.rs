//! Work on independent items, on all cores.

/// A function of each item, in their order: the same for any number of threads.
#[cfg(feature = "parallel")]
pub fn map<'a, T, R>(
    items: &'a [T],
    function: impl Fn(&'a T) -> R + Sync + Send,
) -> impl Iterator<Item = R>
where
    T: Sync,
    R: Send,
{
    use rayon::prelude::*;

    items
        .par_iter()
        .map(function)
        .collect::<Vec<R>>()
        .into_iter()
}

/// A function of each item, in their order: a page in a browser has one thread.
#[cfg(not(feature = "parallel"))]
pub fn map<'a, T, R>(items: &'a [T], function: impl Fn(&'a T) -> R) -> impl Iterator<Item = R> {
    items.iter().map(function)
}
