//! The motion of the model with its derivatives, moved over a part of a sample.

use super::acting::{Acting, Shape};
use super::front_end::FrontEnd;
use super::twisting::Twisting;
use super::{Column, Effect, Values};

/// The motion of the model and its derivatives, relative to the record. A `PLAIN` one has the effects of every servo
/// alone, and columns of the first of them.
pub(super) struct State<'c, const C: usize, const PLAIN: bool> {
    /// Measured less model position, counts.
    pub(super) error: f64,
    pub(super) velocity: f64,
    /// The load that walks.
    pub(super) load: f64,
    /// Acceleration over the last sample.
    pub(super) acceleration: f64,
    /// The twist of the spring between motor and load.
    pub(super) twisting: Twisting,
    /// The encoder's position within the backlash, from its middle.
    pub(super) backlash: f64,
    /// True if there is backlash, or a column of it.
    pub(super) has_backlash: bool,
    pub(super) columns: &'c [Column],
    /// Those of columns that have one of their own.
    pub(super) resonances: &'c [OwnResonance],
    /// The column of the delay.
    pub(super) delay: Option<usize>,
    pub(super) tangents: Tangents<C>,
    /// The response over either part of a sample, which is nearly always that of the last sample. It is elsewhere in
    /// memory, because the compiler keeps no state in registers beside an array that is indexed by a variable.
    pub(super) responses: &'c mut [Response; 2],
}

/// Derivatives of the state by each column, by quantity: the processor takes several columns at once.
#[derive(Clone, Copy)]
pub(super) struct Tangents<const C: usize> {
    pub(super) error: [f64; C],
    pub(super) velocity: [f64; C],
    load: [f64; C],
    /// Derivative of the current by a shape of the command.
    current: [f64; C],
    /// Derivative of the acceleration over the last sample.
    pub(super) acceleration: [f64; C],
    /// For a column with a resonance of its own, the twist per κ and its rate.
    twisted: [[f64; 2]; C],
    /// Derivative of the twist of the spring.
    pub(super) twisting: [Twisting; C],
    /// Derivative of the force with which the spring brakes the motor.
    pub(super) held: [f64; C],
    /// Derivative of the position within the backlash. For a column with a backlash of its own it is that position.
    backlash: [f64; C],
}

impl<const C: usize> Tangents<C> {
    pub(super) const NONE: Self = Self {
        error: [0.0; C],
        velocity: [0.0; C],
        load: [0.0; C],
        current: [0.0; C],
        acceleration: [0.0; C],
        twisted: [[0.0; 2]; C],
        twisting: [Twisting::NONE; C],
        held: [0.0; C],
        backlash: [0.0; C],
    };
}

/// A sample of ÿ + 2ζω ẏ + ω² y = ω² q̈ under a constant q̈, exact at any ω: it turns and shrinks the way to q̈.
#[derive(Clone, Copy, Default)]
pub(super) struct OwnResonance {
    kept: [f64; 2],
    rate: [f64; 2],
}

impl OwnResonance {
    /// Of a column; none turns where it has no resonance of its own.
    pub(super) fn of(column: &Column) -> Self {
        if column.effect != Effect::Compliance || column.setting == 0.0 {
            return Self::default();
        }
        let (frequency, damping) = (column.setting, Values::USUAL_DAMPING);
        let turning = frequency * libm::sqrt(1.0 - damping * damping);
        let (sine, cosine) = libm::sincos(turning);
        let left = libm::exp(-damping * frequency);
        let per_rate = left * sine / turning;
        let slow = damping * frequency * per_rate;
        Self {
            kept: [left * cosine + slow, per_rate],
            rate: [-frequency * frequency * per_rate, left * cosine - slow],
        }
    }

    fn process(&self, [y, rate]: &mut [f64; 2], acceleration: f64) {
        let (way, before) = (*y - acceleration, *rate);
        *y = acceleration + self.kept[0] * way + self.kept[1] * before;
        *rate = self.rate[0] * way + self.rate[1] * before;
    }
}

/// (1 − e^(−z))/z and (1 − (1 − e^(−z))/z)/z times powers of the length, with their derivatives by a.
#[derive(Clone, Copy, Default)]
pub(super) struct Response {
    a: f64,
    length: f64,
    /// The part of a velocity that is left at the end.
    kept: f64,
    velocity: f64,
    position: f64,
    velocity_per_a: f64,
    position_per_a: f64,
}

impl Response {
    #[inline]
    fn new(a: f64, length: f64) -> Self {
        let z = a * length;
        let square = length * length;
        let series = |c: [f64; 5]| c[0] - z * (c[1] - z * (c[2] - z * (c[3] - z * c[4])));
        let velocity = length * series([1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0]);
        Self {
            a,
            length,
            kept: 1.0 - a * velocity,
            velocity,
            position: square * series([1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0]),
            velocity_per_a: -square
                * series([1.0 / 2.0, 1.0 / 3.0, 1.0 / 8.0, 1.0 / 30.0, 1.0 / 144.0]),
            position_per_a: -square
                * length
                * series([1.0 / 6.0, 1.0 / 12.0, 1.0 / 40.0, 1.0 / 180.0, 1.0 / 1008.0]),
        }
    }

    /// That over another length, which is its own where it has been computed.
    #[inline]
    fn over(&mut self, a: f64, length: f64) -> Self {
        if self.a.to_bits() != a.to_bits() || self.length.to_bits() != length.to_bits() {
            *self = Self::new(a, length);
        }
        *self
    }

    /// The velocity at the end.
    #[inline]
    fn after(&self, velocity: f64, pushed: f64) -> f64 {
        self.kept * velocity + self.velocity * pushed
    }
}

/// The error of an eccentric encoder where the angle has this sine and cosine, counts.
fn eccentric(values: &Values, [sine, cosine]: [f64; 2]) -> f64 {
    values.get(Effect::EccentricitySine) * sine + values.get(Effect::EccentricityCosine) * cosine
}

/// The same per unit of an effect.
const fn eccentric_per(effect: Effect, [sine, cosine]: [f64; 2]) -> f64 {
    match effect {
        Effect::EccentricitySine => sine,
        Effect::EccentricityCosine => cosine,
        _ => 0.0,
    }
}

impl<const C: usize, const PLAIN: bool> State<'_, C, PLAIN> {
    /// The innovation, and the regressor of each column. The pair `wave` is sin q and cos q minus those at the
    /// beginning of the motion, where an encoder counts from.
    #[inline]
    pub(super) fn innovation(
        &self,
        values: &Values,
        wave: [f64; 2],
        regressor: &mut [f64; C],
    ) -> f64 {
        let tangents = &self.tangents;
        for (regressor, error) in regressor.iter_mut().zip(&tangents.error) {
            *regressor = -error;
        }
        if PLAIN {
            return self.error;
        }
        let twist = values.get(Effect::Compliance);
        let lag = values.get(Effect::EncoderOnLoad);
        for (i, column) in self.columns.iter().enumerate() {
            regressor[i] += twist * tangents.acceleration[i] - lag * tangents.twisting[i].twist;
            regressor[i] += match column.effect {
                Effect::Compliance if column.setting > 0.0 => tangents.twisted[i][0],
                Effect::Compliance => self.acceleration,
                effect => tangents.backlash[i] + eccentric_per(effect, wave),
            };
        }
        self.error + lag * self.twisting.twist
            - twist * self.acceleration
            - self.backlash
            - eccentric(values, wave)
    }

    /// Updates the twist of columns that have a resonance of their own, with the acceleration over the last sample. It
    /// is y of ÿ + 2ζω ẏ + ω² y = ω² q̈. The motor is ahead of both masses by y per κ = ρ/((1 − ρ) ω²).
    pub(super) fn twist_columns(&mut self) {
        for (own, twisted) in self.resonances.iter().zip(&mut self.tangents.twisted) {
            own.process(twisted, self.acceleration);
        }
    }

    /// Moves the motor by a displacement, counts, from earlier derivatives of the error. The motor stays within the
    /// backlash or takes the encoder along.
    pub(super) fn take_up_backlash(&mut self, backlash: f64, travel: f64, earlier: &[f64; C]) {
        let wanted = self.backlash - travel;
        let half = 0.5 * backlash;
        self.backlash = wanted.max(-half).min(half);
        let tangents = &mut self.tangents;
        for (i, column) in self.columns.iter().enumerate() {
            let place = &mut tangents.backlash[i];
            *place = match column.effect {
                Effect::Backlash if column.setting > 0.0 => {
                    (*place - travel / column.setting).clamp(-0.5, 0.5)
                }
                _ if wanted.abs() < half => *place - (earlier[i] - tangents.error[i]),
                Effect::Backlash => 0.5 * wanted.signum(),
                _ => 0.0,
            };
        }
    }

    /// Takes the innovation in.
    #[inline]
    pub(super) fn correct(&mut self, gain: &[f64; 3], innovation: f64, regressor: &[f64; C]) {
        self.error -= gain[0] * innovation;
        self.velocity += gain[1] * innovation;
        self.load += gain[2] * innovation;
        let tangents = &mut self.tangents;
        for i in 0..C {
            tangents.error[i] += gain[0] * regressor[i];
            tangents.velocity[i] -= gain[1] * regressor[i];
            tangents.load[i] -= gain[2] * regressor[i];
        }
    }

    /// The column of the delay. For a plain model the compiler knows it and keeps the tangents in registers.
    #[inline]
    pub(super) fn delay(&self) -> Option<usize> {
        if PLAIN {
            Some(Effect::Delay as usize)
        } else {
            self.delay
        }
    }

    /// True if there is backlash, or a column of it.
    #[inline]
    pub(super) fn has_backlash(&self) -> bool {
        !PLAIN && self.has_backlash
    }

    /// The value of an effect that a plain servo does not have.
    #[inline]
    pub(super) fn extra(values: &Values, effect: Effect) -> f64 {
        if PLAIN { 0.0 } else { values.get(effect) }
    }

    /// The command steps between two parts of a sample. A longer delay, the column at `place`, makes the earlier push
    /// act longer. A spring takes `held` of either.
    #[inline]
    pub(super) fn pass_step(&mut self, acting: &Acting<'_>, earlier: f64, held: f64, place: usize) {
        let push = acting.push - held;
        let longer = if self.velocity != 0.0 {
            earlier - acting.push
        } else {
            let low_speed = Self::extra(acting.values, Effect::LowSpeed);
            let friction = acting.coulomb + low_speed * acting.friction;
            if push.abs() <= friction {
                0.0
            } else {
                friction * push.signum() - push
            }
        };
        self.tangents.velocity[place] += longer;
        if !PLAIN {
            self.tangents.twisting[place].rate += longer;
        }
    }

    /// The derivatives of the command over a part of a sample by the columns of its shape.
    #[inline]
    pub(super) fn shaped(&mut self, acting: &Acting<'_>) -> [f64; C] {
        let mut shaped = [0.0; C];
        if !PLAIN {
            for (i, column) in self.columns.iter().enumerate() {
                if FrontEnd::is_shape(column.effect) {
                    let current = &mut self.tangents.current[i];
                    let front_end = acting.front_end;
                    shaped[i] = front_end.derivative(acting.record, acting.part, column, current);
                }
            }
        }
        shaped
    }

    /// Moves the model over a piece of a part of a sample in which the command is constant. Friction may stop or
    /// reverse it on the way.
    #[inline]
    pub(super) fn advance_motor(&mut self, acting: &Acting<'_>, shaped: &[f64; C]) {
        let values = acting.values;
        let friction_by = |effect| Self::extra(values, effect) * acting.friction;
        let low_speed = friction_by(Effect::LowSpeed);
        let fading = Self::extra(values, Effect::LowSpeedVelocity);
        let per_square = if fading > 0.0 {
            1.0 / (fading * fading)
        } else {
            0.0
        };
        let viscous = values.get(Effect::A) * acting.friction;
        let asymmetry = friction_by(Effect::Asymmetry);
        let quadratic = friction_by(Effect::Quadratic);
        // Half of the inertia's change takes momentum as friction does: ½ i′(q) q̇².
        let inertia_rate = 0.5 * acting.inertia_change * acting.per_inertia;
        let mut left = acting.length;
        let mut turned = false;
        // The derivative of the length that is left, for each column.
        let mut lengths = [0.0; C];
        // From the second piece on the model begins at rest.
        for _ in 0..4 {
            let velocity = self.velocity;
            let direction = if velocity > 0.0 {
                1.0
            } else if velocity < 0.0 {
                -1.0
            } else {
                if acting.push.abs() <= acting.coulomb + low_speed {
                    self.tangents.velocity = [0.0; C];
                    return;
                }
                acting.push.signum()
            };
            let uniform = viscous + inertia_rate + asymmetry * direction;
            // What goes with the speed is that of its middle, which is known after one try.
            let mut is_again = low_speed != 0.0 || quadratic != 0.0;
            let mut middle = velocity;
            let (rate, mut response, stribeck_factor, pushed, after) = loop {
                let rate = match quadratic != 0.0 {
                    true => uniform + quadratic * middle.abs(),
                    false => uniform,
                };
                let response = self.responses[acting.part.last].over(rate, left);
                let mut stribeck_factor = 0.0;
                let mut friction = acting.coulomb;
                if low_speed != 0.0 {
                    stribeck_factor = libm::exp(-middle * middle * per_square);
                    friction += low_speed * stribeck_factor;
                }
                let pushed = acting.push - friction * direction;
                let after = response.after(velocity, pushed);
                if !is_again || after * direction <= 0.0 {
                    break (rate, response, stribeck_factor, pushed, after);
                }
                is_again = false;
                middle = 0.5 * (velocity + after);
            };
            // ∂(push)/∂velocity of what grows with the velocity's square, and of what fades with it.
            let mut coupling = 0.0;
            if low_speed != 0.0 || quadratic != 0.0 {
                let fading = 2.0 * middle.abs() * per_square * low_speed * stribeck_factor;
                coupling = fading - quadratic * middle.abs();
            }
            let acceleration = pushed - rate * velocity;
            let crosses = velocity != 0.0 && after * direction < 0.0;
            let mut length = left;
            if crosses {
                // The time at which it stops: along a straight line at first, then Newton's steps.
                length *= velocity / (velocity - after);
                for _ in 0..2 {
                    response = Response::new(rate, length);
                    let rest = velocity + acceleration * response.velocity;
                    length -= rest / (pushed - rate * rest);
                }
                response = Response::new(rate, length);
            }
            let shape = Shape {
                direction,
                viscous: rate - inertia_rate,
                stribeck_factor,
                low_speed,
                middle,
                fading,
                acceleration,
                pushed,
            };
            let (mut forcing, mut per_rate) = ([0.0; C], [0.0; C]);
            if PLAIN {
                let of_base = [
                    (0.0, 1.0),
                    (acting.part.command, 0.0),
                    (-direction, 0.0),
                    (1.0, 0.0),
                ];
                for (i, own) in of_base.into_iter().enumerate().take(C) {
                    (forcing[i], per_rate[i]) = own;
                }
            } else {
                acting.force(self.columns, &shape, shaped, &mut forcing, &mut per_rate);
            }
            let tangents = &mut self.tangents;
            let kept = response.kept + coupling * response.velocity;
            for i in 0..C {
                let before = tangents.velocity[i];
                let load = if PLAIN {
                    tangents.load[i]
                } else {
                    tangents.load[i] - tangents.held[i]
                };
                let forcing = forcing[i] + acting.motor_inertia_inverse * load;
                tangents.velocity[i] = kept * before + forcing * response.velocity;
                tangents.error[i] -= before * response.velocity + forcing * response.position;
            }
            for (i, &per_rate) in per_rate.iter().enumerate() {
                if per_rate != 0.0 {
                    tangents.velocity[i] += per_rate
                        * (acceleration * response.velocity_per_a - velocity * response.velocity);
                    tangents.error[i] -= per_rate
                        * (velocity * response.velocity_per_a + pushed * response.position_per_a);
                }
            }
            if turned {
                // The model left rest later or earlier.
                for (i, length) in lengths.iter().enumerate() {
                    tangents.velocity[i] += pushed * response.kept * length;
                    tangents.error[i] -= pushed * response.velocity * length;
                }
            }
            self.error -= velocity * response.velocity + pushed * response.position;
            if !crosses {
                self.velocity = after;
                return;
            }
            // It stops later, and less of the sample is left.
            lengths = tangents.velocity.map(|change| change / pushed);
            tangents.velocity = [0.0; C];
            self.velocity = 0.0;
            left -= length;
            turned = true;
        }
    }
}
