//! The STM32F401's interrupts and their vectors, by the vendor's description.

pub(super) use drive_chip::F401 as Family;
pub use drive_chip::background::f401 as background;
pub use stm32f4xx_hal::pac::{Interrupt, interrupt};

/// The handler of the supply's detector.
#[macro_export]
macro_rules! disable_at_a_sag {
    () => {
        /// The supply sags.
        #[interrupt]
        fn EXTI16_PVD() {
            $crate::board::disable_for_sag();
        }
    };
}
