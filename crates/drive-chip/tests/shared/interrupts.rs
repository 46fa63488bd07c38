use drive_chip::interrupts::{begin, begin_serial};

use crate::facts::PVD;
use crate::healthy;
use crate::pac::Interrupt;

#[test]
fn a_sample_interrupts_everything_and_a_byte_only_the_background() {
    let chip = healthy();
    begin(&chip);
    assert_eq!(chip.priority(Interrupt::TIM5), 0);
    assert_eq!(chip.priority(Interrupt::USART2), 0x80);
    // By then the priorities held.
    assert_eq!(chip.unmasked(Interrupt::TIM5), Some(0));
    assert_eq!(chip.unmasked(Interrupt::USART2), Some(0x80));
    assert_eq!(chip.unmasked(PVD), Some(0));
    assert_eq!(chip.unmasked_count(), 3);
}

#[test]
fn the_line_can_be_served_without_samples() {
    let chip = healthy();
    begin_serial(&chip);
    assert_eq!(chip.unmasked(Interrupt::USART2), Some(0x80));
    assert_eq!(chip.unmasked_count(), 1);
}

#[test]
fn other_priorities_stay_as_they_are() {
    let chip = healthy();
    chip.set_priorities(0x70);
    begin(&chip);
    for (interrupt, priority) in [
        (Interrupt::TIM5, 0),
        (Interrupt::USART2, 0x80),
        (Interrupt::SPI3, 0x70),
        (Interrupt::UART4, 0x70),
        (Interrupt::USART1, 0x70),
        (Interrupt::USART3, 0x70),
        (Interrupt::TIM2, 0x70),
    ] {
        assert_eq!(chip.priority(interrupt), priority, "{interrupt:?}");
    }
}
