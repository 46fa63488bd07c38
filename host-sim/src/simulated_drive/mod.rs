//! A drive without hardware: the firmware's logic in real time against the servo of a scenario, at the
//! other end of a TCP port. Whatever talks to a drive talks to it as to a real one.

mod chip;
mod clock;
mod flash;
mod wire;

use std::fmt;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::thread;
use std::time::Duration;

use drive_link::{Command, Dither, Protection, Refusal, Report, Request, Settings};
use drive_logic::{Channel, Conversation, Memory, Sampler, Stage, Supervisor};

use self::chip::SimulatedChip;
use self::clock::Clock;
pub use self::flash::FlashInMemory;
pub use self::wire::Wire;
use crate::commission::Axis;
use crate::scenario::{Fault, Scenario};

/// From the reading of the encoder to the change of the output, s: in the simulation there is none.
const COMMAND_DELAY: f64 = 0.0;

/// How long it sleeps at most between two looks at the line.
const NAP: Duration = Duration::from_micros(500);

/// A drive that waits for its power, with a port that is open already.
pub struct SimulatedDrive {
    listener: TcpListener,
    chip: SimulatedChip,
    stage: Stage,
    built_in: Settings,
    configured: Option<Settings>,
}

/// Why there is no such drive.
#[derive(Debug)]
#[non_exhaustive]
pub enum SimulatedDriveError {
    /// The scenario describes no servo that could be simulated.
    Scenario(Fault),
    /// The drive refuses its settings.
    Refused(Refusal),
    /// The port cannot be opened.
    Port(SocketAddr, io::Error),
}

impl fmt::Display for SimulatedDriveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scenario(fault) => fault.fmt(f),
            Self::Refused(refusal) => write!(f, "the drive refuses: {refusal}"),
            Self::Port(address, error) if error.kind() == io::ErrorKind::AddrInUse => write!(
                f,
                "{address} is in use by another program: choose another port with --listen, port 0 for any \
                 that is free"
            ),
            Self::Port(address, error) => write!(f, "{address} cannot be listened at: {error}"),
        }
    }
}

impl std::error::Error for SimulatedDriveError {}

impl fmt::Debug for SimulatedDrive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SimulatedDrive")
            .field("listener", &self.listener)
            .finish_non_exhaustive()
    }
}

impl SimulatedDrive {
    /// With the servo, the encoder and the amplifier of a scenario; nobody has told it anything yet.
    ///
    /// # Errors
    /// If the scenario describes no such servo, or the port cannot be opened.
    pub fn new(scenario: &Scenario, address: SocketAddr) -> Result<Self, SimulatedDriveError> {
        let axis = Axis::of(scenario).map_err(SimulatedDriveError::Scenario)?;
        let core = scenario
            .settings()
            .map_err(|error| SimulatedDriveError::Scenario(scenario.fault(&error)))?;
        let chip = SimulatedChip::new(axis, core.sample_time);
        let port = |error| SimulatedDriveError::Port(address, error);
        let listener = TcpListener::bind(address).map_err(port)?;
        listener.set_nonblocking(true).map_err(port)?;
        let stage = Stage {
            full_scale: core.controller.map_or(1.0, |controller| {
                let [low, high] = controller.limit;
                high.max(-low)
            }),
            // The servo moves in steps of that.
            period: core.sample_time,
            command_delay: COMMAND_DELAY,
        };
        Ok(Self {
            listener,
            chip,
            stage,
            built_in: example(core),
            configured: None,
        })
    }

    /// What it holds without being told anything, to be changed and given to
    /// [`configured`](Self::configured).
    #[must_use]
    pub fn built_in(&self) -> Settings {
        self.built_in
    }

    /// The same, told by somebody what its servo is.
    #[must_use]
    pub fn configured(self, settings: Settings) -> Self {
        Self {
            configured: Some(settings),
            ..self
        }
    }

    /// Where it listens.
    ///
    /// # Errors
    /// If the system does not know.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Switches it on, for as long as the program runs.
    ///
    /// # Errors
    /// If it refuses the settings that it was [`configured`](Self::configured) with.
    pub fn run(mut self) -> Result<std::convert::Infallible, SimulatedDriveError> {
        let mut channel = Channel::new();
        let (background, interrupt) = channel.split();
        // A drive keeps its memory for ever, and a program has few drives.
        let memory = Box::leak(Box::new(Memory::new()));
        let flash = (FlashInMemory::erased(), 0);
        let mut supervisor = Supervisor::new(
            background,
            memory,
            flash,
            &self.built_in,
            self.stage,
            Ok(()),
        );
        if let Some(settings) = self.configured {
            let command = Command::Configure(settings);
            if let Report::Refused { refusal, .. } = supervisor.answer(&Request { id: 0, command })
            {
                return Err(SimulatedDriveError::Refused(refusal));
            }
        }
        let mut sampler = Sampler::new(interrupt, Ok(()));
        let mut conversation = Conversation::new();
        let mut wire = Wire::default();
        let mut clock = Clock::start();
        loop {
            if let Ok((line, _)) = self.listener.accept() {
                wire.connect(line);
            }
            clock.look();
            while clock.is_due() {
                let sample_time = supervisor.sample_time();
                clock.advance(sample_time);
                self.chip.begin_sample();
                sampler.interrupt(&mut self.chip);
                self.chip.pass(sample_time);
                while conversation.turn(&mut wire, &mut supervisor) {}
                wire.flush();
            }
            // Without a sample that is due, too, so that nobody waits for an answer.
            while conversation.turn(&mut wire, &mut supervisor) {}
            wire.flush();
            thread::sleep(clock.left().min(NAP));
        }
    }
}

/// Settings as the firmware has them built in, for the servo of a scenario.
fn example(core: identifier_core::Settings) -> Settings {
    Settings {
        closed_loop: drive_link::LoopSettings {
            core: identifier_core::Settings {
                identifier: identifier_core::Settings::new(core.sample_time, 1.0).identifier,
                ..core
            },
            law: drive_link::Law::GaussNewton,
            format: drive_link::Format::Single,
        },
        dither: Dither {
            amplitude: 0.0,
            hold: 0.05,
        },
        protection: Protection::OF_A_BARE_MOTOR,
    }
}
