//! Figures of a commissioning: its phases shaded, the limits drawn, and the step of the trial beside the predicted one.

use commissioning::Phase;
use host_sim::commission::{FrequencyResponse, Outcome, Sample, StepResponse};
use host_sim::scenario::Scenario;
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::Tuner;

use super::Commissioned;
use crate::present::sensitivity::sensitivity;
use crate::present::{Envelope, Figure, TIME, TimeSpan, Trace};

/// Room beyond the limits, a part of their distance.
const ROOM: f64 = 0.08;

/// The course of a commissioning in bounded memory.
#[derive(Debug, Clone, Default)]
pub struct CommissionTraces {
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
    /// Time of its step, s, and position of the servo then, rad.
    begun: Option<(f64, f64)>,
    servo: Envelope,
}

impl CommissionTraces {
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

/// The figures of a commissioning, the step of its trial where there are gains.
pub(super) fn figures(of: &Commissioned<'_>, traces: &CommissionTraces) -> Vec<Figure> {
    let (scenario, limits, outcome) = (of.scenario, of.limits, of.outcome);
    let phases = outcome.course.phases.iter().map(|time_span| {
        let duration = time_span.end - time_span.begin;
        let name = time_span.phase.name();
        TimeSpan {
            name: match time_span.phase.is_end() {
                true => name.to_owned(),
                false => format!("{name}, {duration:.3} s"),
            },
            extent: [time_span.begin, time_span.end],
            colour: colour(time_span.phase),
        }
    });
    let phases: Vec<TimeSpan> = phases.collect();
    let position = vec![
        traces.position.trace("servo"),
        traces.reference.trace("reference"),
    ];
    let speed = vec![traces.speed.trace("speed")];
    let command = vec![traces.command.trace("command")];
    let speeds = [-limits.speed, limits.speed];
    let mut figures = vec![
        limited("Position", "q [rad]", position, &limits.travel, &phases),
        limited("Speed", "q̇ [rad/s]", speed, &speeds, &phases),
        limited(
            "Command",
            "u [command units]",
            command,
            &limits.command,
            &phases,
        ),
    ];
    let predicted = StepResponse::predicted(scenario, outcome);
    let steps = predicted.iter().zip(&outcome.tuning);
    figures.extend(
        steps.map(|(step, tuning)| {
            trial(&traces.step, tuning.predicted_response.settling_time, step)
        }),
    );
    let measured = outcome.response.iter().zip(outcome.servo());
    figures.extend(
        measured.map(|(response, servo)| bode(response, &servo.parameters, scenario.sample_time())),
    );
    figures.extend(margins(scenario, outcome));
    figures.extend(load(of));
    figures
}

/// The load by the angle, within the friction that holds the axis, as found and as it is; none where none was found to
/// change.
fn load(of: &Commissioned<'_>) -> Option<Figure> {
    const POINTS: u32 = 400;
    let (outcome, effects) = (of.outcome, &of.scenario.effects);
    let found = outcome.servo().filter(|_| outcome.forces.order > 0.0)?;
    let [low, high] = of.limits.travel;
    let angles = (0..=POINTS).map(|at| low + (high - low) * f64::from(at) / f64::from(POINTS));
    let points = |load: &dyn Fn(f64) -> f64| {
        let points = angles.clone().map(|q| (q, load(q)));
        points.collect::<Vec<_>>()
    };
    let ServoParameters { coulomb, load, .. } = found.parameters;
    let load = points(&|q| load + outcome.forces.load(q));
    let bounds = load.iter().flat_map(|(_, d)| [d - coulomb, d + coulomb]);
    let bounds = bounds.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| {
        [low.min(d), high.max(d)]
    });
    let mut traces = vec![Trace {
        name: "found ± Coulomb friction".to_owned(),
        band: vec![coulomb; load.len()],
        points: load,
    }];
    traces.extend(of.scenario.plant.map(|servo| {
        let wave = |[of_sine, of_cosine]: [f64; 2], angle: f64| {
            of_sine * angle.sin() + of_cosine * angle.cos()
        };
        let truth = |q: f64| {
            let cogging = wave(effects.ripple, f64::from(effects.ripple_order) * q);
            servo.load + wave(effects.gravity, q) + cogging
        };
        Trace::new("true", points(&truth))
    }));
    let [axis, title] = ["q [rad]", "Load by the angle"];
    Some(Figure::new(title, axis, "d [rad/s²]", traces).within(Some(bounds)))
}

/// The sensitivity of the loop under the gains that were found, with the measured lines; none where none were found.
fn margins(scenario: &Scenario, outcome: &Outcome) -> Option<Figure> {
    let (servo, tuning) = (outcome.servo()?, outcome.tuning.as_ref()?);
    let order = scenario.commission_settings().ok()?;
    let [least, most] = order.limits.command;
    let (command, step) = (most.min(-least), tuning.predicted_response.step);
    let settings = order.tuning(command, step);
    let (lines, resonance) = match &outcome.response {
        Some(response) => (&response.lines[..], response.resonance.as_ref()),
        None => (&[][..], None),
    };
    let tuner = Tuner::for_response(&settings, servo, resonance).ok()?;
    Some(sensitivity(&tuner, tuning, &settings, lines))
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

/// A figure with the limits of its traces.
fn limited(
    title: &str,
    axis: &str,
    traces: Vec<Trace>,
    limits: &[f64],
    phases: &[TimeSpan],
) -> Figure {
    let lowest = limits.iter().copied().fold(0.0, f64::min);
    let highest = limits.iter().copied().fold(0.0, f64::max);
    let room = ROOM * (highest - lowest);
    let mut figure =
        Figure::new(title, TIME, axis, traces).within(Some([lowest - room, highest + room]));
    figure.time_spans = phases.to_vec();
    let with_limit = |figure: Figure, limit: &f64| figure.with_level("limit", *limit);
    limits.iter().fold(figure, with_limit)
}

/// The measured frequency response beside that of the identified servo. One mass is a line at 0 dB from its friction's
/// corner on.
fn bode(response: &FrequencyResponse, servo: &ServoParameters, sample_time: f64) -> Figure {
    let measured = response.measured(servo.b);
    let (points, band) = measured
        .map(|(at, size, deviation)| ((at, size), deviation))
        .unzip();
    let measured = Trace {
        name: "measured ± standard deviation".to_owned(),
        band,
        points,
    };
    let identified = Trace::new(
        "identified",
        response.identified(servo, sample_time).collect(),
    );
    let mut figure = Figure::new(
        "Frequency response",
        "frequency [Hz]",
        "q̈/(b u) [dB]",
        vec![measured, identified],
    );
    figure.horizontal.is_logarithmic = true;
    figure
}

/// The step of the trial until the servo is disturbed, beside the predicted one with the tolerance of its overshoot.
fn trial(step: &Step, settling_time: f64, predicted: &StepResponse) -> Figure {
    /// Settling times that are shown: the disturbance comes later.
    const SHOWN: f64 = 1.5;
    /// Tolerance of the overshoot, a part of the step.
    const TOLERANCE: f64 = 0.03;
    let is_shown = |(time, _): &(f64, f64)| *time <= SHOWN * settling_time;
    let mut servo = step.servo.trace("servo");
    servo.points.retain(is_shown);
    let points: Vec<_> = predicted.points().filter(is_shown).collect();
    let end = points.last().map_or(0.0, |(time, _)| *time);
    let reference = vec![(0.0, 0.0), (0.0, predicted.step()), (end, predicted.step())];
    let traces = vec![
        servo,
        Trace::new("reference", reference),
        Trace {
            name: "predicted ± 3 % of the step".to_owned(),
            band: vec![TOLERANCE * predicted.step().abs(); points.len()],
            points,
        },
    ];
    Figure::new(
        "Step of the trial",
        "time since the step [s]",
        "q [rad]",
        traces,
    )
}
