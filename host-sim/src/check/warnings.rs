//! What speaks against a scenario, in plain words with what to do.

use super::document::Check;
use super::rehearsal::Rehearsal;
use crate::scenario::Scenario;

/// What speaks against it.
pub(super) fn warnings(check: &Check, scenario: &Scenario, rehearsal: &Rehearsal) -> Vec<String> {
    let mut said = Vec::new();
    of_the_loop(check, &mut said);
    of_the_motion(check, scenario, rehearsal, &mut said);
    for known in check.known.iter().filter(|known| !known.within_run) {
        let name = known.unknown;
        said.push(match known.from {
            Some(from) => format!(
                "{name} will not be known within the run, but after about {from:.2} s: run longer \
                 (run.duration), or move more, and faster and slower"
            ),
            // That it breaks off is said.
            None if known.std_error.is_some() => continue,
            None => format!(
                "the motion says nothing of {name}: the reference must change, in both directions and \
                 at more than one frequency ([excitation])"
            ),
        });
    }
    said
}

fn of_the_loop(check: &Check, said: &mut Vec<String>) {
    /// The least modulus margin, 1/Mₛ with Mₛ = 2, and phase margin, degrees: the usual ones.
    const LEAST_MODULUS: f64 = 0.5;
    const LEAST_PHASE: f64 = 30.0;
    /// The part of a sample that the loop's fastest motion may turn by, rad.
    const FASTEST: f64 = 0.3;
    let Some(found) = check.closed_loop else {
        return;
    };
    if !found.stable {
        said.push(
            "the loop is unstable with this servo: sample faster, raise the cut-off of the velocity \
             filter, or lower the gains"
                .to_owned(),
        );
    }
    if let Some(modulus) = found
        .modulus_margin
        .filter(|modulus| *modulus < LEAST_MODULUS)
    {
        said.push(format!(
            "the loop comes within {modulus:.2} of instability, where 0.5 is usual: more kd, less ki, or \
             less delay"
        ));
    }
    if let Some(phase) = found.phase_margin.filter(|phase| *phase < LEAST_PHASE) {
        said.push(format!(
            "its phase margin of {phase:.0} degrees lets it ring: 45 and more are usual"
        ));
    }
    if let Some(crossover) = found.crossover
        && crossover * check.sample_time > FASTEST
    {
        said.push(format!(
            "the samples are slow for this loop: {:.1} in a radian of its fastest motion, where 3 and \
             more are usual; sample faster (controller.sample_time) or lower the gains",
            1.0 / (crossover * check.sample_time)
        ));
    }
}

fn of_the_motion(
    check: &Check,
    scenario: &Scenario,
    rehearsal: &Rehearsal,
    said: &mut Vec<String>,
) {
    /// Counts from which on rounding is noise.
    const FEWEST_COUNTS: f64 = 10.0;
    /// Parts of the samples, and of the limit.
    const OFTEN: f64 = 0.05;
    const MOST_NOISE: f64 = 0.05;
    let [low, high] = scenario.controller().limit;
    let limit = high.min(-low);
    if check.encoder.motion < FEWEST_COUNTS {
        said.push(format!(
            "the servo moves by {:.1} counts of the encoder only: a larger reference, or a finer encoder",
            check.encoder.motion
        ));
    }
    if rehearsal.limited > OFTEN {
        said.push(format!(
            "the command is at its limit in {:.0} % of the samples: the loop does not follow there; a \
             smaller or slower reference",
            100.0 * rehearsal.limited
        ));
    }
    if let Some(step) = check.encoder.command_per_count
        && step > MOST_NOISE * limit
    {
        said.push(format!(
            "a single count moves the command by {step:.3}, {:.0} % of its limit: lower kd or the cut-off \
             of the velocity filter, or take a finer encoder",
            100.0 * step / limit
        ));
    }
    if check.servo.breakaway > limit {
        said.push(format!(
            "friction and load take a command of {:.3}, and the limit is {limit}: the servo cannot move",
            check.servo.breakaway
        ));
    }
    if rehearsal.outcome.abort.is_some() {
        said.push("the run breaks off: `run` says when and why".to_owned());
    }
    if rehearsal.command <= 0.0 {
        said.push("the command never changes: there is no excitation".to_owned());
    }
}
