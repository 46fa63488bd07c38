//! Problems of a scenario, with their remedies.

use super::rehearsal::Rehearsal;
use crate::result::CheckResult;
use crate::scenario::Scenario;

/// The problems.
pub(super) fn warnings(
    check: &CheckResult,
    scenario: &Scenario,
    rehearsal: &Rehearsal,
) -> Vec<String> {
    let mut warnings = Vec::new();
    loop_warnings(check, &mut warnings);
    motion_warnings(check, scenario, rehearsal, &mut warnings);
    for known in check.known.iter().filter(|known| !known.within_run) {
        let name = known.unknown;
        warnings.push(match known.from {
            Some(from) => format!(
                "{name} will not be known within the run, but after about {from:.2} s: run longer \
                 (run.duration), or move more, and faster and slower"
            ),
            // The end of the run has a warning of its own.
            None if known.std_error.is_some() => continue,
            None => format!(
                "the motion says nothing of {name}: the reference must change, in both directions and \
                 at more than one frequency ([excitation])"
            ),
        });
    }
    warnings
}

fn loop_warnings(check: &CheckResult, warnings: &mut Vec<String>) {
    /// The least modulus margin, 1/Mₛ with Mₛ = 2, and phase margin, degrees: the usual ones.
    const MIN_MODULUS_MARGIN: f64 = 0.5;
    const MIN_PHASE_MARGIN: f64 = 30.0;
    /// The part of a sample that the loop's fastest motion may turn by, rad.
    const MAX_CROSSOVER_PER_SAMPLE: f64 = 0.3;
    let Some(found) = check.closed_loop else {
        return;
    };
    if !found.stable {
        warnings.push(
            "the loop is unstable with this servo: sample faster, raise the cut-off of the velocity \
             filter, or lower the gains"
                .to_owned(),
        );
    }
    if let Some(modulus) = found
        .modulus_margin
        .filter(|modulus| *modulus < MIN_MODULUS_MARGIN)
    {
        warnings.push(format!(
            "the loop comes within {modulus:.2} of instability, where 0.5 is usual: more kd, less ki, or \
             less delay"
        ));
    }
    if let Some(phase) = found.phase_margin.filter(|phase| *phase < MIN_PHASE_MARGIN) {
        warnings.push(format!(
            "its phase margin of {phase:.0} degrees lets it ring: 45 and more are usual"
        ));
    }
    if let Some(crossover) = found.crossover
        && crossover * check.sample_time > MAX_CROSSOVER_PER_SAMPLE
    {
        warnings.push(format!(
            "the samples are slow for this loop: {:.1} in a radian of its fastest motion, where 3 and \
             more are usual; sample faster (controller.sample_time) or lower the gains",
            1.0 / (crossover * check.sample_time)
        ));
    }
}

fn motion_warnings(
    check: &CheckResult,
    scenario: &Scenario,
    rehearsal: &Rehearsal,
    warnings: &mut Vec<String>,
) {
    /// Counts from which on rounding is noise.
    const MIN_MOTION_COUNTS: f64 = 10.0;
    /// Parts of the samples, and of the limit.
    const MAX_LIMITED_PART: f64 = 0.05;
    const MAX_COMMAND_PER_COUNT: f64 = 0.05;
    let [low, high] = scenario.controller().limit;
    let limit = high.min(-low);
    if check.encoder.motion < MIN_MOTION_COUNTS {
        warnings.push(format!(
            "the servo moves by {:.1} counts of the encoder only: a larger reference, or a finer encoder",
            check.encoder.motion
        ));
    }
    if rehearsal.limited > MAX_LIMITED_PART {
        warnings.push(format!(
            "the command is at its limit in {:.0} % of the samples: the loop does not follow there; a \
             smaller or slower reference",
            100.0 * rehearsal.limited
        ));
    }
    if let Some(step) = check.encoder.command_per_count
        && step > MAX_COMMAND_PER_COUNT * limit
    {
        warnings.push(format!(
            "a single count moves the command by {step:.3}, {:.0} % of its limit: lower kd or the cut-off \
             of the velocity filter, or take a finer encoder",
            100.0 * step / limit
        ));
    }
    if check.servo.breakaway > limit {
        warnings.push(format!(
            "friction and load take a command of {:.3}, and the limit is {limit}: the servo cannot move",
            check.servo.breakaway
        ));
    }
    if rehearsal.outcome.abort.is_some() {
        warnings.push("the run breaks off: `run` says when and why".to_owned());
    }
    if rehearsal.command <= 0.0 {
        warnings.push("the command never changes: there is no excitation".to_owned());
    }
}
