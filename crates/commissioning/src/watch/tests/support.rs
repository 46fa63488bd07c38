//! A servo in motion, watched.

use crate::watch::{
    DetectionTimes, KnownServo, Observation, ServoWatch, ServoWatchState, Use, WatchSettings,
};
use identifier_core::parameters::IdentifiedServo;
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use std::f64::consts::TAU;
use virtual_servo::faults::{Faults, InjectedFault};
use virtual_servo::{Effects, Encoder, Servo};

/// An axis and its drive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis {
    pub(crate) servo: ServoParameters,
    pub(crate) counts_per_rev: f64,
    pub(crate) sample_time: f64,
    /// Command units.
    pub(crate) limit: f64,
    /// Samples.
    pub(crate) delay: f64,
    /// Of the position loop, rad/s.
    pub(crate) bandwidth: f64,
}

/// From a step of the setpoint to the next, s.
pub(crate) const STEP: f64 = 0.25;

/// Motion of the servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Drive {
    /// A ramp until it moves, then a relay within the travel.
    Probing,
    /// A PID, whose setpoint jumps to and fro, and the servo comes to rest between.
    Steps,
    /// The same without rest.
    Shake,
    /// A PID at a constant setpoint.
    Hold,
}

/// Knowledge of the servo.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Knowledge {
    Nothing,
    /// Each parameter by such a factor.
    Model([f64; 3]),
}

impl Axis {
    pub(crate) fn units(&self) -> f64 {
        TAU / self.counts_per_rev
    }

    /// Of a relay, or of setpoints that ask for 40 % of the command, rad.
    pub(crate) fn amplitude(&self, drive: Drive) -> f64 {
        match drive {
            Drive::Probing => 0.1,
            _ => 0.2 * self.servo.b * self.limit / (self.bandwidth * self.bandwidth),
        }
    }

    /// A travel to either side that the motion stays within, rad.
    pub(crate) fn reach(&self, drive: Drive) -> f64 {
        match drive {
            Drive::Probing => 2.0,
            _ => 2.0 * self.amplitude(drive),
        }
    }

    /// A limit of the speed that the motion stays below, rad/s.
    pub(crate) fn speed(&self, drive: Drive) -> f64 {
        match drive {
            Drive::Probing => 60.0,
            _ => 1.5 * self.bandwidth * self.amplitude(drive),
        }
    }

    pub(crate) fn settings(&self) -> WatchSettings {
        WatchSettings {
            sample_time: self.sample_time,
            resolution: self.units(),
            travel: [f64::NEG_INFINITY, f64::INFINITY],
            speed: f64::INFINITY,
            command: [-self.limit, self.limit],
            used_for: Use::Commissioning,
        }
    }

    pub(crate) fn identified(&self, [a, b, coulomb]: [f64; 3]) -> IdentifiedServo {
        let servo = &self.servo;
        IdentifiedServo {
            unexplained: 0.3 * self.units(),
            ..IdentifiedServo::known(
                ServoParameters::new(
                    a * servo.a,
                    b * servo.b,
                    coulomb * servo.coulomb,
                    servo.load,
                ),
                self.delay * self.sample_time,
            )
        }
    }
}

/// A run of an axis.
#[derive(Debug)]
pub(crate) struct Run<'f> {
    pub(crate) axis: Axis,
    pub(crate) drive: Drive,
    pub(crate) knowledge: Knowledge,
    pub(crate) settings: WatchSettings,
    pub(crate) faults: &'f [InjectedFault],
    /// A load that oscillates: by how much, rad/s², and how often, Hz.
    pub(crate) half_cycle: [f64; 2],
    /// S.
    pub(crate) duration: f64,
    /// The amplitude of relay and steps, rad.
    pub(crate) amplitude: f64,
}

/// The fault found, and the number of its sample.
pub(crate) type Found = Option<(Reason, u64)>;

impl<'f> Run<'f> {
    pub(crate) fn new(
        axis: Axis,
        drive: Drive,
        knowledge: Knowledge,
        faults: &'f [InjectedFault],
    ) -> Self {
        Self {
            axis,
            drive,
            knowledge,
            settings: axis.settings(),
            faults,
            half_cycle: [0.0; 2],
            duration: 1.0,
            amplitude: axis.amplitude(drive),
        }
    }

    pub(crate) fn detection(&self) -> DetectionTimes {
        let watch = ServoWatch::<f32>::new(&self.settings).expect("allowed");
        watch.detection_times(&self.begin(&watch))
    }

    fn begin(&self, watch: &ServoWatch<f32>) -> ServoWatchState<f32> {
        let mut state = watch.start();
        if let Knowledge::Model(factors) = self.knowledge {
            let servo = self.axis.identified(factors);
            let known = KnownServo::from_identified(&self.settings, &servo).expect("it has a gain");
            watch.know(&mut state, &known);
        }
        state
    }

    pub(crate) fn run(&self) -> Found {
        let Axis {
            sample_time,
            limit,
            counts_per_rev,
            ..
        } = self.axis;
        let watch = ServoWatch::<f32>::new(&self.settings).expect("allowed");
        let mut state = self.begin(&watch);
        let effects = Effects {
            delay: self.axis.delay * sample_time,
            ..Effects::NONE
        };
        let mut servo =
            Servo::at_rest(&self.axis.servo, &effects, sample_time, 1).expect("allowed");
        let mut faults = Faults::new(self.faults, sample_time, self.axis.units()).expect("allowed");
        let encoder = Encoder::new(counts_per_rev);
        let mut controller = Control::new(&self.axis, self.drive, self.amplitude);
        let samples = (self.duration / sample_time) as u64;
        let (mut last, mut acted) = (None, controller.integral);
        for sample in 0..samples {
            let now = faults.begin_sample(&mut servo);
            let [load, frequency] = self.half_cycle;
            if load != 0.0 {
                let phase = TAU * frequency * sample as f64 * sample_time;
                servo.disturb(load * phase.sin(), 0.0);
            }
            let count = faults.seen(servo.position()).map(|seen| encoder.read(seen));
            let increment = count.map(|count| (count - last.unwrap_or(count)) as f32);
            last = count.or(last);
            let position = last.unwrap_or(0);
            let observation = Observation {
                increment,
                command: acted as f32,
                position: position as f32,
                setpoint: controller
                    .setpoint()
                    .map(|rad| (rad / self.axis.units()) as f32),
                late: now.late,
                must_move: controller.must_move(),
                excited: false,
            };
            if let Err(reason) = watch.process(&mut state, &observation) {
                return Some((reason, sample));
            }
            acted = controller
                .process(position as f64 * self.axis.units())
                .clamp(-limit, limit);
            servo.advance(faults.acting(acted));
        }
        None
    }
}

/// Controller of the servo.
struct Control {
    axis: Axis,
    drive: Drive,
    amplitude: f64,
    samples: u64,
    /// Last position and velocity estimate.
    last: f64,
    velocity: f64,
    integral: f64,
    /// Of the probing motion: the breakaway command, and the relay's direction.
    broke: Option<f64>,
    direction: f64,
    start: f64,
}

impl Control {
    fn new(axis: &Axis, drive: Drive, amplitude: f64) -> Self {
        Self {
            axis: *axis,
            drive,
            amplitude,
            samples: 0,
            last: 0.0,
            velocity: 0.0,
            // The command that holds the servo when the run begins.
            integral: -axis.servo.load / axis.servo.b,
            broke: None,
            direction: 1.0,
            start: 0.0,
        }
    }

    fn setpoint(&self) -> Option<f64> {
        match self.drive {
            Drive::Probing => None,
            Drive::Hold => Some(0.0),
            Drive::Steps | Drive::Shake => {
                let half = if self.drive == Drive::Steps {
                    STEP
                } else {
                    2.5 / self.axis.bandwidth
                };
                let half = (half / self.axis.sample_time) as u64;
                let out = (self.samples / half).is_multiple_of(2);
                Some(if out { self.amplitude } else { -self.amplitude })
            }
        }
    }

    fn must_move(&self) -> bool {
        self.drive == Drive::Probing && self.broke.is_some()
    }

    fn process(&mut self, position: f64) -> f64 {
        let Axis {
            sample_time,
            bandwidth,
            servo,
            ..
        } = self.axis;
        let step = position - self.last;
        self.last = position;
        self.samples += 1;
        let smoothing = 1.0 - (-sample_time * 5.0 * bandwidth).exp();
        self.velocity += smoothing * (step / sample_time - self.velocity);
        match self.setpoint() {
            None => self.probe(position),
            Some(setpoint) => {
                let error = setpoint - position;
                let kp = bandwidth * bandwidth / servo.b;
                let kd = (2.0 * bandwidth - servo.a).max(0.0) / servo.b;
                let ki = 0.2 * kp * bandwidth;
                let command = kp * error - kd * self.velocity + self.integral;
                if command.abs() < self.axis.limit {
                    self.integral += ki * error * sample_time;
                }
                command
            }
        }
    }

    /// A ramp to 2 % of the limit in a millisecond, then a relay about the command that holds the servo.
    fn probe(&mut self, position: f64) -> f64 {
        let hold = -self.axis.servo.load / self.axis.servo.b;
        let time = self.samples as f64 * self.axis.sample_time;
        let moved = (8.0 * self.axis.units()).max(0.05 * self.amplitude);
        let ramp = (20.0 * time).min(1.0) * (self.axis.limit - hold.abs());
        let Some(broke) = self.broke else {
            if position.abs() > moved {
                self.broke = Some(ramp.max(0.05 * self.axis.limit));
                self.start = position;
            }
            return hold + ramp;
        };
        if position > self.start + self.amplitude / 2.0 {
            self.direction = -1.0;
        } else if position < self.start - self.amplitude / 2.0 {
            self.direction = 1.0;
        }
        hold + self.direction * broke
    }
}
