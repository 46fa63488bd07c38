use commissioning::Phase;
use serde::{Serialize, Serializer};

/// One sample of a commissioning, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time since it began, s.
    pub time: f64,
    /// The phase.
    pub phase: Phase,
    /// Position by the encoder, rad; none if it gave no valid reading.
    pub measured: Option<f64>,
    /// Reference, rad; none where no controller acts.
    pub reference: Option<f64>,
    /// True position of the servo, rad.
    pub position: f64,
    /// Its true velocity, rad/s.
    pub velocity: f64,
    /// The command that acts from here on, command units; none if the servo is disabled.
    pub command: Option<f64>,
}

/// The course of a commissioning, phase by phase.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Course {
    samples: u64,
    /// The phases, in their order.
    pub phases: Vec<PhaseSpan>,
}

/// A phase, from when to when.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PhaseSpan {
    /// The phase.
    #[serde(serialize_with = "name")]
    pub phase: Phase,
    /// Its first sample, s.
    pub begin: f64,
    /// The first sample of the next, or the last that was watched, s.
    pub end: f64,
    /// True motion of the servo; none once it is disabled, as it goes where its load takes it.
    pub excursion: Option<Excursion>,
}

/// Extremes of the motion, and of the commands that acted.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Excursion {
    /// Lowest and highest position, rad from where it stood.
    pub position: [f64; 2],
    /// The largest speed, rad/s.
    pub speed: f64,
    /// Lowest and highest command, command units.
    pub command: [f64; 2],
    /// Root of the mean square of the command, by which it heats the motor, command units.
    pub command_rms: f64,
    #[serde(skip)]
    samples: u64,
}

fn name<S: Serializer>(phase: &Phase, serializer: S) -> Result<S::Ok, S::Error> {
    phase.name().serialize(serializer)
}

impl Course {
    /// Takes in a sample.
    pub fn add(&mut self, sample: &Sample) {
        self.samples += 1;
        let is_disabled = sample.phase.is_end() && sample.command.is_none();
        let excursion = (!is_disabled).then(|| Excursion::of(sample));
        match self.phases.last_mut() {
            Some(last) if last.phase == sample.phase => {
                last.excursion = Excursion::both(last.excursion, excursion);
            }
            last => {
                if let Some(last) = last {
                    last.end = sample.time;
                }
                self.phases.push(PhaseSpan {
                    phase: sample.phase,
                    begin: sample.time,
                    end: sample.time,
                    excursion,
                });
            }
        }
    }

    /// True motion of the servo while it was commanded, of all phases.
    #[must_use]
    pub fn excursion(&self) -> Excursion {
        let phases = self.phases.iter().map(|phase_span| phase_span.excursion);
        phases.fold(None, Excursion::both).unwrap_or_default()
    }

    /// The course, which ends at a time, s.
    #[must_use]
    pub fn finish(mut self, time: f64) -> Self {
        if let Some(last) = self.phases.last_mut() {
            last.end = time;
        }
        self
    }

    /// The phase now.
    pub(super) fn phase(&self) -> Phase {
        self.phases.last().map_or(Phase::Idle, |last| last.phase)
    }

    /// The samples that were run.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }
}

impl Excursion {
    fn of(sample: &Sample) -> Self {
        let command = sample.command.unwrap_or(0.0);
        Self {
            position: [sample.position; 2],
            speed: sample.velocity.abs(),
            command: [command; 2],
            command_rms: command.abs(),
            samples: 1,
        }
    }

    /// Combines two segments, either of which may be empty.
    fn both(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        let (Some(one), Some(other)) = (one, other) else {
            return one.or(other);
        };
        let widest =
            |[low, high]: [f64; 2], [lower, higher]: [f64; 2]| [low.min(lower), high.max(higher)];
        let samples = one.samples + other.samples;
        let squares = |of: &Self| of.samples as f64 * of.command_rms * of.command_rms;
        Some(Self {
            position: widest(one.position, other.position),
            speed: one.speed.max(other.speed),
            command: widest(one.command, other.command),
            command_rms: ((squares(&one) + squares(&other)) / samples as f64).sqrt(),
            samples,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disabled_servo_moves_no_extreme_and_all_phases_have_those_of_each() {
        let sample = |time: f64, phase, position: f64, command| Sample {
            time,
            phase,
            measured: None,
            reference: None,
            position,
            velocity: -3.0 * position,
            command,
        };
        let mut course = Course::default();
        course.add(&sample(0.0, Phase::Probe, -0.5, Some(3.0)));
        course.add(&sample(1.0, Phase::Probe, 0.1, Some(-4.0)));
        course.add(&sample(2.0, Phase::Fit, 0.4, None));
        course.add(&sample(3.0, Phase::Aborted, 9.0, None));
        let course = course.finish(4.0);
        let [probe, fit, aborted] = course.phases[..] else {
            panic!("{:?}", course.phases);
        };
        let probed = probe.excursion.expect("commanded");
        let extremes = (probed.position, probed.speed, probed.command);
        assert_eq!(extremes, ([-0.5, 0.1], 1.5, [-4.0, 3.0]));
        assert!((probed.command_rms - 12.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!(fit.excursion.map(|fit| fit.command_rms), Some(0.0));
        assert_eq!((aborted.excursion, aborted.end), (None, 4.0));
        let all = course.excursion();
        assert_eq!((all.position, all.samples), ([-0.5, 0.4], 3));
        assert!((all.command_rms - (25.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }
}
