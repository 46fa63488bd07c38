use crate::number::Number;
use crate::unrolled::each;

/// xᵀ y.
#[inline]
pub(crate) fn dot<N: Number, const P: usize>(x: &[N; P], y: &[N; P]) -> N {
    let mut sum = x[0] * y[0];
    each::<P>(|i| {
        if i > 0 {
            sum += x[i] * y[i];
        }
    });
    sum
}
