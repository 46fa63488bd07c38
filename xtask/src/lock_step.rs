//! The loop on the chip and the plant on the PC against both on the PC: the same bits.

use host_sim::experiment::{self, Sample};
use host_sim::pil;
use host_sim::scenario::{Arithmetic, Purpose, Scenario};

use crate::{emulator, firmware};

/// What is run: the scenario, what it is computed in, and for how long, s. The emulator takes about
/// one and a half times as long.
const CASES: [(&str, Arithmetic, f64); 4] = [
    ("host-sim/scenarios/paper.toml", Arithmetic::F32, 60.0),
    ("host-sim/scenarios/paper.toml", Arithmetic::Fixed, 10.0),
    ("host-sim/scenarios/drift.toml", Arithmetic::F32, 10.0),
    ("host-sim/scenarios/friction.toml", Arithmetic::F32, 10.0),
];

/// Runs every case both ways and compares every sample.
pub(crate) fn check() -> Result<(), String> {
    firmware::build(&["emulator"])?;
    let (_running, mut port) = emulator::Running::start(&firmware::path("pil"))?;
    for (file, arithmetic, duration) in CASES {
        let mut scenario = Scenario::load(&firmware::root().join(file), Purpose::Run)
            .map_err(|error| error.to_string())?;
        scenario.identifier.arithmetic = arithmetic;
        scenario.duration = duration;
        let mut expected: Vec<Sample> = Vec::new();
        experiment::run(&scenario, &mut |sample| {
            expected.push(Sample {
                // The chip tells no standard errors.
                standard_errors: None,
                ..*sample
            });
        });
        let mut differing = None;
        let mut count = 0;
        pil::run(&scenario, &mut port, &mut |sample| {
            if differing.is_none() && expected.get(count) != Some(sample) {
                differing = Some((expected.get(count).copied(), *sample));
            }
            count += 1;
        })
        .map_err(|error| error.to_string())?;
        let name = arithmetic.name();
        if let Some((expected, found)) = differing {
            return Err(format!(
                "{file} in {name}: the loop on the chip first differs with\n  {found:?}\nfrom\n  \
                 {expected:?}"
            ));
        }
        println!("{file} in {name}: {count} samples on the chip are the simulator's, bit for bit");
    }
    Ok(())
}
