//! Ends of the program. Whatever it is, the stage is disabled first; the watchdog then resets the chip.

use crate::board;

/// Disables the servo after a fault of the program.
pub fn give_up() -> ! {
    board::disable_outputs();
    #[cfg(feature = "emulator")]
    emulated::report();
    loop {
        cortex_m::asm::nop();
    }
}

/// The handlers of everything that ends a program. One is a hard fault, to which every other fault of the processor
/// escalates, an overflow of the stack among them. The others are a failed oscillator and an unexpected interrupt.
#[macro_export]
macro_rules! give_up_at_every_end {
    () => {
        /// An overflow has left no stack to work on: it begins anew. Nothing returns to what was on it.
        // SAFETY: the vector table has it for hard faults, and it touches no memory before the stack is whole.
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        unsafe extern "C" fn HardFault() -> ! {
            core::arch::naked_asm!(
                "movw r0, #:lower16:_stack_start",
                "movt r0, #:upper16:_stack_start",
                "msr msp, r0",
                "bl {give_up}",
                give_up = sym $crate::ending::give_up,
            )
        }

        #[cortex_m_rt::exception]
        unsafe fn DefaultHandler(_: i16) {
            $crate::ending::give_up()
        }

        /// The oscillator failed, or the flash is damaged where the program lies.
        #[cortex_m_rt::exception]
        unsafe fn NonMaskableInt() {
            if !$crate::board::outlives_nmi() {
                $crate::ending::give_up()
            }
        }
    };
}

/// A report to the emulator's host, for a test of the ends.
#[cfg(feature = "emulator")]
pub mod emulated {
    use core::sync::atomic::{AtomicBool, Ordering};

    use drive_chip::emulated::{is_high, outputs};

    use crate::board::BOARD;
    use crate::host::{exit, print};

    static IS_REPORTED: AtomicBool = AtomicBool::new(false);

    /// Has the end of the program be reported.
    pub fn report_end() {
        IS_REPORTED.store(true, Ordering::Relaxed);
    }

    /// True while the output drives the servo.
    #[must_use]
    pub fn drives() -> bool {
        outputs().duty.is_some() || is_high(BOARD.enable)
    }

    pub(super) fn report() {
        if IS_REPORTED.load(Ordering::Relaxed) {
            print(&[if drives() { "driven" } else { "disabled" }]);
            exit(!drives());
        }
    }
}
