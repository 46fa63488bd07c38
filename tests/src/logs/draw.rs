//! The drawing of a loop: servo, controller and reference, then effects in proportion to its motion.

use std::f64::consts::{PI, TAU};

use virtual_servo::{Effects, SensorEffects, ServoParameters, distinct_seed};

use super::{Controller, Effect, LoadStep, LoopSetup, RecordedLog, Reference};
use crate::Random;

/// The most effects of a log.
const MAX_EFFECTS: usize = 5;

/// The log of a number in the campaign of a seed, with zero to five effects. Loops that do not
/// work are drawn again.
///
/// # Panics
/// If no loop works.
#[must_use]
pub fn drawn(campaign: u32, number: u32) -> RecordedLog {
    let mut random = Random::new(distinct_seed(campaign, number));
    working(&mut random, RATES, &mut |random| {
        let count = random.uniform(0.0, MAX_EFFECTS as f64 + 1.0) as usize;
        let mut left = Effect::ALL.to_vec();
        let mut drawn = || left.swap_remove(random.uniform(0.0, left.len() as f64) as usize);
        (0..count).map(|_| drawn()).collect()
    })
}

/// The log of a number in the campaign of a seed, with these effects.
///
/// # Panics
/// If no loop works.
#[must_use]
pub fn drawn_with(campaign: u32, number: u32, effects: &[Effect]) -> RecordedLog {
    let mut random = Random::new(distinct_seed(campaign, number));
    working(&mut random, RATES, &mut |_| effects.to_vec())
}

/// The log of a number in the campaign of a seed, without effects and with a sample rate (Hz), that covers some counts or
/// more.
///
/// # Panics
/// If no loop works.
#[must_use]
pub fn exact(campaign: u32, number: u32, rate: f64, counts: f64) -> RecordedLog {
    let mut random = Random::new(distinct_seed(campaign, number));
    loop {
        let log = working(&mut random, [rate, rate], &mut |_| Vec::new());
        if log.range * log.setup.counts_per_rev >= counts * TAU {
            return log;
        }
    }
}

/// The log of a number in the campaign of a seed: two masses, friction up to 8 % of the command and at most 1.6 samples of
/// delay, in ordinary motion for 15 s. The encoder is on the motor, or on the load. Without masses it is the same servo as
/// one mass.
///
/// # Panics
/// If no loop works.
#[must_use]
pub fn two_masses(campaign: u32, number: u32, masses: Masses) -> RecordedLog {
    const RATES: [f64; 2] = [500.0, 4000.0];
    const DURATION: f64 = 15.0;
    let mut random = Random::new(distinct_seed(campaign, number));
    loop {
        let mut setup = exact_setup(&mut random, RATES);
        let authority = setup.servo.b * setup.limit;
        setup.servo.coulomb = authority * random.log_uniform(0.002, 0.08);
        setup.samples = (DURATION / setup.sample_time) as usize;
        setup.skipped = 0;
        setup.effects.delay = random.uniform(0.0, 1.6) * setup.sample_time;
        let resonance = random.log_uniform(60.0, 4000.0);
        let (share, damping) = (random.uniform(0.1, 0.85), random.log_uniform(0.005, 0.08));
        if masses != Masses::One {
            setup.effects.resonance = resonance;
            setup.effects.inertia_ratio = share;
            setup.effects.resonance_damping = Some(damping);
            setup.effects.encoder_on_load = masses == Masses::TwoWithEncoderOnLoad;
        }
        if matches!(setup.controller, Controller::Relay { .. }) {
            continue;
        }
        let log = setup.record();
        if log.works() && log.limited < 0.05 {
            return log;
        }
    }
}

/// The log of a number in the campaign of a seed: a pendulum, an arm or a gimbal, which gravity holds or throws over, in a
/// motion from a tenth to ten times its own frequency, in a loop or driven openly.
///
/// # Panics
/// If a controller has no servo that it suits.
#[must_use]
pub fn under_gravity(campaign: u32, number: u32) -> RecordedLog {
    const MIN_COUNTS: f64 = 100.0;
    let mut random = Random::new(distinct_seed(campaign, number));
    let random = &mut random;
    loop {
        let own = random.log_uniform(2.0, 12.0);
        let motion = own * random.log_uniform(0.1, 10.0);
        let (faster, period) = (own.max(motion), TAU / motion);
        let sample_time = 1.0 / random.log_uniform((8.0 * faster).max(100.0), 2000.0);
        let duration = (20.0 * period).clamp(10.0, 60.0);
        let swing = random.log_uniform(0.2, 1.5);
        let limit = random.log_uniform(0.5, 50.0);
        let a = own * random.log_uniform(0.02, 0.5);
        let is_open = random.chance(0.3);
        let needed = if is_open {
            swing * (own * own - motion * motion).abs().max(a * motion)
        } else {
            1.5 * own * own + 2.0 * swing * motion * motion
        };
        let authority = needed * random.uniform(1.0, 3.0);
        let b = authority / limit;
        let bandwidth = (3.0 * faster).min(0.12 / sample_time);
        let (controller, amplitude) = if is_open {
            (Controller::Open, limit * needed / authority)
        } else {
            (controller_for(random, b, bandwidth, limit, swing), swing)
        };
        if matches!(controller, Controller::Relay { .. }) {
            continue;
        }
        let reference = if random.chance(0.1) {
            Reference::Chirp {
                amplitude,
                frequencies: [motion; 2],
                sweep: duration,
            }
        } else {
            reference_for(random, amplitude, motion, duration)
        };
        let angle = random.uniform(-PI, PI);
        let setup = LoopSetup {
            servo: ServoParameters {
                a,
                b,
                coulomb: needed * random.log_uniform(0.002, 0.05),
                load: 0.0,
            },
            effects: Effects {
                gravity: [own * own * angle.sin(), own * own * angle.cos()],
                ..Effects::NONE
            },
            counts_per_rev: random.log_uniform(2000.0, 65_536.0).round(),
            sample_time,
            samples: (duration / sample_time) as usize,
            skipped: (3.0 / sample_time) as usize,
            limit,
            controller,
            cutoff: (8.0 * bandwidth).min(1.0 / sample_time),
            bandwidth,
            reference,
            present: vec![Effect::Gravity],
            ..exact_setup(random, [1000.0, 1000.0])
        };
        let log = setup.record();
        if log.range > MIN_COUNTS * TAU / setup.counts_per_rev && log.limited < 0.3 {
            return log;
        }
    }
}

/// The log of a number in the campaign of a seed: one to four waves of cogging with 6 to 252 periods a turn, and an encoder
/// with four or more counts to each. Each wave shows in the motion, which covers a turn.
///
/// # Panics
/// If no loop works.
#[must_use]
pub fn with_cogging(campaign: u32, number: u32) -> RecordedLog {
    const RATES: [f64; 2] = [500.0, 4000.0];
    /// The displacement by a wave, counts, and the most that one turns by in a sample, rad.
    const LEAST_COUNTS: f64 = 0.2;
    const FASTEST: f64 = 0.8;
    let mut random = Random::new(distinct_seed(campaign, number));
    let random = &mut random;
    let counts = random.log_uniform(1024.0, 65_536.0).round();
    let highest = (counts / 4.0).min(252.0);
    let mut orders = Vec::<u32>::new();
    for _ in 0..random.uniform(1.0, 5.0) as usize {
        let order = random.log_uniform(6.0, highest + 1.0) as u32;
        if !orders.contains(&order) {
            orders.push(order);
        }
    }
    let most = orders.iter().fold(0, |most, order| most.max(*order));
    loop {
        let mut setup = exact_setup(random, RATES);
        if matches!(setup.controller, Controller::Relay { .. }) {
            continue;
        }
        let duration = setup.samples as f64 * setup.sample_time;
        let fastest = FASTEST / (f64::from(most) * setup.sample_time);
        let velocity = fastest * random.log_uniform(0.05, 1.0);
        setup.counts_per_rev = counts;
        let acceleration = velocity * setup.bandwidth;
        setup.servo.coulomb = acceleration * random.log_uniform(0.05, 1.5);
        setup.servo.load = acceleration * random.uniform(-1.0, 1.0);
        setup.reference = Reference::Trapezoids {
            amplitude: TAU * random.uniform(0.6, 3.0),
            velocity,
            acceleration: acceleration * random.uniform(0.2, 0.6),
            pause: random.uniform(0.0, 0.3),
        };
        if velocity * duration < 2.0 * TAU {
            continue;
        }
        let alone = setup.record();
        if !alone.works() || alone.range < TAU {
            continue;
        }
        let push = Sizes::of(&alone).push;
        let waves = orders.iter().map(|&order| {
            let size = push * random.log_uniform(0.02, 0.2);
            let shown = size * counts / (f64::from(order) * velocity).powi(2);
            let (sine, cosine) = random.uniform(-PI, PI).sin_cos();
            (shown > LEAST_COUNTS * TAU).then_some(([size * sine, size * cosine], order))
        });
        let Some(waves) = waves.collect::<Option<Vec<_>>>() else {
            continue;
        };
        (setup.effects.ripple, setup.effects.ripple_order) = waves[0];
        for (place, wave) in setup.effects.ripples.iter_mut().zip(&waves[1..]) {
            *place = *wave;
        }
        setup.present = vec![Effect::Ripple];
        let log = setup.record();
        if log.works() {
            return log;
        }
    }
}

/// The masses of a drawn servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Masses {
    /// One.
    One,
    /// Two, with the encoder on the motor.
    Two,
    /// Two, with the encoder on the load.
    TwoWithEncoderOnLoad,
}

/// The lowest and the highest sample rate, Hz.
const RATES: [f64; 2] = [250.0, 20_000.0];

/// Draws until a loop works.
fn working(
    random: &mut Random,
    rates: [f64; 2],
    effects: &mut dyn FnMut(&mut Random) -> Vec<Effect>,
) -> RecordedLog {
    const MAX_DRAWS: u32 = 1000;
    for _ in 0..MAX_DRAWS {
        let exact = exact_setup(random, rates);
        let effects = effects(random);
        let alone = exact.record();
        if !alone.works() {
            continue;
        }
        if effects.is_empty() {
            return alone;
        }
        let log = alone.draw_effects(&effects, random).record();
        if log.works() {
            return log;
        }
    }
    panic!("none of {MAX_DRAWS} loops works");
}

/// A servo without effects, in its loop.
fn exact_setup(random: &mut Random, rates: [f64; 2]) -> LoopSetup {
    let sample_time = 1.0 / random.log_uniform(rates[0], rates[1]);
    let longest = (MAX_SAMPLES * sample_time).clamp(3.0, 40.0);
    let duration = random.log_uniform(3.0, longest);
    let samples = (duration / sample_time) as usize;
    let counts_per_rev = random.log_uniform(500.0, 65_536.0).round();
    let count = TAU / counts_per_rev;

    // At full command it moves by no more than this in a sample.
    const LARGEST_STEP: f64 = 0.02;
    let strongest = (LARGEST_STEP / (sample_time * sample_time)).min(5e4);
    let authority = random.log_uniform(50.0, strongest);
    let limit = random.log_uniform(0.5, 50.0);
    let b = authority / limit;
    let servo = ServoParameters {
        a: random.log_uniform(0.05, 30.0),
        b,
        coulomb: authority * random.log_uniform(0.002, 0.2),
        load: if random.chance(0.6) {
            authority * random.log_uniform(0.003, 0.15) * random.sign()
        } else {
            0.0
        },
    };

    // The share of the limit that the reference needs, and its size. A stiff loop with little of it would move less
    // than the encoder resolves.
    const FEWEST_COUNTS: f64 = 100.0;
    let demand = random.log_uniform(0.05, 1.5);
    let stiffest = (demand * authority / (FEWEST_COUNTS * count)).sqrt();
    let slowest = TAU * 0.7;
    let fastest = (0.12 / sample_time).min(TAU * 40.0).min(stiffest);
    // Weak loops are there, and are the fewer.
    let mut drawn = || random.log_uniform(slowest, fastest.max(1.5 * slowest));
    let bandwidth = drawn().max(drawn());
    let cutoff = (bandwidth * random.log_uniform(4.0, 20.0)).min(1.0 / sample_time);
    let largest = demand * authority / (bandwidth * bandwidth);
    let amplitude = if random.chance(0.12) {
        largest.min(count * random.log_uniform(10.0, 100.0))
    } else {
        largest.min(100.0)
    };
    let controller = controller_for(random, b, bandwidth, limit, amplitude);
    let reference = reference_for(random, amplitude, bandwidth, duration);
    LoopSetup {
        seed: random.seed(),
        servo,
        effects: Effects::NONE,
        sensor: SensorEffects::default(),
        counts_per_rev,
        sample_time,
        samples,
        skipped: if random.chance(0.5) {
            0
        } else {
            (random.uniform(0.1, 1.0) / sample_time) as usize
        },
        limit,
        controller,
        cutoff,
        bandwidth,
        reference,
        shift: 0.0,
        load_steps: Vec::new(),
        present: Vec::new(),
    }
}

/// A controller of a bandwidth (rad/s) for a servo whose b is known by a factor.
fn controller_for(
    random: &mut Random,
    b: f64,
    bandwidth: f64,
    limit: f64,
    amplitude: f64,
) -> Controller {
    let believed = b * random.log_uniform(0.6, 1.6);
    match random.uniform(0.0, 5.0) as u32 {
        0 | 1 => Controller::Pid {
            kp: bandwidth * bandwidth / believed,
            ki: if random.chance(0.7) {
                bandwidth.powi(3) * random.log_uniform(0.02, 0.3) / believed
            } else {
                0.0
            },
            kd: 2.0 * random.uniform(0.5, 1.0) * bandwidth / believed,
        },
        2 | 3 => Controller::Cascade {
            kv: bandwidth / random.uniform(2.5, 6.0),
            kp: bandwidth / believed,
            ki: bandwidth * bandwidth / random.uniform(4.0, 15.0) / believed,
        },
        _ => {
            let high = limit * random.log_uniform(0.2, 1.0);
            let hysteresis = random.uniform(0.2, 0.6) * amplitude;
            // Time in which half of the hysteresis is crossed at full acceleration.
            let crossing = (2.0 * hysteresis / (b * high)).sqrt();
            let low = if random.chance(0.5) {
                high
            } else {
                high * random.uniform(0.4, 0.8)
            };
            Controller::Relay {
                levels: [high, low],
                hold: crossing * random.uniform(20.0, 100.0),
                hysteresis,
                lead: crossing * random.uniform(0.4, 1.5),
            }
        }
    }
}

fn reference_for(random: &mut Random, amplitude: f64, bandwidth: f64, duration: f64) -> Reference {
    let period = TAU / bandwidth;
    match random.uniform(0.0, 5.0) as u32 {
        0 => Reference::Noise {
            amplitude: 0.6 * amplitude,
            hold: period * random.log_uniform(0.2, 1.5),
        },
        1 => Reference::Steps {
            amplitude,
            hold: period * random.uniform(0.8, 4.0),
        },
        2 => Reference::Chirp {
            amplitude,
            frequencies: [bandwidth / 20.0, bandwidth * random.uniform(0.5, 1.5)],
            sweep: duration / random.uniform(1.0, 4.0),
        },
        3 => {
            let acceleration = amplitude * bandwidth * bandwidth * random.uniform(0.2, 0.6);
            Reference::Trapezoids {
                amplitude: amplitude * random.log_uniform(1.0, 5.0),
                velocity: acceleration * period * random.uniform(0.1, 0.6),
                acceleration,
                pause: period * random.uniform(0.0, 1.0),
            }
        }
        _ => Reference::Binary {
            amplitude: 0.5 * amplitude,
            hold: period * random.uniform(0.3, 1.0),
        },
    }
}

/// Samples of a log, unless it is shorter than 3 s then.
const MAX_SAMPLES: f64 = 60_000.0;

impl RecordedLog {
    /// True if the loop works: the servo moves to and fro, by more than some counts, and the command is seldom at
    /// the limit, where it is not that of a relay.
    fn works(&self) -> bool {
        const LEAST_COUNTS: f64 = 12.0;
        const MOST_RANGE: f64 = 1e4;
        const LEAST_CROSSINGS: u32 = 4;
        const MOST_LIMITED: f64 = 0.4;
        let is_relay = matches!(self.setup.controller, Controller::Relay { .. });
        let is_steady = is_relay || self.limited < MOST_LIMITED;
        is_steady
            && self.range > LEAST_COUNTS * TAU / self.setup.counts_per_rev
            && self.range < MOST_RANGE
            && self.crossings >= LEAST_CROSSINGS
    }

    /// The same loop with effects, each of a usual size for the motion of this log.
    fn draw_effects(&self, effects: &[Effect], random: &mut Random) -> LoopSetup {
        let mut setup = self.setup.clone();
        let sizes = Sizes::of(self);
        for &effect in effects {
            let contradicts = match effect {
                Effect::Resonance => setup.effects.backlash > 0.0,
                Effect::Backlash => setup.effects.resonance > 0.0,
                _ => false,
            };
            if contradicts {
                continue;
            }
            if let Controller::Relay { levels, .. } = &mut setup.controller
                && effect.needs_several_commands()
            {
                levels[1] = levels[1].min(0.6 * levels[0]);
            }
            setup.add(effect, &sizes, random);
            setup.present.push(effect);
        }
        setup
    }
}

/// The motion that the sizes of effects go by.
struct Sizes {
    /// A usual command, command units, and the acceleration by it, rad/s².
    command: f64,
    push: f64,
    /// A usual velocity, rad/s.
    velocity: f64,
    /// The distance from end to end, rad.
    range: f64,
    /// The command that is seldom exceeded.
    peak: f64,
    duration: f64,
    count: f64,
}

impl Sizes {
    fn of(log: &RecordedLog) -> Self {
        let setup = &log.setup;
        let (command, count) = (log.command_rms(), TAU / setup.counts_per_rev);
        Self {
            command,
            push: setup.servo.b * command,
            velocity: log.velocity_rms,
            range: log.range,
            peak: log.command_exceeded_by(0.01),
            duration: setup.samples as f64 * setup.sample_time,
            count,
        }
    }
}

impl LoopSetup {
    /// Adds an effect of a drawn size.
    fn add(&mut self, effect: Effect, sizes: &Sizes, random: &mut Random) {
        let Self { effects, servo, .. } = self;
        let around = |size: f64, random: &mut Random| {
            let (sin, cos) = random.uniform(-PI, PI).sin_cos();
            [size * sin, size * cos]
        };
        let order = |random: &mut Random| random.uniform(2.0, 37.0) as u32;
        match effect {
            Effect::Delay => {
                // More would leave the loop no phase.
                let longest = 0.25 / (self.bandwidth * self.sample_time);
                effects.delay = random.uniform(0.2, longest.clamp(0.4, 4.0)) * self.sample_time;
            }
            Effect::CurrentLoop => {
                effects.current_loop = 1.0 / (TAU * random.log_uniform(150.0, 2000.0));
            }
            Effect::Asymmetry => {
                effects.asymmetry = servo.a * random.uniform(0.2, 0.7) * random.sign();
            }
            Effect::QuadraticFriction => {
                let drag = sizes.push * random.log_uniform(0.01, 0.15);
                effects.quadratic_friction = drag / (sizes.velocity * sizes.velocity);
            }
            Effect::LowSpeedFriction => {
                effects.low_speed_friction = servo.coulomb * random.uniform(0.2, 0.8);
                effects.low_speed_velocity = sizes.velocity * random.log_uniform(0.03, 0.3);
            }
            Effect::Gravity => {
                effects.gravity = around(sizes.push * random.log_uniform(0.02, 0.2), random);
            }
            Effect::Ripple => {
                effects.ripple = around(sizes.push * random.log_uniform(0.005, 0.05), random);
                effects.ripple_order = order(random);
            }
            Effect::TorqueRipple => {
                effects.torque_ripple = around(random.log_uniform(0.005, 0.05), random);
                effects.torque_ripple_order = order(random);
            }
            Effect::DeadBand => {
                effects.dead_band = sizes.command * random.log_uniform(0.005, 0.05);
            }
            Effect::LoadDependentFriction => {
                effects.load_dependent_friction = random.log_uniform(0.02, 0.15);
            }
            Effect::HiddenLimit => {
                effects.hidden_limit = sizes.peak * random.uniform(0.6, 0.95);
            }
            Effect::GainAsymmetry => {
                effects.gain_asymmetry = random.log_uniform(0.005, 0.05) * random.sign();
            }
            Effect::GainDrift => {
                let all = random.log_uniform(0.01, 0.1) * random.sign();
                effects.gain_drift = all / sizes.duration;
            }
            Effect::FrictionDrift => {
                let fastest = Effects::FASTEST_DRIFT * sizes.duration;
                let all = random.uniform(0.1, fastest.min(0.4)) * random.sign();
                effects.friction_drift = all / sizes.duration;
            }
            Effect::Resonance => {
                effects.resonance = TAU * random.log_uniform(20.0, 400.0);
                effects.resonance_damping = Some(random.log_uniform(0.01, 0.1));
                effects.inertia_ratio = random.uniform(0.1, 0.7);
            }
            Effect::Backlash => {
                let widest = (0.2 * sizes.range / sizes.count).clamp(2.0, 20.0);
                effects.backlash = sizes.count * random.log_uniform(1.0, widest);
            }
            Effect::InertiaVariation => {
                effects.inertia_variation = around(random.log_uniform(0.02, 0.2), random);
                effects.inertia_order = random.uniform(1.0, 3.0) as u32;
            }
            Effect::Noise => {
                let largest = (0.05 * sizes.range / sizes.count).clamp(0.2, 10.0);
                self.sensor.noise = sizes.count * random.log_uniform(0.1, largest);
            }
            Effect::Eccentricity => {
                self.sensor.eccentricity = random.log_uniform(1e-4, 3e-3);
            }
            Effect::Shift => self.shift = random.uniform(-2.0, 3.0),
            Effect::LoadSteps => {
                let count = random.uniform(1.0, 4.0) as usize;
                let mut steps: Vec<LoadStep> = (0..count)
                    .map(|_| LoadStep {
                        sample: (random.uniform(0.1, 0.9) * self.samples as f64) as usize,
                        load: sizes.push * random.log_uniform(0.02, 0.2) * random.sign(),
                    })
                    .collect();
                steps.sort_by_key(|step| step.sample);
                self.load_steps = steps;
            }
            Effect::Jitter => self.sensor.jitter = random.log_uniform(0.01, 0.1),
        }
    }
}
