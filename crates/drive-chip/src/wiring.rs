//! Sets up everything of a board, in the order that is safe.

use drive_link::Fault;

use crate::board::Board;
use crate::family::{Bus, Family, Functions, Peripherals, Storage, Supply};
use crate::flash::RecordFlash;
use crate::inputs::Inputs;
use crate::line_timer::LineTimer;
use crate::pins::{Output, Pull};
use crate::pwm::{self, Direction, Pwm};
use crate::quadrature::Quadrature;
use crate::sample_timer::SampleTimer;
use crate::serial::{self, Bytes, Line, Port, Ring};
use crate::step_input::StepInput;
use crate::watchdog::Watchdog;
use crate::{clock, supply};

/// Everything of a board that a drive uses.
#[derive(Debug)]
pub struct Wired<'a, B> {
    /// Counts the position.
    pub encoder: Quadrature<B>,
    /// Magnitude of the output.
    pub pwm: Pwm<B>,
    /// Sign of the output, high for positive.
    pub direction: Direction<B>,
    /// Enables the amplifier, high is on.
    pub enable: Output<B>,
    /// Opens the holding brake, high is open.
    pub brake: Output<B>,
    /// Counts steps with their direction.
    pub steps: StepInput<B>,
    /// The amplifier's fault line, the limit switches and the home switch.
    pub inputs: Inputs<B>,
    /// Interrupts at every sample.
    pub timer: SampleTimer<B>,
    /// The background's end of the serial line.
    pub line: Line<'a, B>,
    /// The interrupt's end of the serial line.
    pub port: Port<'a, B>,
    /// Has the line listened to.
    pub line_timer: LineTimer<B>,
    /// Keeps records.
    pub flash: RecordFlash<B>,
    /// Resets the chip unless it is fed.
    pub watchdog: Watchdog<B>,
    /// The option bytes have the chip reset itself before its supply is too low for it.
    pub resets_in_time: bool,
    /// The fault found on the way: an unstable clock, or a reset by the watchdog.
    pub found: Result<(), Fault>,
}

/// Wires a board. The outputs are low before anything else happens, and the timers and interrupts
/// stand still at the end.
pub fn wire<'a, B: Bus>(
    bus: B,
    board: &Board<B::Family>,
    received: &'static Ring,
    to_send: &'a mut Bytes,
) -> Wired<'a, B> {
    for output in [board.enable, board.brake, board.pwm, board.direction] {
        output.power(bus);
        output.output(bus);
    }
    let by_watchdog = B::Family::was_reset_by_watchdog(bus);
    let (clocks, clock) = clock::start(bus, board.oscillator);
    B::Family::power_peripherals(bus);
    B::Family::watch_supply(bus);
    B::Family::run_while_halted(bus);

    // Before the PWM locks its breaks.
    B::Family::wire(bus, &board.own);
    let (pwm, direction) = pwm::signed(bus, &clocks);
    let Functions {
        tim1,
        tim3,
        tim4,
        usart2,
    } = B::Family::FUNCTIONS;
    for (pin, function, pull) in [
        // The timer drives both low already.
        (board.pwm, tim1, Pull::None),
        (board.direction, tim1, Pull::None),
        (board.fault, tim1, Pull::Up),
        (board.encoder[0], tim3, Pull::Up),
        (board.encoder[1], tim3, Pull::Up),
        (board.index, tim3, Pull::Up),
        (board.step[0], tim4, Pull::Up),
        (board.step[1], tim4, Pull::Up),
        (board.serial[0], usart2, Pull::None),
        // Pulled up, an open line is idle.
        (board.serial[1], usart2, Pull::Up),
    ] {
        pin.power(bus);
        pin.alternate(bus, function, pull);
    }
    for switch in [board.low_switch, board.high_switch, board.home_switch] {
        switch.power(bus);
        switch.input(bus);
    }
    let (line, port) = serial::line(bus, &clocks, received, to_send);
    Wired {
        encoder: Quadrature::new(bus),
        pwm,
        direction,
        enable: Output::new(bus, board.enable),
        brake: Output::new(bus, board.brake),
        steps: StepInput::new(bus, board),
        inputs: Inputs::new(bus, board),
        timer: SampleTimer::new(bus, &clocks),
        line,
        port,
        line_timer: LineTimer::new(bus, &clocks),
        flash: RecordFlash::new(bus, board.records),
        watchdog: Watchdog::new(bus),
        resets_in_time: B::Family::resets_in_time(bus),
        found: clock.and(if by_watchdog {
            Err(Fault::ResetByWatchdog)
        } else {
            Ok(())
        }),
    }
}

/// Disables the output in any state of the drivers, for a program that cannot continue. The amplifier is off, the
/// brake closes, and the PWM's pins are driven low and do not float.
pub fn disable_outputs<B: Bus>(bus: B, board: &Board<B::Family>) {
    board.enable.set_low(bus);
    board.brake.set_low(bus);
    pwm::off(bus);
}

/// Serves the interrupt of the supply's detector: disables the output until the samples have seen the sag.
pub fn disable_for_sag<B: Bus>(bus: B, board: &Board<B::Family>) {
    disable_outputs(bus, board);
    supply::silence(bus);
}

/// Serves the interrupt that nothing masks: true if the program may continue.
#[must_use]
pub fn outlives_nmi<B: Bus>(bus: B) -> bool {
    B::Family::outlives_nmi(bus)
}
