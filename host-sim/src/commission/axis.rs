//! The simulated axis that a commissioning moves.

use std::f64::consts::TAU;

use commissioning::CommissionInputs;
use identifier_core::reason::Reason;
use virtual_servo::{Encoder, VirtualBrake};

use crate::scenario::{Fault, Scenario};
use crate::virtual_axis::VirtualAxis;

const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// A servo with its encoder, as a scenario describes them.
#[derive(Debug, Clone)]
pub struct CommissionedAxis {
    axis: VirtualAxis,
    encoder: Encoder,
    /// Distance of its first position beyond an edge of the encoder, rad.
    beyond: f64,
    /// The command that balances the load at the servo's start, command units.
    balance: f64,
    brake: Option<VirtualBrake>,
    sample_time: f64,
}

impl CommissionedAxis {
    /// At rest where its encoder counts zero; how far beyond the edge follows from the seed.
    ///
    /// # Errors
    /// The key that it cannot be built from.
    pub fn new(scenario: &Scenario) -> Result<Self, Fault> {
        let units = scenario.checked_units()?;
        let parameters = scenario.servo()?;
        let counts = scenario.counts_per_rev;
        let effects = &scenario.effects;
        // Gravity and cogging at an angle of zero are their cosines.
        let load = parameters.load + effects.gravity[1] + effects.ripple[1];
        let acting = -load / parameters.b;
        let balance = match acting {
            0.0 => 0.0,
            acting => acting + effects.dead_band * acting.signum(),
        };
        // Multiples of the golden ratio fill an interval evenly (H. Weyl, 1916).
        let part = (f64::from(scenario.noise_seed()) * GOLDEN_RATIO).fract();
        Ok(Self {
            axis: VirtualAxis::new(scenario, &units)?,
            encoder: Encoder::new(counts.unwrap_or(TAU / units.position_unit())),
            beyond: part * units.position_unit(),
            balance,
            brake: (scenario.brake).map(|[opens, closes]| VirtualBrake::closed(opens, closes)),
            sample_time: units.sample_time(),
        })
    }

    /// The command that keeps it at its start, command units.
    #[must_use]
    pub fn balance(&self) -> f64 {
        self.balance
    }

    /// The same where that command has acted for long.
    #[must_use]
    pub fn held(mut self) -> Self {
        self.axis.servo = self.axis.servo.held_by(self.balance);
        self
    }

    /// Begins a sample: what is seen in it. The encoder's counter wraps at 32 bits.
    pub fn sense(&mut self) -> CommissionInputs {
        let (shown, condition) = self.axis.sense(self.beyond);
        let open = condition.limit_switch.then_some(Reason::LimitSwitch);
        let fault = condition.amplifier_fault.then_some(Reason::AmplifierFault);
        CommissionInputs {
            count: shown.map(|shown| self.encoder.read(shown) as i32),
            late: condition.late,
            stop: open.or(fault),
        }
    }

    /// Its true position, rad.
    #[must_use]
    pub fn position(&self) -> f64 {
        self.axis.servo.position()
    }

    /// Its true velocity, rad/s.
    #[must_use]
    pub fn velocity(&self) -> f64 {
        self.axis.servo.velocity()
    }

    /// Moves one sample under a held command.
    pub fn advance(&mut self, command: f64) {
        self.axis.advance(command);
    }

    /// The same with the holding brake of the scenario, which opens with power.
    pub fn advance_beside_brake(&mut self, command: f64, has_power: bool) {
        let (brake, time) = (self.brake.as_mut(), self.sample_time);
        if brake.is_some_and(|brake| brake.holds(has_power, time)) {
            let acting = self.axis.acting(command);
            self.axis.servo.stand(acting);
        } else {
            self.advance(command);
        }
    }
}
