use embedded_hal::pwm::SetDutyCycle;

use crate::model::Line;
use crate::{healthy, wired};

#[test]
fn every_line_that_is_not_closed_to_ground_is_a_fault_of_its_own() {
    for line in [Line::Open, Line::Supply] {
        for (place, (port, number)) in [(1, 12), (2, 0), (2, 1)].into_iter().enumerate() {
            let chip = healthy();
            let mut wired = wired(&chip);
            let _ = wired.pwm.set_duty_cycle_fully_off();
            let inputs = wired.inputs;
            let read = || {
                let [low, high] = inputs.closed_switches();
                [inputs.amplifier_is_healthy(), low, high]
            };
            assert_eq!(read(), [true; 3]);
            chip.drive(port, number, line);
            let mut expected = [true; 3];
            expected[place] = false;
            assert_eq!(read(), expected, "{line:?} at {port} {number}");
        }
    }
}

#[test]
fn the_home_switch_is_closed_by_ground_alone() {
    let chip = healthy();
    let inputs = wired(&chip).inputs;
    for (line, closed) in [
        (Line::Open, false),
        (Line::Ground, true),
        (Line::Supply, false),
    ] {
        chip.drive(2, 2, line);
        assert_eq!(inputs.home_switch_is_closed(), closed, "{line:?}");
    }
}
