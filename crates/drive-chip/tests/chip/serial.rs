use std::collections::VecDeque;

use drive_chip::serial::BAUD;
use drive_link::Line;
use stm32f4::stm32f405::Interrupt;

use crate::{healthy, slow, wired};

#[test]
fn the_rate_is_the_host_s() {
    for chip in [healthy(), slow()] {
        let _wired = wired(&chip);
        let baud = chip.usart.baud(&chip.clocks);
        let error = (baud / f64::from(BAUD) - 1.0).abs();
        assert!(error <= 1e-9, "{baud} bits a second: {error}");
        assert!(chip.usart.is_open());
    }
}

#[test]
fn bytes_that_come_are_heard_in_order() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert!(chip.usart.interrupts_for_hearing());
    assert_eq!(wired.line.hear(), None);
    assert!(wired.line.is_silent());
    *chip.usart.came.borrow_mut() = VecDeque::from([1, 2, 0xff]);
    for _ in 0..3 {
        wired.port.serve();
    }
    wired.port.serve();
    let heard = [(); 4].map(|()| wired.line.hear());
    assert_eq!(heard, [Some(1), Some(2), Some(0xff), None]);
}

#[test]
fn an_overrun_is_forgotten_and_interrupts_no_more() {
    let chip = healthy();
    let mut wired = wired(&chip);
    chip.usart.overrun.set(true);
    wired.port.serve();
    assert!(!chip.usart.overrun.get());
}

#[test]
fn bytes_are_said_one_an_interrupt_until_there_are_none() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert!(!chip.pending(Interrupt::USART2));
    wired.line.say(b"abc");
    assert!(chip.pending(Interrupt::USART2));
    assert!(chip.usart.said.borrow().is_empty());
    wired.port.serve();
    assert!(chip.usart.interrupts_for_saying());
    assert_eq!(*chip.usart.said.borrow(), b"a");
    // While it is on its way, nothing is said.
    chip.usart.busy.set(true);
    wired.port.serve();
    assert_eq!(*chip.usart.said.borrow(), b"a");
    chip.usart.busy.set(false);
    for _ in 0..2 {
        wired.port.serve();
        assert!(chip.usart.interrupts_for_saying());
    }
    wired.port.serve();
    assert!(!chip.usart.interrupts_for_saying());
    assert!(chip.usart.interrupts_for_hearing());
    assert_eq!(*chip.usart.said.borrow(), b"abc");
}

#[test]
fn the_line_knows_its_room() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert_eq!(wired.line.room(), 2047);
    wired.line.say(&[0; 47]);
    assert_eq!(wired.line.room(), 2000);
}

#[test]
fn both_ends_show_themselves() {
    let chip = healthy();
    let wired = wired(&chip);
    assert_eq!(format!("{:?}", wired.line), "Line { .. }");
    assert_eq!(format!("{:?}", wired.port), "Port { .. }");
}
