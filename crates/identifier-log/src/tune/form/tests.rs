//! Each firmware's own update, written from its source in its own units, around a servo in small steps. Its margins and
//! its step match those that the form predicts.

use std::f64::consts::TAU;

use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::StepMeasure;

use super::super::KnownEffects;
use super::firmware::FIRMWARES;
use super::*;

/// The number of small steps in a period.
const PARTS: usize = 20;

/// An identified servo. Its delay is a whole number of small steps.
fn identified(a: f64, b: f64, delay: f64, sample_time: f64) -> IdentifiedResult {
    IdentifiedResult {
        servo: IdentifiedServo {
            parameters: ServoParameters::new(a, b, 0.0, 0.3 * b),
            delay,
            covariance: [[0.0; 5]; 5],
            unexplained: 0.0,
        },
        axis: AxisKind::Rotary,
        load: [0.3 * b, 0.0],
        effects: KnownEffects::default(),
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

/// The same with the rate of the position.
fn rate_of_position(
    [kp, ki, kd]: [f64; 3],
    mut velocity: impl FnMut(f64) -> f64 + 'static,
    time: f64,
) -> Controller {
    let mut sum = 0.0;
    Box::new(move |target, position| {
        sum += (target - position) * time;
        kp * (target - position) + ki * sum - kd * velocity(position)
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
        ..stated
    };
    let settings = conditions.settings(goal, result, &known);
    Tuned::of_conditions(result, &known, &conditions, &settings.expect("conditions"))
}

fn cases() -> [Case; 12] {
    [
        Case::of(
            "pid",
            |_| {},
            |of, time| {
                let velocity = filtered_difference(1.0 - (-of("cutoff") * time).exp(), time);
                rate_of_position(["kp", "ki", "kd"].map(of), velocity, time)
            },
        ),
        Case::of(
            "cascade",
            |_| {},
            |of, time| {
                let velocity = filtered_difference(1.0 - (-of("cutoff") * time).exp(), time);
                cascade(["Kx", "Kv", "Kvi"].map(of), velocity, time)
            },
        ),
        Case::of(
            "simplefoc",
            |case| {
                case.unit = CommandUnit::Volt;
                case.conditions.sample_time = Some(1e-3);
            },
            |of, time| {
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
        ),
        Case::of(
            "odrive",
            |case| {
                // The log's command is a current; the motor gives 0.04 Nm/A.
                (case.period, case.angle, case.output) = (125e-6, TAU, 1.0 / 0.04);
                case.unit = CommandUnit::Ampere;
                case.conditions.torque_constant = Some(0.04);
            },
            |of, time| {
                let [pos_gain, vel_gain, integrator_gain] =
                    ["pos_gain", "vel_gain", "vel_integrator_gain"]
                        .map(|name| of(&format!("controller.config.{name}")));
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
        ),
        Case::of(
            "moteus",
            |case| {
                (case.period, case.angle) = (1.0 / 30e3, TAU);
                case.unit = CommandUnit::NewtonMetre;
            },
            |of, time| {
                let [kp, ki, kd] =
                    ["kp", "ki", "kd"].map(|name| of(&format!("servo.pid_position.{name}")));
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
        ),
        Case::of(
            "vesc",
            |case| {
                // A share of 60 A.
                (case.angle, case.output) = (TAU / 360.0, 60.0);
                case.unit = CommandUnit::Ampere;
                case.conditions.max_current = Some(60.0);
            },
            |of, time| {
                let velocity = filtered_difference(of("p_pid_kd_filter"), time);
                let gains = ["p_pid_kp", "p_pid_ki", "p_pid_kd_proc"].map(of);
                rate_of_position(gains, velocity, time)
            },
        ),
        Case::of(
            "dynamixel",
            |case| {
                // A step of PWM is 1/885 of 12 V.
                (case.a, case.angle, case.output) = (60.0, TAU / 4096.0, 12.0 / 885.0);
                case.at_12_volts();
            },
            |of, time| textbook([of("Position P Gain (84)") / 128.0, 0.0, 0.0], time),
        ),
        Case::of(
            "feetech",
            |case| {
                // 0.166 of 12 V per rad.
                (case.a, case.output) = (60.0, 0.166 * 12.0);
                case.at_12_volts();
            },
            |of, time| textbook([of("P (21)"), 0.0, 0.0], time),
        ),
        Case::of(
            "wpilib",
            |case| (case.period, case.unit) = (20e-3, CommandUnit::Volt),
            |of, time| textbook(["kP", "kI", "kD"].map(of), time),
        ),
        Case::of(
            "sparkmax",
            |case| {
                (case.angle, case.output) = (TAU, 12.0);
                case.at_12_volts();
            },
            // Once per millisecond, its unit of time.
            |of, _| textbook(["kP", "kI", "kD"].map(of), 1.0),
        ),
        Case::of(
            "linuxcnc",
            |_| {},
            |of, time| textbook(["Pgain", "Igain", "Dgain"].map(of), time),
        ),
        Case::of(
            "cia402",
            |case| case.conditions.cutoff = Some(800.0),
            |of, time| {
                // J = 1/b: the torque is an acceleration, of which the command is 1/500.
                let kv = TAU * of("speed gain") / 500.0;
                let ti = 1e-3 * of("speed integral time");
                let velocity = filtered_difference(1.0 - (-800.0 * time).exp(), time);
                cascade([of("position gain"), kv, kv / ti], velocity, time)
            },
        ),
    ]
}

impl Case {
    const B: f64 = 500.0;

    /// A form at 1 kHz in SI, but for a change.
    fn of(form: &'static str, change: fn(&mut Self), controller: Update) -> Self {
        let mut case = Self {
            form,
            period: 1e-3,
            a: 2.0,
            angle: 1.0,
            output: 1.0,
            conditions: Conditions::default(),
            unit: CommandUnit::Other,
            controller,
        };
        change(&mut case);
        case
    }

    fn at_12_volts(&mut self) {
        self.unit = CommandUnit::Volt;
        self.conditions.bus_voltage = Some(12.0);
    }

    /// A whole number of small steps, about 0.4 ms.
    fn delay(&self) -> f64 {
        let part = self.period / PARTS as f64;
        (4e-4 / part).round() * part
    }

    fn tuned(&self) -> Tuned {
        let result = identified(self.a, Self::B, self.delay(), 1e-3);
        let goal = Goal::Stiffest;
        let tuned = tuned(&result, self.unit, self.form, self.conditions, goal);
        tuned.unwrap_or_else(|error| panic!("{}: {error:?}", self.form))
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
            let mut parameters = form.parameters.iter();
            let found = parameters.find(|parameter| parameter.name == name);
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
        let mut ends = [from, to];
        for _ in 0..9 {
            let middle = (ends[0] * ends[1]).sqrt();
            let is_stable = self.is_stable(form, middle, bandwidth);
            ends[usize::from(!is_stable)] = middle;
        }
        (ends[0] * ends[1]).sqrt()
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
            let (mut re, mut im) = (0.0, 0.0);
            for ([_, command], at) in impulse.iter().zip(0..) {
                let (sine, cosine) = (frequency * case.period * f64::from(at)).sin_cos();
                (re, im) = (re + command * cosine, im - command * sine);
            }
            f64::hypot(re, im)
        };
        let frequencies = (0..120).map(|at| bandwidth * 0.3 * 1.04_f64.powi(at));
        let below_half = frequencies.filter(|frequency| frequency * case.period < 3.1);
        let found = below_half.map(sensitivity).fold(0.0, f64::max);
        let predicted = form.margins.sensitivity;
        let [fall, rise] = form.margins.gain_margins;
        let edge = |to| case.edge(&form, 1.0, to, bandwidth);
        let edges = [edge(100.0), if fall > 0.0 { edge(0.01) } else { 0.0 }];
        let measured = |smoothing: f64| {
            // Sampled at the end of a period, as the filter of a program does.
            let target = |time: f64| 1.0 - (-(time + case.period) / smoothing).exp();
            let course = case.run(&form, 1.0, target, 0.0, 0.0, samples);
            let mut measure = StepMeasure::<f64>::new(1.0, 0.0);
            (course.iter()).for_each(|[position, _]| measure.take(*position));
            let rise = case.period * measure.rise().expect("it rises");
            (rise, measure.overshoot())
        };
        for step in &form.steps {
            let (rise, overshoot) = measured(step.smoothing);
            let expected = step.rise_time.expect("it rises");
            assert!(is_near(rise, expected, 0.003), "{}", case.form);
            assert!((overshoot - step.overshoot).abs() < 0.001, "{}", case.form);
        }
        let (own_rise, own_overshoot) = measured(0.0);
        let predicted_step = form.steps[0];
        println!(
            "{}, {}, ω {bandwidth:.2}: {:.3?} found {found:.3} {edges:.3?}, {predicted_step:.3?} found {own_rise:.4} s {own_overshoot:.3}",
            form.name, form.exactness, form.margins
        );
        assert!(predicted <= 1.61, "{}", case.form);
        assert!(is_near(found, predicted, 0.003), "{}", case.form);
        assert!(is_near(edges[0], rise, 0.03), "{}", case.form);
        assert!(is_near(edges[1], fall, 0.03), "{}", case.form);
        // The integral holds the load where there is one.
        let [loaded, _] = case.run(&form, 1.0, |_| 0.0, 0.0, 5.0, samples)[samples - 1];
        let stored = form.parameters[0].value * case.output / case.angle;
        let kp = match case.form {
            "dynamixel" => stored / 128.0,
            "feetech" => stored,
            _ => tuned.tuning.kp,
        };
        let sags = 5.0 / (Case::B * kp);
        let off = loaded - f64::from(u8::from(form.exactness == "P only")) * sags;
        assert!(off.abs() < 0.02 * sags, "{} {off}", case.form);
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
    assert!(names.eq(cases().iter().map(|case| case.form)));
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
        ("vesc", "other", "--max-current 60"),
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
