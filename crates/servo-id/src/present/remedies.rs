//! Remedies for a verdict that keeps estimates from being relied on.

use identifier_log::result::Summary;
use identifier_log::verdict::VerdictReason;

use super::number::sentence;

/// Steps in the order in which they are worth trying; none where nothing is to be done.
pub(super) fn remedies(summary: &Summary) -> Vec<String> {
    let reason = summary.refused.as_ref().unwrap_or(&summary.verdict.reason);
    let mut steps = own_remedies(reason);
    // A fit has all four parameters, whatever is asked for.
    if let Some(unknown) = reason.unknown().filter(|_| summary.fit.is_none())
        && matches!(reason, VerdictReason::NotExcited { .. })
    {
        steps.push(format!(
            "If {} does not matter, leave it out of identifier.parameters.",
            unknown.name()
        ));
    }
    let is_other_model = matches!(
        reason,
        VerdictReason::AtBound { .. }
            | VerdictReason::NoEstimate {
                rejection_reason: Some(_),
                ..
            }
            | VerdictReason::StillMoving { .. }
            | VerdictReason::Lacks { .. }
            | VerdictReason::RefitDiffers { .. }
    );
    if is_other_model && summary.fit.is_none() {
        steps.push(
            "A fit to the whole log tolerates encoder noise and tests for every known effect: identifier.law = \"fit\"."
                .to_owned(),
        );
    }
    steps
}

/// Those of a reason, for every estimator.
fn own_remedies(reason: &VerdictReason) -> Vec<String> {
    match *reason {
        VerdictReason::Explained | VerdictReason::Left { .. } => Vec::new(),
        VerdictReason::EndedEarly => vec![
            "Correct the cause named above: results after it are not reliable.".to_owned(),
        ],
        VerdictReason::NoEstimate {
            rejection_reason: Some(rejection_reason),
            ..
        } => vec![sentence(rejection_reason.remedy())],
        VerdictReason::NoEstimate { unknown, .. } => vec![
            "Let the servo move for some seconds, with reversals, so that the method can start.".to_owned(),
            format!(
                "If it still finds no {}, choose another method: identifier.law = \"gauss-newton\" needs no initial \
                 estimate.",
                unknown.name()
            ),
        ],
        VerdictReason::TooShort { .. } => {
            vec!["Run longer: run.duration, or a longer log.".to_owned()]
        }
        VerdictReason::NoMotion { .. } => vec![
            "Move the servo further, with reversals: a larger reference, or one that changes more often."
                .to_owned(),
            "Check that the encoder counts: a broken cable or a wrong position unit looks the same.".to_owned(),
        ],
        VerdictReason::NotExcited {
            needs_more_amplitudes: true, ..
        } => vec![
            "Use commands of several sizes in both directions; change the level of a relay or binary sequence from \
             time to time."
                .to_owned(),
        ],
        VerdictReason::NotExcited { unknown, .. } => vec![
            format!(
                "Excite {} more: move further, faster, longer, or with more reversals.",
                unknown.name()
            ),
        ],
        VerdictReason::AtBound { unknown, .. } => vec![
            format!("Widen the bounds of {}: identifier.bounds or servo_range.", unknown.name()),
            "If the estimate then becomes implausible, the model lacks something: see the residual.".to_owned(),
        ],
        VerdictReason::NotSeparated { .. } => vec![
            "Move faster, with reversals and with commands of several sizes well above friction.".to_owned(),
            "A longer log of such motion or less encoder noise also separates gain and friction. A finer encoder \
             helps if quantisation is the noise."
                .to_owned(),
        ],
        VerdictReason::OneDirection => {
            vec!["Record a motion with reversals: equal parts in both directions are best.".to_owned()]
        }
        VerdictReason::NotAServo => vec![
            "Move further, with reversals: the motion must be many times the encoder's resolution and noise.".to_owned(),
            "Check that the position and command columns belong to the same axis.".to_owned(),
            "Check the sign of the command and the units of the position.".to_owned(),
        ],
        VerdictReason::LongestDelay => {
            vec!["Check that command and position have the same clock, row by row.".to_owned()]
        }
        VerdictReason::TermNotEntered { term } => vec![
            format!(
                "Excite {} more: move further, longer, or with more reversals.",
                term.name()
            ),
            "If the servo has no such effect, remove the term from identifier.required_terms.".to_owned(),
        ],
        VerdictReason::StillMoving { .. } => vec![
            "Run longer: run.duration, or more --passes over a log.".to_owned(),
            "If it never settles, the servo itself changes: identifier.memory lets the estimates follow."
                .to_owned(),
        ],
        VerdictReason::Stopped => vec!["Run the same command to its end.".to_owned()],
        VerdictReason::Lacks {
            cause: Some(cause), ..
        } => vec![
            format!("The model lacks {}: {}.", cause.meaning(), cause.remedy()),
            "Then run again: the largest effect may hide others.".to_owned(),
        ],
        VerdictReason::Lacks { cause: None, .. } => vec![
            "No single effect explains the residual, so several act at the same time. Declare what you know of the amplifier (amplifier.delay, \
             amplifier.current_loop, amplifier.dead_band). Have other effects of your servo estimated: \
             identifier.required_terms."
                .to_owned(),
        ],
        VerdictReason::RefitDiffers { unknown, .. } => vec![
            format!("Run longer, until {} has settled.", unknown.name()),
            "If it does not, the model lacks something: see the residual.".to_owned(),
        ],
        VerdictReason::ScalesDiffer { .. } => vec![
            "Check that position and command belong to the same axis, and that the command is what acted.".to_owned(),
            "See b by time scale in the picture: a b that changes is that of several masses, or of a command that \
             passes through more than a gain."
                .to_owned(),
        ],
        VerdictReason::LoopDiffers => vec![
            "State what else the servo's own loop has: --cutoff or --velocity, --limit, --loop-time, --integrator.".to_owned(),
            "Or record the command that acts.".to_owned(),
        ],
        // Those of the fit that was refused.
        VerdictReason::Rough { .. } => Vec::new(),
        VerdictReason::Assumed => vec![
            "State the unit of the time, or the time from row to row: --time-unit or --sample-time.".to_owned(),
        ],
        VerdictReason::NotPredicted { .. } => vec![
            "Identify from motions like those to be predicted: speeds, loads, angles.".to_owned(),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use identifier_core::parameters::Unknown;
    use identifier_log::verdict::Cause;

    #[test]
    fn only_a_good_verdict_asks_for_nothing() {
        assert!(own_remedies(&VerdictReason::Explained).is_empty());
        let lacks = VerdictReason::Lacks {
            cause: Some(Cause::DeadBand),
            share: 0.5,
            unknown: Unknown::A,
            shift: 1.0,
        };
        let steps = own_remedies(&lacks);
        assert!(
            steps[0].contains("a dead band of the power stage: set amplifier.dead_band"),
            "{steps:?}"
        );
    }
}
