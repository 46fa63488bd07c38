//! The watch over servo and encoder in a run, at its own pace: its times are milliseconds, at any sample rate.

use commissioning::watch::{KnownServo, Observation, ServoWatch, ServoWatchState, WatchSettings};
use drive_link::Fault;
use identifier_core::control::ControlSample;
use identifier_core::error::OutOfRange;
use identifier_core::parameters::IdentifiedServo;

/// A [`ServoWatch`] that sees some samples as one: all of their counts, and their mean command. Its detectors take turns
/// in the samples that follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PacedWatch {
    watch: ServoWatch<f32>,
    state: ServoWatchState<f32>,
    /// The settings from which it was built; its sample time is that from one observation to the next.
    axis: WatchSettings,
    /// Samples of an observation, the part of each, and those that are left.
    every: u32,
    part: f32,
    left: u32,
    /// The mean command of those before.
    command: f32,
    /// The count from which it has its positions, whatever the origin is, and that of the last observation.
    from: i32,
    count: i32,
    seen: Observation<f32>,
    /// The detectors of the next sample, as bits, and how many run in one.
    next: u32,
    at_once: u32,
}

impl PacedWatch {
    /// The time from one observation to the next, s.
    const TIME: f64 = 5e-4;

    /// For an axis at its sample time.
    ///
    /// # Errors
    /// The setting that is not allowed, by name.
    pub(crate) fn new(settings: &WatchSettings) -> Result<Self, OutOfRange> {
        let every = ((Self::TIME / settings.sample_time + 0.5) as u32).max(1);
        let axis = WatchSettings {
            sample_time: settings.sample_time * f64::from(every),
            ..*settings
        };
        let watch = ServoWatch::new(&axis)?;
        Ok(Self {
            state: watch.start(),
            watch,
            axis,
            every,
            part: 1.0 / every as f32,
            left: every,
            command: 0.0,
            from: 0,
            count: 0,
            seen: Observation::default(),
            next: 0,
            at_once: ServoWatch::<f32>::ALL_DETECTORS
                .count_ones()
                .div_ceil(every),
        })
    }

    /// From now on the servo is identified. False if it cannot be known from that.
    pub(crate) fn know(&mut self, servo: &IdentifiedServo) -> bool {
        let known = KnownServo::from_identified(&self.axis, servo);
        if let Some(known) = &known {
            self.watch.know(&mut self.state, known);
        }
        known.is_some()
    }

    /// Begins at a count.
    pub(crate) fn start(&mut self, count: i32) {
        (self.from, self.count) = (count, count);
    }

    /// A sample at a count, and the command that acted until then.
    ///
    /// # Errors
    /// The fault that a detector has found.
    #[inline(always)]
    pub(crate) fn process(
        &mut self,
        control: &ControlSample<f32>,
        count: i32,
        command: f32,
    ) -> Result<(), Fault> {
        self.command += self.part * command;
        self.left -= 1;
        if self.left == 0 {
            // Counts from the start, as exact as a float has them.
            let position = count.wrapping_sub(self.from) as f32;
            self.seen = Observation {
                increment: Some(count.wrapping_sub(self.count) as f32),
                command: self.command,
                position,
                setpoint: Some(position + control.error),
                ..self.seen
            };
            (self.count, self.command, self.left) = (count, 0.0, self.every);
            self.next = (1 << self.at_once) - 1;
        }
        let detectors = self.next & ServoWatch::<f32>::ALL_DETECTORS;
        if detectors == 0 {
            return Ok(());
        }
        self.next <<= self.at_once;
        self.watch
            .process_some(&mut self.state, &self.seen, detectors)
    }
}

#[cfg(test)]
mod tests {
    use commissioning::watch::Use;
    use identifier_core::parameters::ServoParameters;
    use virtual_servo::faults::{FaultKind, Faults, InjectedFault};
    use virtual_servo::{Effects, Encoder, Servo};

    use super::*;

    const RESOLUTION: f64 = 1e-3;

    fn watch(sample_time: f64) -> PacedWatch {
        let axis = WatchSettings {
            sample_time,
            resolution: RESOLUTION,
            travel: [f64::NEG_INFINITY, f64::INFINITY],
            speed: f64::INFINITY,
            command: [-10.0, 10.0],
            used_for: Use::Operation,
        };
        PacedWatch::new(&axis).expect("valid")
    }

    /// From the fault at 1 s until it is found, s. The servo shakes under a loop of 40 rad/s all the time.
    fn found(sample_time: f64, fault: Option<FaultKind>) -> Option<f64> {
        const START: f64 = 1.0;
        let parameters = ServoParameters::new(2.0, 100.0, 5.0, 0.0);
        let mut watch = watch(sample_time);
        assert!(watch.know(&IdentifiedServo::known(parameters, 0.0)));
        watch.start(0);
        let injected = fault.map(|kind| InjectedFault {
            kind,
            time: START,
            duration: f64::INFINITY,
            size: 0.0,
        });
        let mut faults =
            Faults::new(injected.as_slice(), sample_time, RESOLUTION).expect("allowed");
        let mut servo =
            Servo::at_rest(&parameters, &Effects::NONE, sample_time, 1).expect("allowed");
        let encoder = Encoder::new(core::f64::consts::TAU / RESOLUTION);
        let (mut before, mut command) = (0, 0.0);
        for sample in 0..(2.0 / sample_time) as u64 {
            faults.begin_sample(&mut servo);
            let seen = faults.seen(servo.position()).expect("an encoder");
            let count = encoder.read(seen) as i32;
            let now = sample as f64 * sample_time;
            let error = 0.8 * (20.0 * now).sin() - f64::from(count) * RESOLUTION;
            let control = ControlSample {
                error: (error / RESOLUTION) as f32,
                increment: (count - before) as f32,
                velocity: 0.0,
                command: command as f32,
            };
            if watch.process(&control, count, command as f32).is_err() {
                return Some(now - START);
            }
            before = count;
            command = (16.0 * error - 0.8 * servo.velocity()).clamp(-10.0, 10.0);
            servo.advance(faults.acting(command));
        }
        None
    }

    #[test]
    fn a_failure_is_found_as_soon_at_every_rate() {
        for fault in [FaultKind::EncoderStuck, FaultKind::ActuatorDead] {
            let at_two = found(5e-4, Some(fault)).expect("found at 2 kHz");
            assert!(at_two > 0.0);
            for sample_time in [1e-3, 2.5e-4, 1e-4, 5e-5] {
                let time = found(sample_time, Some(fault)).expect("found");
                assert!(
                    (time - at_two).abs() <= 2e-3 + 0.03 * at_two,
                    "{fault:?} at {sample_time} s: {time} s, at 2 kHz {at_two} s"
                );
            }
        }
        for sample_time in [1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5] {
            assert_eq!(found(sample_time, None), None);
        }
    }

    const CONTROL: ControlSample<f32> = ControlSample {
        error: 1000.0,
        increment: 0.0,
        velocity: 0.0,
        command: 10.0,
    };

    #[test]
    fn counts_and_commands_between_observations_are_seen() {
        let mut watch = watch(5e-5);
        watch.start(0);
        for k in 1..=35 {
            let count = k * (k + 1) / 2;
            assert_eq!(watch.process(&CONTROL, count, k as f32), Ok(()));
        }
        // Samples 21 to 30.
        assert_eq!(watch.seen.increment, Some(255.0));
        assert!((watch.seen.command - 25.5).abs() < 1e-5);
        assert!((watch.seen.position - 465.0).abs() < 1e-9);
    }
}
