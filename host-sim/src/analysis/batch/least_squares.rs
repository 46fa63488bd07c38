//! Least squares on columns by orthogonalisation (modified Gram and Schmidt, twice; Björck, "Solving
//! linear least squares problems by Gram–Schmidt orthogonalization", BIT 7, 1967).

/// Columns made orthogonal, and the triangle that makes the columns of them again.
#[derive(Debug, Clone)]
pub(super) struct Basis {
    /// Of length one; without an entry where a column depends on those before it.
    directions: Vec<Option<Vec<f64>>>,
    /// Column by column: coefficients of the directions up to its own.
    triangle: Vec<Vec<f64>>,
}

impl Basis {
    /// A column of which less than this part is left, without those before it, depends on them.
    const MIN_INDEPENDENT_SHARE: f64 = 1e-6;

    /// Of columns, in their order.
    pub(super) fn new(columns: Vec<Vec<f64>>) -> Self {
        let mut basis = Self {
            directions: Vec::with_capacity(columns.len()),
            triangle: Vec::with_capacity(columns.len()),
        };
        for mut column in columns {
            let whole = dot(&column, &column).sqrt();
            let mut coefficients = basis.take_from(&mut column);
            for (coefficient, again) in coefficients.iter_mut().zip(basis.take_from(&mut column)) {
                *coefficient += again;
            }
            let left = dot(&column, &column).sqrt();
            let known = left.is_finite() && left > Self::MIN_INDEPENDENT_SHARE * whole;
            coefficients.push(if known { left } else { 0.0 });
            basis.triangle.push(coefficients);
            basis.directions.push(known.then(|| {
                column.iter_mut().for_each(|value| *value /= left);
                column
            }));
        }
        basis
    }

    /// Takes out of values what the columns explain; returns the coefficients of the directions.
    pub(super) fn take_from(&self, values: &mut [f64]) -> Vec<f64> {
        self.directions
            .iter()
            .map(|direction| {
                let Some(direction) = direction else {
                    return 0.0;
                };
                let coefficient = dot(direction, values);
                for (value, along) in values.iter_mut().zip(direction) {
                    *value -= coefficient * along;
                }
                coefficient
            })
            .collect()
    }

    /// The multiples of the columns that give these coefficients of the directions: R⁻¹ q; zero for
    /// a column that depends on others.
    pub(super) fn multiples(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut rest = coefficients.to_vec();
        for j in (0..self.triangle.len()).rev() {
            let column = &self.triangle[j];
            let multiple = if column[j] > 0.0 {
                rest[j] / column[j]
            } else {
                0.0
            };
            for (value, along) in rest.iter_mut().zip(&column[..j]) {
                *value -= multiple * along;
            }
            rest[j] = multiple;
        }
        rest
    }

    /// The number of its columns.
    pub(super) fn len(&self) -> usize {
        self.triangle.len()
    }

    /// The variance of each multiple for noise of variance one: the diagonal of (RᵀR)⁻¹.
    pub(super) fn variances(&self) -> Vec<f64> {
        let mut variances = vec![0.0; self.len()];
        for j in 0..self.len() {
            let mut unit = vec![0.0; self.len()];
            unit[j] = 1.0;
            for (variance, multiple) in variances.iter_mut().zip(self.multiples(&unit)) {
                *variance += multiple * multiple;
            }
        }
        variances
    }

    /// True if a column is independent of those before it.
    pub(super) fn is_known(&self, column: usize) -> bool {
        self.directions[column].is_some()
    }

    /// The products of each direction with values, summed over groups of about equal length:
    /// one row a group.
    pub(super) fn in_groups(&self, values: &[f64], groups: usize) -> Vec<Vec<f64>> {
        let length = values.len().div_ceil(groups.max(1)).max(1);
        (0..values.len())
            .step_by(length)
            .map(|from| {
                let part = from..(from + length).min(values.len());
                let product = |direction: &Option<Vec<f64>>| {
                    let of =
                        |direction: &Vec<f64>| dot(&direction[part.clone()], &values[part.clone()]);
                    direction.as_ref().map_or(0.0, of)
                };
                self.directions.iter().map(product).collect()
            })
            .collect()
    }
}

pub(super) fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_of_columns_are_found_again_and_dependent_ones_are_known() {
        let x: Vec<f64> = (0..50).map(|k| f64::from(k).sin()).collect();
        let y: Vec<f64> = (0..50).map(|k| f64::from(k % 7)).collect();
        let both: Vec<f64> = x.iter().zip(&y).map(|(x, y)| 2.0 * x - y).collect();
        let basis = Basis::new(vec![x.clone(), y.clone(), both]);
        assert!(basis.is_known(0) && basis.is_known(1) && !basis.is_known(2));
        let mut values: Vec<f64> = x.iter().zip(&y).map(|(x, y)| 3.0 * x + 0.5 * y).collect();
        let found = basis.multiples(&basis.take_from(&mut values));
        assert!((found[0] - 3.0).abs() < 1e-9 && (found[1] - 0.5).abs() < 1e-9);
        assert!(dot(&values, &values) < 1e-18);
    }
}
