//! A drive at a TCP port: the firmware's logic in a thread, its servo simulated, its flash in memory. A test can
//! hold the shaft, switch the motor's supply, swap its leads, and cut the drive's power. All of that is timed by
//! the drive's own clock, so that it does not depend on the load of the machine.

use std::net::{Ipv4Addr, TcpListener};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread;
use std::time::Duration;

use drive_link::{Estimator, LoopSettings, Settings};
use drive_logic::{Chip, Lines, OutputStage};
use identifier_core::drive::PositionSensor;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::ControllerSettings;
use servo_id::simulated_drive::{Board, Clock, FlashInMemory, Held, SimulatedPins};
use virtual_servo::{Encoder, Plant};

const SAMPLE_TIME: f64 = 1e-3;
const COUNTS: f64 = 10_000.0;

/// Drive's seconds per second of the test.
const PACE: f64 = 2.0;

/// Largest motion of the axis by a hand in a sample, rad.
const HAND: f64 = 2e-3;

/// Longest real time that a test waits for the drive: the machine may be busy.
const TIMEOUT: Duration = Duration::from_secs(120);

/// The servo of the drive's tests.
pub(crate) const SERVO: ServoParameters = ServoParameters {
    a: 0.2174,
    b: 257.7,
    coulomb: 5.0,
    load: 0.0,
};

/// The settings of a drive that was never configured, for an estimator.
pub(crate) fn built_in(law: Estimator) -> Settings {
    let mut core = identifier_core::Settings {
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..identifier_core::Settings::new(SAMPLE_TIME, COUNTS)
    };
    core.identifier.initial.b = Some(150.0);
    Settings::example(LoopSettings { core, law })
}

/// A hand at the shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Hand {
    Off,
    /// Moves the axis to this position, rad, and holds it against the motor.
    Holds(f64),
}

/// The surroundings of the drive.
#[derive(Debug)]
pub(crate) struct Surroundings {
    pub(crate) hand: Hand,
    pub(crate) supply: bool,
    /// The motor's leads, right (1) or swapped (−1).
    pub(crate) leads: f64,
    pub(crate) power: bool,
    /// Its test is over.
    is_over: bool,
    /// Position of the axis, rad, and the command that is held.
    pub(crate) position: f64,
    pub(crate) held: Option<f32>,
    /// The drive's time, s.
    time: f64,
}

/// The same, shared with the drive's thread.
#[derive(Debug)]
struct Shared {
    around: Mutex<Surroundings>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Surroundings> {
        self.around.lock().expect("no thread panicked")
    }
}

/// A drive with changeable surroundings.
pub(crate) struct SimulatedDrive {
    pub(crate) port: String,
    shared: Arc<Shared>,
}

impl SimulatedDrive {
    /// Switched on, the motor without supply, no hand at the shaft.
    pub(crate) fn start(servo: ServoParameters, example: Settings) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port is free");
        listener.set_nonblocking(true).expect("a socket");
        let port = format!("tcp:{}", listener.local_addr().expect("it has an address"));
        let shared = Arc::new(Shared {
            around: Mutex::new(Surroundings {
                hand: Hand::Off,
                supply: false,
                leads: 1.0,
                power: true,
                is_over: false,
                position: 0.0,
                held: None,
                time: 0.0,
            }),
            changed: Condvar::new(),
        });
        let of_drive = Arc::clone(&shared);
        thread::spawn(move || power_cycles(&listener, &of_drive, &servo, &example));
        Self { port, shared }
    }

    /// Changes the surroundings.
    pub(crate) fn with<T>(&self, change: impl FnOnce(&mut Surroundings) -> T) -> T {
        let changed = change(&mut self.shared.lock());
        self.shared.changed.notify_all();
        changed
    }

    /// Waits until this much of the drive's time has passed, s.
    pub(crate) fn pass(&self, time: f64) {
        let end = self.shared.lock().time + time;
        self.wait_until("its time passes", |around| around.time >= end);
    }

    /// Waits until the drive commands its servo.
    pub(crate) fn wait_until_driven(&self) {
        self.wait_until("it is driven", |around| around.held.is_some());
    }

    /// Switches the drive off and on again.
    pub(crate) fn cycle_power(&self) {
        self.with(|around| (around.power, around.held) = (false, None));
        self.wait_until("it is on again", |around| around.power);
    }

    fn wait_until(&self, what: &str, condition: impl Fn(&Surroundings) -> bool) {
        let (around, waited) = self
            .shared
            .changed
            .wait_timeout_while(self.shared.lock(), TIMEOUT, |around| !condition(around))
            .expect("no thread panicked");
        drop(around);
        assert!(!waited.timed_out(), "waited too long until {what}");
    }
}

/// It would take a core from the other tests.
impl Drop for SimulatedDrive {
    fn drop(&mut self) {
        if let Ok(mut around) = self.shared.around.lock() {
            (around.power, around.is_over) = (false, true);
        }
    }
}

/// Powers the drive up again after each power-off, with its flash unchanged, until its test is over.
fn power_cycles(
    listener: &TcpListener,
    shared: &Shared,
    servo: &ServoParameters,
    example: &Settings,
) {
    let mut flash = FlashInMemory::erased();
    loop {
        let board = Board {
            listener,
            stage: OutputStage {
                full_scale: 10.0,
                period: 5e-5,
                command_delay: 1.25e-5,
                board: "simulated",
                is_simulated: true,
            },
            built_in: example,
            clock: Clock::at_pace(PACE),
        };
        let mut axis = Axis {
            servo: Servo {
                plant: Plant::at_rest(servo, SAMPLE_TIME),
                encoder: Encoder::new(COUNTS),
            },
            stage: Held(None),
            shared,
        };
        let off = board.power_up(&mut flash, None, &mut axis);
        off.expect("nothing is configured");
        if shared.lock().is_over {
            return;
        }
        shared.lock().power = true;
        shared.changed.notify_all();
    }
}

struct Servo {
    plant: Plant,
    encoder: Encoder,
}

struct Axis<'a> {
    servo: Servo,
    stage: Held,
    shared: &'a Shared,
}

impl SimulatedPins for Axis<'_> {
    fn pass(&mut self, sample_time: f64) {
        let mut around = self.shared.lock();
        around.held = self.stage.0;
        let push = around.held.filter(|_| around.supply);
        let push = push.map_or(0.0, |command| around.leads * f64::from(command));
        let plant = &mut self.servo.plant;
        plant.advance(push);
        if let Hand::Holds(position) = around.hand {
            plant.position += (position - plant.position).clamp(-HAND, HAND);
            plant.velocity = 0.0;
        }
        around.position = plant.position;
        around.time += sample_time;
        drop(around);
        self.shared.changed.notify_all();
    }

    fn is_powered(&self) -> bool {
        self.shared.lock().power
    }
}

impl PositionSensor for Servo {
    type Error = ();

    fn count(&mut self) -> Result<i32, ()> {
        Ok(self.encoder.read(self.plant.position) as i32)
    }
}

/// The home switch is closed below this position, rad.
const HOME: f64 = -0.2;

impl Chip for Axis<'_> {
    type Sensor = Servo;
    type Output = Held;

    fn lines(&self) -> Lines {
        Lines::HEALTHY
    }

    fn servo(&mut self) -> (&mut Servo, &mut Held) {
        (&mut self.servo, &mut self.stage)
    }

    fn home_switch_is_closed(&self) -> bool {
        self.servo.plant.position < HOME
    }

    fn index(&mut self) -> Option<i32> {
        None
    }

    fn steps(&mut self) -> Option<i16> {
        Some(0)
    }

    fn next_is_due(&self) -> bool {
        false
    }

    fn feed_watchdog(&mut self) {}
}
