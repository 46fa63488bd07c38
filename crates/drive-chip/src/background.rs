//! The background of a drive on the chip.
//!
//! Generic code is compiled for the crate that names its types. These types are named here and not in the firmware. The
//! firmware is compiled for the speed of its interrupts, everything else for size.

use drive_link::{Fault, Settings};
use drive_logic::{BackgroundEnd, Conversation, Memory, OutputStage, Records};

use crate::Mmio;
use crate::flash::RecordFlash;
use crate::serial::Line;

/// The background of a family of chips.
macro_rules! background {
    ($name:ident, $family:ty, $documented:literal) => {
        #[doc = concat!("Of an ", $documented, ".")]
        pub mod $name {
            use super::*;

            /// The background's half.
            pub type Supervisor = drive_logic::Supervisor<'static, RecordFlash<Mmio<$family>>>;

            /// The background's half with the record in the flash; see [`drive_logic::Supervisor::new`]. None if there
            /// is one already, because its large memory is static.
            #[inline(never)]
            pub fn supervisor(
                channel: BackgroundEnd<'static>,
                memory: &'static mut Memory,
                flash: RecordFlash<Mmio<$family>>,
                built_in: &Settings,
                stage: OutputStage,
                found_at_boot: Result<(), Fault>,
            ) -> Option<&'static mut Supervisor> {
                let records = Records::open(flash, 0, &stage);
                place(channel, memory, records, built_in, stage, found_at_boot)
            }

            #[inline(never)]
            fn place(
                channel: BackgroundEnd<'static>,
                memory: &'static mut Memory,
                records: Records<RecordFlash<Mmio<$family>>>,
                built_in: &Settings,
                stage: OutputStage,
                found_at_boot: Result<(), Fault>,
            ) -> Option<&'static mut Supervisor> {
                cortex_m::singleton!(: Supervisor =
                    Supervisor::new(channel, memory, records, built_in, stage, found_at_boot))
            }

            /// One turn; true if there may be more to do at once.
            #[inline(never)]
            pub fn turn(
                conversation: &mut Conversation,
                line: &mut Line<'static, Mmio<$family>>,
                supervisor: &mut Supervisor,
            ) -> bool {
                conversation.turn(line, supervisor)
            }
        }
    };
}

background!(f4, crate::F4, "STM32F4");
background!(f401, crate::F401, "STM32F401");
background!(g4, crate::G4, "STM32G4");
