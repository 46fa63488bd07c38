//! Loops over the parameters of a model, written out.
//!
//! The estimators are generic, so their samples are compiled in the user's crate, at its optimiser level. At "s" the
//! compiler keeps loops over two to six parameters as loops, and with them every array in memory. A sample then took
//! twice its instructions.

/// The longest loop that is written out. A longer one is a loop if the optimiser leaves it one.
const MAX_LENGTH: usize = 6;

/// Calls `body` with 0, 1, … N − 1, in this order.
#[inline(always)]
pub(crate) fn each<const N: usize>(mut body: impl FnMut(usize)) {
    if N > MAX_LENGTH {
        for i in 0..N {
            body(i);
        }
        return;
    }
    if N > 0 {
        body(0);
    }
    if N > 1 {
        body(1);
    }
    if N > 2 {
        body(2);
    }
    if N > 3 {
        body(3);
    }
    if N > 4 {
        body(4);
    }
    if N > 5 {
        body(5);
    }
}

/// The array of `value(0)`, `value(1)`, …, computed in this order; `zero` is any constant.
#[inline(always)]
pub(crate) fn from_fn<T: Copy, const N: usize>(
    zero: T,
    mut value: impl FnMut(usize) -> T,
) -> [T; N] {
    let mut array = [zero; N];
    each::<N>(|i| array[i] = value(i));
    array
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::{MAX_LENGTH, each, from_fn};

    fn each_is_visited<const N: usize>() {
        let mut visited = Vec::new();
        each::<N>(|i| visited.push(i));
        assert!(visited.iter().copied().eq(0..N), "{N}: {visited:?}");
    }

    #[test]
    fn every_index_is_visited_once_in_order_however_long_the_loop() {
        macro_rules! loops {
            ($($length:expr),*) => {$(each_is_visited::<{ $length }>();)*};
        }
        loops!(0, 1, 2, 3, 4, 5, MAX_LENGTH, MAX_LENGTH + 1, 12);
    }

    #[test]
    fn an_array_has_the_value_of_every_index() {
        assert_eq!(from_fn::<_, 5>(9, |i| i * i), [0, 1, 4, 9, 16]);
        assert_eq!(from_fn::<_, 8>(9, |i| i), [0, 1, 2, 3, 4, 5, 6, 7]);
    }
}
