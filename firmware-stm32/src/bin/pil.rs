//! Processor in the loop: the servo is simulated by a host at the other end of the serial line, the
//! loop runs here, one sample a question.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use drive_chip::{Mmio, interrupts};
use drive_link::{LONGEST_FRAME, Line, Question, Receiver, frame};
use drive_logic::LockStep;
use firmware_stm32::board::{self, Port, Wired};
use firmware_stm32::hand_off::HandOff;
use stm32f4xx_hal::pac::interrupt;

static PORT: HandOff<Port> = HandOff::new();

#[interrupt]
fn USART2() {
    static mut OWN: Option<Port> = None;
    if OWN.is_none() {
        *OWN = PORT.take();
    }
    if let Some(port) = OWN {
        port.serve();
    }
}

#[entry]
fn main() -> ! {
    if let Some(wired) = board::wire() {
        run(wired);
    }
    loop {
        cortex_m::asm::wfi();
    }
}

fn run(wired: Wired) -> ! {
    let Wired { mut line, port, .. } = wired;
    PORT.give(port);
    interrupts::begin_serial(Mmio);
    let mut receiver = Receiver::new();
    let mut lock_step = LockStep::new();
    // Without sleep between the bytes: an emulator takes long to wake.
    loop {
        while line.room() >= LONGEST_FRAME
            && let Some(byte) = line.hear()
        {
            // What was not understood is asked again.
            if let Some(Ok(question)) = receiver.take::<Question>(byte)
                && let Ok(framed) = frame(&lock_step.answer(&question))
            {
                line.say(&framed);
            }
        }
    }
}
