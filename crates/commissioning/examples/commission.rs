//! A commissioning in your own firmware: the interrupt's half and the background's half, with a queue in each
//! direction. Then your own loop runs with the new gains, continues the identification and detects faults.
//!
//! ```sh
//! cargo run -p commissioning --example commission
//! ```

use core::f64::consts::TAU;

use commissioning::watch::{
    KnownServo, Observation, ServoWatch, ServoWatchState, Use, WatchSettings,
};
use commissioning::{
    CommissionInputs, CommissionIsr, CommissionSettings, CommissionSolver, CommissionState,
    Decision, Limits, Phase, RecordEvent,
};
use heapless::spsc::{Consumer, Producer, Queue};
use identifier_core::Settings;
use identifier_core::control::{Shaped, ShapedState};
use identifier_core::identifier::{
    ExpectedMotion, GaussNewtonRecursion, Identify, ServoLoop, ServoLoopState,
};
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::parameters::Unknowns;
use identifier_core::settings::ControllerSettings;

const SAMPLE_TIME: f64 = 1e-3;
const COUNTS_PER_REV: f64 = 10_000.0;
const COMMAND: [f64; 2] = [-10.0, 10.0];

const SETTINGS: CommissionSettings = CommissionSettings::new(
    SAMPLE_TIME,
    TAU / COUNTS_PER_REV,
    Limits::new([-0.3, 0.3], 15.0, COMMAND),
);

type Recursion = GaussNewtonRecursion<f32, Unknowns<4>, 4>;
type Loop = ServoLoop<f32, LowPass<f32>, Recursion, Shaped<f32>>;
type LoopState = ServoLoopState<
    f32,
    <LowPass<f32> as VelocityEstimate<f32>>::State,
    <Recursion as Identify<f32>>::State,
    ShapedState<f32>,
>;

/// The sample interrupt's half of the commissioning.
struct Interrupt<'a> {
    commission: CommissionIsr<f32>,
    state: CommissionState<f32>,
    records: Producer<'a, RecordEvent<f32>, 64>,
    decisions: Consumer<'a, Decision<f32>, 4>,
}

impl Interrupt<'_> {
    /// One sample: the command for the output stage; none: disable it.
    fn sample(&mut self, count: i32) -> Option<f32> {
        while let Some(decision) = self.decisions.dequeue() {
            self.commission.accept(&mut self.state, &decision);
        }
        let inputs = CommissionInputs {
            count: Some(count),
            late: false,
            stop: None,
        };
        // On a chip this command goes to the stage at once, and `learn` runs while it acts.
        self.commission.control(&mut self.state, &inputs);
        let step = self.commission.learn(&mut self.state);
        if let Some(record) = step.finding {
            // A record that is lost fails the motion, which the solver sees.
            let _ = self.records.enqueue(record);
        }
        step.command
    }
}

/// The main loop's half.
struct Background<'a> {
    solver: CommissionSolver<f32>,
    records: Consumer<'a, RecordEvent<f32>, 64>,
    decisions: Producer<'a, Decision<f32>, 4>,
}

impl Background<'_> {
    /// One turn of the main loop: a bounded slice of work.
    fn turn(&mut self) {
        while let Some(record) = self.records.dequeue() {
            self.solver.take(&record);
        }
        if let Some(decision) = self.solver.work() {
            // The interrupt takes one before the next can be there.
            let _ = self.decisions.enqueue(decision);
        }
    }
}

/// The loop after the commissioning: PID, identifier and watch.
struct Running {
    servo_loop: Loop,
    state: LoopState,
    watch: ServoWatch<f32>,
    watched: ServoWatchState<f32>,
    /// Where the commissioning began, and the setpoint, counts.
    origin: i32,
    setpoint: i32,
    /// The command that acts.
    command: f32,
}

impl Running {
    /// Takes over in the sample after the last one of a commissioning that was applied, without a bump of the command.
    /// All but the last sample is known as soon as the trial begins, and can be prepared in the background.
    fn take_over(commission: &CommissionState<f32>, origin: i32, count: i32) -> Self {
        let tuning = commission.tuning().expect("it was applied");
        let servo = commission.servo().expect("it was applied");
        let last = commission.last_sample().expect("the gains hold the servo");

        let servo_loop: Loop = Settings {
            cutoff: tuning.cutoff,
            controller: Some(ControllerSettings::tuned(tuning, COMMAND)),
            ..Settings::new(SAMPLE_TIME, COUNTS_PER_REV)
        }
        .build()
        .expect("the trial ran with them");
        let mut state = servo_loop.start(count);
        servo_loop.take_over(&mut state, count, &last);
        *state.identification_mut() = servo_loop.identifier().start_from_known(
            servo,
            &ExpectedMotion {
                bandwidth: tuning.bandwidth,
                command: tuning.kp * tuning.predicted_response.step,
            },
        );

        let Limits {
            travel,
            speed,
            command,
            ..
        } = SETTINGS.limits;
        let settings = WatchSettings {
            sample_time: SAMPLE_TIME,
            resolution: SETTINGS.resolution,
            travel,
            speed,
            command,
            used_for: Use::Operation,
        };
        let watch = ServoWatch::new(&settings).expect("the commissioning ran with them");
        let mut watched = watch.start();
        if let Some(known) = KnownServo::from_identified(&settings, servo) {
            watch.know(&mut watched, &known);
        }
        Self {
            servo_loop,
            state,
            watch,
            watched,
            origin,
            setpoint: count + last.error as i32,
            command: last.command,
        }
    }

    /// One sample: the command for the output stage; none: disable it.
    fn sample(&mut self, count: i32) -> Option<f32> {
        let acted = self.command;
        let sample = self
            .servo_loop
            .control(&mut self.state, self.setpoint, 0.0, count)
            .ok()?;
        self.command = sample.command;
        // On a chip the command goes to the stage here.
        self.servo_loop.learn(&mut self.state, &sample);
        let seen = Observation {
            increment: Some(sample.increment),
            command: acted,
            position: (count - self.origin) as f32,
            setpoint: Some((self.setpoint - self.origin) as f32),
            late: false,
            must_move: false,
            excited: false,
        };
        match self.watch.process(&mut self.watched, &seen) {
            Ok(()) => Some(self.command),
            Err(fault) => {
                eprintln!("disabled: {fault:?}");
                None
            }
        }
    }
}

/// The axis: q̈ = −a q̇ + b u − c sign(q̇), with an encoder.
struct Axis {
    position: f64,
    velocity: f64,
}

impl Axis {
    const A: f64 = 0.22;
    const B: f64 = 258.0;
    const COULOMB: f64 = 12.0;

    fn count(&self) -> i32 {
        (self.position / TAU * COUNTS_PER_REV).floor() as i32
    }

    fn advance(&mut self, command: f32) {
        const STEPS: u32 = 10;
        let time = SAMPLE_TIME / f64::from(STEPS);
        for _ in 0..STEPS {
            let driven =
                self.velocity + time * (Self::B * f64::from(command) - Self::A * self.velocity);
            self.velocity = driven.signum() * (driven.abs() - time * Self::COULOMB).max(0.0);
            self.position += time * self.velocity;
        }
    }
}

fn main() {
    let (mut records, mut decisions) = (Queue::new(), Queue::new());
    let (record_in, record_out) = records.split();
    let (decision_in, decision_out) = decisions.split();
    let mut axis = Axis {
        position: 0.0,
        velocity: 0.0,
    };

    let commission = CommissionIsr::new(&SETTINGS, None).expect("limits that can be kept");
    println!("largest motion: {:?}", commission.largest_motion());
    let slices = commission.slices();
    let mut interrupt = Interrupt {
        state: commission.start(axis.count(), None),
        commission,
        records: record_in,
        decisions: decision_out,
    };
    let mut background = Background {
        solver: CommissionSolver::new(&SETTINGS).expect("limits that can be kept"),
        records: record_out,
        decisions: decision_in,
    };
    let origin = axis.count();
    let mut count = origin;
    while !interrupt.state.phase().is_end() {
        count = axis.count();
        let command = interrupt.sample(count);
        (0..slices).for_each(|_| background.turn());
        axis.advance(command.unwrap_or(0.0));
    }
    let state = &interrupt.state;
    assert_eq!(state.phase(), Phase::Applied, "{:?}", state.reason());

    let mut running = Running::take_over(state, origin, count);
    running.setpoint += 100;
    for _ in 0..1000 {
        count = axis.count();
        axis.advance(running.sample(count).expect("no fault"));
    }
    let identifier = running.servo_loop.identifier();
    let learnt = identifier
        .estimates(running.state.identification())
        .expect("estimates");
    println!("gains: {:?}", state.tuning());
    println!(
        "at {count} of {} counts; estimates: {learnt:?}",
        running.setpoint
    );
    assert!((running.setpoint - count).abs() <= 2);
    assert!((learnt.b / Axis::B - 1.0).abs() < 0.01);

    // The encoder's cable breaks: its count stays, and the watch has the stage disabled.
    running.setpoint += 100;
    let noticed = (1..100).find(|_| running.sample(count).is_none());
    println!("disabled {noticed:?} samples after the encoder stopped");
    assert!(noticed.is_some());
}
