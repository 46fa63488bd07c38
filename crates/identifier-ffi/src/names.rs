//! Sentences for people.

use core::ffi::c_char;

use crate::object::write;
use crate::status::{self, NO_SUCH_NUMBER, OK};

face! {
    /// A sentence about a status.
    fn servo_id_status_text(status: i32, text: *mut *const c_char) {
        let found = status::ROWS.iter().find(|row| row.number == status);
        // SAFETY: the header's conditions.
        unsafe {
            match found {
                Some(row) => write(text, row.text.as_ptr()).map(|()| OK),
                None => write(text, c"this status has no text".as_ptr()).map(|()| NO_SUCH_NUMBER),
            }
        }
    }
}
