use drive_chip::serial::{BAUD, Line as SerialLine, Port, Reception};
use drive_link::Line;

use crate::model::Chip;
use crate::pac::Interrupt;
use crate::{healthy, slow, wired};

/// Bytes that the ring holds.
const RING: usize = 4096;

/// Receives bytes with a listening after each `interval`, and returns what was heard.
fn received(chip: &Chip, port: &mut Port<'_, &Chip>, bytes: &[u8], interval: usize) -> Heard {
    let mut heard = Heard::default();
    for bytes in bytes.chunks(interval) {
        bytes.iter().for_each(|&byte| chip.usart.receive(byte));
        heard.listen(port);
    }
    heard
}

#[derive(Debug, Default, PartialEq)]
struct Heard {
    bytes: Vec<u8>,
    disturbances: u32,
}

impl Heard {
    fn listen(&mut self, port: &mut Port<'_, &Chip>) {
        port.serve(|reception| match reception {
            Reception::Byte(byte) => self.bytes.push(byte),
            Reception::Disturbed => self.disturbances += 1,
        });
    }
}

fn taken(line: &mut SerialLine<'_, &Chip>) -> Vec<u8> {
    std::iter::from_fn(|| line.receive()).collect()
}

/// Bytes that tell their places.
fn numbered(count: usize) -> Vec<u8> {
    (0..count).map(|k| (k ^ k >> 8 ^ k >> 13) as u8).collect()
}

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
fn bytes_are_received_in_order_without_an_interrupt() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert!(!chip.usart.interrupts_on_reception());
    assert_eq!(chip.usart.priority(), 3);
    assert_eq!(wired.line.receive(), None);
    assert!(wired.line.is_silent());
    // Through the ring several times, however the listening falls.
    for interval in [1, 25, 700, RING / 2 - 1] {
        let bytes = numbered(5 * RING + 3);
        for bytes in bytes.chunks(interval) {
            let heard = received(&chip, &mut wired.port, bytes, interval);
            assert_eq!((&heard.bytes[..], heard.disturbances), (bytes, 0));
            assert!(!wired.line.is_silent());
            assert_eq!(taken(&mut wired.line), bytes);
            assert!(wired.line.is_silent());
        }
    }
}

#[test]
fn a_byte_is_given_to_the_background_once_it_was_listened_to() {
    let chip = healthy();
    let mut wired = wired(&chip);
    chip.usart.receive(7);
    assert_eq!(wired.line.receive(), None);
    // The background asks for it, and waits until it is done.
    let barriers = chip.barriers.get();
    wired.line.listen();
    assert!(chip.pending(Interrupt::USART2));
    assert_eq!(chip.barriers.get(), barriers + 1);
    Heard::default().listen(&mut wired.port);
    assert_eq!(wired.line.receive(), Some(7));
}

#[test]
fn a_ring_that_has_gone_round_unheard_is_a_disturbance_and_its_newest_half_is_heard() {
    for count in [
        RING / 2 + 1,
        RING - 1,
        RING,
        RING + 1,
        2 * RING,
        7 * RING + 100,
    ] {
        for before in [0, 1, RING / 2 - 1, RING - 1, RING + 5] {
            let chip = healthy();
            let mut wired = wired(&chip);
            received(&chip, &mut wired.port, &numbered(before), 100);
            taken(&mut wired.line);
            let bytes = numbered(count);
            let heard = received(&chip, &mut wired.port, &bytes, count);
            let end = &heard.bytes[heard.bytes.len() - RING / 2..];
            assert_eq!(end, &bytes[count - RING / 2..], "{before}, {count}");
            let passed = |every: usize, offset: usize| {
                (before + count + offset) / every > (before + offset) / every
            };
            let is_round = passed(RING, 0) && passed(RING, RING / 2);
            assert_eq!(heard.disturbances, u32::from(is_round), "{before}, {count}");
            assert!(is_round || count < RING, "more than the ring holds");
            // The background loses what may be overwritten, and resumes.
            taken(&mut wired.line);
            let more = received(&chip, &mut wired.port, &[1, 2, 3], 1);
            assert_eq!((&more.bytes[..], more.disturbances), (&[1, 2, 3][..], 0));
            assert_eq!(taken(&mut wired.line), [1, 2, 3]);
        }
    }
}

#[test]
fn a_background_that_is_too_slow_loses_bytes_that_were_heard() {
    let chip = healthy();
    let mut wired = wired(&chip);
    let bytes = numbered(RING / 2);
    received(&chip, &mut wired.port, &bytes, 25);
    assert_eq!(taken(&mut wired.line), bytes, "half a ring waits");
    let heard = received(&chip, &mut wired.port, &numbered(RING / 2 + 1), 25);
    assert_eq!(heard.disturbances, 0);
    assert!(taken(&mut wired.line).is_empty(), "more may be overwritten");
    received(&chip, &mut wired.port, &[5], 1);
    assert_eq!(taken(&mut wired.line), [5]);
}

#[test]
fn an_overrun_and_a_framing_error_are_cleared_and_reported_once() {
    let errors: [fn(&Chip); 2] = [
        |chip| chip.usart.overrun.set(true),
        |chip| chip.usart.framing_error.set(true),
    ];
    for error in errors {
        let chip = healthy();
        let mut wired = wired(&chip);
        error(&chip);
        let mut heard = Heard::default();
        heard.listen(&mut wired.port);
        assert_eq!(heard.disturbances, 1);
        assert!(!chip.usart.overrun.get() && !chip.usart.framing_error.get());
        heard.listen(&mut wired.port);
        assert_eq!(heard.disturbances, 1);
        // And bytes are received as before.
        let more = received(&chip, &mut wired.port, &[1, 2], 1);
        assert_eq!(more.bytes, [1, 2]);
    }
}

#[test]
fn a_break_of_the_line_is_a_disturbance_and_a_zero() {
    let chip = healthy();
    let mut wired = wired(&chip);
    // A loose wire breaks again and again.
    for breaks in [1, 2, 30] {
        let mut heard = received(&chip, &mut wired.port, &[7, 8], 1);
        for _ in 0..breaks {
            chip.usart.receive_break();
            heard.listen(&mut wired.port);
        }
        assert_eq!(heard.disturbances, breaks, "each is counted");
        // The zero ends what was a frame until then.
        let zeros = vec![0; breaks as usize];
        assert_eq!(heard.bytes, [&[7, 8][..], &zeros].concat());
        let more = received(&chip, &mut wired.port, &[9], 1);
        assert_eq!((&more.bytes[..], more.disturbances), (&[9][..], 0));
        assert_eq!(taken(&mut wired.line), [&heard.bytes[..], &[9]].concat());
    }
    // Several before the line is listened to are one.
    chip.usart.receive_break();
    let heard = received(&chip, &mut wired.port, &[1, 2], 2);
    assert_eq!((&heard.bytes[..], heard.disturbances), (&[0, 1, 2][..], 1));
}

#[test]
fn a_stream_that_has_failed_is_started_again() {
    for before in [0, 10, RING - 1, RING + 10] {
        let chip = healthy();
        let mut wired = wired(&chip);
        received(&chip, &mut wired.port, &numbered(before), 100);
        taken(&mut wired.line);
        chip.usart.fail_transfer();
        let mut heard = Heard::default();
        heard.listen(&mut wired.port);
        // One that was received meanwhile stands in the register.
        assert_eq!((heard.bytes.len(), heard.disturbances), (0, 1));
        taken(&mut wired.line);
        let more = received(&chip, &mut wired.port, &[3, 4], 1);
        assert_eq!((&more.bytes[..], more.disturbances), (&[3, 4][..], 0));
        assert_eq!(taken(&mut wired.line), [3, 4]);
    }
}

#[test]
fn bytes_are_sent_one_per_interrupt_until_there_are_none() {
    let chip = healthy();
    let mut wired = wired(&chip);
    let mut serve = || Heard::default().listen(&mut wired.port);
    assert!(!chip.pending(Interrupt::USART2));
    wired.line.send(b"abc");
    assert!(chip.pending(Interrupt::USART2));
    assert!(chip.usart.sent.borrow().is_empty());
    serve();
    assert!(chip.usart.interrupts_for_sending());
    assert_eq!(*chip.usart.sent.borrow(), b"a");
    // While it is being sent, no other is.
    chip.usart.busy.set(true);
    serve();
    assert_eq!(*chip.usart.sent.borrow(), b"a");
    chip.usart.busy.set(false);
    for _ in 0..2 {
        serve();
        assert!(chip.usart.interrupts_for_sending());
    }
    serve();
    assert!(!chip.usart.interrupts_for_sending());
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
