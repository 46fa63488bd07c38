//! Drawn logs → identification → the stiffest gains → the exact loop with the true servo.
//!
//! ```sh
//! LOGS=500 SEED=7 cargo test --release -p integration-tests --test integration gains::campaign -- --ignored --nocapture
//! ```

use identifier_core::parameters::IdentifiedServo;
use identifier_core::tuning::{Mode, Resonance, Shown, Tuner, Tuning, TuningSettings};
use identifier_log::identify;
use identifier_log::log::{Log, Table};
use identifier_log::recognise::{LogOptions, recognise};
use identifier_log::result::{KeptResult, Summary};
use identifier_log::tune::{Conditions, IdentifiedResult, KnownConditions, Tuned};
use integration_tests::exact_loop::{ExactLoop, LinearController};
use integration_tests::logs::{Masses, RecordedLog, two_masses};
use integration_tests::{environment, in_parallel};

use std::f64::consts::TAU;

/// What gains are on the servo of their log.
struct Judged {
    /// True if the resonance is in the result.
    is_shown: bool,
    /// True if the servo is known as the verdict has it.
    is_known: bool,
    gains: Option<Gains>,
    /// Bandwidth of the true servo's gains, rad/s; with two masses those of a commissioning.
    ideal: Option<f64>,
}

struct Gains {
    bandwidth: f64,
    /// Mₛ of the exact loop, infinite if unstable.
    sensitivity: f64,
}

/// Identifies columns of a log with what is stated of it.
pub(super) fn identified(
    columns: Vec<(String, Vec<f64>)>,
    stated: &LogOptions,
) -> Result<Summary, String> {
    let table = Table::of_columns("drawn", columns)?;
    let options = recognise(&table, stated).map_err(|error| error.to_string())?;
    let options = options.options().map_err(|error| error.to_string())?;
    let log = Log::new(&table, &options.log_columns(), options.log_sample_time());
    let log = log.map_err(|error| error.to_string())?;
    let found = identify(&[log], &[], &options, &|| true);
    Ok(found.map_err(|error| error.to_string())?.summary)
}

/// Time, position and command of a log.
pub(super) fn columns(log: &RecordedLog) -> [Vec<f64>; 3] {
    let rows = 0..log.commands.len();
    let time = rows.clone().map(|row| row as f64 * log.setup.sample_time);
    let position = rows.map(|row| log.position(row));
    [time.collect(), position.collect(), log.commands.clone()]
}

/// The exact loop of gains around the servo of a log.
pub(super) fn exact(log: &RecordedLog, tuning: &Tuning) -> ExactLoop {
    let setup = &log.setup;
    let controller = LinearController::tuned(tuning, setup.sample_time);
    ExactLoop::new(&setup.servo, &setup.effects, setup.sample_time, controller)
}

/// What identification has found that gains may be built on.
fn found(log: &RecordedLog) -> Option<IdentifiedResult> {
    let names = ["time_s", "position_rad", "command"].map(str::to_owned);
    let stated = LogOptions {
        counts_per_rev: Some(log.setup.counts_per_rev),
        ..LogOptions::default()
    };
    let columns = names.into_iter().zip(columns(log)).collect();
    let summary = identified(columns, &stated).ok()?;
    let result = IdentifiedResult::new(&KeptResult::from(&summary)).ok()?;
    result.reservation.is_none().then_some(result)
}

fn judged(log: &RecordedLog) -> Judged {
    let setup = &log.setup;
    let result = found(log);
    let conditions = Conditions {
        counts: Some(setup.counts_per_rev),
        limit: Some(setup.limit),
        resonance: environment("RESONANCE"),
        ..Conditions::default()
    };
    let tuned = result.as_ref().and_then(|result| {
        let settings = conditions.settings(conditions.goal(), result, &KnownConditions::default());
        Tuned::new(result, None, &settings.ok()?).ok()
    });
    Judged {
        is_shown: (result.as_ref()).is_some_and(|result| result.model.resonance.is_some()),
        is_known: result.is_some(),
        gains: tuned.map(|tuned| Gains {
            bandwidth: tuned.tuning.bandwidth,
            sensitivity: exact(log, &tuned.tuning).sensitivity(),
        }),
        ideal: ideal(log),
    }
}

/// The bandwidth of the true servo's gains, rad/s.
fn ideal(log: &RecordedLog) -> Option<f64> {
    let (setup, effects) = (&log.setup, &log.setup.effects);
    let servo = IdentifiedServo::known(setup.servo, effects.delay);
    let share = effects.inertia_ratio;
    let on_motor = effects.resonance > 0.0 && !effects.encoder_on_load;
    let resonance = on_motor.then(|| Resonance {
        mode: Mode {
            frequency: effects.resonance,
            damping: effects.resonance_damping.unwrap_or_default(),
            ratio: share / (1.0 - share),
        },
        errors: [0.0; 2],
        friction_on_motor: true,
    });
    let count = TAU / setup.counts_per_rev;
    let room = setup.limit - (setup.servo.load / setup.servo.b).abs();
    let step = Conditions::STEP.max(TuningSettings::MIN_STEP_COUNTS * count);
    let settings = TuningSettings::new(setup.sample_time, count, room, step);
    let tuner = Tuner::for_response(&settings, &servo, resonance.as_ref()).ok()?;
    Some(tuner.run(Shown::Nothing).ok()?.bandwidth)
}

/// Judges the logs of a seed and prints their table: how many loops are unstable or near it.
fn campaign(masses: Masses, seed: u32, logs: u32) -> Vec<Judged> {
    let numbers: Vec<u32> = (0..logs).collect();
    let all = in_parallel(&numbers, |&number| {
        judged(&two_masses(seed, number, masses))
    });
    let detail = environment::<u8>("DETAIL").is_some();
    for (number, of) in numbers.iter().zip(&all) {
        let sensitivity = of.gains.as_ref().map(|gains| gains.sensitivity);
        if detail || sensitivity.is_some_and(|of| of > 1.8) {
            println!(
                "log {number} of seed {seed}: Ms {sensitivity:.2?}, resonance in the result: {}",
                of.is_shown
            );
        }
    }
    let with = || all.iter().filter_map(|of| Some((of, of.gains.as_ref()?)));
    let above = |shown: bool, most: f64| {
        let alike = with().filter(|(of, _)| of.is_shown == shown);
        alike.filter(|(_, gains)| gains.sensitivity > most).count()
    };
    let shown = with().filter(|(of, _)| of.is_shown).count();
    let mut parts: Vec<f64> = with()
        .filter_map(|(of, gains)| Some(gains.bandwidth / of.ideal?))
        .collect();
    parts.sort_by(f64::total_cmp);
    let part = |quantile: f64| {
        let place = quantile * (parts.len().max(1) - 1) as f64;
        parts.get(place as usize).copied().unwrap_or(f64::NAN)
    };
    println!(
        "{masses:?}, seed {seed}: {logs} logs, {} known, {} with gains, {} unstable",
        all.iter().filter(|of| of.is_known).count(),
        with().count(),
        with()
            .filter(|(_, gains)| gains.sensitivity.is_infinite())
            .count(),
    );
    println!(
        "  resonance in the result: {shown}, Ms above 1.68 in {}; not: {}, above 1.8 in {}",
        above(true, 1.68),
        with().count() - shown,
        above(false, 1.8)
    );
    println!(
        "  bandwidth by that of the true servo's gains: a tenth below {:.2}, half below {:.2}",
        part(0.1),
        part(0.5)
    );
    all
}

fn on_demand(masses: Masses) {
    let [seed, logs] =
        [("SEED", 1), ("LOGS", 60)].map(|(of, usual)| environment(of).unwrap_or(usual));
    campaign(masses, seed, logs);
}

#[test]
#[ignore = "campaign: minutes, LOGS=500 SEED=n"]
fn of_two_masses() {
    on_demand(Masses::Two);
}

#[test]
#[ignore = "campaign: minutes, LOGS=200 SEED=n"]
fn of_an_encoder_on_the_load() {
    on_demand(Masses::TwoWithEncoderOnLoad);
}

/// With `RESONANCE=inf` for servos that are known to have none.
#[test]
#[ignore = "campaign: minutes, LOGS=200 SEED=n"]
fn of_one_mass() {
    on_demand(Masses::One);
}

#[test]
fn of_a_few_drawn_servos_no_loop_is_unstable() {
    for masses in [Masses::One, Masses::Two, Masses::TwoWithEncoderOnLoad] {
        let all = campaign(masses, 8, 5);
        let gains: Vec<_> = all.iter().filter_map(|of| of.gains.as_ref()).collect();
        assert!(gains.len() >= 3, "{masses:?}: {} have gains", gains.len());
        for gains in gains {
            assert!(gains.sensitivity < 2.5, "{masses:?}: {}", gains.sensitivity);
        }
    }
}

#[test]
fn the_mode_that_is_found_is_the_highest_of_many_peaks() {
    // That of a lower peak is half as high again, with gains that are unstable.
    let log = two_masses(25_821, 371, Masses::Two);
    let mode = found(&log).and_then(|found| found.model.resonance);
    let mode = mode.expect("found").mode;
    let off = mode.frequency / log.setup.effects.resonance - 1.0;
    assert!(off.abs() < 0.01, "{mode:?}");
}
