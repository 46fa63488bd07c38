//! A drive without hardware: the firmware's logic in real time with the servo of a scenario, at a TCP
//! port. Every host of a drive can use it as a real one.

mod chip;
mod clock;
mod flash;
mod wire;

use std::net::{SocketAddr, TcpListener};
use std::time::Duration;
use std::{fmt, io, thread};

use drive_link::{Command, Estimator, LoopSettings, Refusal, Report, Request, Settings};
use drive_logic::{
    Channel, Conversation, LineListener, Memory, OutputStage, PolledLine, Records, Sampler,
    Supervisor, self_test,
};
use host_sim::commission::CommissionedAxis;
use host_sim::scenario::{Fault, Scenario};

use self::chip::SimulatedChip;
pub use self::chip::{Held, SimulatedPins};
pub use self::clock::Clock;
pub use self::flash::FlashInMemory;
pub use self::wire::Wire;

/// From the reading of the encoder to the change of the output, s: in the simulation there is none.
const COMMAND_DELAY: f64 = 0.0;

/// Longest sleep between two looks at the line.
const MAX_SLEEP: Duration = Duration::from_micros(500);

/// A drive that waits for its power, with a port that is open already.
pub struct SimulatedDrive {
    listener: TcpListener,
    chip: SimulatedChip,
    stage: OutputStage,
    built_in: Settings,
    configured: Option<Settings>,
}

/// Why there is no such drive.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimulatedDriveError {
    /// The scenario describes no servo that could be simulated.
    #[error(transparent)]
    Scenario(#[from] Fault),
    /// The drive refuses its settings.
    #[error("the drive refuses: {0}")]
    Refused(Refusal),
    /// Another program uses the port.
    #[error(
        "{0} is in use by another program: choose another port with --listen, port 0 for any that is free"
    )]
    PortInUse(SocketAddr),
    /// The port cannot be opened.
    #[error("cannot listen at {0}: {1}")]
    Port(SocketAddr, io::Error),
}

impl fmt::Debug for SimulatedDrive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SimulatedDrive")
            .field("listener", &self.listener)
            .finish_non_exhaustive()
    }
}

impl SimulatedDrive {
    /// With the servo, the encoder and the amplifier of a scenario; not configured.
    ///
    /// # Errors
    /// If the scenario describes no such servo, or the port cannot be opened.
    pub fn new(scenario: &Scenario, address: SocketAddr) -> Result<Self, SimulatedDriveError> {
        let axis = CommissionedAxis::new(scenario)?;
        let core = scenario.settings()?;
        let chip = SimulatedChip::new(axis, core.sample_time);
        let port = |error: io::Error| match error.kind() {
            io::ErrorKind::AddrInUse => SimulatedDriveError::PortInUse(address),
            _ => SimulatedDriveError::Port(address, error),
        };
        let listener = TcpListener::bind(address).map_err(port)?;
        listener.set_nonblocking(true).map_err(port)?;
        let stage = OutputStage {
            full_scale: core.controller.map_or(1.0, |controller| {
                let [low, high] = controller.limit;
                high.max(-low)
            }),
            // The servo moves in steps of that.
            period: core.sample_time,
            command_delay: COMMAND_DELAY,
            board: "simulated",
            is_simulated: true,
        };
        Ok(Self {
            listener,
            chip,
            stage,
            built_in: example(core),
            configured: None,
        })
    }

    /// Its settings until it is configured, to be changed and given to [`configured`](Self::configured).
    #[must_use]
    pub fn built_in(&self) -> Settings {
        self.built_in
    }

    /// The same, configured for its servo.
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

    /// Powers it up, for as long as the program runs.
    ///
    /// # Errors
    /// If it refuses the settings that it was [`configured`](Self::configured) with.
    pub fn run(mut self) -> Result<(), SimulatedDriveError> {
        let board = Board {
            listener: &self.listener,
            stage: self.stage,
            built_in: &self.built_in,
            clock: Clock::at_pace(1.0),
        };
        board
            .power_up(
                &mut FlashInMemory::erased(),
                self.configured,
                &mut self.chip,
            )
            .map_err(SimulatedDriveError::Refused)
    }
}

/// A drive without its servo and its flash.
#[derive(Debug)]
pub struct Board<'a> {
    /// Its port, which does not block.
    pub listener: &'a TcpListener,
    /// Its output stage.
    pub stage: OutputStage,
    /// Its settings until it is configured.
    pub built_in: &'a Settings,
    /// Its time.
    pub clock: Clock,
}

impl Board<'_> {
    /// Runs the firmware's logic until the power is gone.
    ///
    /// # Errors
    /// If it refuses the settings that it is to be configured with.
    pub fn power_up<P: SimulatedPins>(
        self,
        flash: &mut FlashInMemory,
        configured: Option<Settings>,
        pins: &mut P,
    ) -> Result<(), Refusal> {
        let (stage, mut clock) = (self.stage, self.clock);
        let mut channel = Channel::new();
        let (background, interrupt, line) = channel.split();
        // A drive keeps its memory for ever, and a program has few drives.
        let memory = Box::leak(Box::new(Memory::new()));
        let records = Records::open(flash, 0, &stage);
        let mut supervisor =
            Supervisor::new(background, memory, records, self.built_in, stage, Ok(()));
        let (board_test, _) = self_test(stage.board, || 0);
        supervisor.set_board_test(board_test);
        if let Some(settings) = configured {
            let request = Request::without_order(0, Command::Configure(settings));
            if let Report::Refused { refusal, .. } = supervisor.answer(&request) {
                return Err(refusal);
            }
        }
        let mut sampler = Sampler::new(interrupt, Ok(()));
        let mut conversation = Conversation::new();
        let mut wire = PolledLine::new(Wire::default(), LineListener::new(line));
        while pins.is_powered() {
            if let Ok((line, _)) = self.listener.accept() {
                wire.line().connect(line);
            }
            clock.update();
            while clock.is_due() {
                let sample_time = supervisor.sample_time();
                clock.advance(sample_time);
                pins.begin_sample();
                sampler.interrupt(pins);
                pins.pass(sample_time);
                while conversation.turn(&mut wire, &mut supervisor) {}
                wire.line().flush();
            }
            // As on the chip, bytes wake the background between samples, and nothing else: a commissioning gets its
            // slices of work with the samples.
            if wire.line().has_received() {
                while conversation.turn(&mut wire, &mut supervisor) {}
            }
            wire.line().flush();
            thread::sleep(clock.left().min(MAX_SLEEP));
        }
        Ok(())
    }
}

/// Settings as the firmware has them built in, for the servo of a scenario.
fn example(core: identifier_core::Settings) -> Settings {
    let mut settings = Settings::example(LoopSettings {
        core: identifier_core::Settings {
            identifier: identifier_core::Settings::new(core.sample_time, 1.0).identifier,
            ..core
        },
        law: Estimator::GaussNewton,
    });
    settings.dither.amplitude = 0.0;
    settings
}
