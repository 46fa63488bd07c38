//! Many random servos under one scenario.

mod draw;

pub use draw::draw;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use identifier_core::parameters::ServoParameters;
use rayon::prelude::*;

use crate::analysis::Summariser;
use crate::result::SweepRun;
use crate::scenario::{Fault, Scenario};
use crate::{identify_run, simulate};

/// Runs the random servos of some numbers on all cores, in the order of their numbers for any number of threads. A
/// servo is the same in any range. Each completed one calls `done`. Once `stop` is set no further one begins, and the
/// result contains the completed ones.
///
/// # Errors
/// The key that a servo's scenario cannot be built from.
pub fn sweep(
    base: &Scenario,
    numbers: Range<u32>,
    seed: u32,
    stop: &AtomicBool,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<SweepRun>, Fault> {
    let base = base.clone().with_gamma_chosen();
    let results: Result<Vec<Option<SweepRun>>, Fault> = numbers
        .into_par_iter()
        .map(|index| {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let run = run(&draw(&base, seed, index), index)?;
            done();
            Ok(Some(run))
        })
        .collect();
    Ok(results?.into_iter().flatten().collect())
}

fn run(scenario: &Scenario, index: u32) -> Result<SweepRun, Fault> {
    let truth = scenario.servo()?;
    let summary = if scenario.identifier.law.takes_whole_record() {
        identify_run(scenario.clone(), &|| true, &mut |_, _| {})?.summary
    } else {
        let mut summariser = Summariser::brief(scenario);
        let outcome = simulate::run(scenario, &mut |sample| summariser.add(sample))?;
        summariser.finish(scenario, outcome)
    };
    Ok(SweepRun {
        index,
        truth,
        status: summary.status(),
        found: ServoParameters::from_fn(|parameter| {
            let estimate = summary.estimate(parameter);
            estimate.map_or(f64::NAN, |estimate| estimate.value)
        }),
        settling_a: summary.settling_time.a,
        settling_b: summary.settling_time.b,
    })
}
