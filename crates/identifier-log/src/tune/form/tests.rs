//! The loop of each firmware is that of its own code, and its margins and its step are those that the form predicts.

use std::f64::consts::TAU;

use identifier_core::number::Complex;
use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{Mode, Resonance, StepMeasure};
use virtual_servo::{Effects, Servo, SplitMix64};

use super::super::{KnownEffects, LoopModel};
use super::firmware::FIRMWARES;
use super::firmware_loop::Controller;
use super::*;

/// An identified servo that nothing is hidden of.
fn identified(a: f64, b: f64, delay: f64, sample_time: f64) -> IdentifiedResult {
    let parameters = ServoParameters::new(a, b, 0.0, 0.3 * b);
    IdentifiedResult {
        model: LoopModel::new(IdentifiedServo::known(parameters, delay)),
        axis: AxisKind::Rotary,
        load: [0.3 * b, 0.0],
        effects: KnownEffects::default(),
        has_delay: true,
        sample_time,
        noise: None,
        reading: None,
        reservation: None,
    }
}

/// The gains of a result for a form, in a loop with an ideal sensor, and the reason why there are none.
fn tuned(
    result: &IdentifiedResult,
    unit: CommandUnit,
    form: &str,
    stated: Conditions,
    goal: Goal,
) -> Result<Tuned, NoGains> {
    let known = KnownConditions {
        resolution: Some(0.0),
        limit: Some([-20.0, 20.0]),
        command_unit: Some(unit),
        ..KnownConditions::default()
    };
    let conditions = Conditions {
        form: Some(form.parse().expect("a form")),
        resonance: stated.resonance.or(Some(f64::INFINITY)),
        ..stated
    };
    let settings = conditions.settings(goal, result, &known);
    Tuned::of_conditions(result, &known, &conditions, &settings.expect("conditions"))
}

/// Positions that a firmware was shown, rad, with a target of 0.1 rad from the first on.
const SHOWN: [f64; 12] = [
    0.001, 0.01, 0.03, 0.06, 0.1, 0.14, 0.17, 0.19, 0.2, 0.203, 0.19, 0.17,
];

/// Of a firmware by its name.
type Response = (&'static str, [f64; 3], f64, f64, [f64; SHOWN.len()]);

/// What the firmware's own code put out then, compiled from the files that the table names: gains in SI, period, and what one
/// of its output is in SI. SimpleFOC puts out in the loop that follows.
const RESPONSES: [Response; 6] = [
    (
        "simplefoc",
        [94.7214, 0.02, 0.105573],
        1e-3,
        1.0,
        [
            0.184701,
            0.1390567,
            0.04042997,
            -0.1009078,
            -0.2813138,
            -0.4453516,
            -0.5434009,
            -0.5830852,
            -0.5707395,
            -0.5273517,
            -0.4085304,
            f64::NAN,
        ],
    ),
    (
        "odrive",
        [94.7214, 0.125664 / TAU, 0.663334 / TAU],
        125e-6,
        1.0,
        [
            0.1864707,
            0.1576173,
            0.07671953,
            -0.07231138,
            -0.3007968,
            -0.5865647,
            -0.8823555,
            -1.152254,
            -1.369411,
            -1.523123,
            -1.579367,
            -1.540408,
        ],
    ),
    (
        "moteus",
        [0.125664 / TAU, 12.5664 / TAU, 62.8319 / TAU],
        1.0 / 30e3,
        -1.0,
        [
            -0.1992117,
            -0.1910782,
            -0.1670415,
            -0.1199364,
            -0.04308496,
            0.06150758,
            0.1837188,
            0.3140671,
            0.4436791,
            0.5667248,
            0.670361,
            0.7499959,
        ],
    ),
    (
        "vesc",
        [1.16355e-4, 0.0116355, 0.0581776],
        1e-3,
        TAU / 360.0 / 60.0,
        [
            3.899787, 2.853788, 0.6246009, -2.521949, -6.48559, -9.984502, -11.91123, -12.49942,
            -11.93556, -10.72909, -7.869442, -4.63731,
        ],
    ),
    (
        "wpilib",
        [0.02, 2.0, 10.0],
        20e-3,
        1.0,
        [
            0.3168, 0.2088, 0.1718, 0.1098, 0.0198, -0.0682, -0.1322, -0.1802, -0.2102, -0.2298,
            -0.2058, -0.1728,
        ],
    ),
    (
        "linuxcnc",
        [0.02, 2.0, 10.0],
        1e-3,
        1.0,
        [
            1.97799, 0.00089, -0.25841, -0.51801, -0.79801, -0.87841, -0.73911, -0.58001, -0.40101,
            -0.26804, 0.07706, 0.25636,
        ],
    ),
];

#[test]
fn a_firmware_puts_out_what_its_own_code_does() {
    for (name, gains, sample_time, unit, expected) in RESPONSES {
        let firmware = FIRMWARES.iter().find(|firmware| firmware.name == name);
        let firmware = firmware.expect("a row");
        let frequency = firmware.cutoff.expect("its own");
        let mut controller = Controller::new(FirmwareLoop {
            firmware,
            sample_time,
            filter: firmware.filter.of(frequency, sample_time).0,
            gains,
            limit: f64::INFINITY,
        });
        for (position, expected) in SHOWN.into_iter().zip(expected) {
            let found = controller.process(0.1, position);
            let off = found - unit * expected;
            assert!(
                expected.is_nan() || off.abs() <= 2e-4 * unit.abs(),
                "{name}: {found} {expected}"
            );
        }
    }
    // Whose code can be read has its numbers here.
    let read = FIRMWARES
        .iter()
        .filter(|firmware| firmware.source.is_some());
    assert!(
        read.map(|of| &*of.name)
            .eq(RESPONSES.map(|(name, ..)| name))
    );
}

/// A form with what it needs to be stated, and the viscous friction of the servos that it is for, 1/s.
struct Case {
    form: &'static str,
    friction: f64,
    unit: CommandUnit,
    conditions: Conditions,
}

fn cases() -> impl Iterator<Item = Case> {
    FIRMWARES.iter().map(|firmware| {
        let form = &*firmware.name;
        let stated = Conditions::default();
        let at_12_volts = Conditions {
            bus_voltage: Some(12.0),
            ..stated
        };
        let (friction, unit, conditions) = match form {
            "simplefoc" => (
                2.0,
                CommandUnit::Volt,
                Conditions {
                    sample_time: Some(1e-3),
                    ..stated
                },
            ),
            // The log's command is a current; the motor gives 0.04 Nm/A.
            "odrive" => (
                2.0,
                CommandUnit::Ampere,
                Conditions {
                    torque_constant: Some(0.04),
                    ..stated
                },
            ),
            "moteus" => (2.0, CommandUnit::NewtonMetre, stated),
            "vesc" => (
                2.0,
                CommandUnit::Ampere,
                Conditions {
                    max_current: Some(60.0),
                    ..stated
                },
            ),
            "dynamixel" | "feetech" => (60.0, CommandUnit::Volt, at_12_volts),
            "wpilib" => (2.0, CommandUnit::Volt, stated),
            "sparkmax" => (2.0, CommandUnit::Volt, at_12_volts),
            "cia402" => (
                2.0,
                CommandUnit::Other,
                Conditions {
                    cutoff: Some(800.0),
                    ..stated
                },
            ),
            _ => (2.0, CommandUnit::Other, stated),
        };
        Case {
            form,
            friction,
            unit,
            conditions,
        }
    })
}

/// A loop that runs around a servo of the simulator.
struct Running<'a> {
    of: &'a FirmwareLoop,
    servo: ServoParameters,
    effects: Effects,
}

impl Running<'_> {
    /// Position (rad) and command of each sample, for a target (rad, of the time) and a command in the first sample beside the
    /// controller's. The gain of the servo is multiplied by a factor.
    fn run(
        &self,
        factor: f64,
        target: impl Fn(f64) -> f64,
        extra: f64,
        samples: usize,
    ) -> Vec<[f64; 2]> {
        let time = self.of.sample_time;
        let parameters = ServoParameters {
            b: factor * self.servo.b,
            ..self.servo
        };
        let mut servo = Servo::at_rest(&parameters, &self.effects, time, 1).expect("allowed");
        let mut controller = Controller::new(*self.of);
        let sample = |sample: usize| {
            let position = servo.position();
            let own = controller.process(target(sample as f64 * time), position);
            let command = own + if sample == 0 { extra } else { 0.0 };
            servo.advance(command);
            [position, command]
        };
        (0..samples).map(sample).collect()
    }

    fn is_stable(&self, factor: f64, samples: usize) -> bool {
        let course = self.run(factor, |_| 0.0, 1e-12, samples);
        let largest =
            |part: &[[f64; 2]]| part.iter().fold(0.0_f64, |most, at| most.max(at[0].abs()));
        let third = samples / 3;
        largest(&course[2 * third..]) < largest(&course[third..2 * third])
    }

    /// The factor up to which it is stable on one side.
    fn edge(&self, to: f64, samples: usize) -> f64 {
        let mut ends = [1.0, to];
        for _ in 0..9 {
            let middle = (ends[0] * ends[1]).sqrt();
            ends[usize::from(!self.is_stable(middle, samples))] = middle;
        }
        (ends[0] * ends[1]).sqrt()
    }

    /// Mₛ: the command under an impulse beside the controller's is the impulse response of 1/(1 + L).
    fn sensitivity(&self, frequencies: impl Iterator<Item = f64>, samples: usize) -> f64 {
        let impulse = self.run(1.0, |_| 0.0, 1e-3, samples);
        let of = |frequency: f64| {
            let turn = Complex::new(0.0, -frequency * self.of.sample_time).exponential();
            let start = (Complex::ZERO, Complex::ONE);
            let (sum, _) = impulse.iter().fold(start, |(sum, at), [_, command]| {
                (sum + at.scaled(*command), at * turn)
            });
            1e3 * sum.power().sqrt()
        };
        let below_half = frequencies.filter(|frequency| frequency * self.of.sample_time < 3.1);
        below_half.map(of).fold(0.0, f64::max)
    }
}

fn is_near(own: f64, predicted: f64, part: f64) -> bool {
    (own - predicted).abs() <= part * predicted.abs()
}

/// Twenty servos for each form, of which the first half have a second mass. Prints a row for the last of each.
#[test]
fn the_loop_of_each_firmware_has_the_margins_and_the_step_that_are_predicted() {
    let mut random = SplitMix64::new(93);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.next_uniform();
    for case in cases() {
        let period =
            case.conditions
                .sample_time
                .or(case.form.parse::<Form>().expect("one").0.sample_time);
        let period = period.unwrap_or(1e-3);
        for number in 0..20 {
            let b = 500.0 * uniform(-1.5, 1.5).exp();
            // Friction of the motor damps a mode, which the tuner does not count on.
            let a = match number < 10 {
                true => 0.1,
                false => case.friction * uniform(1.0, 3.0),
            };
            let delay = uniform(1e-4, 6e-4);
            let mut result = identified(a, b, delay, 1e-3);
            let own: Form = case.form.parse().expect("a form");
            let mut effects = Effects {
                delay: delay + own.0.delay * period,
                ..Effects::NONE
            };
            if number < 10 {
                let share = uniform(0.2, 0.6);
                let frequency = uniform(0.2, 0.8) / period.max(1e-3);
                effects.resonance = frequency;
                effects.inertia_ratio = share;
                effects.resonance_damping = Some(0.03);
                result.model.resonance = Some(Resonance {
                    mode: Mode {
                        frequency,
                        damping: 0.03,
                        ratio: share / (1.0 - share),
                    },
                    errors: [0.0; 2],
                    friction_on_motor: true,
                });
            }
            let tuned = tuned(
                &result,
                case.unit,
                case.form,
                case.conditions,
                Goal::Stiffest,
            );
            let tuned = match tuned {
                Ok(tuned) => tuned,
                // A proportional loop around a second mass may have no damping.
                Err(NoGains::Form(_)) if number < 10 => continue,
                Err(error) => panic!("{} {number}: {error:?}", case.form),
            };
            let form = tuned.form.clone().expect("its form");
            let known = KnownConditions {
                command_unit: Some(case.unit),
                ..KnownConditions::default()
            };
            let output = own
                .output(&known, &case.conditions, &result)
                .expect("its unit");
            let (.., firmware_loop) = own.run(&tuned, &case.conditions, output);
            let running = Running {
                of: &firmware_loop,
                servo: ServoParameters::new(a, b, 0.0, 0.0),
                effects,
            };
            let bandwidth = tuned.tuning.bandwidth;
            let samples = (80.0 / (bandwidth * period)) as usize;
            let dense = (0..240).map(|at| bandwidth * 0.3 * 1.02_f64.powi(at));
            let near = (-40..=40).map(|at| effects.resonance * (1.0 + 1e-3 * f64::from(at)));
            let found = running.sensitivity(dense.chain(near), 2 * samples);
            let predicted = form.margins.sensitivity;
            assert!(predicted <= 1.61, "{} {number}: {predicted}", case.form);
            // Corners are no worse than the servo itself, which is known.
            assert!(
                is_near(found, predicted, 0.05),
                "{} {number}: {found} {predicted}",
                case.form
            );
            assert!(
                running.is_stable(1.0, 4 * samples),
                "{} {number}",
                case.form
            );
            for step in form.steps.iter().filter(|_| number >= 10) {
                let target = |time: f64| {
                    let past = (time + period) / step.smoothing;
                    tuned.settings.step * (1.0 - (-past).exp())
                };
                let course = running.run(1.0, target, 0.0, samples);
                let mut measure = StepMeasure::<f64>::new(tuned.settings.step, 0.0);
                (course.iter()).for_each(|[position, _]| measure.take(*position));
                let rise = period * measure.rise().expect("it rises");
                let expected = step.rise_time.expect("it rises");
                assert!(
                    is_near(rise, expected, 0.003),
                    "{} {number}: {rise} {expected}",
                    case.form
                );
                let off = measure.overshoot() - step.overshoot;
                assert!(off.abs() < 0.001, "{} {number}: {off}", case.form);
            }
            if number == 19 {
                assert!(is_near(found, predicted, 0.003), "{}: {found}", case.form);
                let [fall, rise] = form.margins.gain_margins;
                let unlimited = Running {
                    of: &FirmwareLoop {
                        limit: f64::INFINITY,
                        ..firmware_loop
                    },
                    ..running
                };
                let edge = |to| unlimited.edge(to, 4 * samples);
                let edges = [edge(100.0), if fall > 0.0 { edge(0.01) } else { 0.0 }];
                println!(
                    "{}, ω {bandwidth:.2}: {:.3?} found {found:.3} {edges:.3?}",
                    form.name, form.margins
                );
                assert!(is_near(edges[0], rise, 0.03), "{}", case.form);
                assert!(is_near(edges[1], fall, 0.03), "{}", case.form);
            }
        }
    }
}

/// A tuning with these gains around q̈ = 500 u, at 1 kHz.
fn with_gains(kp: f64, ki: f64, kd: f64) -> Tuned {
    let result = identified(2.0, 500.0, 0.0, 1e-3);
    let settings = TuningSettings::new(1e-3, 0.0, 10.0, 0.1);
    let mut tuned = Tuned::new(&result, None, &settings).expect("gains");
    tuned.tuning = Tuning {
        kp,
        ki,
        kd,
        ..tuned.tuning
    };
    tuned
}

/// The values of a form for gains and a scale of the command, and the gains that these are.
fn values(form: &str, tuned: &Tuned, scale: f64) -> (Vec<f64>, [f64; 3], &'static str) {
    let form: Form = form.parse().expect("a form");
    let frequency = form.0.cutoff.unwrap_or(400.0);
    let (exactness, parameters, gains) = form.parameters(
        tuned,
        frequency,
        Output {
            scale,
            unit: "command",
        },
    );
    let values = parameters.iter().map(|parameter| parameter.value);
    (values.collect(), gains, exactness)
}

/// Numbers that were worked out by hand, and back to SI: kp, ki, kd and a scale of the command become the numbers of a form,
/// which are the last three. The scales are those of 60 A at 0.05 Nm/A, of 12 V, and of 500 · 0.02/2π Hz.
const NUMBERS: &str = "
    pid       | 2 10 0.02   1       | 2 10 0.02 400                            | 0.02 2 10
    cascade   | 2 10 0.02   1       | 94.7214 0.02 0.105573 189.442 400        | 94.72136 0.02 0.105573
    simplefoc | 2 10 0.02   1       | 94.7214 0.02 0.105573 10.3 0.005         | 94.72136 0.02 0.105573
    odrive    | 2 10 0.02   1       | 94.7214 0.125664 0.663334 0.0125664 1000 | 94.72136 0.02 0.105573
    moteus    | 2 10 0.02   1       | 12.5664 62.8319 0.125664 10.3 400 0.002  | 0.02 2 10
    vesc      | 2 10 0.02   0.333333333 | 0.0116355 0.0581776 0.000116355 0.2  | 0.02 2 10
    dynamixel | 1 0 0       1       | 174                                      | 0 1.00133 0
    feetech   | 1 0 0       1       | 6                                        | 0 0.996 0
    wpilib    | 20 100 0.2  1       | 20 100 0.2 10.3 0 0.004 0.002            | 0.2 20 100
    sparkmax  | 20 100 0.2  0.0833333333 | 10.472 0.0523599 104.72             | 0.2 20 100
    linuxcnc  | 2 10 0.02   1       | 2 10 0.02 0.004 0.002 10.3               | 0.02 2 10
    cia402    | 2 10 0.02   79.5774715 | 94.7214 1.59155 189.443 400           | 94.72136 0.02 0.105573";

#[test]
fn gains_become_the_numbers_of_each_firmware_and_back() {
    for row in NUMBERS.trim().lines() {
        let numbers = |text: &str| -> Vec<f64> {
            let numbers = text.split_whitespace().map(str::parse);
            numbers.collect::<Result<_, _>>().expect("numbers")
        };
        let mut cells = row.split('|');
        let form = cells.next().expect("a form").trim();
        let [given, expected, gains] = [(); 3].map(|()| numbers(cells.next().expect("numbers")));
        let tuned = with_gains(given[0], given[1], given[2]);
        let (own, own_gains, _) = values(form, &tuned, given[3]);
        for (own, expected, part) in [(&own[..], expected, 1e-5), (&own_gains, gains, 1e-4)] {
            assert_eq!(own.len(), expected.len(), "{form}");
            let near = own
                .iter()
                .zip(&expected)
                .all(|(own, value)| is_near(*own, *value, part));
            assert!(near, "{form}: {own:?} {expected:?}");
        }
    }
}

/// Every row of the table is read: that of a form without gains would be missing.
#[test]
fn the_table_has_every_form() {
    let names = (FIRMWARES.iter()).map(|firmware| firmware.name.as_str());
    assert!(names.eq(cases().map(|case| case.form)));
}

/// kp² = 4 kd ki is the edge; beyond it the integral is what it is there.
#[test]
fn a_cascade_without_real_gains_gets_less_integral() {
    for (ki, expected, left) in [(49.9, "exact", 49.9), (80.0, "needs ki cut", 50.0)] {
        let (_, [kx, kv, kvi], exactness) = values("cascade", &with_gains(2.0, ki, 0.02), 1.0);
        assert_eq!(exactness, expected);
        assert!((kv * kx + kvi - 2.0).abs() < 1e-4 && (kvi * kx - left).abs() < 1e-3);
    }
}

#[test]
fn what_a_form_needs_is_named_with_its_option() {
    let refusal = |axis, form: &str, a: f64, unit: &str, change: fn(&mut Conditions)| {
        let result = IdentifiedResult {
            axis,
            ..identified(a, 500.0, 5e-4, 1e-3)
        };
        let mut stated = Conditions::default();
        change(&mut stated);
        let unit = unit.parse().expect("a unit");
        match tuned(&result, unit, form, stated, Goal::Stiffest) {
            Err(NoGains::Form(error)) => error.to_string(),
            other => panic!("{form}: {other:?}"),
        }
    };
    for (form, unit, part) in [
        ("odrive", "A", "--torque-constant 0.1"),
        ("moteus", "V", "in Nm, but the log has one in V"),
        ("vesc", "other", "--command-unit A"),
        ("vesc", "A", "--max-current 60"),
        ("vesc", "V", "in A, but the log has one in V"),
        ("dynamixel", "V", "--bus-voltage 12"),
        ("sparkmax", "A", "in V, but the log has one in A"),
        ("wpilib", "Nm", "in V, but the log has one in Nm"),
    ] {
        let said = refusal(AxisKind::Rotary, form, 2.0, unit, |_| {});
        assert!(said.contains(part), "{said}");
    }
    let own = |form, a, unit, change| refusal(AxisKind::Rotary, form, a, unit, change);
    let zero = own("vesc", 2.0, "A", |of| of.max_current = Some(0.0));
    let linear = refusal(AxisKind::Linear, "odrive", 2.0, "other", |_| {});
    let fast = own("odrive", 2.0, "Nm", |of| of.cutoff = Some(5000.0));
    let free = own("dynamixel", 0.0, "V", |of| of.bus_voltage = Some(12.0));
    let unknown = "esc".parse::<Form>().expect_err("no form");
    for (said, part) in [
        (zero, "--max-current for its command, a number above 0"),
        (linear, "the result is in m"),
        (fast, "--cutoff 4000.0"),
        (free, "too little friction"),
        (unknown, "one of pid, cascade"),
    ] {
        assert!(said.contains(part), "{said}");
    }
}

/// A response time is that of the form's own loop.
#[test]
fn a_response_time_is_met_by_the_form() {
    for form in ["cascade", "simplefoc", "odrive", "linuxcnc"] {
        let result = identified(2.0, 500.0, 5e-4, 1e-3);
        let (unit, none) = (CommandUnit::NewtonMetre, Conditions::default());
        let tuned = tuned(&result, unit, form, none, Goal::ResponseTime(0.2));
        let steps = tuned.expect("gains").form.expect("its form").steps;
        let took = steps.last().and_then(|step| step.rise_time);
        let part = took.expect("a time") / 0.2;
        assert!((part - 1.0).abs() < 0.021, "{form} {part}");
    }
}
