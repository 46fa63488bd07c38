//! Objects in the caller's memory.

use core::mem::MaybeUninit;

use crate::settings::Settings;
use crate::status::{self, Error};

/// The content of an object.
///
/// It has no address of itself or of anything else, so that an object may be copied byte by byte.
pub trait Content: Copy {
    /// Marks initialised storage: another number for each content.
    const MARK: u32;
    /// Eight-byte words of the storage, as the header has them.
    const WORDS: usize;
    /// The content fits into the storage of the header, which has some room for what the core may need more.
    const FITS: () = assert!(size_of::<Object<Self>>() <= 8 * Self::WORDS);
}

/// Storage of the caller: `uint64_t words[WORDS]` in the header.
#[derive(Debug)]
#[repr(C, align(8))]
pub struct Object<T> {
    mark: u32,
    content: MaybeUninit<T>,
}

/// Size and name of an object in the header.
pub trait HasWords {
    /// Eight-byte words.
    const WORDS: usize;
}

impl<T: Content> HasWords for Object<T> {
    const WORDS: usize = T::WORDS;
}

impl<T> Object<T> {
    /// Storage that was not initialised.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            mark: 0,
            content: MaybeUninit::uninit(),
        }
    }
}

/// The content of an object that was initialised.
///
/// # Safety
/// An address that is neither null nor misaligned is of an object that nothing else uses meanwhile.
#[inline(always)]
pub(crate) unsafe fn content<'a, T: Content>(object: *mut Object<T>) -> Result<&'a mut T, i32> {
    check(object)?;
    // SAFETY: guaranteed by the caller; an integer and bytes that may be anything are always valid.
    let object = unsafe { &mut *object };
    if object.mark != T::MARK {
        return Err(status::NOT_INITIALISED);
    }
    // SAFETY: the mark is set once the content is.
    Ok(unsafe { object.content.assume_init_mut() })
}

/// The same for reading.
///
/// # Safety
/// As for [`content`], but others may read it too.
#[inline(always)]
pub(crate) unsafe fn shared<'a, T: Content>(object: *const Object<T>) -> Result<&'a T, i32> {
    const { T::FITS };
    check(object)?;
    // SAFETY: as in `content`.
    let object = unsafe { &*object };
    if object.mark != T::MARK {
        return Err(status::NOT_INITIALISED);
    }
    // SAFETY: as in `content`.
    Ok(unsafe { object.content.assume_init_ref() })
}

/// Storage for an object, not initialised from now on: its address is right, and it has `size` bytes.
///
/// # Safety
/// As for [`content`].
pub(crate) unsafe fn storage<T: Content>(
    object: *mut Object<T>,
    size: u32,
) -> Result<*mut Object<T>, i32> {
    const { T::FITS };
    check(object)?;
    if (size as usize) < 8 * T::WORDS {
        return Err(status::TOO_SMALL);
    }
    // SAFETY: guaranteed by the caller.
    unsafe { (&raw mut (*object).mark).write(0) };
    Ok(object)
}

/// Initialises an object.
///
/// # Safety
/// It is of [`storage`].
pub(crate) unsafe fn fill<T: Content>(object: *mut Object<T>, content: T) {
    // SAFETY: guaranteed by the caller.
    unsafe {
        (&raw mut (*object).content).write(MaybeUninit::new(content));
        (&raw mut (*object).mark).write(T::MARK);
    }
}

/// Refuses an address that cannot be of a T.
#[inline(always)]
pub(crate) fn check<T>(address: *const T) -> Result<(), i32> {
    if address.is_null() {
        Err(status::NULL_POINTER)
    } else if !address.is_aligned() {
        Err(status::MISALIGNED)
    } else {
        Ok(())
    }
}

/// Settings that are complete.
///
/// # Safety
/// As the header says.
pub(crate) unsafe fn given<'a>(settings: *const Settings) -> Result<&'a Settings, Error> {
    check(settings)?;
    // SAFETY: guaranteed by the caller.
    let settings = unsafe { &*settings };
    settings.complete()?;
    Ok(settings)
}

/// Writes a result.
///
/// # Safety
/// An address that is neither null nor misaligned may be written.
#[inline(always)]
pub(crate) unsafe fn write<T>(address: *mut T, value: T) -> Result<(), i32> {
    check(address)?;
    // SAFETY: guaranteed by the caller.
    unsafe { address.write(value) };
    Ok(())
}

/// Reads an argument.
///
/// # Safety
/// An address that is neither null nor misaligned may be read.
#[inline(always)]
pub(crate) unsafe fn read<T: Copy>(address: *const T) -> Result<T, i32> {
    check(address)?;
    // SAFETY: guaranteed by the caller.
    Ok(unsafe { address.read() })
}

/// The status of a result, with its refusal written where the caller wants it.
///
/// # Safety
/// An address that is neither null nor misaligned may be written.
pub(crate) unsafe fn answered(address: *mut Error, result: Result<i32, Error>) -> Result<i32, i32> {
    result.map_err(|refused| {
        // SAFETY: guaranteed by the caller. Null is allowed: only the status is read then.
        let _ = unsafe { write(address, refused) };
        refused.status
    })
}
