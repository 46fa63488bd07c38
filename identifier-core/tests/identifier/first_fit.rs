//! A first fit that does not succeed: its reason after a second of motion, and the fit that succeeds later.

use crate::support::{
    Draw, Kind, Loop, Servo, amplitude_for, learn, on_all_cores, ordinary_servo, paper,
};
use identifier_core::Settings;
use identifier_core::identifier::{Event, GaussNewtonIdentifier, Identify};
use identifier_core::parameters::{ServoParameters, Unknowns};
use identifier_core::reason::Reason;
use virtual_servo::Plant;

/// As many blocks as a drive has.
type GaussNewton = GaussNewtonIdentifier<f32, Unknowns<4>, 4, 64>;

/// 250 Hz to 20 kHz.
const SAMPLE_TIMES: [f64; 4] = [4e-3, 1e-3, 0.25e-3, 50e-6];

const REASONS: [Reason; 9] = [
    Reason::TooLittleMotion,
    Reason::OneWayMotion,
    Reason::ConstantCommand,
    Reason::DoesNotFollow,
    Reason::EarlyCommand,
    Reason::PartlyExplained,
    Reason::TooLittleEvidence,
    Reason::EstimateAtBound,
    Reason::Reversed,
];

fn servo(sample_time: f64) -> Servo {
    Servo {
        sample_time,
        ..paper(ServoParameters::new(2.0, 250.0, 15.0, 20.0), 20.0, 5)
    }
}

/// A servo in the motion from which it can be identified.
fn lively(servo: &Servo) -> Loop {
    Loop::new(Kind::Pid, servo, amplitude_for(Kind::Pid, servo, 0.2))
}

/// The counts moved until a sample, and the command that acts from then on.
type Sample = (f64, f64);

/// A servo under a command of the time.
fn open_loop(
    sample_time: f64,
    command: impl Fn(f64) -> f64 + 'static,
) -> Box<dyn FnMut() -> Sample> {
    let servo = servo(sample_time);
    let mut plant = Plant::at_rest(&servo.parameters, sample_time);
    let (mut time, mut last) = (0.0, 0.0);
    Box::new(move || {
        let count = (plant.position / servo.count()).floor();
        let moved = count - std::mem::replace(&mut last, count);
        let command = command(time);
        time += sample_time;
        plant.advance(command);
        (moved, command)
    })
}

/// Settings and samples for which a first fit has no other reason not to succeed.
fn case(reason: Reason, sample_time: f64) -> (Settings, Box<dyn FnMut() -> Sample>) {
    let servo = servo(sample_time);
    let mut settings = servo.settings();
    let mut motion = lively(&servo);
    let quick = Servo {
        seed: 77,
        bandwidth: 60.0,
        ..servo
    };
    let mut other = lively(&quick);
    let mut alike = lively(&Servo { seed: 77, ..servo });
    let samples: Box<dyn FnMut() -> Sample> = match reason {
        Reason::TooLittleMotion => {
            let mut draw = Draw::new(3);
            let mut count = 0.0;
            Box::new(move || {
                let noise = draw.uniform(-30.0, 30.0).round();
                let moved = noise - std::mem::replace(&mut count, noise);
                (moved, motion.sample().1)
            })
        }
        Reason::OneWayMotion => {
            // Noise that hides how the small changes of the command act.
            settings.identifier.noise = Some(0.2);
            open_loop(sample_time, |time| 0.15 + 0.05 * (20.0 * time).sin())
        }
        Reason::ConstantCommand => open_loop(sample_time, |_| 0.3),
        Reason::DoesNotFollow => Box::new(move || (motion.sample().0, other.sample().1)),
        Reason::EarlyCommand => {
            // By the time of a sample at 250 Hz: a sample of 50 µs would not show.
            let late = (4e-3 / sample_time).round() as usize;
            let mut given = std::collections::VecDeque::from(vec![0.0; late]);
            Box::new(move || {
                let (moved, command) = motion.sample();
                given.push_back(command);
                (moved, given.pop_front().expect("a command"))
            })
        }
        Reason::PartlyExplained => {
            // In a shorter time a fit explains enough by chance.
            settings.identifier.start_time = Some(1.0);
            Box::new(move || {
                let (moved, command) = motion.sample();
                (moved, command + 1.5 * alike.sample().1)
            })
        }
        Reason::TooLittleEvidence => {
            settings.identifier.noise = Some(0.05);
            let mut small = Loop::new(Kind::Pid, &servo, 0.02);
            Box::new(move || small.sample())
        }
        Reason::EstimateAtBound => {
            settings.identifier.bounds.b = Some([500.0, 1000.0]);
            Box::new(move || motion.sample())
        }
        Reason::Reversed => Box::new(move || {
            let (moved, command) = motion.sample();
            (moved, -command)
        }),
        _ => unreachable!("no reason of a first fit"),
    };
    (settings, samples)
}

/// An identifier with its state, and the first of its events.
struct Run {
    identifier: GaussNewton,
    state: <GaussNewton as Identify<f32>>::State,
    sample_time: f64,
    samples: u32,
    /// The time of the first report, s, and its reason.
    reported: Option<(f64, Option<Reason>)>,
    /// The time of the first success, s.
    started: Option<f64>,
}

impl Run {
    fn new(settings: &Settings) -> Self {
        let identifier: GaussNewton = settings.build().expect("valid");
        Self {
            state: identifier.start(),
            identifier,
            sample_time: settings.sample_time,
            samples: 0,
            reported: None,
            started: None,
        }
    }

    fn run(&mut self, time: f64, mut sample: impl FnMut() -> Sample) {
        for _ in 0..(time / self.sample_time).round() as u32 {
            let (moved, command) = sample();
            let update = learn(&self.identifier, &mut self.state, (moved, command));
            self.samples += 1;
            let now = f64::from(self.samples) * self.sample_time;
            match update.event {
                Event::FirstFitOverdue => {
                    let report = (now, self.rejection_reason());
                    self.reported = self.reported.or(Some(report));
                }
                Event::Started => self.started = self.started.or(Some(now)),
                _ => {}
            }
        }
    }

    fn rejection_reason(&self) -> Option<Reason> {
        self.identifier.report(&self.state).rejection_reason
    }
}

#[test]
fn gauss_newton_reports_why_there_is_no_first_fit_after_a_second_of_motion() {
    for sample_time in SAMPLE_TIMES {
        for reason in REASONS {
            let (settings, mut sample) = case(reason, sample_time);
            let mut run = Run::new(&settings);
            run.run(0.95, &mut sample);
            let name = format!("{sample_time} s: {reason:?}");
            assert_eq!(run.rejection_reason(), None, "{name}");
            run.run(0.85, &mut sample);
            let (time, said) = run.reported.unwrap_or_default();
            assert_eq!(said, Some(reason), "{name}, started {:?}", run.started);
            assert!((1.0..1.6).contains(&time), "{name}: {time} s");
        }
    }
}

/// The noise by a first fit, counts, of a position that is wrong by so many counts to one side or the other.
fn noise_found(sample_time: f64, counts: f64) -> Option<f64> {
    let servo = servo(sample_time);
    let (mut motion, mut draw, mut off) = (lively(&servo), Draw::new(9), 0.0);
    let mut run = Run::new(&servo.settings());
    assert_eq!(run.identifier.report(&run.state).noise, None);
    run.run(3.0, || {
        let (moved, command) = motion.sample();
        let next = counts * draw.uniform(-1.0, 1.0).signum();
        (moved + next - std::mem::replace(&mut off, next), command)
    });
    run.identifier.report(&run.state).noise
}

#[test]
fn a_first_fit_finds_the_noise_of_the_position() {
    // The errors of a block's mean command are noise to the fit: in blocks of 16 ms a count.
    for sample_time in &SAMPLE_TIMES[1..] {
        for counts in [0.0, 1.0, 3.0] {
            let expected = f64::hypot(counts, 12.0_f64.sqrt().recip());
            let found = noise_found(*sample_time, counts).expect("a first fit");
            let off = found / expected - 1.0;
            assert!(off.abs() < 0.15, "{sample_time} s: {found} of {expected}");
        }
    }
}

#[test]
fn a_first_fit_succeeds_once_the_motion_is_informative() {
    for (sample_time, reason) in [
        (4e-3, Reason::ConstantCommand),
        (4e-3, Reason::Reversed),
        (4e-3, Reason::TooLittleMotion),
        (0.25e-3, Reason::ConstantCommand),
        (0.25e-3, Reason::Reversed),
        (0.25e-3, Reason::TooLittleMotion),
    ] {
        let (settings, sample) = case(reason, sample_time);
        let mut run = Run::new(&settings);
        run.run(2.0, sample);
        assert_eq!(run.rejection_reason(), Some(reason));
        let servo = servo(sample_time);
        let mut motion = lively(&servo);
        run.run(2.5, || motion.sample());
        assert_eq!(run.rejection_reason(), None, "after {reason:?}");
        assert!(run.started.is_some(), "after {reason:?}");
        let found = run.identifier.estimates(&run.state).expect("estimates");
        let off = found.b / servo.parameters.b - 1.0;
        assert!(off.abs() < 0.01, "after {reason:?}: {off}");
    }
}

#[test]
fn a_healthy_servo_never_waits_for_a_first_fit() {
    let runs = on_all_cores(200, |i| {
        let ordinary = ordinary_servo(i + 8000);
        let sample_time = SAMPLE_TIMES[i as usize % SAMPLE_TIMES.len()];
        let servo = Servo {
            sample_time,
            bandwidth: ordinary.bandwidth.min(0.15 / sample_time),
            ..ordinary
        };
        let amplitude = amplitude_for(Kind::Pid, &servo, 0.2);
        let mut moved = Loop::new(Kind::Pid, &servo, amplitude);
        let mut recursion = Run::new(&servo.settings());
        recursion.run(3.0, || moved.sample());
        recursion.reported.is_none() && recursion.started.is_some()
    });
    let waits: Vec<_> = (0..200).filter(|i| !runs[*i]).collect();
    assert!(waits.is_empty(), "{waits:?}");
}
