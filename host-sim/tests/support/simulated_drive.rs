//! A drive at the other end of a TCP port: the firmware's logic in a thread, its servo simulated, its
//! flash in memory. Somebody can put a hand on the shaft, switch the motor's supply, swap its leads, and
//! take the drive's power away.

use std::net::{Ipv4Addr, TcpListener};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use drive_link::Settings;
use drive_logic::{Channel, Chip, Conversation, Lines, Sampler, Stage, Supervisor};
use host_sim::simulated_drive::{FlashInMemory, Wire};
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::parameters::ServoParameters;
use virtual_servo::{Encoder, Plant};

const SAMPLE_TIME: f64 = 1e-3;
const COUNTS: f64 = 10_000.0;

/// What the drive does in a second of the test, s.
const HASTE: u32 = 2;

/// How far a hand moves the axis in a sample, rad.
const HAND: f64 = 2e-3;

/// What somebody does to the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Hand {
    Off,
    /// Moves it here, rad, and holds it, whatever the motor does.
    Holds(f64),
}

/// What is around the drive.
#[derive(Debug)]
pub(crate) struct Surroundings {
    pub(crate) hand: Hand,
    pub(crate) supply: bool,
    /// The motor's leads, right (1) or swapped (−1).
    pub(crate) leads: f64,
    pub(crate) power: bool,
    /// Where the axis is, rad, and the command that is held.
    pub(crate) position: f64,
    pub(crate) held: Option<f32>,
}

/// A drive that somebody can do things to.
pub(crate) struct SimulatedDrive {
    pub(crate) port: String,
    around: Arc<Mutex<Surroundings>>,
}

impl SimulatedDrive {
    /// Switched on, the motor without supply, nobody's hand on the shaft.
    pub(crate) fn start(servo: ServoParameters, example: Settings) -> Self {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port is free");
        listener.set_nonblocking(true).expect("a socket");
        let port = format!("tcp:{}", listener.local_addr().expect("it has an address"));
        let around = Arc::new(Mutex::new(Surroundings {
            hand: Hand::Off,
            supply: false,
            leads: 1.0,
            power: true,
            position: 0.0,
            held: None,
        }));
        let theirs = Arc::clone(&around);
        thread::spawn(move || live(&listener, &theirs, &servo, &example));
        Self { port, around }
    }

    /// Changes what is around it.
    pub(crate) fn with<T>(&self, change: impl FnOnce(&mut Surroundings) -> T) -> T {
        change(&mut self.around.lock().expect("nobody panicked"))
    }

    /// Lets time pass for the drive, s.
    pub(crate) fn pass(&self, time: f64) {
        thread::sleep(Duration::from_secs_f64(time / f64::from(HASTE)));
    }
}

/// Powers the drive up again whenever its power comes back, with what its flash kept.
fn live(
    listener: &TcpListener,
    around: &Mutex<Surroundings>,
    servo: &ServoParameters,
    example: &Settings,
) {
    let mut flash = FlashInMemory::erased();
    loop {
        while !around.lock().expect("nobody panicked").power {
            thread::sleep(Duration::from_millis(1));
        }
        boot(listener, around, servo, example, &mut flash);
    }
}

fn boot(
    listener: &TcpListener,
    around: &Mutex<Surroundings>,
    servo: &ServoParameters,
    example: &Settings,
    flash: &mut FlashInMemory,
) {
    let mut channel = Channel::new();
    let (background, interrupt) = channel.split();
    let memory = Box::leak(Box::new(drive_logic::Memory::new()));
    let stage = Stage {
        full_scale: 10.0,
        period: 5e-5,
        command_delay: 1.25e-5,
    };
    let mut supervisor = Supervisor::new(background, memory, (flash, 0), example, stage, Ok(()));
    let mut sampler = Sampler::new(interrupt, Ok(()));
    let mut conversation = Conversation::new();
    let mut wire = Wire::default();
    let mut axis = Axis {
        servo: Servo {
            plant: Plant::at_rest(servo, SAMPLE_TIME),
            encoder: Encoder::new(COUNTS),
        },
        stage: Held(None),
    };
    let begun = Instant::now();
    let mut samples = 0;
    loop {
        if let Ok((line, _)) = listener.accept() {
            wire.connect(line);
        }
        let due = begun.elapsed().as_millis() as u64 * u64::from(HASTE);
        while samples < due {
            samples += 1;
            sampler.interrupt(&mut axis);
            let mut around = around.lock().expect("nobody panicked");
            if !around.power {
                return;
            }
            around.held = axis.stage.0;
            let push = axis
                .stage
                .0
                .filter(|_| around.supply)
                .map_or(0.0, |command| around.leads * f64::from(command));
            axis.servo.plant.advance(push);
            if let Hand::Holds(position) = around.hand {
                let way = position - axis.servo.plant.position;
                axis.servo.plant.position += way.clamp(-HAND, HAND);
                axis.servo.plant.velocity = 0.0;
            }
            around.position = axis.servo.plant.position;
            drop(around);
            while conversation.turn(&mut wire, &mut supervisor) {}
            wire.flush();
        }
        thread::sleep(Duration::from_micros(200));
    }
}

struct Servo {
    plant: Plant,
    encoder: Encoder,
}

struct Held(Option<f32>);

struct Axis {
    servo: Servo,
    stage: Held,
}

impl PositionSensor for Servo {
    type Error = ();

    fn count(&mut self) -> Result<i32, ()> {
        Ok(self.encoder.read(self.plant.position) as i32)
    }
}

impl Actuator<f32> for Held {
    type Error = ();

    fn hold(&mut self, command: f32) -> Result<(), ()> {
        self.0 = Some(command);
        Ok(())
    }

    fn release(&mut self) -> Result<(), ()> {
        self.0 = None;
        Ok(())
    }
}

impl Chip for Axis {
    type Sensor = Servo;
    type Output = Held;

    fn lines(&self) -> Lines {
        Lines {
            amplifier: true,
            low_switch: true,
            high_switch: true,
        }
    }

    fn servo(&mut self) -> (&mut Servo, &mut Held) {
        (&mut self.servo, &mut self.stage)
    }

    fn next_is_due(&self) -> bool {
        false
    }

    fn feed_watchdog(&mut self) {}
}
