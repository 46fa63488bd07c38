use identifier_core::commission::Phase;
use serde::{Serialize, Serializer};

use super::Sample;

/// The course of a commissioning: its phases, and how far the servo went.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Course {
    samples: u64,
    /// The phases, in their order.
    pub phases: Vec<Stretch>,
    /// True motion of the servo while it was commanded.
    pub excursion: Excursion,
}

/// A phase, from when to when.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stretch {
    /// The phase.
    #[serde(serialize_with = "name")]
    pub phase: Phase,
    /// Its first sample, s.
    pub begin: f64,
    /// The first sample of the next, or the last that was watched, s.
    pub end: f64,
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
}

fn name<S: Serializer>(phase: &Phase, serializer: S) -> Result<S::Ok, S::Error> {
    phase.name().serialize(serializer)
}

impl Course {
    /// Takes in a sample.
    pub fn add(&mut self, sample: &Sample) {
        self.samples += 1;
        match self.phases.last_mut() {
            Some(last) if last.phase == sample.phase => {}
            last => {
                if let Some(last) = last {
                    last.end = sample.time;
                }
                self.phases.push(Stretch {
                    phase: sample.phase,
                    begin: sample.time,
                    end: sample.time,
                });
            }
        }
        // A disabled servo goes where its load takes it.
        let is_disabled = sample.phase.is_end() && sample.command.is_none();
        if !is_disabled {
            self.excursion.add(sample);
        }
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
    fn add(&mut self, sample: &Sample) {
        let widen = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
        self.position = widen(self.position, sample.position);
        self.speed = self.speed.max(sample.velocity.abs());
        self.command = widen(self.command, sample.command.unwrap_or(0.0));
    }
}
