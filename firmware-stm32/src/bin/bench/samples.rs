//! Instructions per whole sample (on the chip: cycles), per estimator and number format. A sample goes from the
//! register of the encoder's counter, with a setpoint and an offset, to the command and the estimates. The instructions
//! of building the loops of a parameter range are counted too. Their stability is proved before the first sample.

use core::hint::black_box;

use firmware_stm32::instructions::{Counter as Instructions, Tally};
use firmware_stm32::measured::{
    COULOMB, COUNTED, Experiment, Fixed, GaussNewton, Gradient, Halves, Loop, Pid, STARTING,
    Single, Words, counted, measure, on_both, split,
};
use firmware_stm32::paper;
use identifier_core::Settings;
use identifier_core::identifier::{
    GaussNewtonFitted, GaussNewtonFitterState, GradientIdentifier, Identify,
};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{ServoParameters, Unknowns};
use identifier_core::settings::{
    FromSettings, IdentifierSettings, ParameterRangeSettings, SettingsError,
};

type GradientWithFriction = GradientIdentifier<f32, LowPass<f32>, Unknowns<3>, 3>;

pub(crate) fn run() -> Result<(), &'static str> {
    laws(&Instructions::start()).map_err(|_| "an estimator could not be built")
}

fn laws(instructions: &Instructions) -> Result<(), SettingsError> {
    pid(instructions)?;
    single::<Gradient>(instructions, "gradient-f32-2")?;
    single::<GradientWithFriction>(instructions, "gradient-f32-friction")?;
    gauss_newton(instructions)?;
    words(instructions)?;
    builds(instructions)
}

/// As [`measure`], in which every second sample is one call of the loop, and the others are two: a firmware that uses a
/// loop twice may lose what is inlined once.
fn measure_both(
    coulomb: f64,
    mut sample: impl FnMut((f64, u16), bool) -> (f64, u32),
) -> Result<Tally, SettingsError> {
    let mut at_once = false;
    measure(coulomb, |reference, register| {
        at_once = !at_once;
        sample((reference, register), at_once)
    })
}

fn pid(instructions: &Instructions) -> Result<(), SettingsError> {
    let mut bytes = 0;
    let tally = on_both([0.0, COULOMB], |coulomb| {
        let mut pid = Pid::build(&paper::settings())?;
        bytes = size_of_val(&pid.state);
        measure_both(coulomb, |given, at_once| {
            let (setpoint, offset, register) = black_box(split(given));
            let (command, taken) = if at_once {
                counted(instructions, || pid.sample(setpoint, offset, register))
            } else {
                let ((command, _), taken) =
                    counted(instructions, || pid.shown(setpoint, offset, register));
                (command, taken)
            };
            (f64::from(command), taken)
        })
    })?;
    tally.print("pid-f32", bytes);
    Ok(())
}

fn single<I: Identify<f32> + FromSettings>(
    instructions: &Instructions,
    name: &str,
) -> Result<(), SettingsError> {
    let tally = on_both([0.0, COULOMB], |coulomb| {
        let mut parts = Single::<I>::build(&paper::settings())?;
        measure_both(coulomb, |given, at_once| match at_once {
            true => parts.counted(instructions, given, Single::whole),
            false => parts.counted(instructions, given, Single::sample),
        })
    })?;
    tally.print(name, size_of::<I::State>());
    Ok(())
}

/// Gauss–Newton on a servo with friction, and its longest sample on that and one without.
fn gauss_newton(instructions: &Instructions) -> Result<(), SettingsError> {
    let without = Course::run(instructions, 0.0)?.running;
    let Course {
        halves,
        recording,
        beginning,
        fitting,
        mut running,
    } = Course::run(instructions, COULOMB)?;
    running.take_max(&without);
    let state = size_of::<<GaussNewton<Unknowns<4>, 4> as Identify<f32>>::State>();
    recording.print("gauss-newton-recording", state);
    beginning.print(
        "gauss-newton-beginning",
        size_of::<GaussNewtonFitted<f32>>(),
    );
    fitting.print(
        "gauss-newton-fitting",
        size_of::<GaussNewtonFitterState<f32, 64>>(),
    );
    running.print("gauss-newton-f32-4", state);
    // The report of a sample that is shown.
    let interrupt = &halves.interrupt;
    let identifier = interrupt.servo_loop.identifier();
    let state = interrupt.state.identification();
    let (shown, taken) = counted(instructions, || identifier.snapshot(black_box(state)));
    once("gauss-newton-shown", taken, size_of_val(&shown));
    let (_, taken) = counted(instructions, || identifier.estimates_in(black_box(&shown)));
    once("gauss-newton-in-si", taken, size_of::<ServoParameters>());
    Ok(())
}

/// Gauss–Newton without any guess. Its samples are those that it records, the one that takes over the first fit, and
/// those of the recursion. In each recorded one the background takes a block of its first fit.
struct Course {
    halves: Halves<Unknowns<4>, 4>,
    recording: Tally,
    beginning: Tally,
    fitting: Tally,
    running: Tally,
}

impl Course {
    /// On a servo with some friction, rad/s².
    fn run(instructions: &Instructions, coulomb: f64) -> Result<Self, SettingsError> {
        /// Samples within which a first fit is found.
        const PATIENCE: u32 = 60_000;
        let settings = Settings {
            identifier: IdentifierSettings::UNSTATED,
            ..paper::settings()
        };
        let mut halves = Halves::<Unknowns<4>, 4>::build(&settings)?;
        let mut experiment = Experiment::start(coulomb)?;
        let (mut recording, mut fitting) = (Tally::default(), Tally::default());
        let mut beginning = Tally::default();
        while !halves.is_running() {
            if recording.rounds() == PATIENCE {
                return Err(SettingsError::NotGiven { setting: "motion" });
            }
            let one = experiment.count(1, &mut |reference, register| {
                halves.counted(instructions, (reference, register), &mut fitting)
            });
            let tally = if halves.is_running() {
                &mut beginning
            } else {
                &mut recording
            };
            tally.add(one.total());
        }
        let mut idle = Tally::default();
        let mut sample =
            |reference, register| halves.counted(instructions, (reference, register), &mut idle);
        experiment.count(STARTING, &mut sample);
        let running = experiment.count(COUNTED, &mut sample);
        Ok(Self {
            halves,
            recording,
            beginning,
            fitting,
            running,
        })
    }
}

/// Prints a figure that was counted once.
fn once(name: &str, taken: u32, bytes: usize) {
    let mut tally = Tally::default();
    tally.add(taken);
    tally.print(name, bytes);
}

fn words(instructions: &Instructions) -> Result<(), SettingsError> {
    let mut bytes = 0;
    let tally = on_both([0.0, COULOMB], |coulomb| {
        let mut parts = Words::build(&paper::settings())?;
        bytes = size_of_val(parts.state.identification());
        measure_both(coulomb, |given, at_once| {
            parts.counted(instructions, given, at_once)
        })
    })?;
    tally.print("gradient-fixed-2", bytes);
    Ok(())
}

/// Building the gradient's loops: the paper's, and those of three wide parameter ranges from 250 Hz to 20 kHz, whose
/// estimates have no bounds.
fn builds(instructions: &Instructions) -> Result<(), SettingsError> {
    let mut tally = Tally::default();
    for settings in [
        paper::settings(),
        boxed(4e-3, [0.0, 20.0], [30.0, 300.0]),
        boxed(2.5e-4, [0.0, 100.0], [20.0, 2000.0]),
        boxed(5e-5, [0.0, 10.0], [10.0, 10_000.0]),
    ] {
        build::<Loop<Gradient>>(instructions, &settings, &mut tally)?;
        build::<Loop<GradientWithFriction>>(instructions, &settings, &mut tally)?;
        build::<Fixed>(instructions, &settings, &mut tally)?;
    }
    tally.print("gradient-build", size_of::<Loop<GradientWithFriction>>());
    Ok(())
}

fn build<L: FromSettings>(
    instructions: &Instructions,
    settings: &Settings,
    tally: &mut Tally,
) -> Result<(), SettingsError> {
    let (built, taken) = counted(instructions, || black_box(settings).build::<L>());
    tally.add(taken);
    built.map(|_| ())
}

/// The paper's gains and limit at a sample time (s) with a parameter range, a in 1/s and b in rad/s² per command unit.
/// Everything else follows from these.
fn boxed(sample_time: f64, a: [f64; 2], b: [f64; 2]) -> Settings {
    let paper = paper::settings();
    Settings {
        controller: paper.controller,
        identifier: IdentifierSettings {
            parameter_range: Some(ParameterRangeSettings { a, b }),
            gamma: paper.identifier.gamma,
            ..IdentifierSettings::UNSTATED
        },
        resolution: paper.resolution,
        ..Settings::new(sample_time, 1.0)
    }
}
