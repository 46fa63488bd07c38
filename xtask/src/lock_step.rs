//! The loop on the chip and the plant on the PC against both on the PC: the same bits.

use std::fmt::{Debug, Display};
use std::thread;

use host_sim::experiment::Sample;
use host_sim::pil;
use host_sim::scenario::{Arithmetic, Purpose, Scenario};
use host_sim::simulate;

use crate::{emulator, firmware};

/// The scenario, what it is computed in, and for how long, s.
type Case = (&'static str, Arithmetic, f64);

/// What is run, one case after the other on a chip of each row. The emulator takes about one and a half
/// times as long as the chip.
const CHIPS: [&[Case]; 2] = [
    &[("host-sim/scenarios/paper.toml", Arithmetic::F32, 20.0)],
    &[
        ("host-sim/scenarios/paper.toml", Arithmetic::Fixed, 10.0),
        ("host-sim/scenarios/drift.toml", Arithmetic::F32, 10.0),
        ("host-sim/scenarios/friction.toml", Arithmetic::F32, 10.0),
    ],
];

/// Runs every case both ways and compares every sample.
pub(crate) fn check() -> Result<(), String> {
    firmware::build(&["pil"], &["emulator"])?;
    thread::scope(|scope| {
        let chips = CHIPS.map(|cases| scope.spawn(|| check_on_a_chip(cases)));
        let commissioned = scope.spawn(check_commissioning);
        chips
            .into_iter()
            .chain([commissioned])
            .try_for_each(|chip| {
                chip.join()
                    .map_err(|_| "comparing the samples has failed".to_owned())?
            })
    })
}

/// Commissions both ways and compares every sample and what it came to.
fn check_commissioning() -> Result<(), String> {
    let file = "host-sim/scenarios/commission.toml";
    let fault = |error: &dyn Display| format!("{file}: {error}");
    let mut scenario = Scenario::load(&firmware::root().join(file), Purpose::Commission)
        .map_err(|error| fault(&error))?;
    scenario.identifier.arithmetic = Arithmetic::F32;
    let begun = || pil::commissioning(&scenario).map_err(|error| fault(&error));
    let mut expected = Vec::new();
    let outcome = begun()?
        .run(&mut |sample| expected.push(*sample))
        .map_err(|error| fault(&error))?;
    let (_running, mut port) = emulator::Running::start(&firmware::path("pil"))?;
    let mut found = Vec::with_capacity(expected.len());
    let there = pil::commission(begun()?, &mut port, &mut |sample| found.push(*sample))
        .map_err(|error| fault(&error))?;
    same(&expected, &found).map_err(|error| fault(&error))?;
    same(&[&outcome], &[&there]).map_err(|error| fault(&error))?;
    if !outcome.is_applied() {
        return Err(fault(&"no gains were applied, so not all was compared"));
    }
    println!(
        "{file}: a commissioning of {} samples on the chip is the simulator's, bit for bit",
        found.len()
    );
    Ok(())
}

fn check_on_a_chip(cases: &[Case]) -> Result<(), String> {
    let (_running, mut port) = emulator::Running::start(&firmware::path("pil"))?;
    for &(file, arithmetic, duration) in cases {
        let mut scenario = Scenario::load(&firmware::root().join(file), Purpose::Run)
            .map_err(|error| error.to_string())?;
        scenario.identifier.arithmetic = arithmetic;
        scenario.duration = duration;
        let mut expected: Vec<Sample> = Vec::new();
        simulate::run(&scenario, &mut |sample| {
            expected.push(*sample);
        })
        .map_err(|error| format!("{file}: {error}"))?;
        let mut found = Vec::with_capacity(expected.len());
        pil::run(&scenario, &mut port, &mut |sample| found.push(*sample))
            .map_err(|error| error.to_string())?;
        let name = arithmetic.name();
        same(&expected, &found).map_err(|error| format!("{file} in {name}: {error}"))?;
        println!(
            "{file} in {name}: {} samples on the chip are the simulator's, bit for bit",
            found.len()
        );
    }
    Ok(())
}

/// An error if the chip's samples are not the simulator's, all of them, or if there are none.
fn same<S: PartialEq + Debug>(expected: &[S], found: &[S]) -> Result<(), String> {
    if expected.is_empty() {
        return Err("the simulator ran no sample, so nothing was compared".to_owned());
    }
    if let Some((expected, found)) = expected.iter().zip(found).find(|(e, f)| e != f) {
        return Err(format!(
            "the loop on the chip first differs with\n  {found:?}\nfrom\n  {expected:?}"
        ));
    }
    if expected.len() == found.len() {
        Ok(())
    } else {
        Err(format!(
            "the simulator ran {} samples and the chip {}",
            expected.len(),
            found.len()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_samples_are_the_same() {
        assert_eq!(same(&[1.0, 2.0], &[1.0, 2.0]), Ok(()));
    }

    #[test]
    fn no_samples_are_not_the_same() {
        assert!(same::<f64>(&[], &[]).is_err());
        assert!(same(&[], &[1.0]).is_err());
        assert!(same(&[1.0], &[]).is_err());
    }

    #[test]
    fn a_sample_too_many_or_too_few_or_another_is_noticed() {
        assert!(same(&[1.0, 2.0], &[1.0]).is_err());
        assert!(same(&[1.0], &[1.0, 2.0]).is_err());
        let fault = same(&[1.0, 2.0, 3.0], &[1.0, 2.5, 3.5]).expect_err("the second differs");
        assert!(fault.contains("2.5") && !fault.contains("3.5"), "{fault}");
    }
}
