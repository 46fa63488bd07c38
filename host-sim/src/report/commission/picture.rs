//! The picture of a commissioning: its phases shaded, the limits drawn, and the step of the trial beside
//! the promised one.

use identifier_core::commission::{Limits, Phase};

use crate::commission::{Outcome, Sample, StepResponse};
use crate::present::Envelope;
use crate::render::chart::plot::{self, Curve, Panel};
use crate::render::chart::timeline::{Shade, Timeline, Track};

/// Room that a panel leaves beyond its limits, a part of their distance.
const ROOM: f64 = 0.08;

/// What the picture is drawn from, gathered sample by sample in bounded memory.
#[derive(Debug, Clone, Default)]
pub struct Traces {
    position: Envelope,
    reference: Envelope,
    speed: Envelope,
    command: Envelope,
    step: Step,
}

/// The step of the trial.
#[derive(Debug, Clone, Default)]
struct Step {
    /// The reference, rad.
    reference: Option<f64>,
    /// When it stepped, s, and where the servo was, rad.
    begun: Option<(f64, f64)>,
    servo: Envelope,
}

impl Traces {
    /// Takes in a sample.
    pub fn add(&mut self, sample: &Sample) {
        let time = sample.time;
        self.position.add(time, sample.position, None);
        self.speed.add(time, sample.velocity, None);
        self.command.add(time, sample.command.unwrap_or(0.0), None);
        // Where no controller acts, the reference lies under the servo.
        let reference = sample.reference.unwrap_or(sample.position);
        self.reference.add(time, reference, None);
        if sample.phase == Phase::Trial {
            self.step.add(sample);
        }
    }
}

impl Step {
    fn add(&mut self, sample: &Sample) {
        let before = std::mem::replace(&mut self.reference, sample.reference);
        if before.is_some() && before != sample.reference {
            self.begun.get_or_insert((sample.time, sample.position));
        }
        if let Some((time, position)) = self.begun {
            self.servo
                .add(sample.time - time, sample.position - position, None);
        }
    }
}

/// The picture; `promised` is the step that the identified servo would do, where there are gains.
#[must_use]
pub fn picture(
    limits: &Limits,
    outcome: &Outcome,
    traces: &Traces,
    promised: Option<&StepResponse>,
) -> Timeline {
    let mut position = track("q [rad]", &traces.position, &limits.travel);
    position.panel.curves = vec![
        traces.position.curve(Some("servo")),
        traces.reference.curve(Some("reference")),
    ];
    let speed = track("q̇ [rad/s]", &traces.speed, &[-limits.speed, limits.speed]);
    let command = track("u [command units]", &traces.command, &limits.command);
    Timeline {
        stretches: outcome
            .course
            .phases
            .iter()
            .map(|stretch| {
                let lasting = stretch.end - stretch.begin;
                let name = stretch.phase.name();
                Shade {
                    name: match stretch.phase.is_end() {
                        true => name.to_owned(),
                        false => format!("{name}, {lasting:.3} s"),
                    },
                    time: [stretch.begin, stretch.end],
                    colour: colour(stretch.phase),
                }
            })
            .collect(),
        tracks: vec![position, speed, command],
        limit: "limit".to_owned(),
        below: promised
            .zip(outcome.tuning)
            .map(|(promised, tuning)| trial(&traces.step, tuning.promise.settling_time, promised))
            .into_iter()
            .collect(),
    }
}

/// The three ends share a colour; one of them is there.
fn colour(phase: Phase) -> usize {
    let place = Phase::ALL.iter().position(|known| *known == phase);
    let first_end = Phase::ALL.iter().position(|known| known.is_end());
    place
        .unwrap_or(0)
        .min(first_end.unwrap_or(0))
        .saturating_sub(1)
}

fn track(axis: &str, envelope: &Envelope, limits: &[f64]) -> Track {
    let lowest = limits.iter().copied().fold(0.0, f64::min);
    let highest = limits.iter().copied().fold(0.0, f64::max);
    let room = ROOM * (highest - lowest);
    Track {
        panel: Panel {
            title: String::new(),
            abscissa: plot::TIME.to_owned(),
            axis: axis.to_owned(),
            logarithmic_abscissa: false,
            curves: vec![envelope.curve(None)],
            nominal: None,
            range: Some((lowest - room, highest + room)),
        },
        limits: limits.to_vec(),
    }
}

/// The step of the trial until the servo is disturbed, beside the promised one with what may be added to its
/// overshoot.
fn trial(step: &Step, settling_time: f64, promised: &StepResponse) -> Panel {
    /// Settling times that are shown: the disturbance comes later.
    const SHOWN: f64 = 1.5;
    /// What may be added to the overshoot, a part of the step.
    const ADDED: f64 = 0.03;
    let shown = |(time, _): &(f64, f64)| *time <= SHOWN * settling_time;
    let mut servo = step.servo.curve(Some("servo"));
    servo.points.retain(shown);
    let points: Vec<_> = promised.points().filter(shown).collect();
    let band = vec![ADDED * promised.step().abs(); points.len()];
    let end = points.last().map_or(0.0, |(time, _)| *time);
    let reference = vec![(0.0, 0.0), (0.0, promised.step()), (end, promised.step())];
    let curve = |name: &str, points, band| Curve {
        name: Some(name.to_owned()),
        points,
        band,
    };
    Panel {
        title: "Step of the trial".to_owned(),
        abscissa: "time since the step [s]".to_owned(),
        axis: "q [rad]".to_owned(),
        logarithmic_abscissa: false,
        curves: vec![
            servo,
            curve("reference", reference, Vec::new()),
            curve("promised ± 3 % of the step", points, band),
        ],
        nominal: None,
        range: None,
    }
}
