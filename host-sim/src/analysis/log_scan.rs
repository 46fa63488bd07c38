//! The scan of a log, whose conclusions from the motion are checked by the fit.

use crate::log::Log;
use crate::replay::replay;
use crate::result::LogReading;
use crate::scan::{Remark, scan};
use crate::scenario::{Law, Scan, Scenario};
use crate::verdict::Cause;

use super::{Status, Summariser};

/// The findings about a log that is to be identified with a scenario, which is [`fitted`](crate::replay::fitted) to it.
///
/// A regression without a model of friction may miss the command of a servo that sticks most of the time, or take a slow
/// motion for a velocity. If the fit of the whole record knows the servo, it is one: it knows none of the logs with a
/// wrong sign or column on which the scan is tested.
#[must_use]
pub fn remarks(scenario: &Scenario, log: &Log) -> Vec<Remark> {
    let mut remarks = scan(scenario, log);
    let mut refusing = remarks.iter().filter(|remark| remark.refuses);
    if refusing.any(|remark| remark.kind.is_inferred()) && is_known(scenario, log) {
        remarks.retain(|remark| !remark.kind.is_inferred());
    }
    remarks
}

/// True if the fit of a whole log knows its servo, and needs no force that may grow with the position: a loop that follows its
/// goal is one. A ripple of which the motion shows periods does not grow.
fn is_known(scenario: &Scenario, log: &Log) -> bool {
    let mut scenario = scenario.clone();
    scenario.identifier.set_law(Law::Fit);
    let mut summariser = Summariser::lasting(&scenario, log.duration());
    let logs = std::slice::from_ref(log);
    let replayed = replay(&scenario, logs, 1, &mut |_, sample| summariser.add(sample));
    replayed.is_ok_and(|replayed| {
        let summary = summariser.finish(&scenario, replayed.outcome);
        let mut effects = summary.fit.iter().flat_map(|fit| &fit.effects);
        let [gravity, ripple] = [Cause::Gravity, Cause::Ripple].map(Cause::name);
        let grows = effects
            .any(|one| one.name == gravity || (one.name == ripple && one.or == Some(gravity)));
        summary.status() == Status::Converged && !grows
    })
}

/// The reading of a log that is to be identified with a scenario, with the findings about it.
///
/// # Errors
/// Where it contradicts itself or the scenario, a line each, unless `log.scan` makes warnings of them.
pub fn scanned(scenario: &Scenario, log: &Log) -> Result<LogReading, String> {
    let remarks = remarks(scenario, log);
    let refused = remarks.iter().filter(|remark| remark.refuses);
    let refused: Vec<_> = (refused)
        .map(|remark| format!("{}: {remark}", log.path().display()))
        .collect();
    if log.settings().scan == Scan::Refuse && !refused.is_empty() {
        return Err(refused.join("\n"));
    }
    Ok(LogReading {
        remarks,
        ..LogReading::new(log)
    })
}
