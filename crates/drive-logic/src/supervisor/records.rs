use drive_link::{Kept, Record};
use embedded_storage::nor_flash::NorFlash;

use crate::chip::OutputStage;
use crate::run::Run;
use crate::store::Store;

/// The store of a drive, and the record that was found in it.
#[derive(Debug)]
pub struct Records<F> {
    pub(super) store: Store<F>,
    pub(super) record: Option<Record>,
    pub(super) kept: Kept,
}

impl<F: NorFlash> Records<F> {
    /// Opens the store in the two sectors from an address of the flash on. A record that this firmware would refuse is
    /// of no use, however whole it is.
    ///
    /// On its own, for its stack to be free before there is a [`Supervisor`](super::Supervisor).
    #[inline(never)]
    pub fn open(flash: F, start: u32, stage: &OutputStage) -> Self {
        let own = stage.build();
        let read = |bytes: &[u8]| Record::from_bytes(own, bytes);
        let (store, read, kept) = Store::open(flash, start, Record::VERSION, read);
        let (record, kept) = match read {
            Some(Ok(record)) if Run::check(&record.settings, stage).is_ok() => (Some(record), kept),
            Some(Ok(_)) => (None, Kept::OtherVersion),
            Some(Err(stored)) => (None, Kept::OtherBuild { stored, own }),
            None => (None, kept),
        };
        Self {
            store,
            record,
            kept,
        }
    }
}
