//! A pass of the model over a record, with the derivatives of its output error.

use super::front_end::{Current, FrontEnd, Part};
use super::gain::{Diffuse, Riccati};
use super::waves::Waves;
use super::{Column, Effect, Horizon, Record, Values};

/// The most columns of a pass.
pub const MAX_COLUMNS: usize = 72;

/// A sample of a pass.
#[derive(Debug)]
pub struct Row<'a> {
    /// The sample.
    pub sample: usize,
    /// The innovation: measured less predicted position, counts.
    pub innovation: f64,
    /// Its variance over that of a measurement.
    pub variance: f64,
    /// The load that walks, counts/sample².
    pub walk: f64,
    /// The predicted position per unit of each column, counts.
    pub regressor: &'a [f64],
}

/// The model loop: the servo's model, driven by the recorded command and kept with the record by a Kalman
/// filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelPass<'a> {
    /// The record.
    pub record: &'a Record<'a>,
    /// The horizon of the filter.
    pub horizon: Horizon,
    /// Viscous friction that the filter's own model has, 1/sample; not a parameter of the fit, so that the
    /// filter stays while the fit searches.
    pub damping: f64,
    pub(super) diffuse: Diffuse,
}

/// The least relative friction by which is divided.
const MIN_DRIFT: f64 = 1e-3;

/// Innovations beyond this end a pass, counts.
const DIVERGED: f64 = 1e9;

/// The motion of the model and its derivatives, relative to the record.
struct State<'c, const C: usize> {
    /// Measured less model position, counts.
    error: f64,
    velocity: f64,
    /// The load that walks.
    load: f64,
    /// Acceleration over the last sample.
    acceleration: f64,
    columns: &'c [Column],
    tangents: [Tangent; C],
}

/// Derivatives of the state by a column.
#[derive(Clone, Copy, Default)]
struct Tangent {
    error: f64,
    velocity: f64,
    load: f64,
    /// Derivative of the current by a shape of the command, and of the command over the part.
    current: f64,
    shaped: f64,
    /// Derivative of the acceleration over the last sample.
    acceleration: f64,
}

/// The servo and the commands that act over a part of a sample.
struct Acting<'a> {
    values: &'a Values,
    front_end: &'a FrontEnd,
    part: &'a Part,
    motion: (usize, usize),
    sample: usize,
    record: &'a Record<'a>,
    waves: &'a Waves,
    length: f64,
    /// Gain, and the acceleration by the command.
    gain: f64,
    drive: f64,
    /// The mean size of that acceleration.
    effort: f64,
    /// Acceleration but for friction.
    push: f64,
    /// Coulomb friction with that which grows with the load.
    coulomb: f64,
    /// Relative friction at this time.
    drift: f64,
    /// Reciprocal of the relative inertia.
    ease: f64,
    /// Relative friction over relative inertia.
    friction: f64,
    /// Change of the relative inertia over the sample.
    inertia_change: f64,
    /// Reciprocal of the ripple of the gain.
    per_ripple: f64,
    /// The time that has passed, −½ to ½ of the record.
    passed: f64,
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

impl ModelPass<'_> {
    /// Runs the model with some values over the record and shows every sample to `observe`. Returns false
    /// if the model ran away.
    pub fn run(
        &self,
        values: &Values,
        columns: &[Column],
        observe: &mut impl FnMut(&Row<'_>),
    ) -> bool {
        // The tangents of a plain fit stay where the processor has them.
        match columns.len() {
            0 => self.run_with::<0>(values, columns, observe),
            1..=6 => self.run_with::<6>(values, columns, observe),
            7..=16 => self.run_with::<16>(values, columns, observe),
            _ => self.run_with::<MAX_COLUMNS>(values, columns, observe),
        }
    }

    fn run_with<const C: usize>(
        &self,
        values: &Values,
        columns: &[Column],
        observe: &mut impl FnMut(&Row<'_>),
    ) -> bool {
        let columns = &columns[..columns.len().min(C)];
        let front_end = FrontEnd::new(values, columns);
        let mut waves = Waves::new(columns);
        let mut regressor = [0.0; C];
        for motion in self.record.motions() {
            let mut state = State::<C> {
                error: 0.0,
                velocity: 0.0,
                load: 0.0,
                acceleration: 0.0,
                columns,
                tangents: [Tangent::default(); C],
            };
            let mut current = Current::default();
            let mut filter = Riccati::new(self.damping, self.horizon, &self.diffuse);
            for sample in motion.0..motion.1 {
                if self.record.is_measured(sample - motion.0) {
                    filter.measure();
                    let innovation = state.innovation(values, &mut regressor);
                    if innovation.is_nan() || innovation.abs() > DIVERGED {
                        return false;
                    }
                    observe(&Row {
                        sample,
                        innovation,
                        variance: filter.variance,
                        walk: state.load,
                        regressor: &regressor[..columns.len()],
                    });
                    state.correct(&filter.gain, innovation, &regressor);
                }
                filter.predict();
                let parts = front_end.process(self.record, motion, sample, &mut current);
                waves.place(self.record.wave(sample, 1.0));
                self.advance(
                    values,
                    &front_end,
                    &parts,
                    &waves,
                    (motion, sample),
                    &mut state,
                );
                if sample + 1 < motion.1 {
                    state.error += self.record.increment(sample);
                }
            }
        }
        true
    }

    #[inline]
    fn advance<const C: usize>(
        &self,
        values: &Values,
        front_end: &FrontEnd,
        parts: &[Part; 2],
        waves: &Waves,
        (motion, sample): ((usize, usize), usize),
        state: &mut State<'_, C>,
    ) {
        use Effect::{
            B, Coulomb, Delay, FrictionDrift, GainDrift, GravityCosine, GravitySine, InertiaCosine,
            InertiaSine, LoadFriction, RippleCosine, RippleSine, TorqueRippleCosine,
            TorqueRippleSine,
        };
        let record = self.record;
        let passed = sample as f64 / record.len() as f64 - 0.5;
        let has = |one: Effect, other: Effect| values.get(one) != 0.0 || values.get(other) != 0.0;
        let along = |one: Effect, other: Effect, order: f64| {
            let [sine, cosine] = record.wave(sample, order);
            values.get(one) * sine + values.get(other) * cosine
        };
        let mut load = values.get(Effect::Load) + state.load;
        if has(GravitySine, GravityCosine) {
            load += along(GravitySine, GravityCosine, 1.0);
        }
        if has(RippleSine, RippleCosine) {
            load += along(RippleSine, RippleCosine, values.order);
        }
        let mut gain = values.get(B) * (1.0 + values.get(GainDrift) * passed);
        let mut per_ripple = 1.0;
        if has(TorqueRippleSine, TorqueRippleCosine) {
            let ripple = 1.0 + along(TorqueRippleSine, TorqueRippleCosine, values.gain_order);
            gain *= ripple;
            per_ripple = 1.0 / ripple;
        }
        let (mut ease, mut inertia_change) = (1.0, 0.0);
        if has(InertiaSine, InertiaCosine) {
            let order = values.inertia_order;
            ease = 1.0 / (1.0 + along(InertiaSine, InertiaCosine, order)).max(0.1);
            let [sine, cosine] = record.wave_change(motion, sample, order);
            inertia_change = values.get(InertiaSine) * sine + values.get(InertiaCosine) * cosine;
        }
        let drift = (1.0 + values.get(FrictionDrift) * passed).max(0.0);
        let before = state.velocity;
        // Of a stiff shaft the accelerations' derivatives do not show.
        let twists = values.get(Effect::Compliance) != 0.0;
        let mut velocities = [0.0; C];
        if twists {
            for (velocity, tangent) in velocities.iter_mut().zip(&state.tangents) {
                *velocity = tangent.velocity;
            }
        }
        let mut last = None;
        for (i, part) in parts.iter().enumerate() {
            let drive = gain * part.command * ease;
            let effort = (gain * ease).abs() * part.size;
            let acting = Acting {
                values,
                front_end,
                part,
                motion,
                sample,
                record,
                waves,
                length: front_end.lengths[i],
                gain: gain * ease,
                drive,
                effort,
                push: drive + load * ease,
                coulomb: (values.get(Coulomb) * ease + values.get(LoadFriction) * effort) * drift,
                drift,
                ease,
                friction: drift * ease,
                inertia_change,
                per_ripple,
                passed,
            };
            // Behind a current loop the command has a slope and no step.
            if let Some(earlier) = last.filter(|_| !front_end.has_lag()) {
                state.pass_step(&acting, earlier, Delay);
            }
            if acting.length > 0.0 {
                state.advance(&acting);
            }
            last = Some(acting.push);
        }
        state.acceleration = state.velocity - before;
        if twists {
            for (tangent, velocity) in state.tangents.iter_mut().zip(velocities) {
                tangent.acceleration = tangent.velocity - velocity;
            }
        }
    }
}

impl<const C: usize> State<'_, C> {
    /// The innovation, and the regressor of each column.
    #[inline]
    fn innovation(&self, values: &Values, regressor: &mut [f64; C]) -> f64 {
        let twist = values.get(Effect::Compliance);
        for (i, column) in self.columns.iter().enumerate() {
            let tangent = &self.tangents[i];
            regressor[i] = -tangent.error + twist * tangent.acceleration;
            if column.effect == Effect::Compliance {
                regressor[i] += self.acceleration;
            }
        }
        self.error - twist * self.acceleration
    }

    /// Takes the innovation in.
    #[inline]
    fn correct(&mut self, gain: &[f64; 3], innovation: f64, regressor: &[f64; C]) {
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
    fn pass_step(&mut self, acting: &Acting<'_>, earlier: f64, delay: Effect) {
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
    fn advance(&mut self, acting: &Acting<'_>) {
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

/// Friction and motion over a piece of a sample.
struct Shape {
    direction: f64,
    bell: f64,
    low_speed: f64,
    middle: f64,
    fading: f64,
    acceleration: f64,
}

impl Acting<'_> {
    /// The change of the relative inertia over the sample per unit of a column of it.
    fn inertia_change_per(&self, column: &Column) -> f64 {
        let order = match column.setting {
            order if order > 0.0 => order,
            _ => self.values.inertia_order,
        };
        let change = self.record.wave_change(self.motion, self.sample, order);
        change[usize::from(column.effect == Effect::InertiaCosine)]
    }

    /// The acceleration per unit of a column, `shaped` being the derivative of the command.
    #[inline]
    fn forcing(&self, column: &Column, shape: &Shape, shaped: f64) -> f64 {
        // At the column's order where it has one, else at the model's.
        let wave_of = |own: f64| {
            let order = if column.setting > 0.0 {
                column.setting
            } else {
                own
            };
            let known = self.waves.get(order);
            known.unwrap_or_else(|| self.record.wave(self.sample, order))
        };
        // Of a push by the command friction that grows with the load takes a part.
        let slowing = self.values.get(Effect::LoadFriction) * self.drift * shape.direction;
        let kept = 1.0 - slowing * self.drive.signum();
        let driven = self.drive - slowing * self.effort;
        match column.effect {
            Effect::B => driven / self.values.get(Effect::B),
            Effect::Coulomb => -shape.direction * self.friction,
            Effect::Load => self.ease,
            Effect::Delay => -kept * self.gain * self.part.slope,
            Effect::CurrentLoop => kept * self.gain * self.part.per_lag,
            Effect::LowSpeed => {
                let bell = if column.setting > 0.0 {
                    let ratio = shape.middle / column.setting;
                    libm::exp(-ratio * ratio)
                } else {
                    shape.bell
                };
                -shape.direction * bell * self.friction
            }
            Effect::LowSpeedVelocity => {
                let ratio = shape.middle / shape.fading.max(f64::MIN_POSITIVE);
                -shape.low_speed * shape.bell * 2.0 * ratio * ratio
                    / shape.fading.max(f64::MIN_POSITIVE)
                    * shape.direction
            }
            Effect::GravitySine => wave_of(1.0)[0] * self.ease,
            Effect::GravityCosine => wave_of(1.0)[1] * self.ease,
            Effect::RippleSine => wave_of(self.values.order)[0] * self.ease,
            Effect::RippleCosine => wave_of(self.values.order)[1] * self.ease,
            Effect::DeadBand | Effect::GainAsymmetry | Effect::LimitSlope | Effect::HiddenLimit => {
                kept * self.gain * shaped
            }
            Effect::LoadFriction => -self.effort * self.drift * shape.direction,
            Effect::GainDrift => {
                let drift = self.values.get(Effect::GainDrift) * self.passed;
                driven * self.passed / (1.0 + drift)
            }
            Effect::FrictionDrift => {
                let friction = self.coulomb + shape.low_speed * shape.bell;
                -shape.direction * friction * self.passed / self.drift.max(MIN_DRIFT)
            }
            Effect::TorqueRippleSine => {
                driven * self.per_ripple * wave_of(self.values.gain_order)[0]
            }
            Effect::TorqueRippleCosine => {
                driven * self.per_ripple * wave_of(self.values.gain_order)[1]
            }
            Effect::InertiaSine => {
                -shape.acceleration * self.ease * wave_of(self.values.inertia_order)[0]
            }
            Effect::InertiaCosine => {
                -shape.acceleration * self.ease * wave_of(self.values.inertia_order)[1]
            }
            Effect::A | Effect::Asymmetry | Effect::Quadratic | Effect::Compliance => 0.0,
        }
    }
}
