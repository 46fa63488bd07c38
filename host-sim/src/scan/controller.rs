//! The declared controller beside the recorded command, for the units of what it controls.

use super::remark::{Remark, RemarkKind};
use super::units::RATIOS;
use crate::log::{Log, extremes};
use crate::scenario::Scenario;

/// The finding about units or signs of a log whose command the declared controller would give, but for a factor.
pub(super) fn remark(scenario: &Scenario, log: &Log) -> Option<Remark> {
    /// Relative deviation of a factor that is one of units: the velocity here is less filtered than the controller's.
    const TOLERANCE: f64 = 0.15;
    let factor = factor(scenario, log)?;
    let is = |ratio: f64| (factor / ratio - 1.0).abs() < TOLERANCE;
    let text = if is(-1.0) {
        "the recorded command is that of [controller] with the other sign: state log.command_scale = -1, or the signs of \
         log.position_scale and log.reference_scale"
            .to_owned()
    } else if RATIOS.iter().any(|ratio| is(*ratio) || is(1.0 / ratio)) {
        format!(
            "the recorded command is {factor:.4} times that of [controller], which is a factor of units: state \
             log.position_unit and log.reference_unit, or the gains of [controller] for rad"
        )
    } else {
        return None;
    };
    Some(Remark::refusing(RemarkKind::PositionUnit, text))
}

/// The recorded command over that of the declared controller; none where they have another course.
fn factor(scenario: &Scenario, log: &Log) -> Option<f64> {
    /// Correlation from which two commands have one course.
    const MIN_CORRELATION: f64 = 0.95;
    /// Part of the largest command from which one may have been limited.
    const LIMITED: f64 = 0.98;
    /// Samples over which the noise of the velocity is averaged.
    const BLOCK: usize = 8;
    let gains = scenario
        .stated
        .controller
        .filter(|_| !scenario.is_own_log())?;
    let (mut products, mut recorded_squares, mut declared_squares) = (0.0, 0.0, 0.0);
    for segment in log.segments() {
        let [positions, commands] = [&segment.positions, &segment.commands];
        if commands.is_empty() || segment.references.is_empty() {
            return None;
        }
        let (low, high) = extremes(commands);
        let limit = LIMITED * low.abs().max(high.abs());
        let mut integral = 0.0;
        let declared: Vec<f64> = (positions.iter().zip(&segment.references).enumerate())
            .map(|(k, (position, reference))| {
                let error = reference - position;
                let velocity = (position - positions[k.saturating_sub(1)]) / log.sample_time;
                let command = gains.kp * error - gains.kd * velocity + gains.ki * integral;
                integral += error * log.sample_time;
                command
            })
            .collect();
        let pairs: Vec<[f64; 2]> = (commands.chunks(BLOCK).zip(declared.chunks(BLOCK)))
            .filter(|(recorded, _)| recorded.iter().all(|command| command.abs() < limit))
            .map(|(recorded, declared)| {
                [recorded, declared].map(|of| of.iter().sum::<f64>() / of.len() as f64)
            })
            .collect();
        // The integral at the beginning is not known.
        let mean = |of: usize| pairs.iter().map(|pair| pair[of]).sum::<f64>() / pairs.len() as f64;
        let means = [mean(0), mean(1)];
        for pair in &pairs {
            let [recorded, declared] = [pair[0] - means[0], pair[1] - means[1]];
            products += recorded * declared;
            recorded_squares += recorded * recorded;
            declared_squares += declared * declared;
        }
    }
    let correlation = products / (recorded_squares * declared_squares).sqrt();
    (correlation.abs() > MIN_CORRELATION).then(|| products / declared_squares)
}
