//! Sets up everything of a board, in the order that is safe.

use drive_link::Fault;

use crate::analogue_input::AnalogueInput;
use crate::board::Board;
use crate::bus::{Bus, Register};
use crate::clock;
use crate::flash::RecordFlash;
use crate::inputs::Inputs;
use crate::line_timer::LineTimer;
use crate::pins::{Output, Pull};
use crate::pwm::{self, Direction, Pwm};
use crate::quadrature::Quadrature;
use crate::registers::{dbgmcu, rcc};
use crate::sample_timer::SampleTimer;
use crate::serial::{self, Bytes, Line, Port, Ring};
use crate::step_input::StepInput;
use crate::supply;
use crate::watchdog::Watchdog;

/// The functions of the peripherals' pins (STM32F405 data sheet, table 9; those of the STM32F446 are
/// the same).
const TIM1_FUNCTION: u32 = 1;
const TIM3_FUNCTION: u32 = 2;
const TIM4_FUNCTION: u32 = 2;
const USART2_FUNCTION: u32 = 7;

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
    /// Counts steps with their direction.
    pub steps: StepInput<B>,
    /// The command of ±10 V.
    pub analogue: AnalogueInput<B>,
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
    board: &Board,
    received: &'static Ring,
    to_send: &'a mut Bytes,
) -> Wired<'a, B> {
    for output in [board.enable, board.pwm, board.direction] {
        output.power(bus);
        output.output(bus);
    }
    let by_watchdog = bus.read(rcc::CSR) & rcc::CSR_IWDGRSTF != 0;
    bus.modify(rcc::CSR, 0, rcc::CSR_RMVF);
    let (clocks, clock) = clock::start(bus, board.oscillator);
    power_peripherals(bus);
    supply::watch(bus);
    run_while_halted(bus);

    let (pwm, direction) = pwm::signed(bus, &clocks);
    for (pin, function, pull) in [
        // The timer drives both low already.
        (board.pwm, TIM1_FUNCTION, Pull::None),
        (board.direction, TIM1_FUNCTION, Pull::None),
        (board.fault, TIM1_FUNCTION, Pull::Up),
        (board.encoder[0], TIM3_FUNCTION, Pull::Up),
        (board.encoder[1], TIM3_FUNCTION, Pull::Up),
        (board.index, TIM3_FUNCTION, Pull::Up),
        (board.step[0], TIM4_FUNCTION, Pull::Up),
        (board.step[1], TIM4_FUNCTION, Pull::Up),
        (board.serial[0], USART2_FUNCTION, Pull::None),
        // Pulled up, an open line is idle.
        (board.serial[1], USART2_FUNCTION, Pull::Up),
    ] {
        pin.power(bus);
        pin.alternate(bus, function, pull);
    }
    for switch in [board.low_switch, board.high_switch, board.home_switch] {
        switch.power(bus);
        switch.input(bus);
    }
    board.analogue.power(bus);
    board.analogue.analogue(bus);
    let (line, port) = serial::line(bus, &clocks, received, to_send);
    Wired {
        encoder: Quadrature::new(bus),
        pwm,
        direction,
        enable: Output::new(bus, board.enable),
        steps: StepInput::new(bus, board),
        analogue: AnalogueInput::new(bus),
        inputs: Inputs::new(bus, board),
        timer: SampleTimer::new(bus, &clocks),
        line,
        port,
        line_timer: LineTimer::new(bus, &clocks),
        flash: RecordFlash::new(bus, board.records),
        watchdog: Watchdog::new(bus),
        resets_in_time: supply::resets_in_time(bus),
        found: clock.and(if by_watchdog {
            Err(Fault::ResetByWatchdog)
        } else {
            Ok(())
        }),
    }
}

/// Switches the peripherals' clocks on and puts them in the state after reset, which they are not in
/// if a debugger started the program anew.
fn power_peripherals(bus: impl Bus) {
    let power = |enable: Register, reset: Register, peripherals: u32| {
        bus.modify(enable, 0, peripherals);
        // A peripheral answers two ticks after its clock is on (RM0090, 7.2.13): a read takes them.
        let _ = bus.read(enable);
        bus.modify(reset, 0, peripherals);
        bus.modify(reset, peripherals, 0);
    };
    power(rcc::AHB1ENR, rcc::AHB1RSTR, rcc::AHB1_DMA1);
    power(rcc::APB2ENR, rcc::APB2RSTR, rcc::APB2_TIM1 | rcc::APB2_ADC1);
    power(
        rcc::APB1ENR,
        rcc::APB1RSTR,
        rcc::APB1_TIM3 | rcc::APB1_TIM4 | rcc::APB1_TIM5 | rcc::APB1_USART2,
    );
}

/// Has the watchdog and the PWM run on while a debugger halts the processor, whatever the debugger has set before: a PWM
/// that stands still may stand at high, and a watchdog that runs resets the chip, which disables the output.
fn run_while_halted(bus: impl Bus) {
    bus.modify(dbgmcu::APB1_FZ, dbgmcu::APB1_FZ_IWDG, 0);
    bus.modify(dbgmcu::APB2_FZ, dbgmcu::APB2_FZ_TIM1, 0);
}

/// Disables the output whatever the state of the drivers, for a program that cannot continue: the
/// amplifier is off, and the PWM's pins are driven low in place of floating.
pub fn disable_outputs(bus: impl Bus, board: &Board) {
    board.enable.set_low(bus);
    pwm::off(bus);
}

/// Serves the interrupt of the supply's detector: disables the output until the samples have seen the sag.
pub fn disable_for_sag(bus: impl Bus, board: &Board) {
    disable_outputs(bus, board);
    supply::silence(bus);
}
