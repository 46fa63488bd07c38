use std::collections::VecDeque;

use drive_chip::serial::BAUD;
use drive_link::Line;
use stm32f4::stm32f405::Interrupt;

use crate::{healthy, slow, wired};

#[test]
fn the_baud_rate_is_the_host_s() {
    for chip in [healthy(), slow()] {
        let _wired = wired(&chip);
        let baud = chip.usart.baud(&chip.clocks);
        let error = (baud / f64::from(BAUD) - 1.0).abs();
        assert!(error <= 1e-9, "{baud} bits a second: {error}");
        assert!(chip.usart.is_open());
    }
}

#[test]
fn bytes_are_received_in_order() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert!(chip.usart.interrupts_on_reception());
    assert_eq!(wired.line.receive(), None);
    assert!(wired.line.is_silent());
    *chip.usart.received.borrow_mut() = VecDeque::from([1, 2, 0xff]);
    for _ in 0..3 {
        wired.port.serve();
    }
    wired.port.serve();
    let received = [(); 4].map(|()| wired.line.receive());
    assert_eq!(received, [Some(1), Some(2), Some(0xff), None]);
}

#[test]
fn an_overrun_is_cleared() {
    let chip = healthy();
    let mut wired = wired(&chip);
    chip.usart.overrun.set(true);
    wired.port.serve();
    assert!(!chip.usart.overrun.get());
}

#[test]
fn bytes_are_sent_one_per_interrupt_until_there_are_none() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert!(!chip.pending(Interrupt::USART2));
    wired.line.send(b"abc");
    assert!(chip.pending(Interrupt::USART2));
    assert!(chip.usart.sent.borrow().is_empty());
    wired.port.serve();
    assert!(chip.usart.interrupts_for_sending());
    assert_eq!(*chip.usart.sent.borrow(), b"a");
    // While it is being sent, no other is.
    chip.usart.busy.set(true);
    wired.port.serve();
    assert_eq!(*chip.usart.sent.borrow(), b"a");
    chip.usart.busy.set(false);
    for _ in 0..2 {
        wired.port.serve();
        assert!(chip.usart.interrupts_for_sending());
    }
    wired.port.serve();
    assert!(!chip.usart.interrupts_for_sending());
    assert!(chip.usart.interrupts_on_reception());
    assert_eq!(*chip.usart.sent.borrow(), b"abc");
}

#[test]
fn the_line_has_room_for_its_queue() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert_eq!(wired.line.room(), 2047);
    wired.line.send(&[0; 47]);
    assert_eq!(wired.line.room(), 2000);
}
