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
        let mut read = None;
        let (store, mut kept) = Store::open(flash, start, Record::VERSION, |bytes| {
            read = Record::from_bytes(own, bytes);
            read.is_some()
        });
        if kept == Kept::Record
            && let Some(Err(stored)) = read
        {
            kept = Kept::OtherBuild { stored, own };
        }
        let mut record = read.and_then(Result::ok).filter(|_| kept == Kept::Record);
        if let Some(Record { settings, .. }) = &record
            && Run::check(settings, stage).is_err()
        {
            (record, kept) = (None, Kept::OtherVersion);
        }
        Self {
            store,
            record,
            kept,
        }
    }
}
