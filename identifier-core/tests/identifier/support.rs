//! Random servos, controllers as in other firmware, and the loop that runs them.

use core::f64::consts::{PI, TAU};
use identifier_core::Settings;
use identifier_core::excitation::Excitation;
use identifier_core::identifier::{Identify, Update};
use identifier_core::number::Number;
use identifier_core::parameters::{PerParameter, ServoParameters};
use rayon::prelude::*;
use virtual_servo::excitation::{BandLimitedWhiteNoise, NormalSource};
use virtual_servo::{Effects, Encoder, Plant, Servo as TrueServo};

/// A source of random draws.
pub(crate) struct Draw(NormalSource);

impl Draw {
    pub(crate) fn new(seed: u32) -> Self {
        let mut source = NormalSource::new(seed.wrapping_mul(2_654_435_761).wrapping_add(977));
        for _ in 0..8 {
            source.next_uniform();
        }
        Self(source)
    }

    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.next_uniform()
    }

    /// Uniform in the logarithm.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    pub(crate) fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        let index = (self.0.next_uniform() * values.len() as f64) as usize;
        values[index.min(values.len() - 1)]
    }
}

/// The paper's loop with a limit, certified.
pub(crate) fn certified() -> Settings {
    Settings::new(1e-3, 10_000.0)
        .with_pid(9.0, 0.19, 4.0, 10.0)
        .with_servo_range([0.0, 50.0], [110.0, 1000.0])
}

/// Takes an ordinary sample, and does all of the background's work.
pub(crate) fn learn<N: Number, I: Identify<N>>(
    identifier: &I,
    state: &mut I::State,
    (increment, command): (f64, f64),
) -> Update<N> {
    let seen = identifier.learn(state, N::from_f64(increment), N::from_f64(command));
    identifier.work(state, u32::MAX);
    seen.expect("ordinary samples")
}

/// The present estimates, those before the first fit too.
pub(crate) fn shown<N: Copy, I: Identify<N>>(identifier: &I, state: &I::State) -> ServoParameters {
    identifier.estimates_in(&identifier.snapshot(state))
}

/// A servo, its encoder, amplifier and sample time, SI.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Servo {
    pub(crate) parameters: ServoParameters,
    pub(crate) counts_per_rev: f64,
    pub(crate) sample_time: f64,
    pub(crate) limit: f64,
    /// Bandwidth that its controller is tuned for, rad/s.
    pub(crate) bandwidth: f64,
    /// Where the count's edges lie, rad.
    pub(crate) offset: f64,
    pub(crate) seed: u32,
}

impl Servo {
    pub(crate) fn count(&self) -> f64 {
        TAU / self.counts_per_rev
    }

    pub(crate) fn authority(&self) -> f64 {
        self.parameters.b * self.limit
    }

    /// What an identifier is told of it.
    pub(crate) fn settings(&self) -> Settings {
        Settings::new(self.sample_time, self.counts_per_rev)
    }
}

/// The paper's servo with friction and load.
pub(crate) const TRUTH: ServoParameters = ServoParameters::new(0.2174, 257.7, 10.0, 20.0);

/// A servo with the paper's encoder, sample time and limit.
pub(crate) const fn paper(parameters: ServoParameters, bandwidth: f64, seed: u32) -> Servo {
    Servo {
        parameters,
        counts_per_rev: 10_000.0,
        sample_time: 1e-3,
        limit: 10.0,
        bandwidth,
        offset: 0.0,
        seed,
    }
}

/// A true servo with an encoder whose counter has 32 bits and starts anywhere.
pub(crate) struct Bench {
    pub(crate) plant: Plant,
    encoder: Encoder,
    start: i32,
}

impl Bench {
    pub(crate) fn new(servo: &ServoParameters, settings: &Settings, start: i32) -> Self {
        Self {
            plant: Plant::at_rest(servo, settings.sample_time),
            encoder: Encoder::new(TAU / settings.resolution),
            start,
        }
    }

    pub(crate) fn count(&self) -> i32 {
        let moved = self.encoder.read(self.plant.position);
        self.start.wrapping_add(moved as i32)
    }
}

/// Whose firmware closes the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// PID with limit and conditional anti-windup.
    Pid,
    /// Position loop over a PI velocity loop, with feed-forward of velocity and acceleration.
    Cascade,
    /// PI–D with set-point weights.
    PiD,
    /// Bang-bang.
    Relay,
}

/// A controller in SI, written plainly: from a reference and a position to a command.
pub(crate) fn controller(kind: Kind, servo: &Servo) -> impl FnMut(f64, f64) -> f64 + use<> {
    let Servo {
        sample_time,
        limit,
        bandwidth: omega,
        ..
    } = *servo;
    let (b, hysteresis) = (servo.parameters.b, 2.0 * servo.count());
    let smooth = (-8.0 * omega * sample_time).exp();
    let kp = 2.0 * omega * omega / b;
    let kd = 2.4 * omega / b;
    let ki = 0.5 * omega * omega * omega / b;
    let (mut integral, mut velocity, mut output) = (0.0, 0.0, 1.0_f64);
    let [mut last_position, mut last_reference, mut last_rate] = [0.0; 3];
    let rate = move |now: f64, last: &mut f64| (now - std::mem::replace(last, now)) / sample_time;
    move |reference: f64, position: f64| {
        velocity = smooth * velocity + (1.0 - smooth) * rate(position, &mut last_position);
        let reference_velocity = rate(reference, &mut last_reference);
        let reference_acceleration = rate(reference_velocity, &mut last_rate);
        let error = reference - position;
        match kind {
            Kind::Pid => {
                let wanted = kp * error - kd * velocity + ki * integral;
                let command = wanted.clamp(-limit, limit);
                if (wanted - command) * error <= 0.0 {
                    integral += sample_time * error;
                }
                command
            }
            Kind::Cascade => {
                let wanted_velocity = 0.6 * omega * error + 0.9 * reference_velocity;
                let velocity_error = wanted_velocity - velocity;
                let forward = 0.5 / b * reference_acceleration;
                let forward = forward.clamp(-0.5 * limit, 0.5 * limit);
                let wanted =
                    2.0 * omega / b * velocity_error + omega * omega / b * integral + forward;
                let command = wanted.clamp(-limit, limit);
                if (wanted - command) * velocity_error <= 0.0 {
                    integral += sample_time * velocity_error;
                }
                command
            }
            Kind::PiD => {
                let wanted = kp * (0.6 * reference - position)
                    + ki * integral
                    + kd * (0.2 * reference_velocity - velocity);
                let command = wanted.clamp(-limit, limit);
                // Back-calculation.
                integral += sample_time * (error + (command - wanted) / (2.0 * kp) * omega);
                command
            }
            Kind::Relay => {
                let switching = error - velocity / omega;
                if switching * output < -hysteresis {
                    output = -output;
                }
                output * limit
            }
        }
    }
}

/// A reference: noise held for a time, smoothed a little so that no jump is infinitely steep.
fn reference(servo: &Servo, amplitude: f64, seed: u32) -> impl FnMut() -> f64 + use<> {
    let mut draw = NormalSource::new(seed | 1);
    let hold = (PI / servo.bandwidth / servo.sample_time).round().max(2.0) as u32;
    let pole = (-4.0 * servo.bandwidth * servo.sample_time).exp();
    let (mut left, mut level, mut value) = (0, 0.0, 0.0);
    move || {
        if left == 0 {
            left = hold;
            level = amplitude * draw.next_normal();
        }
        left -= 1;
        value = pole * value + (1.0 - pole) * level;
        value
    }
}

/// The paper's noise as a reference, counts.
pub(crate) fn paper_noise(settings: &Settings, seed: u32) -> impl FnMut() -> f64 + use<> {
    let units = settings.units().expect("valid");
    let noise = BandLimitedWhiteNoise::new(&units, 0.005, 0.1, seed).expect("valid");
    let mut state = Excitation::<f64>::start(&noise);
    move || noise.process(&mut state)
}

/// Learns as the paper does from (0, 50), within wide bounds.
pub(crate) fn learn_as_the_paper(settings: &mut Settings) {
    let learning = &mut settings.identifier;
    learning.initial.b = Some(50.0);
    learning.bounds.a = Some([0.0, 100.0]);
    learning.bounds.b = Some([5.0, 5000.0]);
    learning.gamma = Some(PerParameter::new(0.2, 110.0, 0.0, 0.0));
    learning.mu = Some(10.0);
}

/// A servo with its controller, sample by sample: the inputs of an identifier.
pub(crate) struct Loop {
    pub(crate) servo: Servo,
    pub(crate) plant: Plant,
    encoder: Encoder,
    controller: Box<dyn FnMut(f64, f64) -> f64>,
    reference: Box<dyn FnMut() -> f64>,
    count: i64,
    saturated: u64,
    samples: u64,
    /// A load on top, changed from outside, rad/s².
    pub(crate) extra_load: f64,
    /// True if the amplifier is on.
    pub(crate) powered: bool,
}

impl Loop {
    pub(crate) fn new(kind: Kind, servo: &Servo, amplitude: f64) -> Self {
        let encoder = Encoder::new(servo.counts_per_rev);
        let mut plant = Plant::at_rest(&servo.parameters, servo.sample_time);
        plant.position = servo.offset;
        Self {
            servo: *servo,
            plant,
            encoder,
            controller: Box::new(controller(kind, servo)),
            reference: Box::new(reference(servo, amplitude, servo.seed)),
            count: encoder.read(plant.position),
            saturated: 0,
            samples: 0,
            extra_load: 0.0,
            powered: true,
        }
    }

    /// The increment that is measured now and the command that acts from now.
    pub(crate) fn sample(&mut self) -> (f64, f64) {
        let count = self.encoder.read(self.plant.position);
        let increment = (count - self.count) as f64;
        self.count = count;
        let position = count as f64 * self.servo.count();
        let command = (self.controller)((self.reference)(), position);
        self.saturated += u64::from(command.abs() >= self.servo.limit);
        self.samples += 1;
        let acting = if self.powered { command } else { 0.0 };
        self.plant
            .advance(acting + self.extra_load / self.servo.parameters.b);
        (increment, command)
    }

    pub(crate) fn saturation(&self) -> f64 {
        self.saturated as f64 / self.samples.max(1) as f64
    }
}

/// Runs an identifier beside a PID around a servo with effects for a number of samples. `told` is the command that it
/// is told of one.
pub(crate) fn beside_pid<N: Copy, I: Identify<N>>(
    identifier: &I,
    servo: &Servo,
    effects: &Effects,
    (amplitude, samples): (f64, u32),
    mut told: impl FnMut(f64) -> N,
) -> I::State {
    let mut state = identifier.start();
    let mut plant = TrueServo::at_rest(&servo.parameters, effects, servo.sample_time, servo.seed)
        .expect("sound");
    let encoder = Encoder::new(servo.counts_per_rev);
    let mut controller = controller(Kind::Pid, servo);
    let mut reference = reference(servo, amplitude, servo.seed + 3);
    let mut count = encoder.read(plant.position());
    for _ in 0..samples {
        let now = encoder.read(plant.position());
        let moved = (now - std::mem::replace(&mut count, now)) as i32;
        let command = controller(reference(), now as f64 * servo.count());
        let seen = identifier.process(&mut state, moved, told(command));
        seen.expect("ordinary samples");
        identifier.work(&mut state, u32::MAX);
        plant.advance(command);
    }
    state
}

/// The amplitude of the reference for which the limit acts a part of the time.
pub(crate) fn amplitude_for(kind: Kind, servo: &Servo, part: f64) -> f64 {
    let natural = servo.authority() / (servo.bandwidth * servo.bandwidth);
    let (mut low, mut high) = (0.02 * natural, 50.0 * natural);
    for _ in 0..9 {
        let middle = (low * high).sqrt();
        let mut run = Loop::new(kind, servo, middle);
        for _ in 0..(3.0 / servo.sample_time) as u32 {
            run.sample();
        }
        *(if run.saturation() < part {
            &mut low
        } else {
            &mut high
        }) = middle;
    }
    (low * high).sqrt()
}

/// A drawn servo. The ranges are those of the limit, the authority, the sample time, the counts per revolution, the bandwidth
/// and the friction; there is none in `rough`'s part of zero. The load is a share of the authority.
fn drawn(mut draw: Draw, seed: u32, ranges: [[f64; 2]; 6], rough: &[f64], load: f64) -> Servo {
    let [limits, authorities, times, counts, bandwidths, frictions] = ranges;
    let limit = draw.between(limits[0], limits[1]);
    let authority = draw.between(authorities[0], authorities[1]);
    let b = authority / limit;
    let sample_time = draw.between(times[0], times[1]);
    let counts_per_rev = draw.between(counts[0], counts[1]).round();
    let bandwidth = draw.between(bandwidths[0], bandwidths[1]);
    let a = draw.between(0.05, 10.0);
    let friction = draw.one_of(rough) * draw.between(frictions[0], frictions[1]) * authority;
    let load = draw.uniform(-load, load) * authority;
    Servo {
        parameters: ServoParameters::new(a, b, friction, load),
        counts_per_rev,
        sample_time,
        limit,
        bandwidth: bandwidth.min(0.15 / sample_time),
        offset: draw.uniform(0.0, 1.0) * TAU / counts_per_rev,
        seed,
    }
}

/// An ordinary servo. Coarse encoders are for quick motions: the loop must see some counts.
pub(crate) fn ordinary_servo(seed: u32) -> Servo {
    let [limit, authority] = [[1.0, 30.0], [100.0, 10_000.0]];
    let [time, counts, bandwidth] = [[0.25e-3, 1e-3], [2000.0, 65_536.0], [10.0, 60.0]];
    let ranges = [limit, authority, time, counts, bandwidth, [0.003, 0.1]];
    drawn(Draw::new(seed), seed, ranges, &[0.0, 1.0], 0.3)
}

/// A servo with friction, low gains, a coarse encoder and a small limit, at any sample rate: what
/// workshops have.
pub(crate) fn humble_servo(seed: u32) -> Servo {
    let [limit, authority] = [[0.5, 24.0], [30.0, 3000.0]];
    let [time, counts, bandwidth] = [[50e-6, 4e-3], [200.0, 8192.0], [3.0, 40.0]];
    let ranges = [limit, authority, time, counts, bandwidth, [0.005, 0.15]];
    drawn(Draw::new(seed ^ 0x5a5a), seed, ranges, &[1.0], 0.2)
}

/// Runs jobs on the machine's cores.
pub(crate) fn on_all_cores<T: Send>(count: u32, job: impl Fn(u32) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().map(job).collect()
}

/// The value below which a part of the values lie.
pub(crate) fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let index = ((sorted.len() - 1) as f64 * part).round() as usize;
    sorted.get(index).copied().unwrap_or(f64::NAN)
}

/// Prints the quantiles of a figure over some runs.
pub(crate) fn report<T>(name: &str, runs: &[T], figure: impl Fn(&T) -> f64) -> [f64; 4] {
    let values: Vec<f64> = runs.iter().map(figure).collect();
    let quantiles = [0.5, 0.9, 0.95, 1.0].map(|part| quantile(&values, part));
    println!("  {name}: median, 90 %, 95 %, worst {quantiles:9.5?}");
    quantiles
}

/// The part of the values for which something holds, per cent.
pub(crate) fn per_cent<T>(values: &[T], holds: impl Fn(&T) -> bool) -> f64 {
    100.0 * values.iter().filter(|value| holds(value)).count() as f64 / values.len() as f64
}
