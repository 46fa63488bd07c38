//! Each firmware's own update, written from its source in its own units, around a servo in small steps. Its margins and
//! its step match those that the form predicts.

use std::f64::consts::TAU;

use identifier_core::number::Complex;
use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::StepMeasure;

use super::super::Effects;
use super::firmware::FIRMWARES;
use super::*;

/// The number of small steps in a period.
const PARTS: usize = 20;

/// An identified servo. Its delay is a whole number of small steps.
fn identified(a: f64, b: f64, delay: f64, sample_time: f64) -> IdentifiedResult {
    IdentifiedResult {
        servo: IdentifiedServo {
            parameters: ServoParameters {
                a,
                b,
                coulomb: 0.0,
                load: 0.3 * b,
            },
            delay,
            covariance: [[0.0; 5]; 5],
            unexplained: 0.0,
        },
        axis: AxisKind::Rotary,
        load: [0.3 * b, 0.0],
        effects: Effects::default(),
        has_delay: true,
        sample_time,
        noise: None,
        reservation: None,
    }
}

/// A firmware with its state: the output for a target and a position, in its units.
type Controller = Box<dyn FnMut(f64, f64) -> f64>;

/// A controller of the values of its parameters, by name, and a period, s.
type Update = fn(&dyn Fn(&str) -> f64, f64) -> Controller;

/// The facts about a firmware that a test needs.
struct Case {
    form: &'static str,
    period: f64,
    a: f64,
    /// rad per unit of position.
    angle: f64,
    /// Command of the servo per output.
    output: f64,
    conditions: Conditions,
    unit: CommandUnit,
    controller: Update,
}

fn low_pass(share: f64) -> impl FnMut(f64) -> f64 {
    let mut state = 0.0;
    move |input| {
        state += share * (input - state);
        state
    }
}

fn difference(time: f64) -> impl FnMut(f64) -> f64 {
    let mut before = 0.0;
    move |input| {
        let rate = (input - before) / time;
        before = input;
        rate
    }
}

/// kp e + ki ∑ e T + kd (e − e₋)/T.
fn textbook([kp, ki, kd]: [f64; 3], time: f64) -> Controller {
    let (mut sum, mut rate) = (0.0, difference(time));
    Box::new(move |target, position| {
        let error = target - position;
        sum += error * time;
        kp * error + ki * sum + kd * rate(error)
    })
}

fn cascade(
    [kx, kv, kvi]: [f64; 3],
    mut velocity: impl FnMut(f64) -> f64 + 'static,
    time: f64,
) -> Controller {
    let mut integral = 0.0;
    Box::new(move |target, position| {
        let error = kx * (target - position) - velocity(position);
        integral += kvi * error * time;
        kv * error + integral
    })
}

fn filtered_difference(share: f64, time: f64) -> impl FnMut(f64) -> f64 + 'static {
    let (mut rate, mut smooth) = (difference(time), low_pass(share));
    move |position| smooth(rate(position))
}

fn cases() -> Vec<Case> {
    let conditions = Conditions::default();
    let plain = Case {
        form: "pid",
        period: 1e-3,
        a: 2.0,
        angle: 1.0,
        output: 1.0,
        conditions,
        unit: CommandUnit::Other,
        controller: |of, time| {
            let (kp, ki, kd) = (of("kp"), of("ki"), of("kd"));
            let mut velocity = filtered_difference(1.0 - (-of("cutoff") * time).exp(), time);
            let mut sum = 0.0;
            Box::new(move |target, position| {
                sum += (target - position) * time;
                kp * (target - position) + ki * sum - kd * velocity(position)
            })
        },
    };
    vec![
        Case {
            form: "cascade",
            controller: |of, time| {
                let velocity = filtered_difference(1.0 - (-of("cutoff") * time).exp(), time);
                cascade([of("Kx"), of("Kv"), of("Kvi")], velocity, time)
            },
            ..plain
        },
        Case {
            form: "simplefoc",
            conditions: Conditions {
                sample_time: Some(1e-3),
                ..conditions
            },
            unit: CommandUnit::Volt,
            controller: |of, time| {
                let (p_angle, p, i) = (of("P_angle.P"), of("PID_velocity.P"), of("PID_velocity.I"));
                let tf = of("LPF_velocity.Tf");
                let (mut rate, mut lpf) = (difference(time), 0.0);
                let (mut integral, mut before, mut next) = (0.0, 0.0, 0.0);
                Box::new(move |target, position| {
                    let alpha = tf / (tf + time);
                    lpf = alpha * lpf + (1.0 - alpha) * rate(position);
                    let error = p_angle * (target - position) - lpf;
                    integral += i * time * 0.5 * (error + before);
                    before = error;
                    // loopFOC() puts out what move() set in the loop before.
                    std::mem::replace(&mut next, p * error + integral)
                })
            },
            ..plain
        },
        Case {
            form: "odrive",
            period: 125e-6,
            angle: TAU,
            // The log's command is a current; the motor gives 0.04 Nm/A.
            output: 1.0 / 0.04,
            unit: CommandUnit::Ampere,
            conditions: Conditions {
                torque_constant: Some(0.04),
                ..conditions
            },
            controller: |of, time| {
                let (pos_gain, vel_gain, integrator_gain) = (
                    of("controller.config.pos_gain"),
                    of("controller.config.vel_gain"),
                    of("controller.config.vel_integrator_gain"),
                );
                let pll_kp = 2.0 * of("encoder.config.bandwidth");
                let pll_ki = 0.25 * pll_kp * pll_kp;
                let (mut pos, mut vel, mut integrator) = (0.0, 0.0, 0.0);
                Box::new(move |target, turns| {
                    pos += time * vel;
                    let delta = turns - pos;
                    pos += time * pll_kp * delta;
                    vel += time * pll_ki * delta;
                    let error = pos_gain * (target - pos) - vel;
                    let torque = vel_gain * error + integrator;
                    integrator += integrator_gain * time * error;
                    torque
                })
            },
            ..plain
        },
        Case {
            form: "moteus",
            period: 1.0 / 30e3,
            angle: TAU,
            unit: CommandUnit::NewtonMetre,
            controller: |of, time| {
                let (kp, ki, kd) = (
                    of("servo.pid_position.kp"),
                    of("servo.pid_position.ki"),
                    of("servo.pid_position.kd"),
                );
                let w_n = of("motor_position.sources.0.pll_filter_hz") / 2.48 * TAU;
                let (mut filtered, mut pll_integral, mut integral) = (0.0, 0.0, 0.0);
                Box::new(move |target, turns| {
                    let error = turns - filtered;
                    pll_integral += time * w_n * w_n * error;
                    let velocity = pll_integral + 2.0 * w_n * error;
                    filtered += time * velocity;
                    let error = filtered - target;
                    integral += error * ki * time;
                    -(kp * error + kd * velocity + integral)
                })
            },
            ..plain
        },
        Case {
            form: "vesc",
            angle: TAU / 360.0,
            // A share of 60 A.
            output: 60.0,
            unit: CommandUnit::Ampere,
            conditions: Conditions {
                max_current: Some(60.0),
                ..conditions
            },
            controller: |of, time| {
                let (kp, ki, kd) = (of("p_pid_kp"), of("p_pid_ki"), of("p_pid_kd_proc"));
                let mut filter = low_pass(of("p_pid_kd_filter"));
                let (mut before, mut i_term) = (0.0, 0.0);
                Box::new(move |target, degrees| {
                    let error = target - degrees;
                    i_term += error * ki * time;
                    let d_term = filter(-(degrees - before) * kd / time);
                    before = degrees;
                    kp * error + i_term + d_term
                })
            },
            ..plain
        },
        Case {
            form: "dynamixel",
            a: 60.0,
            angle: TAU / 4096.0,
            // A step of PWM is 1/885 of 12 V.
            output: 12.0 / 885.0,
            unit: CommandUnit::Volt,
            conditions: Conditions {
                bus_voltage: Some(12.0),
                ..conditions
            },
            controller: |of, _| {
                let gain = of("Position P Gain (84)") / 128.0;
                Box::new(move |target, counts| gain * (target - counts))
            },
            ..plain
        },
        Case {
            form: "feetech",
            a: 60.0,
            // 0.166 of 12 V per rad.
            output: 0.166 * 12.0,
            unit: CommandUnit::Volt,
            conditions: Conditions {
                bus_voltage: Some(12.0),
                ..conditions
            },
            controller: |of, _| {
                let gain = of("P (21)");
                Box::new(move |target, position| gain * (target - position))
            },
            ..plain
        },
        Case {
            form: "wpilib",
            period: 20e-3,
            unit: CommandUnit::Volt,
            controller: |of, time| textbook([of("kP"), of("kI"), of("kD")], time),
            ..plain
        },
        Case {
            form: "sparkmax",
            angle: TAU,
            output: 12.0,
            unit: CommandUnit::Volt,
            conditions: Conditions {
                bus_voltage: Some(12.0),
                ..conditions
            },
            controller: |of, _| {
                let (kp, ki, kd) = (of("kP"), of("kI"), of("kD"));
                let (mut state, mut before) = (0.0, 0.0);
                // Once per millisecond, its unit of time.
                Box::new(move |target, rotations| {
                    let error = target - rotations;
                    state += ki * error;
                    let rate = error - before;
                    before = error;
                    kp * error + state + kd * rate
                })
            },
            ..plain
        },
        Case {
            form: "linuxcnc",
            controller: |of, time| textbook([of("Pgain"), of("Igain"), of("Dgain")], time),
            ..plain
        },
        Case {
            form: "cia402",
            controller: |of, time| {
                // J = 1/b: the torque is an acceleration, of which the command is 1/500.
                let kv = TAU * of("speed gain") / 500.0;
                let ti = 1e-3 * of("speed integral time");
                let velocity = filtered_difference(1.0 - (-800.0 * time).exp(), time);
                cascade([of("position gain"), kv, kv / ti], velocity, time)
            },
            conditions: Conditions {
                cutoff: Some(800.0),
                ..conditions
            },
            ..plain
        },
        plain,
    ]
}

impl Case {
    const B: f64 = 500.0;

    /// A whole number of small steps, about 0.4 ms.
    fn delay(&self) -> f64 {
        let part = self.period / PARTS as f64;
        (4e-4 / part).round() * part
    }

    fn tuned(&self) -> Tuned {
        let result = identified(self.a, Self::B, self.delay(), 1e-3);
        let known = KnownConditions {
            resolution: Some(0.0),
            limit: Some([-20.0, 20.0]),
            command_unit: Some(self.unit),
            ..KnownConditions::default()
        };
        let conditions = Conditions {
            form: Some(self.form.parse().expect("a form")),
            ..self.conditions
        };
        let settings = conditions
            .settings(Goal::Stiffest, &result, &known)
            .expect("conditions");
        Tuned::of_conditions(&result, &known, &conditions, &settings)
            .unwrap_or_else(|error| panic!("{}: {error:?}", self.form))
    }

    /// Runs the loop of a form, its servo's gain times a factor. The arguments are a target (rad, of the time), a
    /// command in the first sample beside the controller's, and a load (rad/s²). The result is position (rad) and
    /// command of each sample.
    fn run(
        &self,
        form: &FormResult,
        factor: f64,
        target: impl Fn(f64) -> f64,
        extra: f64,
        load: f64,
        samples: usize,
    ) -> Vec<[f64; 2]> {
        let value = |name: &str| {
            let found = form
                .parameters
                .iter()
                .find(|parameter| parameter.name == name);
            found.unwrap_or_else(|| panic!("{name}")).value
        };
        let mut controller = (self.controller)(&value, self.period);
        let part = self.period / PARTS as f64;
        let late = (self.delay() / part).round() as usize;
        let (mut position, mut velocity) = (0.0, 0.0);
        // The command of every small step, from the time on at which it acts.
        let mut acting = vec![0.0; late];
        let mut course = Vec::with_capacity(samples);
        for sample in 0..samples {
            let wanted = target(sample as f64 * self.period);
            let output = controller(wanted / self.angle, position / self.angle);
            let command = self.output * output + if sample == 0 { extra } else { 0.0 };
            course.push([position, command]);
            acting.extend([command; PARTS]);
            for step in sample * PARTS..(sample + 1) * PARTS {
                let push = factor * Self::B * acting[step] + load;
                // Midpoint of the acceleration, twice: exact to the third order of a small step.
                let slope = push - self.a * velocity;
                let middle = push - self.a * (velocity + 0.5 * part * slope);
                position += part * velocity + 0.5 * part * part * slope;
                velocity += part * middle;
            }
        }
        course
    }

    /// Time constants that pass until a loop is still.
    fn samples(&self, bandwidth: f64) -> usize {
        (60.0 / (bandwidth * self.period)) as usize
    }

    fn is_stable(&self, form: &FormResult, factor: f64, bandwidth: f64) -> bool {
        let samples = 4 * self.samples(bandwidth);
        let course = self.run(form, factor, |_| 0.0, 1.0, 0.0, samples);
        let largest =
            |part: &[[f64; 2]]| part.iter().fold(0.0_f64, |most, at| most.max(at[0].abs()));
        let third = samples / 3;
        largest(&course[2 * third..]) < largest(&course[third..2 * third])
    }

    /// The factor from one that is stable to another that is not.
    fn edge(&self, form: &FormResult, from: f64, to: f64, bandwidth: f64) -> f64 {
        let (mut stable, mut other) = (from, to);
        for _ in 0..9 {
            let middle = (stable * other).sqrt();
            if self.is_stable(form, middle, bandwidth) {
                stable = middle;
            } else {
                other = middle;
            }
        }
        (stable * other).sqrt()
    }
}

fn is_near(own: f64, predicted: f64, part: f64) -> bool {
    (own - predicted).abs() <= part * predicted.abs()
}

/// Prints a row for each form.
#[test]
fn the_loop_of_each_firmware_has_the_margins_and_the_step_that_are_predicted() {
    for case in cases() {
        let tuned = case.tuned();
        let form = tuned.form.clone().expect("its form");
        let bandwidth = tuned.tuning.bandwidth;
        let samples = case.samples(bandwidth);
        // The command under an impulse beside the controller's is the impulse response of 1/(1 + L).
        let impulse = case.run(&form, 1.0, |_| 0.0, 1.0, 0.0, samples);
        let sensitivity = |frequency: f64| {
            let turn = |at: usize| {
                Complex {
                    re: 0.0,
                    im: -frequency * case.period * at as f64,
                }
                .exponential()
            };
            let terms = impulse
                .iter()
                .enumerate()
                .map(|(at, [_, command])| turn(at).scaled(*command));
            terms
                .fold(Complex { re: 0.0, im: 0.0 }, |sum, term| sum + term)
                .power()
                .sqrt()
        };
        let frequencies = (0..120).map(|at| bandwidth * 0.3 * 1.04_f64.powi(at));
        let below_half = frequencies.filter(|frequency| frequency * case.period < 3.1);
        let found = below_half.map(sensitivity).fold(0.0, f64::max);
        let predicted = form.margins.sensitivity;
        let [fall, rise] = form.margins.gain_margins;
        let edges = [
            case.edge(&form, 1.0, 100.0, bandwidth),
            if fall > 0.0 {
                case.edge(&form, 1.0, 0.01, bandwidth)
            } else {
                0.0
            },
        ];
        let measured = |smoothing: f64| {
            // Sampled at the end of a period, as the filter of a program does.
            let target = |time: f64| 1.0 - (-(time + case.period) / smoothing).exp();
            let course = case.run(&form, 1.0, target, 0.0, 0.0, samples);
            let mut measure = StepMeasure::<f64>::new(1.0, 0.0);
            course
                .iter()
                .for_each(|[position, _]| measure.take(*position));
            let rise = case.period * measure.rise().expect("it rises");
            (rise, measure.overshoot())
        };
        for step in &form.steps {
            let (rise, overshoot) = measured(step.smoothing);
            assert!(
                is_near(rise, step.rise_time.expect("it rises"), 0.003),
                "{}",
                case.form
            );
            assert!((overshoot - step.overshoot).abs() < 0.001, "{}", case.form);
        }
        let (own_rise, own_overshoot) = measured(0.0);
        let predicted_step = form.steps[0];
        let its_rise = predicted_step.rise_time.expect("it rises");
        println!(
            "{:10} {:12} ω {bandwidth:7.2} Ms design {:.3} promised {predicted:.3} found {found:.3}, gain {fall:.3}..{rise:.2} found {:.3}..{:.2}, \
             rise {:.2} ms found {:.2}, overshoot {:.1} % found {:.1}",
            form.name,
            form.exactness,
            tuned.tuning.predicted_response.sensitivity,
            edges[1],
            edges[0],
            1e3 * its_rise,
            1e3 * own_rise,
            100.0 * predicted_step.overshoot,
            100.0 * own_overshoot,
        );
        assert!(predicted <= 1.61, "{}", case.form);
        assert!(is_near(found, predicted, 0.003), "{}", case.form);
        assert!(is_near(edges[0], rise, 0.03), "{}", case.form);
        assert!(is_near(edges[1], fall, 0.03), "{}", case.form);
        // The integral holds the load where there is one.
        let loaded = case
            .run(&form, 1.0, |_| 0.0, 0.0, 5.0, samples)
            .pop()
            .expect("a sample")[0];
        let stored = form.parameters[0].value * case.output / case.angle;
        let kp = match case.form {
            "dynamixel" => stored / 128.0,
            "feetech" => stored,
            _ => tuned.tuning.kp,
        };
        let sags = 5.0 / (Case::B * kp);
        let left = if form.exactness == "P only" {
            sags
        } else {
            0.0
        };
        assert!(
            (loaded - left).abs() < 0.02 * sags,
            "{} {loaded} {left}",
            case.form
        );
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
    let (exactness, parameters, gains) = form.parameters(tuned, frequency, scale);
    let values = parameters.iter().map(|parameter| parameter.value);
    (values.collect(), gains, exactness)
}

/// Numbers that were worked out by hand, and back to SI.
#[test]
fn gains_become_the_numbers_of_each_firmware_and_back() {
    let tuned = with_gains(2.0, 10.0, 0.02);
    let volts = with_gains(20.0, 100.0, 0.2);
    let duty = with_gains(1.0, 0.0, 0.0);
    let cascade = [94.721_36, 0.02, 0.105_573];
    let pid = [0.02, 2.0, 10.0];
    for (form, tuned, scale, expected, gains) in [
        ("pid", &tuned, 1.0, &[2.0, 10.0, 0.02, 400.0][..], pid),
        (
            "cascade",
            &tuned,
            1.0,
            &[94.7214, 0.02, 0.105_573, 189.442, 400.0],
            cascade,
        ),
        (
            "simplefoc",
            &tuned,
            1.0,
            &[94.7214, 0.02, 0.105_573, 10.3, 5e-3],
            cascade,
        ),
        (
            "odrive",
            &tuned,
            1.0,
            &[94.7214, 0.125_664, 0.663_334, 0.012_566_4, 1000.0],
            cascade,
        ),
        (
            "moteus",
            &tuned,
            1.0,
            &[12.5664, 62.8319, 0.125_664, 10.3, 400.0, 2e-3],
            pid,
        ),
        // 60 A at 0.05 Nm/A.
        (
            "vesc",
            &tuned,
            1.0 / 3.0,
            &[0.011_635_5, 0.058_177_6, 1.163_55e-4, 0.2],
            pid,
        ),
        ("dynamixel", &duty, 1.0, &[174.0], [0.0, 1.001_33, 0.0]),
        ("feetech", &duty, 1.0, &[6.0], [0.0, 0.996, 0.0]),
        (
            "wpilib",
            &volts,
            1.0,
            &[20.0, 100.0, 0.2, 10.3, 0.0, 4e-3, 2e-3],
            [0.2, 20.0, 100.0],
        ),
        (
            "sparkmax",
            &volts,
            1.0 / 12.0,
            &[10.472, 0.052_359_9, 104.72],
            [0.2, 20.0, 100.0],
        ),
        (
            "linuxcnc",
            &tuned,
            1.0,
            &[2.0, 10.0, 0.02, 4e-3, 2e-3, 10.3],
            pid,
        ),
        // 500 · 0.02/2π Hz.
        (
            "cia402",
            &tuned,
            500.0 / TAU,
            &[94.7214, 1.591_55, 189.443, 400.0],
            cascade,
        ),
    ] {
        let (own, own_gains, _) = values(form, tuned, scale);
        assert_eq!(own.len(), expected.len(), "{form}");
        for (own, expected) in own.iter().zip(expected) {
            assert!(
                (own - expected).abs() <= 1e-5 * expected.abs(),
                "{form}: {own} {expected}"
            );
        }
        for (own, expected) in own_gains.iter().zip(gains) {
            assert!(
                (own - expected).abs() <= 1e-4 * expected.abs(),
                "{form}: {own} {expected}"
            );
        }
    }
}

/// Every row of the table is read: that of a form without gains would be missing.
#[test]
fn the_table_has_every_form() {
    let names: Vec<_> = FIRMWARES
        .iter()
        .map(|firmware| firmware.name.as_str())
        .collect();
    let all = "pid cascade simplefoc odrive moteus vesc dynamixel feetech wpilib sparkmax linuxcnc cia402";
    assert_eq!(names.join(" "), all);
    for case in cases() {
        assert!(names.contains(&case.form), "{}", case.form);
    }
}

/// kp² = 4 kd ki is the edge; beyond it the integral is what it is there.
#[test]
fn a_cascade_without_real_gains_gets_less_integral() {
    let (_, uncut, exactness) = values("cascade", &with_gains(2.0, 49.9, 0.02), 1.0);
    assert_eq!(exactness, "exact");
    let [kx, kv, kvi] = uncut;
    assert!((kv * kx + kvi - 2.0).abs() < 1e-4 && (kvi * kx - 49.9).abs() < 1e-3);
    let (_, cut, exactness) = values("cascade", &with_gains(2.0, 80.0, 0.02), 1.0);
    assert_eq!(exactness, "needs ki cut");
    let [kx, kv, kvi] = cut;
    assert!((kv * kx + kvi - 2.0).abs() < 1e-4 && (kvi * kx - 50.0).abs() < 1e-3);
}

/// The rejection reason of a form under conditions.
fn refusal(form: &str, a: f64, known: &KnownConditions, stated: Conditions) -> String {
    refusal_on(AxisKind::Rotary, form, a, known, stated)
}

fn refusal_on(
    axis: AxisKind,
    form: &str,
    a: f64,
    known: &KnownConditions,
    stated: Conditions,
) -> String {
    let result = IdentifiedResult {
        axis,
        ..identified(a, 500.0, 5e-4, 1e-3)
    };
    let known = KnownConditions {
        resolution: Some(0.0),
        limit: Some([-20.0, 20.0]),
        ..known.clone()
    };
    let conditions = Conditions {
        form: form.parse().ok(),
        ..stated
    };
    let settings = conditions
        .settings(Goal::Stiffest, &result, &known)
        .expect("known");
    match Tuned::of_conditions(&result, &known, &conditions, &settings) {
        Err(NoGains::Form(error)) => error.to_string(),
        other => panic!("{form}: {other:?}"),
    }
}

#[test]
fn what_a_form_needs_is_named_with_its_option() {
    let of = |command_unit| KnownConditions {
        command_unit: Some(command_unit),
        ..KnownConditions::default()
    };
    let none = Conditions::default();
    for (form, unit, part) in [
        ("odrive", CommandUnit::Ampere, "--torque-constant 0.1"),
        (
            "moteus",
            CommandUnit::Volt,
            "a command in Nm, but the log has one in V",
        ),
        ("vesc", CommandUnit::Other, "--max-current 60"),
        (
            "vesc",
            CommandUnit::Volt,
            "a command in A, but the log has one in V",
        ),
        ("dynamixel", CommandUnit::Volt, "--bus-voltage 12"),
        (
            "sparkmax",
            CommandUnit::Ampere,
            "a command in V, but the log has one in A",
        ),
        (
            "wpilib",
            CommandUnit::NewtonMetre,
            "a command in V, but the log has one in Nm",
        ),
    ] {
        let said = refusal(form, 2.0, &of(unit), none);
        assert!(said.contains(part), "{said}");
    }
    let zero = Conditions {
        max_current: Some(0.0),
        ..none
    };
    let said = refusal("vesc", 2.0, &of(CommandUnit::Ampere), zero);
    assert!(
        said.contains("--max-current for its command, a number above 0"),
        "{said}"
    );
    let said = refusal_on(
        AxisKind::Linear,
        "odrive",
        2.0,
        &of(CommandUnit::Other),
        none,
    );
    assert!(said.contains("the result is in m"), "{said}");
    let fast = Conditions {
        cutoff: Some(5000.0),
        ..none
    };
    let said = refusal("odrive", 2.0, &of(CommandUnit::NewtonMetre), fast);
    assert!(said.contains("--cutoff 4000.0"), "{said}");
    let supplied = Conditions {
        bus_voltage: Some(12.0),
        ..none
    };
    let said = refusal("dynamixel", 0.0, &of(CommandUnit::Volt), supplied);
    assert!(said.contains("too little friction"), "{said}");
    assert!(
        "esc"
            .parse::<Form>()
            .expect_err("no form")
            .starts_with("one of pid, cascade")
    );
}

/// A response time is that of the form's own loop.
#[test]
fn a_response_time_is_met_by_the_form() {
    for form in ["cascade", "simplefoc", "odrive", "linuxcnc"] {
        let result = identified(2.0, 500.0, 5e-4, 1e-3);
        let known = KnownConditions {
            resolution: Some(0.0),
            limit: Some([-20.0, 20.0]),
            ..KnownConditions::default()
        };
        let conditions = Conditions {
            form: form.parse().ok(),
            ..Conditions::default()
        };
        let settings = conditions
            .settings(Goal::ResponseTime(0.2), &result, &known)
            .expect("known");
        let tuned = Tuned::of_conditions(&result, &known, &conditions, &settings).expect("gains");
        let steps = tuned.form.expect("its form").steps;
        let took = steps
            .last()
            .and_then(|step| step.rise_time)
            .expect("a time");
        assert!((took / 0.2 - 1.0).abs() < 0.021, "{form} {took}");
    }
}
