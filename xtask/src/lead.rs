//! The sample interrupt of the linked drive in a whole commissioning, on an emulated chip. Every sample that drives the
//! output must have its command there within the lead, at every rate.

use std::error::Error;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use commissioning::{CommissionSettings, Limits, Phase};
use drive_link::{Command, Report};
use servo_id::drive::Driven;

use crate::meter::Cost;
use crate::metered::{self, Metered, Next, TIME_LIMIT, instructions_in, share};

/// Rates at which the drive commissions, Hz.
const RATES: [f64; 3] = [1e3, 1e4, 2e4];

/// From a sample to the PWM period in which its command acts, s, as the drive specifies
/// (`drive_chip::sample_timer::LEAD`).
const LEAD: f64 = 12.5e-6;

/// The sample of 10 kHz and slower ones keep this share free.
const MAX_SHARE: f64 = 0.5;
const FASTEST_WITH_A_SHARE: f64 = 1e4;

/// Samples running that drive nothing, after which a commissioning is over.
const AT_REST: usize = 100;

/// Time of the host between two looks at what the emulator has run.
const LISTEN: Duration = Duration::from_millis(100);

/// Instructions of the samples of a commissioning that drive the output, and of those before and after.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct DrivenSamples {
    /// Cost of the whole interrupt, and of the part until the command is out.
    whole: Vec<u64>,
    command: Vec<u64>,
    /// Cost of an interrupt that drives nothing.
    at_rest: Vec<u64>,
}

/// Median instructions until the command is out, by name. Also the upper bounds for half of all interrupts, for nine in
/// ten and for all of them, and for all that drive nothing.
///
/// # Errors
/// Also where a command comes too late.
pub(crate) fn figures(metered: &Metered) -> Result<Vec<(String, u64)>, String> {
    let measured = RATES.map(|rate| Ok((rate, measure(rate, metered)?)));
    let counted = measured.into_iter().collect::<Result<Vec<_>, String>>()?;
    let objections: Vec<String> = (counted.iter())
        .flat_map(|(rate, driven)| driven.objections(*rate))
        .collect();
    if !objections.is_empty() {
        return Err(objections.join("\n  "));
    }
    let named = counted.iter().flat_map(|(rate, driven)| {
        let name = |what| format!("interrupt-commission-{}-khz-{what}", rate / 1e3);
        [
            (name("command"), share(&driven.command, 0.5)),
            (name("typical"), share(&driven.whole, 0.5)),
            (name("ninetieth"), share(&driven.whole, 0.9)),
            (name("worst"), share(&driven.whole, 1.0)),
        ]
    });
    let at_rest = counted
        .iter()
        .map(|(_, driven)| share(&driven.at_rest, 1.0));
    let at_rest = at_rest
        .max()
        .map(|most| ("interrupt-at-rest-worst".to_owned(), most));
    Ok(named.chain(at_rest).collect())
}

impl DrivenSamples {
    /// The limits that were exceeded.
    fn objections(&self, rate: f64) -> Vec<String> {
        let at = format!("at {} kHz", rate / 1e3);
        let lead = instructions_in(LEAD);
        let late = self.command.iter().filter(|&&taken| taken > lead).count();
        let most = share(&self.whole, 1.0);
        let share_allowed = if rate <= FASTEST_WITH_A_SHARE {
            MAX_SHARE
        } else {
            1.0
        };
        let allowed = instructions_in(share_allowed / rate);
        let too_late = (late > 0).then(|| {
            format!(
                "{at} {late} of {} commands take more than the {lead} instructions before the PWM period, {} at most",
                self.command.len(),
                share(&self.command, 1.0)
            )
        });
        let too_long = (most > allowed).then(|| {
            format!("{at} an interrupt takes {most} instructions, of which {allowed} are allowed")
        });
        let nothing = self
            .command
            .is_empty()
            .then(|| format!("{at} no sample has driven the output"));
        too_late
            .into_iter()
            .chain(too_long)
            .chain(nothing)
            .collect()
    }
}

/// Commissions at a rate, Hz.
fn measure(rate: f64, metered: &Metered) -> Result<DrivenSamples, String> {
    let mut driven = DrivenSamples::default();
    let mut at_rest = 0;
    let (is_over, is_heard) = (AtomicBool::new(false), AtomicBool::new(false));
    let take = |cost: Cost| {
        let Some(command) = cost.command else {
            at_rest += 1;
            driven.at_rest.push(cost.instructions);
            if !driven.command.is_empty() && at_rest >= AT_REST {
                is_over.store(true, Relaxed);
            }
            return Ok(if is_heard.load(Relaxed) {
                Next::Enough
            } else {
                Next::Interrupt
            });
        };
        at_rest = 0;
        driven.command.push(command);
        driven.whole.push(cost.instructions);
        Ok(Next::Interrupt)
    };
    let commissioned = |client: &mut Driven| {
        let ended = commission(client, 1.0 / rate, &is_over);
        is_heard.store(true, Relaxed);
        ended
    };
    metered::run(metered, &[], commissioned, take)?;
    Ok(driven)
}

/// Commissions a drive at a sample time, s, to its end, which must be new gains. Until it is over there are no
/// requests. An answer would take its time in the background, and the study would then get it later, by the host's
/// clock.
fn commission(
    drive: &mut Driven,
    sample_time: f64,
    is_over: &AtomicBool,
) -> Result<(), Box<dyn Error>> {
    let mut settings = drive.settings()?;
    let core = &mut settings.closed_loop.core;
    (core.controller, core.sample_time) = (None, sample_time);
    let resolution = core.resolution;
    // The emulator's time is not the host's.
    settings.protection.link_timeout = 0.0;
    drive.ask(Command::Configure(settings))?;
    drive.commission(&CommissionSettings::new(
        sample_time,
        resolution,
        Limits::new([-1.5, 1.5], 40.0, [-10.0, 10.0]),
    ))?;
    let begun = Instant::now();
    while !is_over.load(Relaxed) {
        if begun.elapsed() > TIME_LIMIT {
            return Err("the commissioning does not end".into());
        }
        // Its reports must be read, or it has no room for more.
        drive.port().listen(&|_: &Report| false, LISTEN)?;
    }
    let ended = drive.outcome()?.commissioning;
    if ended.phase == Phase::Applied {
        Ok(())
    } else {
        Err(format!("the commissioning ends with {ended:?}").into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_prediction_has_its_rejection_reason() {
        let driven = |command: u64, whole: u64| DrivenSamples {
            command: vec![100, command],
            whole: vec![200, whole],
            at_rest: Vec::new(),
        };
        assert!(driven(954, 3818).objections(1e4).is_empty());
        assert!(driven(954, 3818).objections(2e4).is_empty());
        assert_eq!(driven(955, 3818).objections(1e4).len(), 1);
        assert_eq!(driven(954, 3819).objections(1e4).len(), 1);
        assert_eq!(driven(955, 3819).objections(2e4).len(), 2);
        assert_eq!(DrivenSamples::default().objections(1e3).len(), 1);
    }

    #[test]
    fn shares_are_those_of_the_sorted_figures() {
        let counted: Vec<u64> = (0..=100).rev().collect();
        assert_eq!(
            [0.0, 0.5, 0.9, 1.0].map(|part| share(&counted, part)),
            [0, 50, 90, 100]
        );
        assert_eq!(share(&[], 0.5), 0);
    }
}
