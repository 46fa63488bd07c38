//! Instructions of a commissioning on a simulated servo, for a sample by its phase and for a slice of the solver.

use core::hint::black_box;

use commissioning::{
    CommissionError, CommissionInputs, CommissionIsr, CommissionSettings, CommissionSolver,
    CommissionState, Limits, Phase,
};
use firmware_stm32::host::{Text, print};
use firmware_stm32::instructions::{Counter as Instructions, Tally};
use firmware_stm32::measured::counted;
use firmware_stm32::paper;
use virtual_servo::{Encoder, Plant};

/// The fastest that a drive is asked to commission at, s.
const SAMPLE_TIME: f64 = 1e-4;

/// Friction, rad/s².
const COULOMB: f64 = 5.0;

/// Instructions that a slice of the solver should not exceed, and that one without work does not.
const LONG: u32 = 20_000;
const IDLE: u32 = 100;

/// Samples within which it is over.
const PATIENCE: u32 = 200_000;

pub(crate) fn run() -> Result<(), &'static str> {
    match commission(&Instructions::start()) {
        Ok(Phase::Applied) => Ok(()),
        Ok(phase) => Err(phase.name()),
        Err(_) => Err("it was refused"),
    }
}

fn settings() -> CommissionSettings {
    CommissionSettings::new(
        SAMPLE_TIME,
        paper::settings().resolution,
        Limits::new([-1.5, 1.5], 40.0, [-10.0, 10.0]),
    )
}

/// Commissions, one sample and the slices that go with it after the other.
fn commission(instructions: &Instructions) -> Result<Phase, CommissionError> {
    let settings = settings();
    let interrupt = CommissionIsr::<f32>::new(&settings, None)?;
    let mut solver = CommissionSolver::<f32>::new(&settings)?;
    let mut state = interrupt.start(0, None);
    let mut plant = Plant::at_rest(&paper::parameters(COULOMB), SAMPLE_TIME);
    let (_, encoder): (_, Encoder) = paper::servo();
    let mut samples = Phase::ALL.map(|phase| (phase, Tally::default()));
    let (mut slices, mut working, mut long) = (Tally::default(), 0, 0);
    let mut add = |taken: u32| {
        slices.add(taken);
        working += u32::from(taken > IDLE);
        long += u32::from(taken > LONG);
    };
    let mut decision = None;
    for _ in 0..PATIENCE {
        let inputs = black_box(CommissionInputs {
            count: Some(encoder.read(plant.position) as i32),
            late: false,
            stop: None,
        });
        // A decision since the last sample is taken over in this one.
        let (step, taken) = counted(instructions, || {
            if let Some(decision) = &decision {
                interrupt.accept(&mut state, decision);
            }
            interrupt.process(&mut state, &inputs)
        });
        decision = None;
        if let Some((_, tally)) = samples.iter_mut().find(|(phase, _)| *phase == step.phase) {
            tally.add(taken);
        }
        if step.phase.is_end() {
            break;
        }
        if let Some(finding) = &step.finding {
            let ((), taken) = counted(instructions, || solver.take(finding));
            add(taken);
        }
        for _ in 0..interrupt.slices() {
            let (decided, taken) = counted(instructions, || solver.work());
            add(taken);
            decision = decided.or(decision);
        }
        plant.advance(f64::from(step.command.unwrap_or(0.0)));
    }
    let phase = state.phase();
    let bytes = size_of::<CommissionState<f32>>();
    for (phase, tally) in samples {
        if tally.rounds() > 0 {
            tally.print(phase.name(), bytes);
        }
    }
    slices.print("slice", size_of::<CommissionSolver<f32>>());
    for (name, slices) in [("slices-working", working), ("slices-long", long)] {
        print(&["count", name, Text::whole(slices).as_str()]);
    }
    Ok(phase)
}
