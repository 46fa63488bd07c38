//! Unknown servos of two masses, commissioned, and the applied gains judged by the frequency response of the true loop:
//! `CAMPAIGN=4` for 240 of them, `CAMPAIGN_SEED=7` for others than usual, `CAMPAIGN_FEED_FORWARD=1` for gains with a
//! feed-forward, `CAMPAIGN_PLAY=0.003` for couplings with so much play, rad, `CAMPAIGN_NARROW=1` for narrow resonances about half of
//! the sampling frequency, `CAMPAIGN_LOAD_FRICTION=0.5` for half of the friction on the load.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use commissioning::{CommissionSettings, Limits, Phase};
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::TuningError;
use virtual_servo::{Effects, SplitMix64};

use super::rig::{Background, Bench, ordinary};
use super::two_mass_loop::TwoMassLoop;

/// Servos of a campaign with a factor of one.
const SERVOS: f64 = 60.0;

/// Largest true sensitivity of applied gains: 1.6 is promised for every servo that the identified one may be.
const MAX_SENSITIVITY: f64 = 1.8;

/// Part of the applied servos that may exceed it.
const EXCEEDING: f64 = 0.02;

/// The largest command, and the gain of the weakest, rad/s² per command unit.
const LIMIT: f64 = 10.0;
const WEAKEST: f64 = 50.0;

/// The change of the speed in a sample by all of the command, over the largest speed, and that beyond which a servo of a
/// declared gain is refused.
fn speed_step(bench: &Bench) -> f64 {
    let settings = &bench.settings;
    bench.servo.b * LIMIT * settings.sample_time / settings.limits.speed
}
const MAX_SPEED_STEP: f64 = 0.15;

/// The twist of the spring over which the motor turns round before the load does, over the travel from end to end, and
/// that beyond which the turn is as large as the motions.
fn wind_up(bench: &Bench) -> f64 {
    let Effects {
        resonance,
        inertia_ratio: share,
        load_friction,
        ..
    } = bench.effects;
    let [low, high] = bench.settings.limits.travel;
    2.0 * load_friction / (resonance * resonance * share * (1.0 - share) * (high - low))
}
const MAX_WIND_UP: f64 = 0.02;

/// Logarithmic between two bounds.
pub(crate) fn log_uniform(random: &mut SplitMix64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.next_uniform())
}

/// A servo of two masses: 10 to 600 Hz, a load share of 0.1 to 0.9, damping of 0.005 to 0.1, friction of 3 to 30 % of the
/// limit, which acts on the motor and holds it at rest, so that it hides the resonance from a motor that stands.
pub(crate) fn two_masses(seed: u64) -> Bench {
    let mut random = SplitMix64::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x2545_f491);
    let random = &mut random;
    let sample_time = random.one_of(&[1e-3, 2.5e-4, 1e-4]);
    let b = log_uniform(random, WEAKEST, 100.0 * WEAKEST);
    let authority = b * LIMIT;
    let coulomb = authority * random.uniform(0.03, 0.3);
    let counts = log_uniform(random, 4096.0, 262_144.0).round();
    let travel = log_uniform(random, 0.3, 3.0);
    Bench {
        servo: ServoParameters::new(
            log_uniform(random, 0.02, 5.0),
            b,
            coulomb,
            coulomb * random.uniform(-0.6, 0.6),
        ),
        effects: Effects {
            delay: sample_time * random.uniform(0.0, 2.0),
            current_loop: log_uniform(random, 5e-5, 3e-4),
            resonance: TAU * log_uniform(random, 10.0, 600.0),
            resonance_damping: Some(log_uniform(random, 0.005, 0.1)),
            inertia_ratio: random.uniform(0.1, 0.9),
            ..Effects::NONE
        },
        counts,
        offset: random.next_uniform(),
        settings: CommissionSettings {
            sample_time,
            resolution: TAU / counts,
            limits: Limits {
                travel: [-travel, travel],
                // Half of the command stops it in a fifth to a half of the travel.
                speed: (authority * travel * random.uniform(0.2, 0.5)).sqrt(),
                command: [-LIMIT, LIMIT],
                duration: 3.0,
            },
            ..ordinary().settings
        },
        background: Background::Busy(seed),
        ..ordinary()
    }
}

/// The same at 1 kHz with a narrow resonance of 0.3 to 0.6 of the sampling frequency: between two lines, beyond them, or an image.
fn narrow(seed: u64) -> Bench {
    let mut bench = two_masses(seed);
    let mut random = SplitMix64::new(seed ^ 0x6e61_7272);
    let ratio = log_uniform(&mut random, 0.1, 1.0);
    bench.settings.sample_time = 1e-3;
    bench.effects.delay = bench.settings.sample_time * random.uniform(0.0, 2.0);
    bench.effects.resonance = TAU * random.uniform(300.0, 600.0);
    bench.effects.resonance_damping = Some(log_uniform(&mut random, 0.005, 0.015));
    bench.effects.inertia_ratio = ratio / (1.0 + ratio);
    bench
}

/// The end of a commissioning.
pub(crate) struct Judged {
    pub(crate) phase: Phase,
    pub(crate) reason: &'static str,
    pub(crate) time: f64,
    /// True Mₛ of applied gains, infinite where they are unstable.
    pub(crate) sensitivity: Option<f64>,
    bandwidth: f64,
    /// Gains that were applied have a feed-forward.
    is_led: bool,
    /// The farthest, as a part of the travel, and the fastest, as a part of the speed.
    travel: f64,
    speed: f64,
    /// The largest speed and travel up to the end, as parts of their limits.
    pub(crate) reached: [f64; 2],
    no_gains: Option<TuningError>,
    resonance: Option<f64>,
}

pub(crate) fn judge(bench: &Bench) -> Judged {
    let course = bench.commission(&mut |_| None);
    let state = &course.state;
    let applied = state.phase() == Phase::Applied;
    let tuning = state.tuning().filter(|_| applied);
    let limits = &bench.settings.limits;
    let farthest = course.travel.map(f64::abs).into_iter().fold(0.0, f64::max);
    Judged {
        phase: state.phase(),
        reason: state.reason().map_or("", |reason| reason.name()),
        time: course.ended().unwrap_or(f64::INFINITY),
        sensitivity: tuning.map(|tuning| {
            let sensitivity = TwoMassLoop::new(bench, tuning).sensitivity();
            sensitivity.unwrap_or(f64::INFINITY)
        }),
        bandwidth: tuning.map_or(0.0, |tuning| tuning.bandwidth),
        is_led: tuning.is_some_and(|tuning| tuning.feed_forward.is_some()),
        travel: farthest / limits.travel[1],
        speed: course.speed / limits.speed,
        reached: course.reached,
        no_gains: state.tuning_error().copied(),
        resonance: course.resonance,
    }
}

/// A load on a spring behind a current loop (s): its resonance, Hz, with its damping, and its share of the inertia.
fn on_a_spring(current_loop: f64, hertz: f64, damping: f64, share: f64) -> Effects {
    Effects {
        current_loop,
        resonance: TAU * hertz,
        resonance_damping: Some(damping),
        inertia_ratio: share,
        ..Effects::NONE
    }
}

/// An axis on which friction hides a resonance of 224 Hz.
pub(crate) fn hidden() -> Bench {
    let mut bench = ordinary();
    bench.servo = ServoParameters::new(0.0653, 491.35, 600.94, 91.88);
    bench.effects = on_a_spring(5.668e-5, 223.91, 0.01436, 0.438);
    bench.set_counts(35_645.0);
    bench.settings.limits = Limits {
        duration: 3.0,
        ..Limits::new([-PI, PI], 190.5, [-48.0, 48.0])
    };
    bench
}

#[test]
fn a_resonance_that_friction_hides_is_found_and_a_notch_lets_gains_be_faster() {
    let [with, without] = [true, false].map(|notch| {
        let mut bench = hidden();
        bench.settings.notch = notch;
        let judged = borne(&bench);
        let shown = judged.resonance.expect("two masses") / bench.effects.resonance;
        assert!((shown - 1.0).abs() < 0.01, "{shown}");
        assert!(judged.travel <= 1.0 && judged.speed <= 1.0);
        judged.bandwidth
    });
    assert!(with / without > 1.5, "{with} {without}");
}

/// An axis with a load on a spring.
fn heavy(hertz: f64, share: f64) -> Bench {
    let mut bench = ordinary();
    bench.servo = ServoParameters::new(0.5, 400.0, 500.0, -300.0);
    bench.effects = on_a_spring(1e-4, hertz, 0.02, share);
    bench.set_counts(20_000.0);
    bench.settings.sample_time = 2.5e-4;
    bench.settings.limits = Limits {
        duration: 3.0,
        ..Limits::new([-1.0, 1.0], 40.0, [-LIMIT, LIMIT])
    };
    bench
}

/// The end of a commissioning that applies gains which its resonance bears.
fn borne(bench: &Bench) -> Judged {
    let judged = judge(bench);
    println!(
        "{} {} {:?} Ms {:?} {:.1} rad/s {:?} travel {:.2} speed {:.2} {:.1} s",
        judged.phase.name(),
        judged.reason,
        judged.no_gains,
        judged.sensitivity,
        judged.bandwidth,
        judged.resonance.map(|shown| shown / TAU),
        judged.travel,
        judged.speed,
        judged.time
    );
    assert_eq!(judged.phase, Phase::Applied, "{}", judged.reason);
    let sensitivity = judged.sensitivity.expect("applied");
    assert!(sensitivity < MAX_SENSITIVITY, "{sensitivity}");
    judged
}

/// The same where the resonance is shown.
fn assert_borne(bench: &Bench) {
    let shown = borne(bench).resonance.expect("two masses");
    let shown = shown / bench.effects.resonance;
    assert!((shown - 1.0).abs() < 0.02, "{shown}");
}

/// Axes at 1 kHz with an encoder in whose rounding single lines of high frequency are lost.
fn hard_to_see(hertz: f64, share: f64) -> Bench {
    let mut bench = ordinary();
    bench.effects = on_a_spring(1e-4, hertz, 0.0133, share);
    bench
}

/// Gains for one mass would have an Ms above 2 here. The start between two counts decides what the lines show.
fn assert_borne_from_any_count(bench: &Bench) {
    for part in 0..3 {
        let mut bench = *bench;
        bench.offset = f64::from(part) / 3.0;
        borne(&bench);
    }
}

#[test]
fn a_resonance_beyond_half_of_the_sampling_frequency_is_borne() {
    let mut bench = hard_to_see(510.0, 0.53);
    bench.servo = ServoParameters::new(2.7, 1000.0, 173.0, -11.0);
    bench.set_counts(16_340.0);
    bench.settings.limits = Limits {
        duration: 5.0,
        ..Limits::new([-PI, PI], 28.0, [-1.0, 1.0])
    };
    assert_borne_from_any_count(&bench);
}

#[test]
fn a_narrow_resonance_between_two_lines_is_borne() {
    let mut bench = hard_to_see(307.5, 0.134);
    bench.servo = ServoParameters::new(2.7, 121.0, 165.0, -12.5);
    bench.set_counts(60_848.0);
    bench.settings.limits = Limits {
        duration: 5.0,
        ..Limits::new([-0.5, 0.5], 8.7, [-5.0, 5.0])
    };
    assert_borne_from_any_count(&bench);
}

/// The antiresonance, 7 to 8 Hz, is at the lowest lines of a survey: low lines show both masses together. From some starts
/// the step of the trial rests in friction for longer than was predicted.
#[test]
fn a_heavy_load_on_a_soft_spring_is_found_by_low_lines() {
    let starts = (0..4).map(|part| f64::from(part) / 4.0);
    let mut applied = 0;
    for (hertz, share) in [(12.0, 0.6), (16.0, 0.8)] {
        for offset in starts.clone() {
            let judged = judge(&Bench {
                offset,
                ..heavy(hertz, share)
            });
            let shown = judged.resonance.expect("two masses") / TAU / hertz;
            assert!((shown - 1.0).abs() < 0.02, "{shown}");
            let sensitivity = judged.sensitivity.unwrap_or(0.0);
            assert!(sensitivity < MAX_SENSITIVITY, "{sensitivity}");
            applied += i32::from(judged.phase == Phase::Applied);
        }
    }
    assert!(applied >= 7, "{applied} of 8");
}

/// The five numbers explain its motions, and gains for these alone have an Ms of 15.
#[test]
fn a_resonance_that_no_motion_shows_is_looked_for_before_there_are_gains() {
    let mut bench = hard_to_see(137.0, 0.7275);
    bench.effects.resonance_damping = Some(0.006);
    bench.effects.delay = 1e-3;
    bench.servo = ServoParameters::new(0.24, 5.06, 12.2, -17.5);
    bench.set_counts(1457.0);
    bench.settings.limits = Limits::new([-0.3, 0.3], 6.0, [-48.0, 48.0]);
    for part in 0..8 {
        bench.offset = f64::from(part) / 8.0;
        let judged = judge(&bench);
        let sensitivity = judged.sensitivity.unwrap_or(0.0);
        println!(
            "{part}: {} {} {sensitivity}",
            judged.phase.name(),
            judged.reason
        );
        assert!(sensitivity < MAX_SENSITIVITY, "{part}: {sensitivity}");
    }
}

/// The motor alone is four to six times as strong as both masses: a relay that goes on while it rings drives it to twice its speed.
#[test]
fn a_relay_that_drives_a_resonance_keeps_its_speed() {
    for (hertz, share, damping) in [(125.0, 0.78, 0.011), (225.0, 0.83, 0.006)] {
        let mut bench = heavy(hertz, share);
        (bench.servo.b, bench.servo.coulomb, bench.servo.load) = (127.0, 80.0, -30.0);
        bench.effects.resonance_damping = Some(damping);
        bench.settings.sample_time = 1e-3;
        bench.settings.limits.travel = [-0.6, 0.6];
        bench.settings.limits.speed = 15.0;
        let judged = judge(&bench);
        assert!(judged.travel <= 1.0, "{hertz}: {}", judged.travel);
        assert!(judged.speed <= 1.0, "{hertz}: {}", judged.speed);
    }
}

/// The motor alone is five times as strong, and the loop that is to hold the axis after its first motion drives the resonance
/// within milliseconds, while its reference moves.
#[test]
fn a_loop_that_drives_a_resonance_gives_way_while_its_reference_moves() {
    for hertz in [360.0, 440.0] {
        let mut bench = heavy(hertz, 0.8);
        (bench.servo.b, bench.servo.coulomb, bench.servo.load) = (110.0, 60.0, 10.0);
        bench.effects.resonance_damping = Some(0.007);
        bench.settings.limits.travel = [-0.75, 0.75];
        bench.settings.limits.speed = 12.0;
        assert_borne(&bench);
    }
}

/// The loop that holds an axis whose command is late by ten samples, which nothing declares, oscillates at first, as one of a
/// second mass does that nothing has shown yet.
#[test]
fn a_servo_that_oscillates_while_it_is_studied_is_held_more_slowly() {
    let mut bench = ordinary();
    bench.settings.sample_time = 5e-4;
    bench.settings.limits.travel = [-0.5, 0.5];
    bench.settings.limits.speed = 30.0;
    bench.effects.delay = 5e-3;
    let judged = judge(&bench);
    assert_eq!(judged.phase, Phase::Applied, "{}", judged.reason);
    assert!(judged.travel <= 1.0 && judged.speed <= 1.0);
}

/// Gravity bends the slow lines of an axis of little travel, as a second mass would whose antiresonance is below them.
#[test]
fn gravity_within_little_travel_is_shown_as_no_resonance() {
    for angle in [0.0, 0.8, 1.57, 3.1] {
        let mut bench = ordinary();
        bench.set_counts(65_536.0);
        bench.settings.limits.travel = [-0.1, 0.1];
        bench.servo.load = 0.0;
        let most = 0.19 * LIMIT * bench.servo.b;
        bench.effects.gravity = [most * f64::sin(angle), most * f64::cos(angle)];
        let judged = judge(&bench);
        println!(
            "{angle}: {} {} {:?}",
            judged.phase.name(),
            judged.reason,
            judged.resonance
        );
        assert_eq!(judged.resonance, None, "{angle}");
    }
}

fn environment(variable: &str) -> Option<f64> {
    std::env::var(variable).ok()?.parse().ok()
}

#[test]
#[ignore = "takes minutes"]
fn a_servo_of_two_masses_gets_gains_that_its_resonance_bears_or_none() {
    let first = 10_000 * environment("CAMPAIGN_SEED").unwrap_or(1.0) as u64;
    let servos = (SERVOS * environment("CAMPAIGN").unwrap_or(1.0)).ceil() as u64;
    let is_narrow = environment("CAMPAIGN_NARROW").is_some_and(|on| on > 0.0);
    let axis = if is_narrow { narrow } else { two_masses };
    let mut benches: Vec<Bench> = (first..first + servos).map(axis).collect();
    for bench in &mut benches {
        bench.settings.feed_forward =
            environment("CAMPAIGN_FEED_FORWARD").is_some_and(|on| on > 0.0);
        bench.effects.backlash = environment("CAMPAIGN_PLAY").unwrap_or(0.0);
        // Of the same friction as a whole.
        let behind = bench.servo.coulomb * environment("CAMPAIGN_LOAD_FRICTION").unwrap_or(0.0);
        bench.effects.load_friction = behind;
        bench.servo.coulomb -= behind;
    }
    let half = benches.len().div_ceil(2);
    let judged: Vec<Judged> = std::thread::scope(|scope| {
        let workers: Vec<_> = benches
            .chunks(half)
            .map(|part| scope.spawn(|| part.iter().map(judge).collect::<Vec<_>>()))
            .collect();
        let ended = workers.into_iter().map(|worker| worker.join());
        ended.flat_map(|judged| judged.expect("no panic")).collect()
    });
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for judged in &judged {
        *reasons.entry(judged.reason).or_default() += 1;
    }
    let count = |is: &dyn Fn(&Judged) -> bool| judged.iter().filter(|judged| is(judged)).count();
    let applied = count(&|judged| judged.sensitivity.is_some());
    let beyond = |limit| count(&|judged| judged.sensitivity.is_some_and(|seen| seen > limit));
    let (unstable, exceeding) = (beyond(1e6), beyond(MAX_SENSITIVITY));
    let left = count(&|judged| judged.travel > 1.0 + 1e-3);
    let too_fast = count(&|judged| judged.speed > 1.0);
    let mut times: Vec<f64> = judged.iter().map(|judged| judged.time).collect();
    times.sort_by(f64::total_cmp);
    println!(
        "{servos} servos of two masses: {applied} applied, {} of them with a feed-forward, {unstable} unstable, {exceeding} with Ms > {MAX_SENSITIVITY}, {} > 2.4; \
         {left} left the travel, {too_fast} the speed; {:.1} s median, {:.1} s at 90 %",
        count(&|judged| judged.is_led),
        beyond(2.4),
        times[times.len() / 2],
        times[times.len() * 9 / 10],
    );
    println!("{reasons:?}");
    let slow = benches.iter().zip(&judged);
    let slow = slow.filter(|(bench, _)| speed_step(bench) <= MAX_SPEED_STEP);
    let (slow, others): (Vec<_>, Vec<_>) =
        slow.partition(|(_, judged)| judged.sensitivity.is_some());
    println!(
        "{} applied of {} whose speed all of the command changes by at most {MAX_SPEED_STEP} of its limit in a sample",
        slow.len(),
        slow.len() + others.len()
    );
    let wound = benches.iter().zip(&judged);
    let wound = wound.filter(|(bench, _)| wind_up(bench) <= MAX_WIND_UP);
    let (wound, others): (Vec<_>, Vec<_>) =
        wound.partition(|(_, judged)| judged.sensitivity.is_some());
    println!(
        "{} applied of {} whose spring friction of the load winds up by at most {MAX_WIND_UP} of the travel",
        wound.len(),
        wound.len() + others.len()
    );
    assert_eq!(unstable, 0);
    assert!(
        exceeding as f64 <= EXCEEDING * applied as f64,
        "{exceeding} of {applied}"
    );
}
