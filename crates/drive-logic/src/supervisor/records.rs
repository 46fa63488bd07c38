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
        let mut read = None;
        let (store, mut kept) = Store::open(flash, start, Record::VERSION, |version, bytes| {
            read = match version {
                Record::VERSION | Record::WITH_UNPROVEN_LOADS => {
                    let own = stage.build(version);
                    Record::from_bytes(own, bytes).map(|found| (version, own, found))
                }
                _ => None,
            };
            read.is_some()
        });
        let read = read.map(|(version, own, found)| {
            if kept == Kept::Record {
                kept = match found {
                    Err(stored) => Kept::OtherBuild { stored, own },
                    Ok(_) if version != Record::VERSION => Kept::WithoutLoads,
                    Ok(_) => kept,
                };
            }
            found.map(|record| match version {
                Record::VERSION => record,
                _ => record.without_loads(),
            })
        });
        let is_taken = matches!(kept, Kept::Record | Kept::WithoutLoads);
        let mut record = read.and_then(Result::ok).filter(|_| is_taken);
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
