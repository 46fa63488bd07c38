//! Random servos, controllers as in other firmware, and the loop that runs them.

use core::f64::consts::{PI, TAU};
use identifier_core::Settings;
use identifier_core::identifier::{Identify, Update};
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use virtual_servo::excitation::NormalSource;
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

/// A controller in SI, written plainly.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Controller {
    kind: Kind,
    servo: Servo,
    integral: f64,
    velocity: f64,
    last_position: f64,
    last_reference: f64,
    last_reference_velocity: f64,
    output: f64,
}

impl Controller {
    pub(crate) fn new(kind: Kind, servo: &Servo) -> Self {
        Self {
            kind,
            servo: *servo,
            integral: 0.0,
            velocity: 0.0,
            last_position: 0.0,
            last_reference: 0.0,
            last_reference_velocity: 0.0,
            output: 1.0,
        }
    }

    pub(crate) fn command(&mut self, reference: f64, position: f64) -> f64 {
        let Servo {
            sample_time,
            limit,
            bandwidth,
            ..
        } = self.servo;
        let b = self.servo.parameters.b;
        let omega = bandwidth;
        let smooth = (-8.0 * omega * sample_time).exp();
        let raw = (position - self.last_position) / sample_time;
        self.last_position = position;
        self.velocity = smooth * self.velocity + (1.0 - smooth) * raw;
        let reference_velocity = (reference - self.last_reference) / sample_time;
        self.last_reference = reference;
        let reference_acceleration =
            (reference_velocity - self.last_reference_velocity) / sample_time;
        self.last_reference_velocity = reference_velocity;
        let error = reference - position;
        let (kp, kd, ki) = (
            2.0 * omega * omega / b,
            2.4 * omega / b,
            0.5 * omega * omega * omega / b,
        );
        match self.kind {
            Kind::Pid => {
                let wanted = kp * error - kd * self.velocity + ki * self.integral;
                let command = wanted.clamp(-limit, limit);
                if (wanted - command) * error <= 0.0 {
                    self.integral += sample_time * error;
                }
                command
            }
            Kind::Cascade => {
                let wanted_velocity = 0.6 * omega * error + 0.9 * reference_velocity;
                let velocity_error = wanted_velocity - self.velocity;
                let forward = 0.5 / b * reference_acceleration;
                let forward = forward.clamp(-0.5 * limit, 0.5 * limit);
                let wanted =
                    2.0 * omega / b * velocity_error + omega * omega / b * self.integral + forward;
                let command = wanted.clamp(-limit, limit);
                if (wanted - command) * velocity_error <= 0.0 {
                    self.integral += sample_time * velocity_error;
                }
                command
            }
            Kind::PiD => {
                let wanted = kp * (0.6 * reference - position)
                    + ki * self.integral
                    + kd * (0.2 * reference_velocity - self.velocity);
                let command = wanted.clamp(-limit, limit);
                // Back-calculation.
                self.integral += sample_time * (error + (command - wanted) / (2.0 * kp) * omega);
                command
            }
            Kind::Relay => {
                let switching = error - self.velocity / omega;
                let hysteresis = 2.0 * self.servo.count();
                if switching * self.output < -hysteresis {
                    self.output = -self.output;
                }
                self.output * limit
            }
        }
    }
}

/// A reference: noise held for a time, smoothed a little so that no jump is infinitely steep.
#[derive(Debug, Clone)]
pub(crate) struct Reference {
    draw: NormalSource,
    amplitude: f64,
    hold: u32,
    left: u32,
    level: f64,
    value: f64,
    pole: f64,
}

impl Reference {
    pub(crate) fn new(servo: &Servo, amplitude: f64, seed: u32) -> Self {
        let hold = (PI / servo.bandwidth / servo.sample_time).round().max(2.0);
        Self {
            draw: NormalSource::new(seed | 1),
            amplitude,
            hold: hold as u32,
            left: 0,
            level: 0.0,
            value: 0.0,
            pole: (-4.0 * servo.bandwidth * servo.sample_time).exp(),
        }
    }

    pub(crate) fn next(&mut self) -> f64 {
        if self.left == 0 {
            self.left = self.hold;
            self.level = self.amplitude * self.draw.next_normal();
        }
        self.left -= 1;
        self.value = self.pole * self.value + (1.0 - self.pole) * self.level;
        self.value
    }
}

/// A servo with its controller, sample by sample: the inputs of an identifier.
pub(crate) struct Loop {
    pub(crate) servo: Servo,
    pub(crate) plant: Plant,
    encoder: Encoder,
    controller: Controller,
    reference: Reference,
    count: i64,
    pub(crate) saturated: u64,
    pub(crate) samples: u64,
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
            controller: Controller::new(kind, servo),
            reference: Reference::new(servo, amplitude, servo.seed),
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
        let reference = self.reference.next();
        let command = self.controller.command(reference, position);
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
    let mut controller = Controller::new(Kind::Pid, servo);
    let mut reference = Reference::new(servo, amplitude, servo.seed + 3);
    let mut count = encoder.read(plant.position());
    for _ in 0..samples {
        let now = encoder.read(plant.position());
        let moved = (now - std::mem::replace(&mut count, now)) as i32;
        let command = controller.command(reference.next(), now as f64 * servo.count());
        identifier
            .process(&mut state, moved, told(command))
            .expect("ordinary samples");
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
        if run.saturation() < part {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low * high).sqrt()
}

/// An ordinary servo.
pub(crate) fn ordinary_servo(seed: u32) -> Servo {
    let mut draw = Draw::new(seed);
    let limit = draw.between(1.0, 30.0);
    let authority = draw.between(100.0, 10_000.0);
    let b = authority / limit;
    let sample_time = draw.between(0.25e-3, 1e-3);
    let counts_per_rev = draw.between(2000.0, 65_536.0).round();
    // Coarse encoders are for quick motions: the loop must see some counts.
    let bandwidth = draw.between(10.0, 60.0);
    let a = draw.between(0.05, 10.0);
    let friction = draw.one_of(&[0.0, 1.0]) * draw.between(0.003, 0.1) * authority;
    let load = draw.uniform(-0.3, 0.3) * authority;
    Servo {
        parameters: ServoParameters::new(a, b, friction, load),
        counts_per_rev,
        sample_time,
        limit,
        bandwidth,
        offset: draw.uniform(0.0, 1.0) * TAU / counts_per_rev,
        seed,
    }
}

/// A servo with friction, low gains, a coarse encoder and a small limit, at any sample rate: what
/// workshops have.
pub(crate) fn humble_servo(seed: u32) -> Servo {
    let mut draw = Draw::new(seed ^ 0x5a5a);
    let limit = draw.between(0.5, 24.0);
    let authority = draw.between(30.0, 3000.0);
    let b = authority / limit;
    let sample_time = draw.between(50e-6, 4e-3);
    let counts_per_rev = draw.between(200.0, 8192.0).round();
    let bandwidth = draw.between(3.0, 40.0).min(0.15 / sample_time);
    let a = draw.between(0.05, 10.0);
    let friction = draw.between(0.005, 0.15) * authority;
    let load = draw.uniform(-0.2, 0.2) * authority;
    Servo {
        parameters: ServoParameters::new(a, b, friction, load),
        counts_per_rev,
        sample_time,
        limit,
        bandwidth,
        offset: draw.uniform(0.0, 1.0) * TAU / counts_per_rev,
        seed,
    }
}

/// Runs jobs on the machine's cores.
pub(crate) fn on_all_cores<T: Send, F: Fn(u32) -> T + Sync>(count: u32, job: F) -> Vec<T> {
    let next = std::sync::atomic::AtomicU32::new(0);
    let results = std::sync::Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    if i >= count {
                        break;
                    }
                    let result = job(i);
                    results.lock().expect("no job panics").push((i, result));
                }
            });
        }
    });
    let mut results = results.into_inner().expect("no job panics");
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}

/// The value below which a part of the values lie.
pub(crate) fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let index = ((sorted.len() - 1) as f64 * part).round() as usize;
    sorted.get(index).copied().unwrap_or(f64::NAN)
}

/// The part of the values for which something holds, per cent.
pub(crate) fn per_cent<T>(values: &[T], holds: impl Fn(&T) -> bool) -> f64 {
    100.0 * values.iter().filter(|value| holds(value)).count() as f64 / values.len() as f64
}
