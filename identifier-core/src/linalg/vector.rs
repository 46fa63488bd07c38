use crate::number::Number;

/// xᵀ y.
#[inline]
pub(crate) fn dot<N: Number, const P: usize>(x: &[N; P], y: &[N; P]) -> N {
    let mut sum = x[0] * y[0];
    for i in 1..P {
        sum += x[i] * y[i];
    }
    sum
}
