use drive_chip::inputs::Healthy;
use embedded_hal::pwm::SetDutyCycle;

use crate::model::Line;
use crate::{healthy, wired};

const ALL: Healthy = Healthy {
    amplifier: true,
    low_switch: true,
    high_switch: true,
};

#[test]
fn every_line_that_is_not_closed_to_ground_is_a_fault_of_its_own() {
    for line in [Line::Open, Line::Supply] {
        for (pin, found) in [
            (
                (1, 12),
                Healthy {
                    amplifier: false,
                    ..ALL
                },
            ),
            (
                (2, 0),
                Healthy {
                    low_switch: false,
                    ..ALL
                },
            ),
            (
                (2, 1),
                Healthy {
                    high_switch: false,
                    ..ALL
                },
            ),
        ] {
            let chip = healthy();
            let mut wired = wired(&chip);
            let _ = wired.pwm.set_duty_cycle_fully_off();
            assert_eq!(wired.inputs.read(), ALL);
            let (port, number) = pin;
            chip.drive(port, number, line);
            assert_eq!(wired.inputs.read(), found, "{line:?} at {pin:?}");
        }
    }
}
