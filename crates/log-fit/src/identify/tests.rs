use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;

const SAMPLES: usize = 9000;
const GAIN: f64 = 0.4;
const COULOMB: f64 = 0.02;

/// A servo that holds against a load, in fine steps, counts and samples. The arguments are friction, the load at a
/// sample, a position and a velocity, and the motion.
fn recorded(coulomb: f64, load: impl Fn(usize, f64, f64) -> f64, amplitude: f64) -> Vec<Logged> {
    let law = |_, error: f64, v: f64| (2e-3 * error - 0.1 * v).clamp(-1.0, 1.0);
    controlled(SAMPLES, law, coulomb, load, amplitude)
}

/// The same with this many samples, and with a control law of a sample, an error and a velocity.
fn controlled(
    count: usize,
    law: impl Fn(usize, f64, f64) -> f64,
    coulomb: f64,
    load: impl Fn(usize, f64, f64) -> f64,
    amplitude: f64,
) -> Vec<Logged> {
    const STEPS: usize = 50;
    let (mut q, mut v) = (0.0_f64, 0.0_f64);
    let dt = 1.0 / STEPS as f64;
    (0..count)
        .map(|k| {
            let phase = 0.011 * k as f64;
            let goal = amplitude * (phase.sin() + 0.5 * (2.7 * phase).sin());
            let command = law(k, goal - q, v);
            let position = q.round();
            for _ in 0..STEPS {
                let push = GAIN * command + load(k, q, v);
                if v == 0.0 && push.abs() <= coulomb {
                    continue;
                }
                let direction = if v == 0.0 { push } else { v }.signum();
                let rate = push - coulomb * direction - 0.003 * v;
                let next = v + dt * (1.0 - 0.5 * 0.003 * dt) * rate;
                // Friction stops it within the step, and the push may move it on.
                let stops = next * direction < 0.0 && coulomb > 0.0;
                let left = if stops { dt * next / (next - v) } else { 0.0 };
                let on = (push.abs() - coulomb).max(0.0).copysign(push);
                let end = if stops { left * on } else { next };
                let kept = if stops { 0.0 } else { next };
                q += 0.5 * (dt - left) * (v + kept) + 0.5 * left * end;
                v = end;
            }
            Logged {
                position,
                command,
                begins: k == 0,
            }
        })
        .collect()
}

fn identified(samples: &[Logged]) -> Identified {
    identified_with(
        4,
        &Recording::new(samples, Axis::new(1.0, Way::Turn(10_000.0))),
    )
}

fn identified_with(max_effects: usize, recording: &Recording<'_>) -> Identified {
    identified_while(&|| true, max_effects, recording)
}

fn identified_while(
    goes_on: GoesOn<'_>,
    max_effects: usize,
    recording: &Recording<'_>,
) -> Identified {
    let demand = ModelDemand {
        known: Values::NONE,
        required: Vec::new(),
        max_effects,
    };
    identify(recording, &recording.scales(), &demand, goes_on).expect("a servo")
}

fn std_error(found: &Identified, wanted: Effect) -> f64 {
    let mut estimated = found.estimated.iter();
    let found = estimated.find(|(effect, _)| *effect == wanted);
    found.expect("it is estimated").1
}

/// Under a command of one size a dead band equals a smaller gain. A gear loss equals friction, and an asymmetric gain
/// equals a load.
#[test]
fn of_a_command_of_one_size_gain_friction_and_load_need_others() {
    let relay = |low: f64| {
        let sizes = [0.5, low];
        let law =
            move |k: usize, error: f64, v: f64| sizes[k / 1000 % 2] * (error - 30.0 * v).signum();
        let found = identified(&controlled(SAMPLES, law, COULOMB, |_, _, _| 0.0, 400.0));
        let error = std_error(&found, Effect::Coulomb);
        (found.needs_more_amplitudes, error)
    };
    let (one, error) = relay(0.5);
    let needed = [Effect::B, Effect::Coulomb, Effect::Load];
    assert_eq!(one, needed);
    assert!(error > 0.02 * GAIN * 0.5, "{error}");
    let (several, error) = relay(0.3);
    assert!(
        !several.contains(&Effect::Coulomb) && error < 0.005 * GAIN * 0.5,
        "{several:?} {error}"
    );
}

#[test]
fn a_fit_that_is_stopped_has_what_it_knew_then() {
    let ripple = |_, q: f64, _| 0.05 * (TAU * 7.0 * q / 10_000.0).sin();
    let samples = recorded(COULOMB, ripple, 400.0);
    let recording = Recording::new(&samples, Axis::new(1.0, Way::Turn(10_000.0)));
    let after = |most: usize| {
        let steps = AtomicUsize::new(0);
        let goes_on = || steps.fetch_add(1, Ordering::Relaxed) < most;
        let found = identified_while(&goes_on, 4, &recording);
        (found, steps.into_inner())
    };
    let (whole, steps) = after(usize::MAX);
    assert!(!whole.was_stopped && !whole.entered.is_empty());
    let (none, asked) = after(0);
    assert!(none.was_stopped && none.entered.is_empty() && none.values.get(Effect::B) > 0.0);
    assert!(asked < steps / 2, "{asked} of {steps}");
    let (most, _) = after(9 * steps / 10);
    assert!(most.was_stopped && !most.entered.is_empty());
    let b = most.values.get(Effect::B);
    assert!((b / GAIN - 1.0).abs() < 0.01, "{b}");
}

#[test]
fn of_a_load_that_steps_the_last_is_the_servos() {
    let step = SAMPLES * 2 / 3;
    let level = |k: usize| if k < step { 0.06 } else { -0.03 };
    let found = identified(&recorded(COULOMB, |k, _, _| level(k), 400.0));
    let off = found.values.get(Effect::Load) - level(SAMPLES);
    let error = std_error(&found, Effect::Load);
    assert!(off.abs() < 2.0 * error, "{off} ± {error}");
    assert!(error < 0.01 * GAIN, "{error}");
    let last = found.last_load.expect("it steps");
    assert!((last - step as f64).abs() < 0.03 * SAMPLES as f64, "{last}");
}

#[test]
fn a_servo_without_friction_has_a_standard_error_of_it() {
    // By chance it would have a little less than none.
    let found = identified(&recorded(0.0, |_, _, v| 5e-4 * v.signum(), 400.0));
    let coulomb = found.values.get(Effect::Coulomb);
    let error = std_error(&found, Effect::Coulomb);
    assert!(coulomb == 0.0 && error < 0.01 * GAIN, "{coulomb} ± {error}");
}

/// A ripple of which the motion shows a part is a load as well. Its mean is in the load's error.
#[test]
fn a_load_is_as_uncertain_as_the_mean_of_a_ripple_beside_it() {
    let ripple = |q: f64| 0.05 * (30.0 * TAU / 10_000.0 * q + 0.8).sin();
    let recording = recorded(COULOMB, |_, q, _| 0.03 + ripple(q), 70.0);
    let found = identified(&recording);
    let load = found.values.get(Effect::Load);
    let error = std_error(&found, Effect::Load);
    assert!((load - 0.03).abs() < 2.0 * error, "{load} ± {error}");
}

#[test]
fn of_a_motion_in_one_direction_what_brakes_it_is_one_number() {
    let pushed = |sign: f64| {
        let law = move |k: usize, _, _| sign * [0.5, 0.25][k / 500 % 2];
        let found = identified(&controlled(SAMPLES, law, COULOMB, |_, _, _| -0.03, 0.0));
        found.braking.expect("it moves one way")
    };
    for (sign, braking) in [(1.0, COULOMB + 0.03), (-1.0, COULOMB - 0.03)] {
        let [value, error] = pushed(sign);
        let off = (value - braking).abs();
        assert!(off < 3.0 * error + 1e-4, "{sign}: {value} ± {error}");
        assert!(error < 0.02, "{error}");
    }
    let both_ways = identified(&recorded(COULOMB, |_, _, _| 0.0, 400.0));
    assert!(both_ways.braking.is_none());
}

/// Blocks, and pieces of a long log, leave out the motion within and between them. The last fit does not.
#[test]
fn of_a_longer_log_no_less_is_known() {
    let mixed = |k: usize| (k as u32).wrapping_mul(0x9e37_79b9) >> 16;
    let pushed = |k: usize| f64::from(mixed(k / 7)) / 65536.0 - 0.5;
    let law = |k, error: f64, v: f64| pushed(k) + 2e-3 * error - 0.1 * v;
    let samples = controlled(132_000, law, COULOMB, |_, _, _| 0.0, 400.0);
    let recording = Recording::new(&samples, Axis::new(1.0, Way::Turn(10_000.0)));
    let found = identified_with(0, &recording);
    let per_block = recording.block.powi(Effect::Coulomb.unit()[1]);
    let off = found.values.get(Effect::Coulomb) * per_block / COULOMB - 1.0;
    assert!(off.abs() < 4e-4, "{off}");
}

#[test]
fn a_load_that_no_command_holds_is_not_known() {
    for (load, beyond) in [(0.3, 0.0), (-0.4, 0.0), (0.5, 0.1), (-1.4, 1.0)] {
        let off = beyond_authority(load, 0.4) - beyond;
        assert!(off.abs() < 1e-12, "{load}");
    }
}

/// A servo of 6 and of 24 thousand samples, pushed at random, and what was identified of it, with the samples to one of its
/// record.
fn pushed_longer(coulomb: f64) -> [(Identified, f64); 2] {
    // SplitMix64: Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
    let mixed = |k: usize| {
        let mut state = (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (state >> 48) as u32
    };
    let random = move |k: usize| f64::from(mixed(k)) / 65536.0 - 0.5;
    let law = move |k, error: f64, v: f64| 0.5 * random(k / 7) + 2e-4 * error - 0.05 * v;
    [6000, 24_000].map(|count| {
        let mut samples = controlled(count, law, coulomb, |_, _, _| 0.0, 4000.0);
        // A sensor's noise of a count and a half, above the rounding that no length averages out.
        for (k, sample) in samples.iter_mut().enumerate() {
            sample.position += (5.0 * random(k + 1_000_000)).round();
        }
        let recording = Recording::new(&samples, Axis::new(1.0, Way::Turn(10_000.0)));
        (identified_with(4, &recording), recording.block)
    })
}

/// What data leave open is less of more data: half of it of four times as many.
#[test]
fn an_interval_shrinks_with_the_root_of_the_time_and_holds_the_truth() {
    for coulomb in [0.004, COULOMB, 0.06] {
        let found = pushed_longer(coulomb);
        for (effect, truth) in [
            (Effect::B, GAIN),
            (Effect::Coulomb, coulomb),
            (Effect::Load, 0.0),
        ] {
            let of_sample = |block: f64| block.powi(effect.unit()[1]);
            let errors = found
                .each_ref()
                .map(|(found, block)| std_error(found, effect) * of_sample(*block));
            let ratio = errors[0] / errors[1];
            // A load adds up over a longer horizon, too.
            let most = if effect == Effect::Load { 40.0 } else { 4.0 };
            let of = format!("{effect:?} {coulomb}");
            assert!((1.4..most).contains(&ratio), "{of}: {errors:?}");
            for ((found, block), error) in found.iter().zip(errors) {
                let off = found.values.get(effect) * of_sample(*block) - truth;
                assert!(off.abs() < 3.0 * error, "{of}: {off} ± {error}");
            }
        }
    }
}

/// What moves two estimates moves both: viscous friction takes over from Coulomb friction.
#[test]
fn errors_and_correlations_are_of_one_covariance() {
    let [(found, _), _] = pushed_longer(COULOMB);
    let free: Vec<Effect> = found.estimated.iter().map(|(effect, _)| *effect).collect();
    let error = |i: usize| found.estimated[i].1;
    let correlation = |i: usize, j: usize| found.covariance[i][j] / (error(i) * error(j));
    for i in 0..free.len() {
        assert!((correlation(i, i) - 1.0).abs() < 1e-12, "{:?}", free[i]);
        for j in 0..i {
            let one = correlation(i, j);
            assert!(one.abs() <= 1.0, "{:?} {:?}: {one}", free[i], free[j]);
            assert!((one - correlation(j, i)).abs() < 1e-9);
        }
    }
    let [a, coulomb] =
        [Effect::A, Effect::Coulomb].map(|wanted| free.iter().position(|effect| *effect == wanted));
    let one = correlation(a.expect("free"), coulomb.expect("free"));
    assert!(one < -0.4, "{one}");
}

/// Every period of a motion that repeats itself has the same rounding. No further period averages it out.
#[test]
fn a_motion_that_repeats_itself_tells_no_more_than_its_first_period() {
    const FRICTION: f64 = 5.0 * COULOMB / 6.0;
    for (band, phase, size) in [(0.3, 0.0, 0.6), (0.3, 0.3, 1.0), (0.15, 0.3, 1.0)] {
        let command = move |k: usize| size * (TAU * k as f64 / 60.0 + phase).sin();
        let dead = move |k: usize, _, v: f64| -GAIN * command(k).clamp(-band, band) - 0.057 * v;
        let found = identified(&controlled(2000, |k, _, _| command(k), FRICTION, dead, 0.0));
        let error = std_error(&found, Effect::B);
        let off = found.values.get(Effect::B) - GAIN;
        assert!(
            off.abs() < 2.0 * error,
            "{band} {phase} {size}: {off} ± {error}"
        );
    }
}

/// Friction that grows with the square of the speed changes within a sample.
#[test]
fn beside_a_quadratic_friction_that_brakes_within_a_sample_the_gain_is_right() {
    let mixed = |k: usize| (k as u32).wrapping_mul(0x9e37_79b9) >> 16;
    let law = move |k: usize, _, _| 40.0 * (f64::from(mixed(k / 12)) / 65536.0 - 0.5);
    let drag = |_, _, v: f64| -0.003 * v * v.abs();
    let found = identified(&controlled(6000, law, 0.2, drag, 0.0));
    let off = found.values.get(Effect::B) / GAIN - 1.0;
    assert!(off.abs() < 1e-3, "{off} with {:?}", found.entered);
}

/// The time scales know nothing of a dead band before the motor, until the fit takes it off the command.
#[test]
fn the_scales_of_what_acted_have_the_gain_that_those_of_the_recorded_command_miss() {
    let band = 0.15;
    let law = |k: usize, error: f64, v: f64| {
        let size = 0.3 + 0.2 * (k as f64 / 700.0).sin();
        (size * (error - 30.0 * v).signum()).clamp(-1.0, 1.0)
    };
    let mut samples = controlled(SAMPLES, law, COULOMB, |_, _, _| 0.0, 400.0);
    for sample in &mut samples {
        sample.command += band * sample.command.signum();
    }
    let recording = Recording::new(&samples, Axis::new(1.0, Way::Turn(10_000.0)));
    let found = identified_with(4, &recording);
    let off = |scale: &TimeScale| (scale.values.get(Effect::B) / GAIN - 1.0).abs();
    let acting = found.acting.as_ref().expect("a gain");
    let raw = recording.scales();
    let raw = surest(&raw).expect("a gain");
    assert!(off(raw) > 0.1, "{raw:?}");
    assert!(off(acting) < 0.02, "{acting:?}");
}
