//! Records in a flash that may lose its power at any step.

use crate::support::{Flash, SECTOR};
use drive_link::Kept;
use drive_logic::{Store, StoreError};
use proptest::prelude::*;

/// Bytes of a slot.
const SLOT: usize = 1336;

/// Some contents of the size of a drive's.
fn contents(k: u32) -> [u32; 32] {
    std::array::from_fn(|i| k.wrapping_mul(2_654_435_761).rotate_left(i as u32))
}

/// Writes such contents.
fn written(k: u32) -> impl FnOnce(&mut [u8]) -> Option<usize> {
    move |room| {
        let bytes = contents(k).map(u32::to_le_bytes).concat();
        room.get_mut(..bytes.len())?.copy_from_slice(&bytes);
        Some(bytes.len())
    }
}

/// Opens a store of such contents.
fn open(flash: Flash, version: u16) -> (Store<Flash>, Option<[u32; 32]>, Kept) {
    let mut read = None;
    let (store, kept) = Store::open(flash, 0, version, |found, bytes| {
        if found != version {
            return false;
        }
        let (words, rest) = bytes.as_chunks::<4>();
        let words = words.iter().map(|&word| u32::from_le_bytes(word));
        let contents: Vec<u32> = words.collect();
        read = contents.try_into().ok().filter(|_| rest.is_empty());
        read.is_some()
    });
    (store, read.filter(|_| kept == Kept::Record), kept)
}

fn opened(flash: &Flash) -> (Store<Flash>, Option<[u32; 32]>, Kept) {
    let rebooted = Flash::with(flash.bytes.borrow().clone());
    open(rebooted, 1)
}

#[test]
fn a_blank_flash_holds_nothing_and_then_the_last_record() {
    let flash = Flash::blank();
    let (mut store, read, kept) = open(flash.clone(), 1);
    assert_eq!((read, kept), (None, Kept::Nothing));
    // More than both sectors hold, several times over.
    for k in 0..60 {
        store.keep(true, written(k)).expect("power is there");
        let (_, read, kept) = opened(&flash);
        assert_eq!(
            (read, kept),
            (Some(contents(k)), Kept::Record),
            "record {k}"
        );
    }
}

#[test]
fn after_a_power_loss_the_old_or_the_new_record_is_read() {
    // Every relevant number of records before the cut: in the first sector, at its end, in the second, and again in the
    // first.
    let slots = (SECTOR / SLOT) as u32;
    for before in 1..=2 * slots + 2 {
        let flash = Flash::blank();
        let (mut store, ..) = open(flash.clone(), 1);
        for k in 0..before {
            store.keep(true, written(k)).expect("power is there");
        }
        let image = flash.bytes.borrow().clone();
        // Steps that keeping one more takes.
        flash.steps.set(0);
        store.keep(true, written(before)).expect("power is there");
        let steps = flash.steps.get();
        for cut in 0..steps {
            let flash = Flash::with(image.clone());
            let (mut store, read, _) = open(flash.clone(), 1);
            assert_eq!(read, Some(contents(before - 1)));
            flash.steps_left.set(cut);
            store
                .keep(true, written(before))
                .expect_err("the power went");
            let (mut store, read, kept) = opened(&flash);
            assert_eq!(
                kept,
                Kept::Record,
                "{before} records, cut after {cut} of {steps}"
            );
            let read = read.expect("a record");
            assert!(
                read == contents(before - 1) || read == contents(before),
                "{before} records, cut after {cut} of {steps}"
            );
            // And the next one is kept in spite of the remains of the cut.
            store
                .keep(true, written(before + 1))
                .expect("power is back");
            // A store that continues without a reboot has the same record in force.
        }
    }
}

#[test]
fn an_attempt_that_failed_late_does_not_hide_the_one_after_it() {
    let flash = Flash::blank();
    let (mut store, ..) = open(flash.clone(), 1);
    store.keep(true, written(0)).expect("power is there");
    // All of the contents are written, and then the flash fails.
    flash.steps_left.set(SLOT / 4 - 1);
    assert_eq!(store.keep(true, written(1)), Err(StoreError::Flash));
    flash.steps_left.set(usize::MAX);
    store.keep(true, written(2)).expect("it continues");
    assert_eq!(opened(&flash).1, Some(contents(2)));
}

#[test]
fn a_record_that_does_not_read_back_is_not_kept() {
    let flash = Flash::blank();
    let (mut store, ..) = open(flash.clone(), 1);
    store.keep(true, written(0)).expect("the flash is new");
    // In the contents of the next slot.
    flash.worn.set(Some(SLOT + 20));
    assert_eq!(store.keep(true, written(1)), Err(StoreError::NotWritten));
    assert_eq!(opened(&flash).1, Some(contents(0)));
    // Only that slot is lost.
    store.keep(true, written(2)).expect("there are others");
    assert_eq!(opened(&flash).1, Some(contents(2)));
}

#[test]
fn a_record_of_another_version_is_known_as_such_and_left_alone() {
    let flash = Flash::blank();
    let (mut old, ..) = open(flash.clone(), 1);
    old.keep(true, written(7)).expect("power is there");
    let (mut new, read, kept) = open(flash.clone(), 2);
    assert_eq!((read, kept), (None, Kept::OtherVersion));
    let (_, read, _) = open(flash.clone(), 1);
    assert_eq!(read, Some(contents(7)));
    new.keep(true, written(8)).expect("power is there");
    let (_, read, kept) = open(flash.clone(), 2);
    assert_eq!((read, kept), (Some(contents(8)), Kept::Record));
}

#[test]
fn a_record_longer_than_a_slot_is_refused() {
    let (mut store, ..) = open(Flash::blank(), 1);
    assert_eq!(store.keep(true, |_| None), Err(StoreError::TooLong));
    let longer = |room: &mut [u8]| Some(room.len() + 1);
    assert_eq!(store.keep(true, longer), Err(StoreError::TooLong));
}

proptest! {
    #[test]
    fn damage_costs_only_the_damaged_record(
        records in 1_u32..12,
        place in 0_usize..2 * SECTOR,
        bit in 0_u8..8,
    ) {
        let flash = Flash::blank();
        let (mut store, ..) = open(flash.clone(), 1);
        for k in 0..records {
            store.keep(true, written(k)).expect("power is there");
        }
        flash.bytes.borrow_mut()[place] ^= 1 << bit;
        let (mut store, read, kept) = opened(&flash);
        let last = read.and_then(|read| (0..records).rev().find(|&k| contents(k) == read));
        match last {
            Some(last) => prop_assert!(last + 2 >= records, "only the struck one is gone"),
            None => {
                prop_assert_eq!(records, 1);
                prop_assert_eq!(kept, Kept::Damaged);
            }
        }
        store.keep(true, written(99)).expect("it continues");
    }

    #[test]
    fn a_flash_of_any_content_can_be_used(
        bytes in prop::collection::vec(any::<u8>(), 2 * SECTOR),
    ) {
        let flash = Flash::with(bytes);
        let (mut store, read, kept) = open(flash.clone(), 1);
        prop_assert_eq!((read, kept), (None, Kept::Damaged));
        store.keep(true, written(1)).expect("it is erased first");
        let (_, read, kept) = opened(&flash);
        prop_assert_eq!((read, kept), (Some(contents(1)), Kept::Record));
    }
}
