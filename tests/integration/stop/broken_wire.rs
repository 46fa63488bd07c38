//! A wire that breaks: the receiver has a framing error, and nothing of what was sent meanwhile.

use drive_link::{Command, Fault, Refusal, State};

use super::host::{DONE, Host};
use super::machine::BYTE;
use super::{LIMIT, settings};

/// Rate of the samples, Hz.
const RATE: u32 = 10_000;

/// Bytes of a start or a stop, with the zero at the end.
const REQUEST: usize = 8;

/// Bytes of a start with its zero: two more, the version and the number of the order.
const START: usize = REQUEST + 2;

#[test]
fn an_order_with_a_break_behind_it_is_refused_by_name_and_one_with_it_inside_is_none() {
    let mut host = Host::configured(RATE, 0.0);
    for time in [BYTE, 3 * BYTE, 200 * BYTE] {
        host.request(Command::Start);
        host.break_wire(time);
        host.pass(DONE + time);
        assert_eq!(host.refusals(), [Refusal::LineDisturbed], "{time} ns");
        assert!(!host.is_driven());
    }
    for place in 1..START {
        host.cut(Command::Start, place);
        host.pass(DONE);
        // The break is a zero, as the end of a request is.
        let is_whole = place == START - 1;
        let expected = is_whole.then_some(Refusal::LineDisturbed);
        assert_eq!(host.refusals(), Vec::from_iter(expected), "{place}");
        assert!(!host.is_driven());
    }
    host.start();
}

#[test]
fn a_break_ends_no_run_and_the_stop_behind_it_is_obeyed() {
    let mut host = Host::configured(RATE, 0.0);
    for place in 0..=REQUEST {
        host.start();
        host.break_wire(3 * BYTE);
        host.pass(DONE);
        assert!(host.is_driven());
        // A stop that is cut by a break, and the host's next.
        host.cut(Command::Stop, place);
        let began = host.stop();
        host.run_to(began + LIMIT);
        assert!(!host.is_driven(), "{place}");
        assert!(host.last_driven() <= began + LIMIT);
        host.pass(DONE);
        host.refusals();
    }
}

#[test]
fn a_wire_that_stays_broken_ends_the_run_by_name() {
    const TIMEOUT: f64 = 0.1;
    for place in [0, 3, REQUEST] {
        let mut host = Host::configured(RATE, TIMEOUT);
        host.start();
        let broken = host.now();
        host.cut(Command::KeepAlive, place);
        // It closes once in a while, and noise is heard, which is no sign of life.
        for _ in 0..100 {
            host.break_wire(10_000_000);
            host.flood();
        }
        let stop_time = settings(RATE).protection.stop_time;
        host.pass(((TIMEOUT + stop_time) * 1e9) as u64 + DONE);
        assert_eq!(host.state(), State::Faulted(Fault::LinkLost), "{place}");
        assert!(!host.is_driven());
        let taken = 1e-9 * (host.last_driven() - broken) as f64;
        assert!(taken > 0.9 * TIMEOUT - 1e-9 * DONE as f64, "{taken} s");
    }
}
