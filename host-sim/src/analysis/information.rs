//! The information on a servo's parameters in a motion, for any estimator.
//!
//! A unit of a parameter θ changes the model's position by s_θ with s̈ = −(a + l_d) ṡ − l_p s + φ_θ. Here φ is −q̇ for
//! a, u for b, −sign q̇ for the Coulomb friction and 1 for the load. The correction that keeps a model beside its servo
//! has l_p = ω² and l_d = 2ω − a. With rounding of variance σ² the standard error is at least σ √(Σ s sᵀ)⁻¹ (Cramér and
//! Rao).

use identifier_core::parameters::Parameter;

/// The information that has come together.
#[derive(Debug, Clone)]
pub(super) struct Information {
    parameters: Vec<Parameter>,
    /// Frequency of the correction, rad/s.
    omega: f64,
    sample_time: f64,
    /// Variance of a position, rad².
    variance: f64,
    /// s and ṡ of every parameter.
    states: Vec<[f64; 2]>,
    /// Σ s sᵀ.
    sum: Vec<Vec<f64>>,
}

impl Information {
    pub(super) fn new(
        parameters: &[Parameter],
        omega: f64,
        sample_time: f64,
        variance: f64,
    ) -> Self {
        let count = parameters.len();
        Self {
            parameters: parameters.to_vec(),
            omega,
            sample_time,
            variance,
            states: vec![[0.0; 2]; count],
            sum: vec![vec![0.0; count]; count],
        }
    }

    /// A sample: the velocity in it, rad/s, and the command.
    pub(super) fn add(&mut self, velocity: f64, command: f64) {
        for row in 0..self.states.len() {
            for column in 0..self.states.len() {
                self.sum[row][column] += self.states[row][0] * self.states[column][0];
            }
        }
        let sign = if velocity == 0.0 {
            0.0
        } else {
            velocity.signum()
        };
        for (parameter, state) in self.parameters.iter().zip(&mut self.states) {
            let shift = match parameter {
                Parameter::A => -velocity,
                Parameter::B => command,
                Parameter::Coulomb => -sign,
                Parameter::Load => 1.0,
            };
            *state = stepped(*state, shift, self.omega, self.sample_time);
        }
    }

    /// The least standard error of each parameter, SI; infinite where the motion says nothing of it.
    pub(super) fn standard_errors(&self) -> Vec<f64> {
        let count = self.states.len();
        // Scaled, so that units do not matter.
        let scale: Vec<f64> = (0..count).map(|i| self.sum[i][i].sqrt()).collect();
        if scale.iter().any(|scale| *scale <= 0.0) {
            let known = |scale: &f64| match *scale > 0.0 {
                true => self.variance.sqrt() / scale,
                false => f64::INFINITY,
            };
            return scale.iter().map(known).collect();
        }
        let scaled = |i: usize, j: usize| self.sum[i][j] / (scale[i] * scale[j]);
        (0..count)
            .map(|place| {
                let inverse = diagonal_of_inverse(count, place, scaled);
                (inverse * self.variance).sqrt() / scale[place]
            })
            .collect()
    }

    /// The parameters that it is on.
    pub(super) fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }
}

/// s and ṡ a sample later, with both poles at −ω and a held shift: exact.
fn stepped([s, rate]: [f64; 2], shift: f64, omega: f64, time: f64) -> [f64; 2] {
    let rest = shift / (omega * omega);
    let decay = (-omega * time).exp();
    let from = s - rest;
    let mixed = rate + omega * from;
    [
        rest + decay * (from + mixed * time),
        decay * (rate - omega * mixed * time),
    ]
}

/// An element of the inverse's diagonal of a positive definite matrix, by elimination with that row last. Infinite if
/// there is no inverse.
fn diagonal_of_inverse(count: usize, place: usize, of: impl Fn(usize, usize) -> f64) -> f64 {
    /// Below this a pivot is rounding.
    const NOTHING: f64 = 1e-12;
    let order: Vec<usize> = (0..count).filter(|i| *i != place).chain([place]).collect();
    let mut rows: Vec<Vec<f64>> = order
        .iter()
        .map(|i| order.iter().map(|j| of(*i, *j)).collect())
        .collect();
    for pivot in 0..count {
        if rows[pivot][pivot] <= NOTHING {
            return f64::INFINITY;
        }
        for row in pivot + 1..count {
            let part = rows[row][pivot] / rows[pivot][pivot];
            for column in pivot..count {
                let taken = part * rows[pivot][column];
                rows[row][column] -= taken;
            }
        }
    }
    1.0 / rows[count - 1][count - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_command_shows_b_as_the_closed_form_says() {
        // s rests at u/ω², so that N samples leave σ ω²/(u √N).
        let mut known = Information::new(&[Parameter::B], 50.0, 1e-3, 1e-8);
        for _ in 0..1_000_000 {
            known.add(0.0, 2.0);
        }
        let expected = 1e-4 * 2500.0 / (2.0 * 1000.0);
        let told = known.standard_errors()[0];
        assert!((told / expected - 1.0).abs() < 1e-3, "{told}, {expected}");
    }

    #[test]
    fn a_constant_command_is_not_distinguished_from_a_load() {
        // A command that never changes is a load.
        let both = [Parameter::B, Parameter::Load];
        let mut known = Information::new(&both, 50.0, 1e-3, 1e-8);
        for _ in 0..1000 {
            known.add(0.0, 2.0);
        }
        assert_eq!(known.standard_errors(), [f64::INFINITY; 2]);
        for _ in 0..1000 {
            known.add(0.0, -2.0);
        }
        assert!(
            known
                .standard_errors()
                .iter()
                .all(|error| error.is_finite())
        );
        let mut nothing = Information::new(&[Parameter::A], 50.0, 1e-3, 1e-8);
        nothing.add(0.0, 1.0);
        nothing.add(0.0, 1.0);
        assert_eq!(nothing.standard_errors(), [f64::INFINITY]);
    }
}
