//! Instructions of the turns of the drive's background: a stop may have to wait for one.

use core::convert::Infallible;

use drive_link::{Command, Cycles, Line, Request, frame};
use drive_logic::{
    Channel, Chip, Conversation, Lines, Memory, Records, Sampler, Supervisor, self_test,
};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use firmware_stm32::board::STAGE;
use firmware_stm32::host::{Text, print};
use firmware_stm32::instructions::{Counter as Instructions, Tally, ticks};
use firmware_stm32::settings;
use identifier_core::drive::{Actuator, PositionSensor};

pub(crate) fn run() -> Result<(), &'static str> {
    count(&Instructions::start()).ok_or("a second run")
}

/// Counts turns with nothing to do, with garbage, with the longest answer, with the longest request and
/// with reports.
fn count(instructions: &Instructions) -> Option<()> {
    let channel = cortex_m::singleton!(: Channel = Channel::new())?;
    let memory = cortex_m::singleton!(: Memory = Memory::new())?;
    let (back, interrupt, _) = channel.split();
    let built_in = settings::built_in();
    let records = Records::open(NoFlash, 0, &STAGE);
    let supervisor = Supervisor::new(back, memory, records, &built_in, STAGE, Ok(()));
    let mut background = Background {
        instructions,
        supervisor,
        conversation: Conversation::new(),
    };
    let mut sampler = Sampler::new(interrupt, Ok(()));
    let mut servo = Servo([Loose, Loose]);

    board_test()?;
    background.count("idle", &[]);
    background.count("garbage", &[0x55; 500]);
    background.count("show", &request(Command::Show));
    for command in [
        Command::Configure(built_in),
        Command::Watch(1),
        Command::Start,
    ] {
        background.turns(&request(command));
    }
    for _ in 0..4 {
        sampler.interrupt(&mut servo);
    }
    background.count("refused-configure", &request(Command::Configure(built_in)));
    sampler.interrupt(&mut servo);
    background.count("news", &[]);
    Some(())
}

/// Counts the instructions of the samples of the boot's known computation, of which a board reports the cycles.
fn board_test() -> Option<()> {
    let (test, _) = self_test("bench", ticks);
    let Cycles { mean, most } = test.cycles?;
    let [mean, most, bytes] = [mean, most, size_of_val(&test) as u32].map(Text::whole);
    print(&["board-test", mean.as_str(), most.as_str(), bytes.as_str()]);
    Some(())
}

/// The background with its instructions.
struct Background<'a> {
    instructions: &'a Instructions,
    supervisor: Supervisor<'a, NoFlash>,
    conversation: Conversation,
}

impl Background<'_> {
    /// Turns until all of these bytes were decoded and nothing is left to do.
    fn turns(&mut self, bytes: &[u8]) -> Tally {
        let mut wire = Wire { bytes };
        let mut tally = Tally::default();
        loop {
            let before = self.instructions.now();
            let more = self.conversation.turn(&mut wire, &mut self.supervisor);
            tally.add(self.instructions.now().wrapping_sub(before));
            if !more {
                return tally;
            }
        }
    }

    fn count(&mut self, name: &str, bytes: &[u8]) {
        let tally = self.turns(bytes);
        tally.print(name, size_of::<Conversation>());
    }
}

/// The bytes of a request, after a zero that ends earlier ones.
fn request(command: Command) -> heapless::Vec<u8, 1024> {
    let mut bytes = heapless::Vec::new();
    let _ = bytes.push(0);
    let (id, order) = (1, 1);
    if let Ok(framed) = frame(&Request { id, order, command }) {
        let _ = bytes.extend_from_slice(&framed);
    }
    bytes
}

/// A line that takes every byte.
struct Wire<'a> {
    bytes: &'a [u8],
}

impl Line for Wire<'_> {
    fn listen(&mut self) {}

    fn receive(&mut self) -> Option<u8> {
        let (&byte, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(byte)
    }

    fn room(&self) -> usize {
        2047
    }

    fn send(&mut self, bytes: &[u8]) {
        core::hint::black_box(bytes);
    }
}

/// A sensor at standstill, and an output without a load.
struct Servo([Loose; 2]);

struct Loose;

impl PositionSensor for Loose {
    type Error = Infallible;

    fn count(&mut self) -> Result<i32, Infallible> {
        Ok(0)
    }
}

impl Actuator<f32> for Loose {
    type Error = Infallible;

    fn hold(&mut self, _: f32) -> Result<(), Infallible> {
        Ok(())
    }

    fn release(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl Chip for Servo {
    type Sensor = Loose;
    type Output = Loose;

    fn lines(&self) -> Lines {
        Lines::HEALTHY
    }

    fn servo(&mut self) -> (&mut Loose, &mut Loose) {
        let [sensor, output] = &mut self.0;
        (sensor, output)
    }

    fn home_switch_is_closed(&self) -> bool {
        false
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

/// A flash that does nothing.
struct NoFlash;

/// Its answer.
const REFUSED: NorFlashErrorKind = NorFlashErrorKind::Other;

impl ErrorType for NoFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for NoFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, _: u32, _: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        Err(REFUSED)
    }

    fn capacity(&self) -> usize {
        0
    }
}

impl NorFlash for NoFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 2048;

    fn erase(&mut self, _: u32, _: u32) -> Result<(), NorFlashErrorKind> {
        Err(REFUSED)
    }

    fn write(&mut self, _: u32, _: &[u8]) -> Result<(), NorFlashErrorKind> {
        Err(REFUSED)
    }
}
