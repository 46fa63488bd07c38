use identifier_core::number::Number;
use identifier_core::tuning::AxisForces;

/// The command that balances how the load changes with the angle. Counts and command units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Compensation<N> {
    /// −w_s/b and −w_c/b.
    wave: [N; 2],
    /// The phase of the wave, rad a count.
    per_count: N,
}

impl<N: Number> Compensation<N> {
    pub(super) const NONE: Self = Self {
        wave: [N::ZERO; 2],
        per_count: N::ZERO,
    };

    /// For a servo of gain b and an encoder of this resolution (rad).
    pub(super) fn new(forces: &AxisForces, b: f64, resolution: f64) -> Self {
        Self {
            wave: forces.wave.map(|force| N::from_f64(-force / b)),
            per_count: N::from_f64(forces.order * resolution),
        }
    }

    /// The command at a position, from where the commissioning began.
    #[inline]
    pub(super) fn command(&self, position: N) -> N {
        if self.per_count == N::ZERO {
            return N::ZERO;
        }
        let (sine, cosine) = (self.per_count * position).sine_cosine();
        let [of_sine, of_cosine] = self.wave;
        of_sine * sine + of_cosine * (cosine - N::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In f32, as far as its sine is exact: b u + w_s sin nq + w_c (cos nq − 1) = 0.
    #[test]
    fn it_balances_the_wave_everywhere() {
        let (b, resolution) = (40.0, 1e-3);
        let forces = AxisForces {
            wave: [30.0, -50.0],
            order: 7.0,
            ..AxisForces::NONE
        };
        let compensation = Compensation::<f32>::new(&forces, b, resolution);
        for count in -900..900_i16 {
            let phase = forces.order * resolution * f64::from(count);
            let [sine, cosine] = forces.wave;
            let load = sine * libm::sin(phase) + cosine * (libm::cos(phase) - 1.0);
            let left = b * f64::from(compensation.command(f32::from(count))) + load;
            assert!(
                left.abs() < 0.01 * forces.wave_amplitude(),
                "{count}: {left}"
            );
        }
        let none = Compensation::<f32>::new(&AxisForces::NONE, b, resolution);
        assert!(none.command(500.0).abs() < f32::MIN_POSITIVE);
    }
}
