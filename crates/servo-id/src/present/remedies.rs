//! Remedies for a verdict that keeps estimates from being relied on.

use host_sim::result::Summary;
use host_sim::verdict::VerdictReason;

use super::number::sentence;

/// Steps in the order in which they are worth trying; none where nothing is to be done.
#[must_use]
pub(super) fn remedies(summary: &Summary) -> Vec<String> {
    let reason = &summary.verdict.reason;
    let mut steps = own_remedies(reason);
    // A fit has all four parameters, whatever is asked for.
    if let Some(unknown) = reason.unknown().filter(|_| summary.fit.is_none())
        && matches!(reason, VerdictReason::NotExcited { .. })
    {
        steps.push(format!(
            "Where it does not matter, leave {} out of identifier.parameters.",
            unknown.name()
        ));
    }
    let is_other_model = matches!(
        reason,
        VerdictReason::AtBound { .. }
            | VerdictReason::NoEstimate {
                obstacle: Some(_),
                ..
            }
            | VerdictReason::StillMoving { .. }
            | VerdictReason::Lacks { .. }
            | VerdictReason::Elsewhere { .. }
    );
    if is_other_model && summary.fit.is_none() {
        steps.push(
            "One fit to the whole record bears noise of the position, and looks for every effect that is known: \
             identifier.law = \"fit\"."
                .to_owned(),
        );
    }
    steps
}

/// Those of a reason, for every estimator.
fn own_remedies(reason: &VerdictReason) -> Vec<String> {
    match *reason {
        VerdictReason::Explained => Vec::new(),
        VerdictReason::EndedEarly => vec![
            "See to the cause that is named above: nothing later can be relied on.".to_owned(),
        ],
        VerdictReason::NoEstimate {
            obstacle: Some(obstacle),
            ..
        } => vec![sentence(obstacle.remedy())],
        VerdictReason::NoEstimate { unknown, .. } => vec![
            "Let the servo move with turns for some seconds, so that the method gets going.".to_owned(),
            format!(
                "If it still finds no {}, take another method: identifier.law = \"gauss-newton\" needs no \
                 first guess.",
                unknown.name()
            ),
        ],
        VerdictReason::TooShort { .. } => {
            vec!["Run longer: run.duration, or a longer log.".to_owned()]
        }
        VerdictReason::NoMotion { .. } => vec![
            "Move the servo further, with turns: a larger reference, or one that changes more often."
                .to_owned(),
            "Check that the encoder counts: a cable, or a wrong log.position_unit, looks the same.".to_owned(),
        ],
        VerdictReason::NotExcited {
            needs_sizes: true, ..
        } => vec![
            "Give the command several sizes, in both directions: of a relay or a binary sequence another level from \
             time to time."
                .to_owned(),
        ],
        VerdictReason::NotExcited { unknown, .. } => vec![
            format!(
                "Excite what shows {}: move further, faster, with more turns, or longer.",
                unknown.name()
            ),
        ],
        VerdictReason::AtBound { unknown, .. } => vec![
            format!("Widen identifier.bounds or the plant_box of {}.", unknown.name()),
            "If it then goes where no servo can be, the model lacks something: see the residual.".to_owned(),
        ],
        VerdictReason::NotSeparated { .. } => vec![
            "Move faster, with turns, and with commands of several sizes well above friction.".to_owned(),
            "A longer record of such motion parts gain and friction too, and so does less noise of the position; a \
             finer encoder helps where the noise is its rounding."
                .to_owned(),
        ],
        VerdictReason::OneDirection => {
            vec!["Record a motion that turns back: forth and back in equal parts is best.".to_owned()]
        }
        VerdictReason::NotAServo => vec![
            "Move further, with turns: the motion must be many of the encoder's steps, and of its noise.".to_owned(),
            "Check that log.position and log.command are columns of the same axis.".to_owned(),
            "Check the sign of the command and the units of the position.".to_owned(),
        ],
        VerdictReason::LongestDelay => {
            vec!["Check that command and position have the same clock, row by row.".to_owned()]
        }
        VerdictReason::TermNotEntered { term } => vec![
            format!(
                "Excite what shows {}: move further, with turns, or longer.",
                term.name()
            ),
            "Where the servo has no such effect, take the term out of identifier.required_terms.".to_owned(),
        ],
        VerdictReason::StillMoving { .. } => vec![
            "Run longer: run.duration, or more --passes over a log.".to_owned(),
            "If it never comes to rest, the servo itself changes: identifier.memory lets the estimates follow."
                .to_owned(),
        ],
        VerdictReason::Stopped => vec!["Let the same command end.".to_owned()],
        VerdictReason::Lacks {
            cause: Some(cause), ..
        } => vec![
            format!("The model lacks {}: {}.", cause.meaning(), cause.remedy()),
            "Then run again: what is hidden behind the largest effect shows up next.".to_owned(),
        ],
        VerdictReason::Lacks { cause: None, .. } => vec![
            "Nothing stands out, so several effects act at once: declare what you know of the amplifier \
             (amplifier.delay, amplifier.current_loop, amplifier.dead_band), and let other effects that your servo has \
             be estimated, with identifier.required_terms."
                .to_owned(),
        ],
        VerdictReason::Elsewhere { unknown, .. } => vec![
            format!("Run longer, until {} has arrived.", unknown.name()),
            "If it does not, the model lacks something: see the residual.".to_owned(),
        ],
        VerdictReason::NotPredicted { .. } => vec![
            "Learn from motions like those that are to be predicted: speeds, loads, angles.".to_owned(),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_sim::verdict::Cause;
    use identifier_core::parameters::Unknown;

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
            steps[0].contains("a dead band of the bridge: set amplifier.dead_band"),
            "{steps:?}"
        );
    }
}
