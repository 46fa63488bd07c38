use crate::number::Number;

/// The forces on an axis beside the five numbers of its servo, over its inertia, near where it is. In SI, or
/// [in units](AxisForces::in_units) of a machine. The default is none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisForces<N = f64> {
    /// w_s and w_c of the load's change with the angle q, w_s sin nq + w_c (cos nq − 1), rad/s²: of gravity or a spring
    /// with n = 1, or of cogging.
    pub wave: [N; 2],
    /// n, periods to a revolution.
    pub order: N,
    /// Friction at rest beyond Coulomb friction, rad/s². It falls with the speed v as exp(−(v/v_s)²).
    pub low_speed: N,
    /// The most that it may be, rad/s², where only the break-away of the axis is known.
    pub most_low_speed: N,
    /// 1/v_s, s/rad.
    pub per_low_speed_velocity: N,
}

impl<N: Number> AxisForces<N> {
    /// The load of the wave at a position. Most axes have none of it, and a chip computes it long.
    #[must_use]
    #[inline]
    pub fn load(&self, position: N) -> N {
        if self.order == N::ZERO {
            return N::ZERO;
        }
        let [of_sine, of_cosine] = self.wave;
        let (sine, cosine) = (self.order * position).sine_cosine();
        of_sine * sine + of_cosine * (cosine - N::ONE)
    }
}

impl AxisForces {
    /// The same with forces in a unit of so many rad/s², and angles in one of so many rad.
    #[must_use]
    pub fn in_units<N: Number>(&self, force: f64, angle: f64) -> AxisForces<N> {
        let of_force = |value: f64| N::from_f64(value / force);
        AxisForces {
            wave: self.wave.map(of_force),
            order: N::from_f64(self.order * angle),
            low_speed: of_force(self.low_speed),
            most_low_speed: of_force(self.most_low_speed),
            per_low_speed_velocity: N::from_f64(self.per_low_speed_velocity * angle),
        }
    }

    /// True if the load changes within a motion by turns.
    #[must_use]
    pub fn has_cogging(&self) -> bool {
        self.order > 1.0
    }

    /// True if the load changes with the angle once to a revolution, as gravity and a spring do.
    #[must_use]
    pub fn has_gravity(&self) -> bool {
        self.order > 0.0 && !self.has_cogging()
    }

    /// The same from an angle that is so much farther, as a phase of the wave.
    #[must_use]
    pub fn at_phase(self, phase: f64) -> Self {
        let [sine, cosine] = self.wave;
        let (s, c) = (libm::sin(phase), libm::cos(phase));
        Self {
            wave: [sine * c - cosine * s, sine * s + cosine * c],
            ..self
        }
    }

    /// The largest force of the wave, rad/s².
    #[must_use]
    pub fn wave_amplitude(&self) -> f64 {
        let [sine, cosine] = self.wave;
        libm::hypot(sine, cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f(p + q) − f(p) is the load of the same wave from the angle p, whose phase is n p.
    #[test]
    fn the_load_of_a_wave_from_another_angle_is_the_difference_of_two() {
        let forces = AxisForces {
            wave: [3.0, -2.0],
            order: 7.0,
            ..AxisForces::default()
        };
        for p in [-1.3, 0.0, 0.2, 2.0] {
            let from = forces.at_phase(forces.order * p);
            for q in [-0.4, 0.1, 1.0] {
                let difference = forces.load(p + q) - forces.load(p);
                assert!((from.load(q) - difference).abs() < 1e-12);
            }
            assert!((from.wave_amplitude() - 13.0_f64.sqrt()).abs() < 1e-12);
        }
        assert!(forces.has_cogging() && !forces.has_gravity());
        let gravity = AxisForces {
            order: 1.0,
            ..forces
        };
        assert!(gravity.has_gravity() && !AxisForces::default().has_gravity());
    }

    /// In f32 as far as its sine is exact, with b as the unit of the forces: b f(q) is the load in SI.
    #[test]
    fn the_load_in_units_of_a_machine_is_that_in_si() {
        let (b, resolution) = (40.0, 1e-3);
        let forces = AxisForces {
            wave: [30.0, -50.0],
            order: 7.0,
            low_speed: 20.0,
            ..AxisForces::default()
        };
        let machine = forces.in_units::<f32>(b, resolution);
        for count in -900..900_i16 {
            let load = forces.load(resolution * f64::from(count));
            let left = b * f64::from(machine.load(f32::from(count))) - load;
            assert!(
                left.abs() < 0.01 * forces.wave_amplitude(),
                "{count}: {left}"
            );
        }
        assert!((machine.low_speed - 0.5).abs() < f32::EPSILON);
        assert_eq!(AxisForces::<f32>::default().load(500.0).to_bits(), 0);
    }
}
