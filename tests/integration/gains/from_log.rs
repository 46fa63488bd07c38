//! The way from a log to gains: what a log is written in changes nothing of the gains of its servo.

use std::f64::consts::{PI, TAU};

use identifier_log::recognise::LogOptions;
use identifier_log::result::KeptResult;
use identifier_log::tune::{
    CommandDirection, ConditionError, Conditions, Form, IdentifiedResult, KnownConditions, Tuned,
};
use integration_tests::logs::{Masses, RecordedLog, two_masses};

use super::campaign::{columns, exact, identified};

const COUNTS: f64 = 40_000.0;

/// A log of one mass.
fn log() -> RecordedLog {
    let mut setup = two_masses(8, 0, Masses::One).setup;
    setup.counts_per_rev = COUNTS;
    setup.record()
}

/// A log as somebody wrote it.
struct Written {
    names: [&'static str; 2],
    /// Of the position and of the command.
    scales: [f64; 2],
    /// The period after which the position begins again, in its unit.
    wrap: Option<f64>,
    command_sign: Option<CommandDirection>,
    form: Option<Form>,
}

impl Written {
    const PLAIN: Self = Self {
        names: ["position_rad", "iq [A]"],
        scales: [1.0, 1.0],
        wrap: None,
        command_sign: None,
        form: None,
    };

    fn result(&self, log: &RecordedLog) -> IdentifiedResult {
        let [time, mut position, mut command] = columns(log);
        for position in &mut position {
            *position *= self.scales[0];
            if let Some(period) = self.wrap {
                *position = position.rem_euclid(period);
            }
        }
        for command in &mut command {
            *command *= self.scales[1];
        }
        let names = ["time_s", self.names[0], self.names[1]].map(str::to_owned);
        let columns = names.into_iter().zip([time, position, command]).collect();
        let stated = LogOptions {
            counts_per_rev: Some(COUNTS),
            ..LogOptions::default()
        };
        let summary = identified(columns, &stated).expect("a log");
        IdentifiedResult::new(&KeptResult::from(&summary)).expect("a result")
    }

    fn gains(&self, log: &RecordedLog) -> Result<Tuned, ConditionError> {
        let result = self.result(log);
        let conditions = Conditions {
            counts: Some(COUNTS),
            limit: Some(log.setup.limit),
            bandwidth: Some(30.0),
            resonance: Some(f64::INFINITY),
            torque_constant: self.form.map(|_| 0.05),
            command_sign: self.command_sign,
            form: self.form,
            ..Conditions::default()
        };
        let known = KnownConditions::default();
        let settings = conditions.settings(conditions.goal(), &result, &known)?;
        Ok(Tuned::of_conditions(&result, &known, &conditions, &settings).expect("gains"))
    }
}

/// k_p, k_d and k_i, per A however the command is written.
fn gains_of(tuned: &Tuned) -> [f64; 3] {
    [tuned.tuning.kp, tuned.tuning.kd, tuned.tuning.ki]
}

#[test]
fn units_wrap_and_sign_of_a_log_change_no_gains() {
    let log = log();
    let plain = gains_of(&Written::PLAIN.gains(&log).expect("gains"));
    let degrees = 180.0 / PI;
    for written in [
        Written {
            names: ["position_deg", "iq [A]"],
            scales: [degrees, 1.0],
            ..Written::PLAIN
        },
        Written {
            wrap: Some(TAU),
            ..Written::PLAIN
        },
        Written {
            names: ["angle [turns]", "iq [mA]"],
            scales: [1.0 / TAU, 1000.0],
            ..Written::PLAIN
        },
        Written {
            scales: [1.0, -1.0],
            command_sign: Some(CommandDirection::Inverted),
            ..Written::PLAIN
        },
    ] {
        let tuned = written.gains(&log).expect("gains");
        for (gain, plain) in gains_of(&tuned).into_iter().zip(plain) {
            let names = written.names;
            assert!(
                (gain / plain - 1.0).abs() < 0.02,
                "{names:?}: {gain}, not {plain}"
            );
        }
    }
}

/// A loop that ran has the other sign than such a column: with its gains in the column's the axis would run away.
#[test]
fn there_are_no_gains_from_a_sign_that_was_inferred() {
    let log = log();
    let inverted = |command_sign| Written {
        scales: [1.0, -1.0],
        command_sign,
        ..Written::PLAIN
    };
    let refused = inverted(None).gains(&log);
    assert_eq!(refused.err(), Some(ConditionError::Sign));
    let refused = inverted(Some(CommandDirection::AsLogged)).gains(&log);
    assert_eq!(refused.err(), Some(ConditionError::Against));
}

#[test]
fn a_prefix_of_the_command_changes_no_parameter_of_a_firmware() {
    let log = log();
    for form in ["odrive", "simplefoc", "moteus"] {
        let form = Some(form.parse::<Form>().expect("a form"));
        let parameters = |names, scale| {
            let written = Written {
                names,
                scales: [1.0, scale],
                form,
                ..Written::PLAIN
            };
            let tuned = written.gains(&log).expect("gains");
            let parameters = tuned.form.expect("a form").parameters.into_iter();
            parameters.map(|of| (of.name, of.value)).collect::<Vec<_>>()
        };
        let of_amperes = parameters(["position_rad", "iq [A]"], 1.0);
        let of_milli = parameters(["position_rad", "iq [mA]"], 1000.0);
        for ((name, value), (_, other)) in of_amperes.into_iter().zip(of_milli) {
            assert!(
                (value - other).abs() <= 0.02 * value.abs(),
                "{name}: {value} and {other}"
            );
        }
    }
}

/// Gains without the delay or the resonance of the log would not hold in the exact loop.
#[test]
fn delay_and_resonance_of_a_log_act_on_its_gains() {
    for (delay, masses) in [(4.0, Masses::One), (1.0, Masses::Two)] {
        let mut setup = two_masses(8, 0, masses).setup;
        setup.effects.delay = delay * setup.sample_time;
        if masses == Masses::Two {
            setup.effects.resonance = 0.3 / setup.sample_time;
            setup.effects.inertia_ratio = 0.5;
            setup.effects.resonance_damping = Some(0.02);
        }
        setup.counts_per_rev = COUNTS;
        let log = setup.record();
        let result = Written::PLAIN.result(&log);
        let conditions = Conditions {
            counts: Some(0.0),
            limit: Some(f64::INFINITY),
            resonance: Some(f64::INFINITY),
            ..Conditions::default()
        };
        let settings = conditions.settings(conditions.goal(), &result, &KnownConditions::default());
        let settings = settings.expect("conditions");
        let sensitivity = |result: &IdentifiedResult| {
            let tuned = Tuned::new(result, None, &settings).expect("gains");
            exact(&log, &tuned.tuning).sensitivity()
        };
        let kept = sensitivity(&result);
        let mut dropped = result.clone();
        dropped.model.servo.delay = 0.0;
        dropped.model.resonance = None;
        let dropped = sensitivity(&dropped);
        println!("{masses:?}: Ms {kept:.2}, {dropped:.2} without");
        assert!(kept < 1.68, "{masses:?}: {kept}");
        assert!(dropped > 1.8, "{masses:?}: {dropped}");
    }
}
