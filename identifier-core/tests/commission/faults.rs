//! Every fault in every phase: it ends the commissioning, the number says what it is, and what held before
//! is in force again.

use identifier_core::commission::{Phase, StopReason};
use identifier_core::model::ServoParameters;

use crate::machine::before;
use crate::rig::{Bench, Course, Fault, Strike, ordinary};

/// A servo as the paper's, a stiff one at 10 kHz with a fine encoder and delay, and a slow one with much
/// friction and load, held by gains.
fn servos() -> [(&'static str, Bench); 3] {
    let mut stiff = ordinary();
    stiff.servo = ServoParameters {
        a: 1.5,
        b: 1200.0,
        coulomb: 150.0,
        load: -300.0,
    };
    stiff.counts = 65_536.0;
    stiff.settings.sample_time = 1e-4;
    stiff.settings.resolution = std::f64::consts::TAU / stiff.counts;
    stiff.effects.delay = 1.5e-4;
    stiff.settings.limits.travel = [-0.5, 0.5];
    stiff.settings.limits.speed = 40.0;
    let mut held = ordinary();
    held.servo.coulomb = 60.0;
    held.servo.load = 40.0;
    held.before = Some(before());
    [("ordinary", ordinary()), ("stiff", stiff), ("held", held)]
}

/// The reasons that a fault may be told by, and the time that it takes at most, s, or samples. What stands
/// still looks dead whether encoder or actuator is; a servo that runs away is over its limits before a
/// reversal is certain, and one whose actuator is dead coasts beyond them.
fn allowed(fault: Fault) -> (&'static [StopReason], f64, u64) {
    use StopReason::{
        ActuatorDead, ActuatorWeak, AmplifierFault, DoesNotMove, EncoderJumped, EncoderLost,
        EncoderStuck, LimitSwitch, Overrun, OvershootExceeded, Reversed, SpeedExceeded,
        TooLittleEvidence, TravelLeft,
    };
    match fault {
        Fault::EncoderStuck => (
            &[EncoderStuck, ActuatorDead, DoesNotMove, TooLittleEvidence],
            1.5,
            0,
        ),
        Fault::ActuatorDead => (
            &[
                ActuatorDead,
                EncoderStuck,
                DoesNotMove,
                Reversed,
                TravelLeft,
                TooLittleEvidence,
            ],
            1.5,
            0,
        ),
        Fault::EncoderLost => (&[EncoderLost], 1e-3, 2),
        Fault::EncoderJump => (&[EncoderJumped], 0.0, 1),
        Fault::EncoderReversed | Fault::ActuatorReversed => {
            (&[Reversed, SpeedExceeded, TravelLeft], 0.25, 0)
        }
        Fault::ActuatorWeak => (&[ActuatorWeak, OvershootExceeded], 1.6, 0),
        Fault::Overrun => (&[Overrun], 0.0, 3),
        Fault::LimitSwitch => (&[LimitSwitch], 0.0, 1),
        Fault::Amplifier => (&[AmplifierFault], 0.0, 1),
    }
}

fn told(course: &Course) -> String {
    let reason = course.state.reason();
    let number = reason.map_or("-".to_owned(), |reason| reason.number().to_string());
    let samples = course
        .detected
        .map_or("never".to_owned(), |samples| samples.to_string());
    format!("{number} after {samples}")
}

#[test]
fn every_fault_in_every_phase_ends_it_and_what_held_before_is_in_force() {
    let mut wrong = Vec::new();
    for (name, bench) in servos() {
        for fault in Fault::ALL {
            let mut row = format!("{name:>9} {fault:<18?}");
            for phase in &Phase::ALL[1..8] {
                let course = bench.commission_with(Strike {
                    fault,
                    phase: *phase,
                    after: 12,
                });
                row += &format!(" {:>16}", told(&course));
                let ended = course.state.phase();
                let Some(reason) = course.state.reason() else {
                    // An actuator that is weak before it was seen strong is what the servo has.
                    let unseen = matches!(phase, Phase::ReleasedCheck | Phase::Wiggle);
                    if fault != Fault::ActuatorWeak || !unseen {
                        wrong.push(format!("{name} {fault:?} in {phase:?}: {ended:?}"));
                    }
                    continue;
                };
                let safe = if bench.before.is_some() && !reason.lets_go() {
                    course.after.iter().all(Option::is_some)
                } else {
                    course.after.iter().all(Option::is_none)
                };
                let (reasons, time, samples) = allowed(fault);
                let most = samples.max((time / bench.settings.sample_time) as u64);
                let in_time = course.detected.is_some_and(|taken| taken <= most);
                if !safe || !in_time || !reasons.contains(&reason) {
                    let told = told(&course);
                    wrong.push(format!(
                        "{name} {fault:?} in {phase:?}: {told}, safe {safe}"
                    ));
                }
            }
            println!("{row}");
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
