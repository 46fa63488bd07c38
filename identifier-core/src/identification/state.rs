//! The motion of the model with its derivatives, moved over a part of a sample.

use super::acting::{Acting, MIN_DRIFT, Shape};
use super::front_end::FrontEnd;
use super::{Column, Effect, Values};

/// The motion of the model and its derivatives, relative to the record.
pub(super) struct State<'c, const C: usize> {
    /// Measured less model position, counts.
    pub(super) error: f64,
    pub(super) velocity: f64,
    /// The load that walks.
    pub(super) load: f64,
    /// Acceleration over the last sample.
    pub(super) acceleration: f64,
    /// The encoder's place within the play, from its middle.
    pub(super) play: f64,
    /// True if there is play, or a column of it.
    pub(super) plays: bool,
    pub(super) columns: &'c [Column],
    pub(super) tangents: [Tangent; C],
}

/// Derivatives of the state by a column.
#[derive(Clone, Copy, Default)]
pub(super) struct Tangent {
    pub(super) error: f64,
    pub(super) velocity: f64,
    pub(super) load: f64,
    /// Derivative of the current by a shape of the command, and of the command over the part.
    pub(super) current: f64,
    pub(super) shaped: f64,
    /// Derivative of the acceleration over the last sample.
    pub(super) acceleration: f64,
    /// Derivative of the place within the play; of a column with a play of its own that place in it.
    play: f64,
}

impl Tangent {
    /// Those of some columns after a way of the motor, the place that it wanted to have, and half of the play.
    fn take_up_play(tangents: &mut [Self], columns: &[Column], earlier: &[Self], of: [f64; 3]) {
        let [way, wanted, half] = of;
        for ((column, tangent), earlier) in columns.iter().zip(tangents).zip(earlier) {
            tangent.play = match column.effect {
                Effect::Play if column.setting > 0.0 => {
                    (tangent.play - way / column.setting).clamp(-0.5, 0.5)
                }
                _ if wanted.abs() < half => tangent.play - (earlier.error - tangent.error),
                Effect::Play => 0.5 * wanted.signum(),
                _ => 0.0,
            };
        }
    }
}

/// (1 − e^(−z))/z and (1 − (1 − e^(−z))/z)/z times powers of the length, and their derivatives by a.
#[derive(Clone, Copy)]
struct Response {
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
        Self {
            velocity: length * series([1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0]),
            position: square * series([1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0]),
            velocity_per_a: -square
                * series([1.0 / 2.0, 1.0 / 3.0, 1.0 / 8.0, 1.0 / 30.0, 1.0 / 144.0]),
            position_per_a: -square
                * length
                * series([1.0 / 6.0, 1.0 / 12.0, 1.0 / 40.0, 1.0 / 180.0, 1.0 / 1008.0]),
        }
    }
}

impl<const C: usize> State<'_, C> {
    /// The innovation, and the regressor of each column.
    #[inline]
    pub(super) fn innovation(&self, values: &Values, regressor: &mut [f64; C]) -> f64 {
        let twist = values.get(Effect::Compliance);
        for (i, column) in self.columns.iter().enumerate() {
            let tangent = &self.tangents[i];
            regressor[i] = -tangent.error + twist * tangent.acceleration;
            regressor[i] += match column.effect {
                Effect::Compliance => self.acceleration,
                _ => tangent.play,
            };
        }
        self.error - twist * self.acceleration - self.play
    }

    /// The motor has moved by a way, counts, and each tangent from an earlier one: within the play, or it takes the encoder along.
    pub(super) fn take_up_play(&mut self, play: f64, way: f64, earlier: &[Tangent; C]) {
        let wanted = self.play - way;
        let half = 0.5 * play;
        self.play = wanted.max(-half).min(half);
        Tangent::take_up_play(
            &mut self.tangents,
            self.columns,
            earlier,
            [way, wanted, half],
        );
    }

    /// Takes the innovation in.
    #[inline]
    pub(super) fn correct(&mut self, gain: &[f64; 3], innovation: f64, regressor: &[f64; C]) {
        self.error -= gain[0] * innovation;
        self.velocity += gain[1] * innovation;
        self.load += gain[2] * innovation;
        let count = self.columns.len();
        for (tangent, predicted) in self.tangents.iter_mut().zip(&regressor[..count]) {
            tangent.error += gain[0] * predicted;
            tangent.velocity -= gain[1] * predicted;
            tangent.load -= gain[2] * predicted;
        }
    }

    /// The command steps between two parts of a sample: a longer delay lets the earlier push act longer.
    #[inline]
    pub(super) fn pass_step(&mut self, acting: &Acting<'_>, earlier: f64, delay: Effect) {
        let Some(place) = self.columns.iter().position(|one| one.effect == delay) else {
            return;
        };
        let change = if self.velocity != 0.0 {
            earlier - acting.push
        } else {
            let friction = acting.coulomb + acting.values.get(Effect::LowSpeed) * acting.friction;
            if acting.push.abs() <= friction {
                0.0
            } else {
                friction * acting.push.signum() - acting.push
            }
        };
        self.tangents[place].velocity += change;
    }

    /// Moves the model over a part of a sample in which the command is constant; friction may stop it or
    /// turn it round on the way.
    #[inline]
    pub(super) fn advance(&mut self, acting: &Acting<'_>) {
        let values = acting.values;
        let low_speed = values.get(Effect::LowSpeed) * acting.friction;
        let fading = values.get(Effect::LowSpeedVelocity);
        let per_square = if fading > 0.0 {
            1.0 / (fading * fading)
        } else {
            0.0
        };
        let friction_by = |effect: Effect| values.get(effect) * acting.friction;
        let viscous = friction_by(Effect::A);
        let asymmetry = friction_by(Effect::Asymmetry);
        let quadratic = friction_by(Effect::Quadratic);
        // Half of the inertia's change takes momentum as friction does: ½ i′(q) q̇².
        let swing = 0.5 * acting.inertia_change * acting.ease;
        let mut left = acting.length;
        // The derivative of the length that is left, for each column.
        let mut turned = false;
        let mut lengths = [0.0; C];
        let count = self.columns.len();
        for (column, tangent) in self.columns.iter().zip(&mut self.tangents) {
            if FrontEnd::is_shape(column.effect) {
                let current = &mut tangent.current;
                tangent.shaped =
                    acting
                        .front_end
                        .derivative(acting.record, acting.part, column, current);
            }
        }
        // From the second piece on the model begins at rest.
        for _ in 0..4 {
            let velocity = self.velocity;
            let direction = if velocity > 0.0 {
                1.0
            } else if velocity < 0.0 {
                -1.0
            } else {
                if acting.push.abs() <= acting.coulomb + low_speed {
                    for tangent in &mut self.tangents[..count] {
                        tangent.velocity = 0.0;
                    }
                    return;
                }
                acting.push.signum()
            };
            let rate = viscous + swing + asymmetry * direction + quadratic * velocity.abs();
            let response = Response::new(rate, left);
            let mut bell = 0.0;
            let mut friction = acting.coulomb;
            if low_speed != 0.0 {
                bell = libm::exp(-velocity * velocity * per_square);
                friction += low_speed * bell;
            }
            let mut pushed = acting.push - friction * direction;
            let mut after = velocity + (pushed - rate * velocity) * response.velocity;
            let mut middle = velocity;
            if low_speed != 0.0 && after * direction > 0.0 {
                middle = 0.5 * (velocity + after);
                bell = libm::exp(-middle * middle * per_square);
                pushed = acting.push - (acting.coulomb + low_speed * bell) * direction;
                after = velocity + (pushed - rate * velocity) * response.velocity;
            }
            let acceleration = pushed - rate * velocity;
            // ∂(push)/∂velocity of what fades with speed and of what grows with its square.
            let coupling =
                2.0 * middle.abs() * per_square * low_speed * bell - quadratic * velocity.abs();
            let crosses = velocity != 0.0 && after * direction < 0.0;
            let mut length = left;
            let mut response = response;
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
            let kept = 1.0 - rate * response.velocity + coupling * response.velocity;
            let shape = Shape {
                direction,
                bell,
                low_speed,
                middle,
                fading,
                acceleration,
            };
            for i in 0..count {
                let column = &self.columns[i];
                let tangent = &mut self.tangents[i];
                let mut forcing = acting.ease * tangent.load;
                let mut per_rate = 0.0;
                match column.effect {
                    Effect::A => per_rate = acting.friction,
                    Effect::Asymmetry => per_rate = acting.friction * direction,
                    Effect::Quadratic => per_rate = acting.friction * velocity.abs(),
                    Effect::FrictionDrift => {
                        per_rate = (rate - swing) * acting.passed / acting.drift.max(MIN_DRIFT);
                        forcing += acting.forcing(column, &shape, tangent.shaped);
                    }
                    Effect::InertiaSine | Effect::InertiaCosine => {
                        per_rate = 0.5 * acting.ease * acting.inertia_change_per(column);
                        forcing += acting.forcing(column, &shape, tangent.shaped);
                    }
                    _ => forcing += acting.forcing(column, &shape, tangent.shaped),
                }
                let before = tangent.velocity;
                let mut change = kept * before + forcing * response.velocity;
                let mut shift = before * response.velocity + forcing * response.position;
                if per_rate != 0.0 {
                    change += per_rate
                        * (acceleration * response.velocity_per_a - velocity * response.velocity);
                    shift += per_rate
                        * (velocity * response.velocity_per_a + pushed * response.position_per_a);
                }
                if turned {
                    // The model left rest later or earlier.
                    change += pushed * (1.0 - rate * response.velocity) * lengths[i];
                    shift += pushed * response.velocity * lengths[i];
                }
                tangent.error -= shift;
                if crosses {
                    // It stops later, and less of the sample is left.
                    lengths[i] = change / pushed;
                    tangent.velocity = 0.0;
                } else {
                    tangent.velocity = change;
                }
            }
            self.error -= velocity * response.velocity + pushed * response.position;
            if !crosses {
                self.velocity = after;
                return;
            }
            self.velocity = 0.0;
            left -= length;
            turned = true;
        }
    }
}
