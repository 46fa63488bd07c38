/// G⁻¹ of a covariance G Gᵀ, lower triangular. A value without variance gets no weight.
pub(super) fn inverse_factor(covariance: &[[f64; 5]; 5]) -> [[f64; 5]; 5] {
    /// The part of a variance below which it is explained by the others.
    const MIN_UNEXPLAINED_SHARE: f64 = 1e-9;
    let mut factor = [[0.0; 5]; 5];
    let mut inverse = [[0.0; 5]; 5];
    for i in 0..5 {
        if covariance[i][i] <= 0.0 {
            continue;
        }
        let left = |factor: &[[f64; 5]; 5], j: usize| {
            let (row, before) = (factor.get(i)?, factor.get(j)?);
            let pairs = row.iter().zip(before).take(j);
            let all = *covariance.get(i)?.get(j)?;
            Some(pairs.fold(all, |left, (own, before)| left - own * before))
        };
        for j in 0..i {
            if factor[j][j] > 0.0 {
                factor[i][j] = left(&factor, j).unwrap_or(0.0) / factor[j][j];
            }
        }
        let variance = left(&factor, i)
            .unwrap_or(0.0)
            .max(MIN_UNEXPLAINED_SHARE * covariance[i][i]);
        factor[i][i] = libm::sqrt(variance);
        inverse[i][i] = 1.0 / factor[i][i];
        for j in 0..i {
            // Without an index, whose check not every chip's code would be rid of.
            let column = |row: &[f64; 5]| row.get(j).copied().unwrap_or(0.0);
            let rows = factor[i].iter().zip(&inverse).take(i).skip(j);
            let sum: f64 = rows.map(|(entry, row)| entry * column(row)).sum();
            inverse[i][j] = -sum / factor[i][i];
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::inverse_factor;

    #[test]
    fn the_factor_makes_a_covariance_white() {
        let root = [
            [2.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, 3.0, 0.0, 0.0, 0.0],
            [0.5, -1.0, 0.2, 0.0, 0.0],
            [0.0, 0.3, 0.1, 1.0, 0.0],
            [4.0, -2.0, 0.0, 0.5, 0.1],
        ];
        let covariance: [[f64; 5]; 5] = core::array::from_fn(|i| {
            core::array::from_fn(|j| (0..5).map(|k| root[i][k] * root[j][k]).sum())
        });
        let inverse = inverse_factor(&covariance);
        for i in 0..5 {
            for j in 0..5 {
                let product: f64 = (0..5).map(|k| inverse[i][k] * root[k][j]).sum();
                let one = if i == j { 1.0 } else { 0.0 };
                assert!((product - one).abs() < 1e-9, "{i} {j}: {product}");
            }
        }
    }
}
