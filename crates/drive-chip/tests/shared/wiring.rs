use drive_chip::flash::Areas;
use drive_chip::{Board, wire};
use drive_link::Fault;
use embedded_storage::nor_flash::NorFlash;

use crate::facts::{PAGES_OF_AREAS_2_AND_3, PORTS};
use crate::model::{Chip, Level, Output};
use crate::{BOARD, Family, healthy, memory, slow, wired};

#[test]
fn the_outputs_are_low_before_anything_else() {
    let chip = healthy();
    // As an earlier program may have left them.
    for (port, number) in [(0, 8), (1, 14), (1, 15)] {
        chip.pins.leave_open_drain(port, number);
    }
    let _wired = wired(&chip);
    let bsrr = |port: u32| PORTS + 0x18 + 0x400 * port;
    let last = [(0, 8), (1, 14), (1, 15)]
        .map(|(port, number)| chip.first_write(bsrr(port), |word| word == 1 << (16 + number)))
        .into_iter()
        .max()
        .expect("three")
        .expect("all of them were set low");
    let moded = [0, 1]
        .map(|port| chip.first_write(PORTS + 0x400 * port, |_| true))
        .map(|place| place.expect("both ports have outputs"));
    let rcc = &chip.clocks.rcc;
    let clocks = chip.first_write(rcc.address(rcc.cr()), |_| true);
    assert!(clocks.expect("the clocks were set") > last);
    assert!(clocks.expect("the clocks were set") > moded[0].max(moded[1]));
    // And low before they were outputs at all.
    for (port, number) in [(0, 8), (1, 15)] {
        let low = chip.first_write(bsrr(port), |word| word == 1 << (16 + number));
        assert!(low < Some(moded[port as usize]));
    }
    assert_eq!(chip.pins.driven(1, 15), Level::Low);
    assert_eq!(chip.pins.driven(1, 14), Level::Low);
    assert_eq!(chip.output(), Output::Low);
    for (port, number) in [(0, 8), (1, 14), (1, 15)] {
        assert!(chip.pins.is_push_pull(port, number));
    }
}

#[test]
fn the_pwm_s_pin_never_floats_once_it_is_low() {
    let chip = healthy();
    let _wired = wired(&chip);
    let low_from = chip
        .outputs()
        .iter()
        .position(|&output| output == Output::Low);
    let low_from = low_from.expect("low");
    assert!(
        chip.outputs()[low_from..]
            .iter()
            .all(|&output| output == Output::Low)
    );
}

#[test]
fn timers_left_running_by_an_earlier_program_restart() {
    let chip = healthy();
    let first = wired(&chip);
    first.timer.start(1e-3);
    chip.timers.turn(5);
    chip.elapse(3e-3);
    let _second = wired(&chip);
    assert_eq!(chip.timers.counting(), [false, false]);
    assert_eq!(chip.timers.tim5.get(chip.timers.tim5.sr()), 0);
}

#[test]
fn the_fault_found_is_returned() {
    let blame_watchdog = |chip: &Chip| {
        let rcc = &chip.clocks.rcc;
        rcc.set(rcc.csr(), rcc.get(rcc.csr()) | 1 << 29);
        assert!(chip.clocks.blames_watchdog());
    };
    assert_eq!(wired(&healthy()).found, Ok(()));
    assert_eq!(wired(&slow()).found, Err(Fault::ClockNotStable));
    let reset = healthy();
    blame_watchdog(&reset);
    assert_eq!(wired(&reset).found, Err(Fault::ResetByWatchdog));
    // Only once.
    assert!(!reset.clocks.blames_watchdog());
    let both = slow();
    blame_watchdog(&both);
    assert_eq!(wired(&both).found, Err(Fault::ClockNotStable));
}

#[test]
fn another_board_keeps_its_records_elsewhere() {
    const OTHER: Board<Family> = Board {
        records: Areas::starting_at(2),
        ..BOARD
    };
    let chip: Chip = healthy();
    let (ring, queue) = memory(&chip);
    let mut flash = wire(&chip, &OTHER, ring, queue).flash;
    assert_eq!(flash.erase(0, 0x8000), Ok(()));
    assert_eq!(*chip.memory.erased.borrow(), PAGES_OF_AREAS_2_AND_3);
    assert_eq!(flash.write(0x4000, &[0; 8]), Ok(()));
    assert_eq!(chip.memory.bytes(0x0800_c000, 8), [0; 8]);
}
