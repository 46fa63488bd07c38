//! The bytes of a log where there are no files: those that were handed in last.

use std::cell::RefCell;
use std::io::{Cursor, Read};
use std::path::Path;
use std::rc::Rc;

use super::LogError;

thread_local! {
    static BYTES: RefCell<Rc<[u8]>> = RefCell::new(Rc::from([]));
}

/// Hands in the bytes of the one log that there is, whatever its path.
pub fn hold(bytes: Vec<u8>) {
    BYTES.set(Rc::from(bytes));
}

pub(super) fn open(_: &Path) -> Result<Box<dyn Read>, LogError> {
    let bytes = BYTES.with_borrow(Rc::clone);
    Ok(Box::new(Cursor::new(bytes)))
}
