//! The gradient with its memory: how fast and how surely it finds drawn servos. `SERVOS` many are drawn from `SEED`.

use core::f64::consts::TAU;

use crate::support::{on_all_cores, per_cent, quantile};
use identifier_core::fixed_point::Word;
use identifier_core::identifier::{GradientRecursion, Identify, MachineEstimates};
use identifier_core::measurement::LowPass;
use identifier_core::number::Arithmetic;
use identifier_core::parameters::{PerParameter, ServoParameters, Unknown, Unknowns};
use identifier_core::{AB_COULOMB, Gradient, Settings};
use virtual_servo::excitation::NormalSource;
use virtual_servo::{Effects, Encoder, Servo, SplitMix64};

const GAINS: [f64; 3] = [9.0, 0.19, 4.0];
const DURATION: f64 = 30.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Pid,
    Cascade,
    Relay,
    Limited,
}

/// What happens to a servo while it is learnt.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Happening {
    Nothing,
    /// Noise of the position, counts.
    Noise(f64),
    /// Delay of the command, samples.
    Delay(f64),
    /// A step of the load after 10 s, rad/s².
    LoadStep(f64),
    /// The reference stays after a second.
    Ends,
    /// b over 1000:1, its range still 9:1.
    Wide,
    /// Friction of 10 to 30 % of the limit.
    Sticky,
    /// b by a factor after 10 s.
    Changes(f64),
    /// A load of 30 % of the limit's force at 5 Hz.
    MovingLoad,
    /// The paper's Γ is stated.
    PaperGamma,
}

/// A drawn servo with encoder, controller and reference, SI.
#[derive(Debug, Clone, Copy)]
struct Case {
    servo: ServoParameters,
    counts: f64,
    time: f64,
    limit: f64,
    /// Of the reference's filter and of the cascade, rad/s.
    omega: f64,
    kind: Kind,
    gains: [f64; 3],
    range: [f64; 2],
    seed: u32,
    happening: Happening,
}

impl Case {
    fn draw(seed: u32, happening: Happening) -> Self {
        let mut draw = SplitMix64::new(0x9e37 + 7919 * u64::from(seed));
        let between =
            |draw: &mut SplitMix64, low: f64, high: f64| draw.uniform(low.ln(), high.ln()).exp();
        let time = draw.one_of(&[4e-3, 1e-3, 1e-3, 0.25e-3, 50e-6]);
        let kinds = [
            Kind::Pid,
            Kind::Pid,
            Kind::Cascade,
            Kind::Relay,
            Kind::Limited,
        ];
        let mut kind = draw.one_of(&kinds);
        let counts = draw.one_of(&[2000.0, 10_000.0]);
        let a = draw.uniform(0.0, 50.0);
        let mut friction = draw.one_of(&[0.0, 1.0, 1.0]) * draw.uniform(2.0, 20.0);
        let load = draw.uniform(-40.0, 40.0);
        let scale = match happening {
            Happening::Wide => between(&mut draw, 0.0316, 31.6),
            _ => 1.0,
        };
        let b = between(&mut draw, 110.0, 1000.0) * scale;
        let limit = 10.0 / scale;
        if happening == Happening::Sticky {
            kind = Kind::Limited;
            friction = draw.uniform(0.1, 0.3) * b * limit;
        }
        // The slower the coarser the time.
        let slow: f64 = if time > 2e-3 { 0.4 } else { 1.0 };
        let [kp, kd, ki] = GAINS;
        Self {
            servo: ServoParameters::new(a, b, friction, load),
            counts,
            time,
            limit,
            omega: 40.0 * slow,
            kind,
            gains: [kp * slow.powi(2), kd * slow, ki * slow.powi(3)].map(|gain| gain / scale),
            range: [110.0 * scale, 1000.0 * scale],
            seed,
            happening,
        }
    }

    fn settings(&self, is_fixed: bool) -> Settings {
        let [kp, kd, ki] = self.gains;
        let mut settings = Settings::new(self.time, self.counts)
            .with_pid(kp, kd, ki, self.limit)
            .with_servo_range([0.0, 50.0], self.range);
        settings.cutoff = (0.5 / self.time).min(1000.0);
        if let Happening::Noise(counts) = self.happening {
            settings.identifier.noise = Some(counts * settings.resolution);
        }
        if self.happening == Happening::PaperGamma {
            settings.identifier.gamma = Some(PerParameter::new(0.2, 110.0, 110.0, 0.0));
        }
        if is_fixed {
            let most = (2.0 * self.servo.coulomb).max(100.0);
            settings.identifier.bounds.coulomb = Some([0.0, most]);
        }
        settings
    }

    /// Calls `sample` with the counts moved and the command of each sample until it returns false.
    fn run(&self, mut sample: impl FnMut(i32, f64)) {
        let delay = match self.happening {
            Happening::Delay(samples) => samples * self.time,
            _ => 0.0,
        };
        let effects = Effects {
            delay,
            ..Effects::NONE
        };
        let mut plant = Servo::at_rest(&self.servo, &effects, self.time, self.seed).expect("sound");
        let encoder = Encoder::new(self.counts);
        let count = TAU / self.counts;
        let mut sensor = NormalSource::new(self.seed.wrapping_mul(2) | 1);
        let mut draw = NormalSource::new(self.seed.wrapping_mul(2_654_435_761) | 1);
        for _ in 0..8 {
            draw.next_uniform();
        }
        let offset = draw.next_uniform() * count;
        let mut control = self.controller();
        let amplitude = 0.05_f64.sqrt()
            * match self.kind {
                Kind::Pid | Kind::Relay => 1.0,
                Kind::Cascade => 0.7,
                Kind::Limited => 3.0,
            };
        let hold = (if self.time > 2e-3 { 0.2 } else { 0.1 } / self.time) as usize;
        let pole = (-4.0 * self.omega * self.time).exp();
        let (mut level, mut reference) = (0.0, 0.0);
        let mut last = encoder.read(offset);
        for k in 0..(DURATION / self.time) as usize {
            let now = k as f64 * self.time;
            let plays = self.happening != Happening::Ends || now < 1.0;
            if k % hold == 0 && plays {
                level = amplitude * draw.next_normal();
            }
            reference = if self.kind == Kind::Pid {
                level
            } else {
                pole * reference + (1.0 - pole) * level
            };
            let mut seen = offset + plant.position();
            let (mut gain, mut push) = (1.0, 0.0);
            match self.happening {
                Happening::Noise(counts) => seen += counts * count * sensor.next_normal(),
                Happening::LoadStep(load) if (now - 10.0).abs() < 0.5 * self.time => {
                    plant.disturb(load, 0.0);
                }
                Happening::Changes(factor) if now >= 10.0 => gain = factor,
                Happening::MovingLoad => push = 0.3 * self.limit * (TAU * 5.0 * now).sin(),
                _ => {}
            }
            let count_now = encoder.read(seen);
            let command = control(reference, count_now as f64 * count);
            sample((count_now - last) as i32, command);
            last = count_now;
            plant.advance(gain * command + push);
        }
    }

    fn controller(&self) -> impl FnMut(f64, f64) -> f64 + use<> {
        let Self {
            time,
            limit,
            omega,
            kind,
            ..
        } = *self;
        let [kp, kd, ki] = self.gains;
        let b = (self.range[0] * self.range[1]).sqrt();
        let hysteresis = 2.0 * TAU / self.counts;
        let smooth = (-(0.5 / time).min(1000.0) * time).exp();
        let (mut integral, mut velocity, mut output) = (0.0, 0.0, 1.0_f64);
        let [mut last_position, mut last_reference, mut last_rate] = [0.0; 3];
        let rate = move |now: f64, last: &mut f64| (now - core::mem::replace(last, now)) / time;
        move |reference: f64, position: f64| {
            velocity = smooth * velocity + (1.0 - smooth) * rate(position, &mut last_position);
            let reference_velocity = rate(reference, &mut last_reference);
            let reference_acceleration = rate(reference_velocity, &mut last_rate);
            let error = reference - position;
            let (wanted, drives) = match kind {
                Kind::Pid | Kind::Limited => (kp * error - kd * velocity + ki * integral, error),
                Kind::Cascade => {
                    let missing = 0.6 * omega * error + 0.9 * reference_velocity - velocity;
                    let forward = 0.5 / b * reference_acceleration;
                    let forward = forward.clamp(-0.5 * limit, 0.5 * limit);
                    let wanted = omega / b * (2.0 * missing + omega * integral) + forward;
                    (wanted, missing)
                }
                Kind::Relay => {
                    let switching = error - velocity / omega;
                    if switching * output < -hysteresis {
                        output = -output;
                    }
                    (0.5 * limit * output, 0.0)
                }
            };
            let command = wanted.clamp(-limit, limit);
            if (wanted - command) * drives <= 0.0 {
                integral += time * drives;
            }
            command
        }
    }
}

/// Times at which estimates and errors are compared, s.
const LOOKS: [f64; 5] = [1.5, 3.0, 10.0, 20.0, 29.9];

/// What became of a servo.
struct Outcome {
    /// b stays within 2 % after, s; infinite if it does not at the end.
    within: f64,
    /// The same after a change of b at 10 s.
    within_again: f64,
    /// Of b at the end, per cent.
    off: f64,
    /// a, b, c, d: the error over its standard error.
    scores: [[f64; 4]; LOOKS.len()],
    /// Two standard errors of b, per cent.
    width: [f64; LOOKS.len()],
}

fn learn<N: Arithmetic>(case: &Case) -> Outcome {
    let settings = case.settings(N::IS_FIXED);
    let identifier: Gradient<N, AB_COULOMB> = settings.build().expect("certified");
    let mut state = identifier.start();
    let gain = |now: f64| match case.happening {
        Happening::Changes(factor) if now >= 10.0 => factor,
        _ => 1.0,
    };
    let every = (1e-2 / case.time).round().max(1.0) as usize;
    let mut out = Outcome {
        within: 0.0,
        within_again: 0.0,
        off: f64::INFINITY,
        scores: [[f64::NAN; 4]; LOOKS.len()],
        width: [f64::INFINITY; LOOKS.len()],
    };
    let mut k = 0;
    case.run(|moved, command| {
        let command = identifier.command_word(command);
        let _ = identifier.process(&mut state, moved, command);
        identifier.work(&mut state, u32::MAX);
        let now = k as f64 * case.time;
        if k % every == 0 {
            let found = identifier.estimates_in(&identifier.snapshot(&state));
            out.off = 100.0 * (found.b / (gain(now) * case.servo.b) - 1.0).abs();
            if out.off > 2.0 {
                let next = now + 1e-2;
                let is_last = next >= DURATION - 1e-2;
                *(if now < 10.0 {
                    &mut out.within
                } else {
                    &mut out.within_again
                }) = if is_last { f64::INFINITY } else { next };
            }
        }
        for (place, look) in LOOKS.into_iter().enumerate() {
            if (look / case.time).round() as usize == k {
                let found = identifier.estimates_in(&identifier.snapshot(&state));
                let report = identifier.report(&state);
                let mut load = case.servo.load;
                if let (Happening::LoadStep(step), true) = (case.happening, now > 10.0) {
                    load += step;
                }
                let of = [Unknown::A, Unknown::B, Unknown::Coulomb, Unknown::Load];
                let errors =
                    of.map(|unknown| report.standard_error_of(unknown).unwrap_or(f64::NAN));
                let ServoParameters { a, b, coulomb, .. } = case.servo;
                let b = gain(now) * b;
                let truth = [a, b, coulomb, load];
                let values = [found.a, found.b, found.coulomb, found.load];
                out.scores[place] =
                    core::array::from_fn(|i| (values[i] - truth[i]).abs() / errors[i]);
                out.width[place] = 200.0 * errors[1] / b;
            }
        }
        k += 1;
    });
    if !matches!(case.happening, Happening::Changes(_)) {
        out.within = out.within.max(out.within_again);
    }
    out
}

fn environment(name: &str, default: u32) -> u32 {
    std::env::var(name)
        .ok()
        .and_then(|value| value.parse().ok())
        .unwrap_or(default)
}

fn campaign<N: Arithmetic>(name: &str, happening: Happening) -> Vec<Outcome> {
    let (servos, seed) = (environment("SERVOS", 16), environment("SEED", 1));
    let cases: Vec<Case> = (0..servos)
        .map(|k| Case::draw(seed.wrapping_mul(100_003).wrapping_add(k), happening))
        .collect();
    let outcomes = on_all_cores(servos, |k| learn::<N>(&cases[k as usize]));
    let of = |figure: fn(&Outcome) -> f64| -> [f64; 3] {
        let values: Vec<f64> = outcomes.iter().map(figure).collect();
        [0.5, 0.9, 1.0].map(|part| quantile(&values, part))
    };
    let never = outcomes.iter().filter(|o| o.within.is_infinite()).count();
    let lost = outcomes.iter().filter(|o| o.off > 10.0).count();
    println!(
        "{name}: {servos} servos of seed {seed}; b within 2 % for good after {:.2?} s (median, 90 %, all), never {never}; off at the end {:.2?} %, more than 10 %: {lost}",
        of(|o| o.within),
        of(|o| o.off),
    );
    if matches!(happening, Happening::Changes(_)) {
        println!(
            "   after the change: {:.2?} s",
            of(|o| o.within_again - 10.0)
        );
    }
    for (place, look) in LOOKS.into_iter().enumerate() {
        let inside = [0, 1, 2, 3].map(|i| per_cent(&outcomes, |o| o.scores[place][i] <= 2.0));
        let widths: Vec<f64> = outcomes.iter().map(|o| o.width[place]).collect();
        let shown = |o: &Outcome| o.width[place] <= 10.0;
        println!(
            "   {look:4} s: a, b, c, d within two errors {inside:.0?} %; b shown {:.0} %, wrongly {:.1} %; two errors of b {:.2} % (median), {:.2} % (90 %)",
            per_cent(&outcomes, shown),
            per_cent(&outcomes, |o| shown(o) && o.scores[place][1] > 2.0),
            quantile(&widths, 0.5),
            quantile(&widths, 0.9)
        );
    }
    outcomes
}

#[test]
fn it_finds_servos_within_a_second_in_every_number_format() {
    type Of = fn(&str, Happening) -> Vec<Outcome>;
    let of: [(&str, Of); 3] = [
        ("f32", campaign::<f32>),
        ("f64", campaign::<f64>),
        ("fixed point", campaign::<Word>),
    ];
    for (name, of) in of {
        let outcomes = of(name, Happening::Nothing);
        let in_time = per_cent(&outcomes, |o| o.within <= 1.5);
        let known = per_cent(&outcomes, |o| o.off <= 10.0);
        assert!(
            in_time >= 80.0 && known > 99.0,
            "{name}: {in_time}, {known}"
        );
    }
}

#[test]
fn what_happens_meanwhile_spoils_no_shown_estimate() {
    for (name, happening) in [
        ("noise of half a count", Happening::Noise(0.5)),
        ("a sample of delay", Happening::Delay(1.0)),
        ("load step", Happening::LoadStep(30.0)),
        ("motion ends", Happening::Ends),
        ("b over 1000:1", Happening::Wide),
        ("friction of 10 to 30 % of the limit", Happening::Sticky),
        ("a load of 30 % of the limit at 5 Hz", Happening::MovingLoad),
        ("the paper's gamma", Happening::PaperGamma),
    ] {
        let outcomes = campaign::<f32>(name, happening);
        // Of a few servos, which are those of a campaign of many.
        let wrong = per_cent(&outcomes, |o| o.width[2] <= 10.0 && o.scores[2][1] > 2.0);
        assert!(wrong <= 30.0, "{name}: {wrong} % wrong");
    }
}

#[test]
fn a_gain_that_changes_is_followed() {
    for (name, factor) in [("b halves", 0.5), ("b doubles", 2.0)] {
        let outcomes = campaign::<f32>(name, Happening::Changes(factor));
        let again: Vec<f64> = outcomes.iter().map(|o| o.within_again - 10.0).collect();
        assert!(quantile(&again, 0.5) <= 15.0, "{name}: {again:?}");
    }
}

/// The estimates of a run whose every so many-th piece is lost on its way, and the pieces that were.
fn with_losses<N: Arithmetic>(case: &Case, every: u32) -> (ServoParameters, u32) {
    type Recursion<N> = GradientRecursion<N, LowPass<N>, Unknowns<3>, 3>;
    let settings = case.settings(N::IS_FIXED);
    let identifier: Recursion<N> = settings.build().expect("certified");
    let memory = identifier.memory();
    let (mut state, mut remembered, mut pieces) = (identifier.start(), memory.start(), 0);
    case.run(|moved, command| {
        let command = identifier.command_word(command);
        let _ = identifier.process(&mut state, moved, command);
        if let Some(piece) = identifier.take_piece(&mut state) {
            pieces += 1;
            let estimates = identifier.machine_estimates(&state);
            if pieces % every != 0
                && let Some(found) = memory.process(&mut remembered, &piece, &estimates)
            {
                identifier.take_over(&mut state, &found);
            }
        }
    });
    let found = identifier.estimates_in(&identifier.snapshot(&state));
    (found, memory.lost(&remembered))
}

#[test]
fn the_halves_are_the_whole_and_a_piece_that_is_lost_is_counted() {
    let case = Case::draw(1, Happening::Nothing);
    let (found, lost) = with_losses::<f32>(&case, u32::MAX);
    assert_eq!(lost, 1, "the one that began before its first command");
    let whole: Gradient<f32, AB_COULOMB> = case.settings(false).build().expect("certified");
    let mut state = whole.start();
    case.run(|moved, command| {
        let _ = whole.process(&mut state, moved, command as f32);
        whole.work(&mut state, 1);
    });
    assert_eq!(found, whole.estimates_in(&whole.snapshot(&state)));
    for k in 0..8 {
        let case = Case::draw(k, Happening::Nothing);
        let (found, lost) = with_losses::<f32>(&case, 20);
        assert!(lost > 100, "{lost}");
        let off = (found.b / case.servo.b - 1.0).abs();
        assert!(off < 0.05, "{k}: {off}");
    }
}

#[test]
fn number_formats_drift_less_than_the_noise() {
    let offs = on_all_cores(environment("SERVOS", 16), |k| {
        let case = Case::draw(k + 50, Happening::Nothing);
        let exact = with_losses::<f64>(&case, u32::MAX).0;
        let single = with_losses::<f32>(&case, u32::MAX).0;
        let fixed = with_losses::<Word>(&case, u32::MAX).0;
        [single, fixed].map(|found| (found.b / exact.b - 1.0).abs())
    });
    let [single, fixed] = [0, 1].map(|i| offs.iter().map(|o| o[i]).fold(0.0, f64::max));
    println!("b differs from that of f64 by at most {single:.1e} (f32), {fixed:.1e} (fixed point)");
    assert!(single < 5e-3 && fixed < 5e-3);
}
