/// The forces on an axis beside the five numbers of its servo, over its inertia, near where it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisForces {
    /// w_s and w_c of the load's change with the angle q, w_s sin nq + w_c (cos nq − 1), rad/s²: of gravity or a spring
    /// with n = 1, or of cogging.
    pub wave: [f64; 2],
    /// n, periods to a revolution.
    pub order: f64,
    /// Friction at rest beyond Coulomb friction, rad/s². It falls with the speed v as exp(−(v/v_s)²).
    pub low_speed: f64,
    /// The most that it may be, rad/s², where only the break-away of the axis is known.
    pub most_low_speed: f64,
    /// 1/v_s, s/rad.
    pub per_low_speed_velocity: f64,
}

impl AxisForces {
    /// None beside the servo's.
    pub const NONE: Self = Self {
        wave: [0.0; 2],
        order: 0.0,
        low_speed: 0.0,
        most_low_speed: 0.0,
        per_low_speed_velocity: 0.0,
    };

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

    /// The load of the wave at a position, rad/s². Most axes have none of it, and a chip computes it in double precision.
    pub(super) fn load(&self, position: f64) -> f64 {
        if self.order == 0.0 {
            return 0.0;
        }
        let [sine, cosine] = self.wave;
        let angle = self.order * position;
        sine * libm::sin(angle) + cosine * (libm::cos(angle) - 1.0)
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
            ..AxisForces::NONE
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
        assert!(gravity.has_gravity() && !AxisForces::NONE.has_gravity());
    }
}
