//! Fault injection at any time of a commissioning: `STRUCK=2000` for as many, `CAMPAIGN_SEED=7` for others than usual,
//! `CAMPAIGN_DETAIL=1` for a line each of those that end wrongly.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use commissioning::Phase;
use host_sim::scenario::Scenario;
use identifier_core::reason::Reason;
use integration_tests::{Random, environment, in_parallel};
use virtual_servo::faults::{FaultKind, InjectedFault};

use super::judged::{Judged, commission};
use super::servos::{Drawn, unknown};

/// An event on an axis, and the reasons that name it.
#[derive(Debug, Clone, Copy)]
struct Kind {
    name: &'static str,
    fault: FaultKind,
    /// The least and the largest size of either sign: counts, a share, or a part of the acceleration that the whole command
    /// gives.
    sizes: [f64; 2],
    /// The least and the largest duration, s.
    durations: [f64; 2],
    /// Empty for an event of ordinary operation.
    names: &'static [Reason],
    /// The first phase in which it is a fault: before, it is a property of the servo.
    since: Phase,
}

/// The part of half of the travel, and of the speed limit, beyond which an axis has left them.
const TRAVEL: f64 = 0.04;
const SPEED: f64 = 0.1;

/// Smallest share of the faults that is named rightly: of 1409 89 % were.
const NAMED: f64 = 0.8;

const STAYS: [f64; 2] = [f64::INFINITY; 2];

/// An axis that rests or coasts looks alike whether its encoder or its actuator has failed.
const STANDING: &[Reason] = &[
    Reason::EncoderStuck,
    Reason::ActuatorDead,
    Reason::DoesNotMove,
];

const KINDS: [Kind; 14] = [
    Kind::fault(FaultKind::EncoderStuck, STANDING),
    Kind::fault(FaultKind::EncoderLost, &[Reason::EncoderLost]),
    Kind {
        sizes: [500.0, 5000.0],
        // For an unknown servo it may be a motion.
        since: Phase::FrequencyResponse,
        ..Kind::fault(FaultKind::EncoderJump, &[Reason::EncoderJumped])
    },
    Kind::fault(FaultKind::EncoderReversed, &[Reason::Reversed]),
    Kind::fault(FaultKind::ActuatorDead, STANDING),
    Kind {
        sizes: [0.1, 0.4],
        since: Phase::Gains,
        ..Kind::fault(
            FaultKind::ActuatorWeak,
            &[Reason::ActuatorWeak, Reason::ActuatorDead],
        )
    },
    Kind::fault(FaultKind::ActuatorReversed, &[Reason::Reversed]),
    Kind::fault(FaultKind::Overrun, &[Reason::Overrun]),
    Kind::fault(FaultKind::LimitSwitch, &[Reason::LimitSwitch]),
    Kind::fault(FaultKind::AmplifierFault, &[Reason::AmplifierFault]),
    Kind {
        name: "one reading lost",
        durations: [1e-4, 1e-4],
        ..Kind::ordinary(FaultKind::EncoderLost, [0.0; 2])
    },
    Kind::ordinary(FaultKind::LoadStep, [0.5, 0.5]),
    Kind {
        name: "a hand",
        durations: [0.05, 0.5],
        ..Kind::ordinary(FaultKind::LoadStep, [0.1, 0.5])
    },
    Kind::ordinary(FaultKind::FrictionRise, [0.05, 0.2]),
];

impl Kind {
    const fn fault(fault: FaultKind, names: &'static [Reason]) -> Self {
        Self {
            name: fault.name(),
            fault,
            sizes: [0.0; 2],
            durations: STAYS,
            names,
            since: Phase::Rest,
        }
    }

    const fn ordinary(fault: FaultKind, sizes: [f64; 2]) -> Self {
        Self {
            sizes,
            ..Self::fault(fault, &[])
        }
    }

    fn is_fault(&self) -> bool {
        !self.names.is_empty()
    }

    /// It is injected at any time of the commissioning that the servo would have had.
    fn injection(&self, servo: &Scenario, sound: &Judged, random: &mut Random) -> InjectedFault {
        let phases = &sound.outcome.course.phases;
        let from = phases
            .iter()
            .find(|stretch| stretch.phase == self.since)
            .map_or(0.0, |stretch| stretch.begin);
        let end = sound.outcome.end.map_or(0.0, |end| end.time);
        let [least, most] = self.sizes;
        let [shortest, longest] = self.durations;
        let [_, command] = servo
            .commission_settings()
            .expect("it was run")
            .limits
            .command;
        let whole = servo.plant.map_or(0.0, |plant| plant.b * command);
        let sign = if random.uniform(0.0, 1.0) < 0.5 {
            1.0
        } else {
            -1.0
        };
        let size = random.uniform(least, most);
        InjectedFault {
            kind: self.fault,
            time: random.uniform(from, end),
            duration: match shortest.is_finite() {
                true => random.uniform(shortest, longest),
                false => f64::INFINITY,
            },
            size: match self.fault {
                FaultKind::LoadStep => sign * size * whole,
                FaultKind::FrictionRise => size * whole,
                FaultKind::EncoderJump => sign * size,
                _ => size,
            },
        }
    }
}

/// Outcomes of one kind of fault injection.
#[derive(Debug, Clone, Default)]
struct Tally {
    fault_injection: usize,
    applied: usize,
    /// Named rightly: a fault by its name, an event of operation by none of a fault.
    right: usize,
    /// The axis left its travel by more than 2 % of it, or its speed by more than 10 %.
    left: usize,
    reasons: BTreeMap<&'static str, usize>,
}

/// The farthest from the middle of the travel over half of it, and the largest speed over its limit.
fn reach(judged: &Judged, servo: &Scenario) -> [f64; 2] {
    let limits = servo.commission_settings().expect("it was run").limits;
    let gone = judged.outcome.course.excursion();
    let [low, high] = limits.travel;
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let farthest = gone.position.map(|position| (position - middle).abs());
    [
        farthest[0].max(farthest[1]) / half,
        gone.speed / limits.speed,
    ]
}

/// True for a reason that blames encoder, actuator or drive.
fn is_of_hardware(reason: Reason) -> bool {
    !matches!(reason, Reason::TravelLeft | Reason::SpeedExceeded)
        && (reason.number() < 100
            || matches!(
                reason,
                Reason::EncoderStuck
                    | Reason::EncoderJumped
                    | Reason::Reversed
                    | Reason::ActuatorDead
                    | Reason::ActuatorWeak
            ))
}

/// A servo with its injected fault, judged; none if it is not commissioned without the fault.
fn fault_injection(drawn: &(Drawn, Kind, u32)) -> Option<(Scenario, Judged)> {
    let (drawn, kind, seed) = drawn;
    let mut servo = drawn.scenario().ok()?;
    let sound = commission(&servo);
    if !sound.outcome.is_applied() {
        return None;
    }
    let mut random = Random::new(*seed);
    servo.faults = vec![kind.injection(&servo, &sound, &mut random)];
    let judged = commission(&servo);
    Some((servo, judged))
}

#[test]
fn nothing_is_applied_after_a_fault_before_its_trial() {
    let mut random = Random::new(environment("CAMPAIGN_SEED").unwrap_or(19));
    let injections = environment("STRUCK").unwrap_or(70);
    let drawn: Vec<(Drawn, Kind, u32)> = (0..injections)
        .map(|place| {
            let servo = unknown(&mut random, place, &[]);
            (servo, KINDS[place % KINDS.len()], random.seed())
        })
        .collect();
    let judged = in_parallel(&drawn, fault_injection);
    let mut tallies: BTreeMap<&str, Tally> = BTreeMap::new();
    let mut wrong = Vec::new();
    for ((_, kind, _), judged) in drawn.iter().zip(&judged) {
        let Some((servo, judged)) = judged else {
            continue;
        };
        let tally = tallies.entry(kind.name).or_default();
        let applied = judged.outcome.is_applied();
        let reason = judged.outcome.reason();
        let is_named = match (kind.is_fault(), reason) {
            (true, reason) => reason.is_some_and(|reason| kind.names.contains(&reason)),
            (false, reason) => reason.is_none_or(|reason| !is_of_hardware(reason)),
        };
        let [travel, speed] = reach(judged, servo);
        let left = travel > 1.0 + TRAVEL || speed > 1.0 + SPEED;
        tally.fault_injection += 1;
        tally.applied += usize::from(applied);
        tally.right += usize::from(is_named);
        tally.left += usize::from(left);
        *tally
            .reasons
            .entry(reason.map_or("applied", Reason::name))
            .or_default() += 1;
        let injection = servo.faults[0];
        let within = judged.outcome.end.map(|end| (end.within.name(), end.time));
        let line = format!(
            "{} {reason:?} {within:?} travel {travel:.2} speed {speed:.2} {injection:?}",
            kind.name
        );
        if std::env::var("CAMPAIGN_DETAIL").is_ok() && (!is_named || left) {
            println!("{line}");
        }
        // At rest after its last step no axis shows a fault, and a weak actuator is one of a weaker servo.
        let trial = judged
            .outcome
            .course
            .phases
            .iter()
            .find(|of| of.phase == Phase::Trial);
        let is_shown = trial.is_some_and(|trial| injection.time < trial.begin);
        if kind.is_fault() && applied && is_shown && kind.fault != FaultKind::ActuatorWeak {
            wrong.push(line);
        }
    }
    println!("{}", table(&tallies));
    assert!(wrong.is_empty(), "{wrong:#?}");
    let of_faults = KINDS.iter().filter(|kind| kind.is_fault());
    let (mut fault_injection, mut named) = (0, 0);
    for kind in of_faults {
        let tally = tallies.get(kind.name).expect("every kind strikes");
        fault_injection += tally.fault_injection;
        named += tally.right;
    }
    assert!(
        named as f64 >= NAMED * fault_injection as f64,
        "{named} of {fault_injection}"
    );
}

fn table(tallies: &BTreeMap<&str, Tally>) -> String {
    let mut text = format!(
        "{:<18}{:>8}{:>9}{:>7}{:>6}  reasons\n",
        "kind", "struck", "applied", "right", "left"
    );
    for (kind, tally) in tallies {
        let reasons: Vec<_> = tally
            .reasons
            .iter()
            .map(|(name, times)| format!("{times} × {name}"))
            .collect();
        writeln!(
            text,
            "{kind:<18}{:>8}{:>9}{:>7}{:>6}  {}",
            tally.fault_injection,
            tally.applied,
            tally.right,
            tally.left,
            reasons.join(", ")
        )
        .expect("a string takes any text");
    }
    text
}
