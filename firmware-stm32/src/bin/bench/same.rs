//! The paper's experiment on the chip, the servo simulated beside the loop. It prints the bits of the final estimates, which are
//! those of the simulator on a PC.

use firmware_stm32::host::{Text, print};
use firmware_stm32::instructions::Counter as Instructions;
use firmware_stm32::measured::{Experiment, Gradient, Single, Words};
use firmware_stm32::paper;
use identifier_core::identifier::Identify;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::SettingsError;

pub(crate) fn run() -> Result<(), &'static str> {
    let done = single_precision().and_then(|()| fixed_point());
    done.map_err(|_| "the experiment could not be built")
}

fn report(format: &str, found: &ServoParameters) {
    let [a, b, load] = [found.a, found.b, found.load].map(Text::bits);
    print(&[format, a.as_str(), b.as_str(), load.as_str()]);
}

fn single_precision() -> Result<(), SettingsError> {
    let mut parts = Single::<Gradient>::build(&paper::settings())?;
    // The simulator's reference is a fraction of the first count, not of the nearest.
    let mut sample = |reference, register| {
        let command = parts.sample(0, reference as f32, register);
        (f64::from(command), 0)
    };
    Experiment::start(0.0)?.count(paper::samples(), &mut sample);
    let identifier = parts.servo_loop.identifier();
    let snapshot = identifier.snapshot(parts.state.identification());
    report("f32", &identifier.estimates_in(&snapshot));
    Ok(())
}

fn fixed_point() -> Result<(), SettingsError> {
    let instructions = Instructions::start();
    let mut parts = Words::build(&paper::settings())?;
    let mut sample =
        |reference, register| parts.counted(&instructions, (reference, register), false);
    Experiment::start(0.0)?.count(paper::samples(), &mut sample);
    let identifier = parts.servo_loop.identifier();
    let snapshot = identifier.snapshot(parts.state.identification());
    report("fixed", &identifier.estimates_in(&snapshot));
    Ok(())
}
