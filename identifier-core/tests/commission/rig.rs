//! A servo with its encoder, and a commissioning of it.

use identifier_core::commission::{
    Commission, CommissionSettings, CommissionState, HoldingGains, Limits, Phase, Seen, StopReason,
    Study,
};
use identifier_core::model::ServoParameters;
use identifier_core::tuning::Goal;
use virtual_servo::{Effects, Encoder, Servo};

/// What is commissioned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bench {
    pub(crate) servo: ServoParameters,
    pub(crate) effects: Effects,
    pub(crate) counts: f64,
    /// Where between two edges the encoder begins, counts.
    pub(crate) offset: f64,
    pub(crate) settings: CommissionSettings,
    pub(crate) before: Option<HoldingGains>,
}

/// What goes wrong from a sample on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    EncoderStuck,
    EncoderLost,
    EncoderJump,
    EncoderReversed,
    ActuatorDead,
    ActuatorWeak,
    ActuatorReversed,
    Overrun,
    LimitSwitch,
    Amplifier,
}

impl Fault {
    pub(crate) const ALL: [Self; 10] = [
        Self::EncoderStuck,
        Self::EncoderLost,
        Self::EncoderJump,
        Self::EncoderReversed,
        Self::ActuatorDead,
        Self::ActuatorWeak,
        Self::ActuatorReversed,
        Self::Overrun,
        Self::LimitSwitch,
        Self::Amplifier,
    ];

    /// Counts by which an encoder jumps.
    const JUMP: i32 = 3000;

    /// What is left of the gain of a weak actuator.
    const WEAK: f64 = 0.3;

    /// The count that is seen: `at_fault` was the first that was wrong.
    fn seen(self, count: i32, at_fault: i32) -> Option<i32> {
        match self {
            Self::EncoderStuck => Some(at_fault),
            Self::EncoderLost => None,
            Self::EncoderJump => Some(count.wrapping_add(Self::JUMP)),
            Self::EncoderReversed => Some(2 * at_fault - count),
            _ => Some(count),
        }
    }

    fn acts(self, command: f64) -> f64 {
        match self {
            Self::ActuatorDead => 0.0,
            Self::ActuatorWeak => Self::WEAK * command,
            Self::ActuatorReversed => -command,
            _ => command,
        }
    }

    fn stop(self) -> Option<StopReason> {
        match self {
            Self::LimitSwitch => Some(StopReason::LimitSwitch),
            Self::Amplifier => Some(StopReason::AmplifierFault),
            _ => None,
        }
    }
}

/// A fault that strikes in a phase, some samples after it began.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Strike {
    pub(crate) fault: Fault,
    pub(crate) phase: Phase,
    pub(crate) after: u64,
}

/// How it went.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    pub(crate) state: CommissionState<f32>,
    /// The time at which each phase began, s.
    pub(crate) phases: Vec<(Phase, f64)>,
    /// Extremes of the true motion, rad and rad/s.
    pub(crate) travel: [f64; 2],
    pub(crate) speed: f64,
    pub(crate) command: [f64; 2],
    /// Where it was in each sample of the trial: time, position, command.
    pub(crate) trial: Vec<[f64; 3]>,
    /// Samples from a fault to the end that it led to.
    pub(crate) detected: Option<u64>,
    /// What was commanded after the end; none: let go.
    pub(crate) after: Vec<Option<f32>>,
    /// Where the servo was at the end of all, rad.
    pub(crate) last: f64,
}

/// A servo as the paper's, with a fine encoder, let go.
pub(crate) fn ordinary() -> Bench {
    Bench {
        servo: ServoParameters {
            a: 0.2174,
            b: 257.7,
            coulomb: 20.0,
            load: 8.0,
        },
        effects: Effects::NONE,
        counts: 10_000.0,
        offset: 0.4,
        settings: CommissionSettings {
            sample_time: 1e-3,
            resolution: std::f64::consts::TAU / 10_000.0,
            limits: Limits {
                travel: [-0.16, 0.16],
                speed: 15.0,
                command: [-10.0, 10.0],
                duration: 1.0,
                one_way: false,
            },
            command_delay: 0.0,
            most_gain: None,
            goal: Goal::Stiffest,
            most_sensitivity: 1.6,
            trial_step: None,
        },
        before: None,
    }
}

impl Bench {
    /// Commissions it; `disturb` may end it in any sample (number, phase).
    pub(crate) fn commission(
        &self,
        disturb: &mut dyn FnMut(u64, Phase) -> Option<StopReason>,
    ) -> Course {
        self.run(disturb, None)
    }

    /// Commissions it with a fault.
    pub(crate) fn commission_with(&self, strike: Strike) -> Course {
        self.run(&mut |_, _| None, Some(strike))
    }

    fn run(
        &self,
        disturb: &mut dyn FnMut(u64, Phase) -> Option<StopReason>,
        strike: Option<Strike>,
    ) -> Course {
        let commission =
            Commission::<f32>::new(&self.settings, self.before.as_ref()).expect("allowed");
        let mut study = Study::<f32, 256>::new(&self.settings).expect("allowed");
        let sample_time = self.settings.sample_time;
        let mut servo =
            Servo::at_rest(&self.servo, &self.effects, sample_time, 1).expect("allowed");
        let encoder = Encoder::new(self.counts);
        let resolution = std::f64::consts::TAU / self.counts;
        let read = |servo: &Servo| encoder.read(servo.position() + self.offset * resolution) as i32;
        // Gains before have long come to rest: their integral holds the load.
        let held = -self.servo.load / self.servo.b;
        let held = self.before.map(|_| held as f32);
        let mut state = commission.start(read(&servo), held);
        let mut course = Course {
            state,
            phases: vec![(Phase::Idle, 0.0)],
            travel: [0.0; 2],
            speed: 0.0,
            command: [0.0; 2],
            trial: Vec::new(),
            detected: None,
            after: Vec::new(),
            last: 0.0,
        };
        let most = (120.0 / sample_time) as u64;
        let mut after = (2.0 / sample_time) as u64;
        let mut in_phase = 0;
        // The fault, the count where it struck, and when.
        let mut struck: Option<(Fault, i32, u64)> = None;
        for k in 0..most {
            let time = k as f64 * sample_time;
            let count = read(&servo);
            if let Some(strike) = strike
                && struck.is_none()
                && state.phase() == strike.phase
            {
                in_phase += 1;
                if in_phase > strike.after {
                    struck = Some((strike.fault, count, k));
                }
            }
            let fault = struck.map(|(fault, ..)| fault);
            let seen = Seen {
                count: struck.map_or(Some(count), |(fault, at, _)| fault.seen(count, at)),
                late: fault == Some(Fault::Overrun),
                stop: disturb(k, state.phase()).or(fault.and_then(Fault::stop)),
            };
            let ended = state.phase().is_end();
            let step = commission.process(&mut state, &seen);
            if let Some((_, _, at)) = struck
                && step.phase.is_end()
                && !ended
            {
                course.detected = Some(k - at);
            }
            if course.phases.last().map(|last| last.0) != Some(step.phase) {
                course.phases.push((step.phase, time));
            }
            if let Some(finding) = &step.finding {
                study.take(finding);
            }
            for _ in 0..commission.slices() {
                if let Some(answer) = study.work() {
                    commission.accept(&mut state, &answer);
                }
            }
            let command = step.command.map_or(0.0, f64::from);
            if step.phase == Phase::Trial {
                course.trial.push([time, servo.position(), command]);
            }
            course.command = [
                course.command[0].min(command),
                course.command[1].max(command),
            ];
            servo.advance(fault.map_or(command, |fault| fault.acts(command)));
            let position = servo.position();
            course.travel = [
                course.travel[0].min(position),
                course.travel[1].max(position),
            ];
            course.speed = course.speed.max(servo.velocity().abs());
            course.last = position;
            if step.phase.is_end() {
                course.after.push(step.command);
                after -= 1;
                if after == 0 {
                    break;
                }
            }
        }
        course.state = state;
        course
    }
}
