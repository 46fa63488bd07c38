/// The forces on an axis beside the five numbers of its servo, over its inertia, near where it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisForces {
    /// The change of the load with the angle, as of gravity or a spring, 1/s².
    pub slope: f64,
    /// Friction at rest beyond Coulomb friction, rad/s². It falls with the speed v as exp(−(v/v_s)²).
    pub low_speed: f64,
    /// 1/v_s, s/rad.
    pub per_low_speed_velocity: f64,
}

impl AxisForces {
    /// None beside the servo's.
    pub const NONE: Self = Self {
        slope: 0.0,
        low_speed: 0.0,
        per_low_speed_velocity: 0.0,
    };
}
