//! A servo with its encoder, and a commissioning of it.

use commissioning::{
    CommissionInputs, CommissionSettings, CommissionState, HoldingGains, Limits, Phase,
    SynchronousCommission,
};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use virtual_servo::faults::{FaultKind, Faults, InjectedFault};
use virtual_servo::{Effects, Encoder, Servo, SplitMix64};

/// The axis that is commissioned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bench {
    pub(crate) servo: ServoParameters,
    pub(crate) effects: Effects,
    pub(crate) counts: f64,
    /// Where between two edges the encoder begins, counts.
    pub(crate) offset: f64,
    /// Standard deviation of the encoder's noise, counts.
    pub(crate) noise: f64,
    pub(crate) settings: CommissionSettings,
    pub(crate) before: Option<HoldingGains>,
    pub(crate) background: Background,
}

/// The slices of work that the background does in each sample.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Background {
    /// As many as it should.
    Usual,
    /// This many.
    Steady(u32),
    /// With other work, by this seed: they are random, and so is their mean, half to twice as many as it should do.
    Busy(u64),
}

impl Background {
    /// Those of sample after sample, if it should do so many.
    fn slices(self, usual: u32) -> Box<dyn FnMut() -> u32> {
        match self {
            Self::Usual => Box::new(move || usual),
            Self::Steady(slices) => Box::new(move || slices),
            Self::Busy(seed) => {
                let mut random = SplitMix64::new(seed);
                let mean = f64::from(usual) * f64::exp2(random.uniform(-1.0, 1.0));
                Box::new(move || random.uniform(0.0, 2.0 * mean).round() as u32)
            }
        }
    }
}

/// A permanent fault in a phase, some samples after the phase began.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FaultInjection {
    pub(crate) kind: FaultKind,
    pub(crate) size: f64,
    pub(crate) phase: Phase,
    pub(crate) after: u32,
}

/// Course of a commissioning.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    pub(crate) state: CommissionState<f32>,
    /// The resonance that is shown, rad/s.
    pub(crate) resonance: Option<f64>,
    /// The time at which each phase began, s.
    pub(crate) phases: Vec<(Phase, f64)>,
    /// Extremes of the true motion, rad and rad/s, and of the command.
    pub(crate) travel: [f64; 2],
    pub(crate) speed: f64,
    /// The largest speed and travel up to its end, as parts of their limits.
    pub(crate) reached: [f64; 2],
    pub(crate) command: [f64; 2],
    /// The times in which the command or the reference moves the servo, s, and when the stage was disabled.
    pub(crate) ordered: Vec<f64>,
    /// The command of every sample, zero where the stage is disabled.
    pub(crate) given: Vec<f64>,
    pub(crate) disabled: Option<f64>,
    /// The commands after the end; `None` while it coasts.
    pub(crate) after: Vec<Option<f64>>,
    /// Where the servo was at the end of all, rad.
    pub(crate) last: f64,
}

impl Course {
    /// When the servo was first ordered to move from a time on, s.
    pub(crate) fn ordered_since(&self, time: f64) -> Option<f64> {
        self.ordered.iter().copied().find(|&at| at >= time)
    }

    /// When a phase began, s.
    pub(crate) fn began(&self, phase: Phase) -> Option<f64> {
        let of = |&&(own, _): &&(Phase, f64)| own == phase;
        self.phases.iter().find(of).map(|&(_, time)| time)
    }

    /// When it ended, s.
    pub(crate) fn ended(&self) -> Option<f64> {
        let end = self.phases.iter().find(|(phase, _)| phase.is_end());
        end.map(|&(_, time)| time)
    }
}

/// The paper's servo with a fine encoder, coasting.
pub(crate) fn ordinary() -> Bench {
    Bench {
        servo: ServoParameters::new(0.2174, 257.7, 20.0, 8.0),
        effects: Effects::NONE,
        counts: 10_000.0,
        offset: 0.4,
        noise: 0.0,
        settings: CommissionSettings::new(
            1e-3,
            std::f64::consts::TAU / 10_000.0,
            Limits::new([-0.16, 0.16], 15.0, [-10.0, 10.0]),
        ),
        before: None,
        background: Background::Usual,
    }
}

impl Bench {
    /// Gives it an encoder of so many counts per revolution.
    pub(crate) fn set_counts(&mut self, counts: f64) {
        self.counts = counts;
        self.settings.resolution = std::f64::consts::TAU / counts;
    }

    /// Commissions it; `disturb` may end it in any sample.
    pub(crate) fn commission(&self, disturb: &mut dyn FnMut(Phase) -> Option<Reason>) -> Course {
        self.run(&[], disturb)
    }

    /// Commissions it with a fault; the course and the time of the fault, s.
    pub(crate) fn commission_with(&self, injection: &FaultInjection) -> (Course, f64) {
        let sound = self.run(&[], &mut |_| None);
        // Gains may ask for further lines, and are tried after the last search.
        let mut phases: Vec<_> = sound.phases.iter().collect();
        if injection.phase == Phase::Gains {
            phases.reverse();
        }
        let of = phases.iter().find(|(phase, _)| *phase == injection.phase);
        let (_, began) = of.expect("it came so far");
        let time = began + f64::from(injection.after) * self.settings.sample_time;
        let fault = InjectedFault::lasting(injection.kind, time, injection.size);
        (self.run(&[fault], &mut |_| None), time)
    }

    /// Commissions it with faults.
    pub(crate) fn run(
        &self,
        faults: &[InjectedFault],
        disturb: &mut dyn FnMut(Phase) -> Option<Reason>,
    ) -> Course {
        /// The longest that it may take, and for how long it is watched after its end, s.
        const MAX_DURATION: f64 = 120.0;
        const AFTERWARDS: f64 = 2.0;
        let sample_time = self.settings.sample_time;
        let resolution = std::f64::consts::TAU / self.counts;
        let mut faults = Faults::new(faults, sample_time, resolution).expect("allowed");
        let mut servo =
            Servo::at_rest(&self.servo, &self.effects, sample_time, 1).expect("allowed");
        let encoder = Encoder::new(self.counts);
        let mut random = SplitMix64::new(5);
        // Gains before have long come to rest: their integral holds the load.
        let held = self.before.map(|_| -self.servo.load / self.servo.b);
        if let Some(command) = held {
            servo = servo.held_by(command);
        }
        let mut commission =
            SynchronousCommission::<f32>::new(&self.settings, self.before.as_ref(), held)
                .expect("allowed");
        let mut slices = self.background.slices(commission.slices());
        let mut phases = vec![(Phase::Idle, 0.0)];
        let (mut travel, mut command) = ([0.0_f64; 2], [0.0_f64; 2]);
        let mut speed = 0.0_f64;
        let mut reached = [0.0_f64; 2];
        let limits = &self.settings.limits;
        let mut commands = vec![];
        let (mut after, mut ordered, mut disabled, mut reference) = (vec![], vec![], None, None);
        for k in 0..(MAX_DURATION / sample_time) as u64 {
            let condition = faults.begin_sample(&mut servo);
            let seen = faults.seen(servo.position());
            let gaussian = (0..12).map(|_| random.next_uniform()).sum::<f64>() - 6.0;
            let beyond = (self.offset + self.noise * gaussian) * resolution;
            let count = seen.map(|at| encoder.read(at + beyond) as i32);
            let line = match () {
                () if condition.limit_switch => Some(Reason::LimitSwitch),
                () if condition.amplifier_fault => Some(Reason::AmplifierFault),
                () => None,
            };
            let phase = phases.last().map_or(Phase::Idle, |last| last.0);
            let inputs = CommissionInputs {
                count,
                late: condition.late,
                stop: disturb(phase).or(line),
            };
            let done = commission.sample_with_slices(&inputs, slices());
            if phase != done.phase {
                phases.push((done.phase, k as f64 * sample_time));
            }
            let time = k as f64 * sample_time;
            if done.command.is_none() && self.before.is_some() {
                disabled = disabled.or(Some(time));
            }
            let is_probed = done.command.is_some() && done.setpoint.is_none();
            if is_probed || reference.is_some() && done.setpoint != reference {
                ordered.push(time);
            }
            reference = done.setpoint;
            let given = done.command.unwrap_or(0.0);
            commands.push(given);
            command = [command[0].min(given), command[1].max(given)];
            servo.advance(faults.acting(given));
            let position = servo.position();
            travel = [travel[0].min(position), travel[1].max(position)];
            speed = speed.max(servo.velocity().abs());
            if after.is_empty() {
                let beyond = (position / limits.travel[0]).max(position / limits.travel[1]);
                reached = [
                    reached[0].max(servo.velocity().abs() / limits.speed),
                    reached[1].max(beyond),
                ];
            }
            if done.phase.is_end() {
                after.push(done.command);
                if after.len() as f64 * sample_time > AFTERWARDS {
                    break;
                }
            }
        }
        Course {
            state: *commission.state().expect("it began"),
            resonance: (commission.solver().resonance()).map(|resonance| resonance.mode.frequency),
            phases,
            travel,
            speed,
            reached,
            command,
            ordered,
            given: commands,
            disabled,
            after,
            last: servo.position(),
        }
    }
}
