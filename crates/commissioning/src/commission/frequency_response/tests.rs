use core::f64::consts::TAU;
use std::vec::Vec;

use super::{
    LineSearch, LineSums, Lines, ResponseMotion, ResponsePlanner, ResponseProgress, ResponseWindows,
};
use crate::commission::conservative_pid::ConservativePid;
use crate::commission::holding::Holding;
use crate::commission::message::EventKind;
use crate::commission::tests::unknown_servos::Unknown;
use crate::commission::{
    CommissionInputs, CommissionIsr, CommissionSettings, CommissionSolver, Limits, Phase,
};
use identifier_core::control::ControlSample;
use identifier_core::number::Complex;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use identifier_core::tuning::AxisForces;
use identifier_core::units::Units;
use virtual_servo::{Effects, Encoder, Servo};

/// An axis with its encoder.
#[derive(Debug, Clone, Copy)]
struct Axis {
    servo: ServoParameters,
    effects: Effects,
    counts: f64,
    sample_time: f64,
    limits: Limits,
}

/// A commissioning of it to the end of its motions.
struct Course {
    /// ∑ ±Y / ∑ ±U / (1 − e^(−jωT)) of each line, rad per command unit, and the motions in which it was measured.
    lines: Vec<(f64, Complex, u32)>,
    /// Extremes of the true motion, rad and rad/s.
    travel: [f64; 2],
    speed: f64,
    /// How long they took, s.
    time: f64,
    reason: Option<Reason>,
}

impl Course {
    fn begun() -> Self {
        Self {
            lines: Vec::new(),
            travel: [0.0; 2],
            speed: 0.0,
            time: 0.0,
            reason: None,
        }
    }

    /// True if every line was measured in so many motions.
    fn is_measured_in(&self, count: u32) -> bool {
        self.lines.iter().all(|&(.., motions)| motions == count)
    }

    fn take(&mut self, servo: &Servo, time: f64) {
        self.time += time;
        let position = servo.position();
        let [low, high] = self.travel;
        self.travel = [low.min(position), high.max(position)];
        self.speed = self.speed.max(servo.velocity().abs());
    }
}

/// ∑ ±Y, ∑ ±U and the motions of each line.
struct Sums(Vec<(f64, [f64; 2], [f64; 2], u32)>);

impl Sums {
    fn new(time: f64) -> Self {
        let lines = LineSearch::first_pass(time, 1.0).all();
        Self(
            lines
                .frequencies()
                .map(|omega| (omega, [0.0; 2], [0.0; 2], 0))
                .collect(),
        )
    }

    fn add(&mut self, line: &LineSums<f32>) {
        let (_, position, command, response_motions) = &mut self.0[usize::from(line.line)];
        let sign = if line.inverted { -1.0 } else { 1.0 };
        for part in 0..2 {
            position[part] += sign * f64::from(line.position[part]);
            command[part] += sign * f64::from(line.command[part]);
        }
        *response_motions += 1;
    }

    fn response(&self, time: f64, resolution: f64) -> Vec<(f64, Complex, u32)> {
        let complex = |[re, im]: [f64; 2]| Complex::new(re, im);
        let of =
            |&(omega, position, command, response_motions): &(f64, [f64; 2], [f64; 2], u32)| {
                let delay = complex([libm::cos(omega * time), -libm::sin(omega * time)]);
                let gain = complex(position) / complex(command) / (Complex::ONE - delay);
                (omega, gain.scaled(resolution), response_motions)
            };
        self.0.iter().map(of).collect()
    }
}

impl Axis {
    fn ordinary() -> Self {
        Self {
            servo: ServoParameters::new(0.8, 257.7, 100.0, 60.0),
            effects: Effects::NONE,
            counts: 10_000.0,
            sample_time: 1e-3,
            limits: Limits::new([-0.5, 0.5], 15.0, [-10.0, 10.0]),
        }
    }

    fn settings(&self) -> CommissionSettings {
        CommissionSettings::new(self.sample_time, TAU / self.counts, self.limits)
    }

    fn response_motion(&self) -> Course {
        const LONGEST: f64 = 30.0;
        let time = self.sample_time;
        let resolution = TAU / self.counts;
        let settings = self.settings();
        let isr = CommissionIsr::<f32>::new(&settings, None).expect("allowed");
        let mut solver = CommissionSolver::<f32>::new(&settings).expect("allowed");
        let mut servo = Servo::at_rest(&self.servo, &self.effects, time, 1).expect("allowed");
        let encoder = Encoder::new(self.counts);
        let mut state = isr.start(0, None);
        let mut sums = Sums::new(time);
        let mut course = Course::begun();
        for _ in 0..(LONGEST / time) as u32 {
            let step = isr.process(
                &mut state,
                &CommissionInputs {
                    count: Some(encoder.read(servo.position() + 0.4 * resolution) as i32),
                    late: false,
                    stop: None,
                },
            );
            if step.phase == Phase::FrequencyResponse {
                course.take(&servo, time);
            }
            if let Some(event) = &step.finding {
                if let EventKind::Line(line) = &event.0 {
                    sums.add(line);
                }
                solver.take(event);
                if step.phase == Phase::FrequencyResponse
                    && matches!(event.0, EventKind::Ended { .. })
                {
                    break;
                }
            }
            if step.phase.is_end() {
                break;
            }
            for answer in (0..isr.slices()).filter_map(|_| solver.work()) {
                isr.accept(&mut state, &answer);
            }
            servo.advance(step.command.unwrap_or(0.0).into());
        }
        course.reason = state.reason();
        course.lines = sums.response(time, resolution);
        course
    }

    /// Motions of an axis at rest, planned for what is known of it.
    fn response_motion_only(&self, known: ServoParameters) -> Course {
        self.response_motion_planned(known, &AxisForces::default(), false)
    }

    /// The same with forces that are known, or for a servo that may differ from its model.
    fn response_motion_planned(
        &self,
        known: ServoParameters,
        forces: &AxisForces,
        is_uncertain: bool,
    ) -> Course {
        let (time, resolution) = (self.sample_time, TAU / self.counts);
        let settings = self.settings();
        let units = Units::new(time, resolution).expect("allowed");
        let known = IdentifiedServo {
            unexplained: resolution,
            ..IdentifiedServo::known(known, 0.0)
        };
        let plan = ResponsePlanner::new(
            &settings,
            &known,
            forces,
            is_uncertain,
            None,
            &LineSearch::first_pass(time, 1.0).all(),
        )
        .expect("room")
        .all()
        .with_motions(4);
        let mut response_motion = ResponseMotion::<f32>::default();
        response_motion.plan(&plan);
        let (rough, delay, bandwidth) = response_motion.loop_plan();
        let conservative = ConservativePid::new(&units, &self.limits);
        let controller = conservative.around(rough, delay, bandwidth);
        let last = ControlSample {
            error: 0.0,
            increment: 0.0,
            velocity: 0.0,
            command: 0.0,
        };
        let limit = self.limits.command.map(|end| end as f32);
        let controller = controller.expect("it can be held");
        let mut holding = Holding::take_over(controller, limit, 0.0, &last, 1.0, 10);
        response_motion.begin(&mut holding);
        let mut servo = Servo::at_rest(&self.servo, &self.effects, time, 1).expect("allowed");
        let encoder = Encoder::new(self.counts);
        let (mut sums, mut course) = (Sums::new(time), Course::begun());
        let (mut before, mut velocity) = (encoder.read(0.0), 0.0);
        loop {
            let count = encoder.read(servo.position());
            let (position, increment) = (count as f32, (count - before) as f32);
            before = count;
            velocity += 0.2 * (increment - velocity);
            let command = holding.process(position, increment).expect("near");
            let sample = ResponseWindows {
                position,
                increment,
                velocity,
                is_cut: false,
                command,
            };
            match response_motion.process(&mut holding, &sample) {
                ResponseProgress::Going => {}
                ResponseProgress::Balance(_) => {}
                ResponseProgress::Line(line) => sums.add(&line),
                ResponseProgress::Over => break,
            }
            servo.advance(f64::from(command));
            course.take(&servo, time);
        }
        course.lines = sums.response(time, resolution);
        course
    }

    /// True if the lines of the servo alone are measured, to a tenth, where these forces are known and not otherwise.
    fn is_measured_only_with(&self, forces: &AxisForces) -> bool {
        let is_measured = |forces| {
            let course = self.response_motion_planned(self.servo, forces, false);
            let off = error(self, &course, [10.0, 150.0]);
            std::println!("{off:.4}");
            course.is_measured_in(4) && off < 0.1
        };
        is_measured(forces) && !is_measured(&AxisForces::default())
    }

    /// Of one mass, sampled and held.
    fn exact(&self, omega: f64) -> Complex {
        let (time, ServoParameters { a, b, .. }) = (self.sample_time, self.servo);
        let decay = libm::exp(-a * time);
        let first = -libm::expm1(-a * time) / a;
        let second = (time - first) / a;
        let z = |samples: f64| {
            Complex::new(
                libm::cos(omega * time * samples),
                libm::sin(omega * time * samples),
            )
        };
        // q z = q + g₁ v + b g₂ u, v z = E v + b g₁ u.
        let velocity = Complex::ONE.scaled(b * first) / (z(1.0) + -decay);
        let late = z(-self.effects.delay / time);
        let free = (velocity.scaled(first) + b * second) / (z(1.0) + -1.0) * late;
        // Gravity changes with the angle.
        let [slope, _] = self.effects.gravity;
        free / (free.scaled(-slope / b) + 1.0)
    }
}

/// Root mean square of the lines' relative errors from one frequency to another, Hz.
fn error(axis: &Axis, course: &Course, [low, high]: [f64; 2]) -> f64 {
    let of = |&&(omega, ..): &&(f64, Complex, u32)| (low..=high).contains(&(omega / TAU));
    let errors: Vec<f64> = course
        .lines
        .iter()
        .filter(of)
        .map(|&(omega, gain, _)| (gain / axis.exact(omega) + -1.0).power())
        .collect();
    (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn a_rigid_servo_moves_within_travel_and_speed_and_its_response_is_measured() {
    for (sample_time, counts) in [
        (4e-3, 131_072.0),
        (1e-3, 131_072.0),
        (2.5e-4, 131_072.0),
        (1e-4, 65_536.0),
        (5e-5, 65_536.0),
    ] {
        let mut axis = Axis {
            sample_time,
            counts,
            ..Axis::ordinary()
        };
        axis.effects.delay = if sample_time > 2e-3 { 0.0 } else { 1e-3 };
        let course = axis.response_motion();
        // Next to half of the sampling frequency a held command hardly moves the samples.
        let (low_lines, high_lines) = ([5.0, (0.42 / sample_time).min(200.0)], [200.0, 400.0]);
        let off = error(&axis, &course, low_lines);
        let above = error(&axis, &course, high_lines);
        let Course {
            travel: [low, high],
            speed,
            time,
            ..
        } = course;
        std::println!("{sample_time}: {off:.4} {above:.4} {low:.3} {high:.3} {speed:.2} {time:.2}");
        assert!(course.is_measured_in(2));
        // By two motions; by the four of a further round 1 %.
        assert!(off < 0.02, "{off}");
        assert!(low > -0.45 && high < 0.45 && high - low > 0.7);
        assert!(speed < 0.75 * axis.limits.speed && time < 3.5);
    }
}

#[test]
fn a_slow_axis_moves_at_two_fifths_of_its_speed() {
    let mut axis = Axis::ordinary();
    axis.counts = 65_536.0;
    axis.sample_time = 1e-4;
    axis.limits.speed = 1.5;
    let course = axis.response_motion();
    let off = error(&axis, &course, [5.0, 100.0]);
    std::println!("{off:.4} {:?} {}", course.travel, course.speed);
    assert!(off < 0.02, "{off}");
    assert!(course.speed < 0.75 * axis.limits.speed);
}

/// The time of motions that show friction alone, s.
const LEARNING: f64 = 1.6;

#[test]
fn gravity_of_a_fifth_of_the_authority_keeps_a_tenth_of_a_radian_of_travel() {
    for angle in [0.0, 0.8, 1.57, 3.1] {
        let mut axis = Axis::ordinary();
        axis.counts = 65_536.0;
        axis.limits.travel = [-0.1, 0.1];
        axis.servo.load = 0.0;
        let most = 0.19 * 10.0 * axis.servo.b;
        axis.effects.gravity = [most * libm::sin(angle), most * libm::cos(angle)];
        let course = axis.response_motion();
        let off = error(&axis, &course, [10.0, 60.0]);
        let [low, high] = course.travel;
        std::println!("{angle}: {off:.4} {low:.4} {high:.4} {:.2}", course.time);
        assert!(course.is_measured_in(2));
        assert!(low > -0.09 && high < 0.09, "{low} {high}");
        // One mass without gravity may not explain the first motion: then it moves both ways before, to be learnt.
        assert!(course.time < 3.5 + LEARNING, "{}", course.time);
        // Friction and the load's slope were taken for viscous friction.
        assert!(off < 0.1, "{off}");
    }
}

#[test]
fn an_axis_with_too_little_for_response_motions_gets_no_plan() {
    let axis = Axis::ordinary();
    let known = IdentifiedServo {
        unexplained: axis.settings().resolution,
        ..IdentifiedServo::known(axis.servo, 0.0)
    };
    let plan = |change: &dyn Fn(&mut CommissionSettings)| {
        let mut settings = axis.settings();
        change(&mut settings);
        ResponsePlanner::<f32>::new(
            &settings,
            &known,
            &AxisForces::default(),
            false,
            None,
            &LineSearch::first_pass(settings.sample_time, 1.0).all(),
        )
    };
    assert!(plan(&|_| {}).is_some());
    assert!(plan(&|settings| settings.limits.travel = [-0.01, 0.015]).is_none());
    assert!(plan(&|settings| settings.limits.speed = 0.08).is_none());
    assert!(plan(&|settings| settings.resolution = 0.03).is_none());
    assert!(plan(&|settings| settings.limits.command = [-0.65, 5.0]).is_none());
}

#[test]
fn a_resonance_that_friction_hides_shows_while_the_servo_moves() {
    for (frequency, damping, share) in [(40.0, 0.05, 0.3), (150.0, 0.02, 0.5), (300.0, 0.01, 0.6)] {
        let mut axis = Axis::ordinary();
        axis.counts = 65_536.0;
        axis.sample_time = 2.5e-4;
        axis.servo.coulomb = 400.0;
        let resonance = TAU * frequency;
        axis.effects.resonance = resonance;
        axis.effects.resonance_damping = Some(damping);
        axis.effects.inertia_ratio = share;
        // As known as one mass.
        let mut known = axis.servo;
        known.b *= 1.2;
        known.coulomb *= 0.9;
        let course = axis.response_motion_only(known);
        assert!(course.is_measured_in(4));
        let [low, high] = course.travel;
        assert!(low > -0.45 && high < 0.45 && course.time < 4.5);
        // With β = share/(1 − share), b (1/(s (s + a)) + β/(s² + 2 ζ ω₂ s + ω₂²)); the hold takes the same from both.
        let beta = share / (1.0 - share);
        let over_one_mass = |omega: f64| {
            let s = Complex { re: 0.0, im: omega };
            let resonant = s * s + s.scaled(2.0 * damping * resonance) + resonance * resonance;
            (s * (s + axis.servo.a)).scaled(beta) / resonant + 1.0
        };
        let within = |&&(omega, ..): &&(f64, Complex, u32)| (8.0..250.0).contains(&(omega / TAU));
        let errors = course.lines.iter().filter(within).map(|&(omega, gain, _)| {
            let (measured, true_ratio) = (gain / axis.exact(omega), over_one_mass(omega));
            // At an antiresonance, of one mass: there is little to measure.
            (measured - true_ratio).power().sqrt() / true_ratio.power().sqrt().max(1.0)
        });
        let errors: Vec<f64> = errors.collect();
        std::println!("{errors:.3?} {:.2} {low:.3} {high:.3}", course.time);
        assert!(errors.iter().all(|&error| error < 0.1));
    }
}

#[test]
fn a_compliant_axis_shows_no_fault_while_it_moves() {
    // Servos of which the motor's response under the multisine is far from that of one mass.
    for (seed, frequency, share, damping) in [
        (2, 234.0, 0.74, 0.037),
        (17, 257.0, 0.83, 0.098),
        (19, 197.0, 0.30, 0.070),
    ] {
        let unknown = Unknown::from_seed(seed);
        let axis = Axis {
            servo: unknown.parameters,
            effects: Effects {
                delay: unknown.delay * unknown.sample_time,
                resonance: TAU * frequency,
                resonance_damping: Some(damping),
                inertia_ratio: share,
                ..Effects::NONE
            },
            counts: unknown.counts,
            sample_time: unknown.sample_time,
            limits: unknown.limits,
        };
        let course = axis.response_motion();
        assert_eq!(course.reason, None, "{seed}");
        assert!(course.is_measured_in(2), "{seed}");
    }
}

/// The first two motions determine friction and gain. The lines of the others are then those of a servo that was
/// identified from the start.
#[test]
fn a_servo_that_is_uncertain_is_learnt_before_its_lines_are_measured() {
    let axis = Axis {
        counts: 65_536.0,
        ..Axis::ordinary()
    };
    for (gain, friction) in [(0.6, 0.4), (1.0, 2.5), (2.0, 1.0)] {
        let taken_for = ServoParameters::new(
            40.0,
            gain * axis.servo.b,
            friction * axis.servo.coulomb,
            -axis.servo.load,
        );
        let course = axis.response_motion_planned(taken_for, &AxisForces::default(), true);
        let off = error(&axis, &course, [10.0, 150.0]);
        let [low, high] = course.travel;
        std::println!(
            "{gain} {friction}: {off:.4} {low:.3} {high:.3} {:.2}",
            course.time
        );
        assert!(course.is_measured_in(4));
        assert!(off < 0.02, "{off}");
        let [lowest, highest] = axis.limits.travel;
        assert!(low > lowest && high < highest);
    }
}

/// Detents that are larger than friction pull it from its reference.
#[test]
fn cogging_that_is_known_is_balanced_while_the_lines_are_measured() {
    let mut axis = Axis::ordinary();
    (axis.effects.ripple, axis.effects.ripple_order) = ([250.0, -150.0], 21);
    let forces = AxisForces {
        wave: axis.effects.ripple,
        order: 21.0,
        ..AxisForces::default()
    };
    assert!(axis.is_measured_only_with(&forces));
}

/// Otherwise the loop pushes until it breaks away, and then beyond its reference.
#[test]
fn an_axis_that_is_known_to_stick_breaks_away_by_a_command_for_it() {
    let mut axis = Axis::ordinary();
    axis.servo.coulomb = 500.0;
    axis.effects.low_speed_friction = 600.0;
    axis.effects.low_speed_velocity = 0.1;
    let forces = AxisForces {
        low_speed: 600.0,
        per_low_speed_velocity: 10.0,
        ..AxisForces::default()
    };
    assert!(axis.is_measured_only_with(&forces));
}

/// A loop that is faster than the lowest of them would leave nothing of low lines.
#[test]
fn low_lines_have_a_slow_loop() {
    // Little travel asks for a fast loop.
    let mut axis = Axis::ordinary();
    (axis.limits.travel, axis.counts) = ([-0.1, 0.1], 65_536.0);
    let lines = LineSearch::low(axis.sample_time).all();
    let known = IdentifiedServo::known(axis.servo, 0.0);
    let loop_of = |lines: &Lines| {
        let plan = ResponsePlanner::<f32>::new(
            &axis.settings(),
            &known,
            &AxisForces::default(),
            false,
            None,
            lines,
        );
        let mut response_motion = ResponseMotion::default();
        response_motion.plan(&plan.expect("room").all());
        let (_, _, bandwidth) = response_motion.loop_plan();
        f64::from(bandwidth) / axis.sample_time
    };
    let usual = LineSearch::first_pass(axis.sample_time, 1.0).all();
    let [lowest, of_usual] = [&lines, &usual].map(|lines| lines.frequencies().next());
    let lowest = lowest.expect("lines");
    assert!(lowest < 0.6 * of_usual.expect("lines"));
    let (slow, fast) = (loop_of(&lines), loop_of(&usual));
    assert!(slow < 3.1 * lowest, "{slow} {lowest}");
    assert!(slow < 0.9 * fast, "{slow} {fast}");
}
