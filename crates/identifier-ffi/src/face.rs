use core::ffi::c_void;

/// A function as Rust has it.
#[derive(Debug, Clone, Copy)]
pub struct Prototype {
    /// Its symbol.
    pub name: &'static str,
    /// Names and types of its arguments.
    pub arguments: &'static [(&'static str, &'static str)],
    /// Calls it with what is given for the name and type of each argument.
    pub call: unsafe fn(&mut dyn FnMut(&'static str, &'static str) -> Argument) -> i32,
}

/// An argument of any type.
#[allow(
    missing_docs,
    missing_debug_implementations,
    reason = "the types are named, and which one it is nobody knows"
)]
#[derive(Clone, Copy)]
#[repr(C)]
pub union Argument {
    pub i32: i32,
    pub u32: u32,
    pub f32: f32,
    pub f64: f64,
    pub address: *mut c_void,
}

impl Argument {
    /// # Safety
    /// It was written as a T.
    pub(crate) unsafe fn read<T: Copy>(self) -> T {
        // SAFETY: guaranteed by the caller.
        unsafe { (&raw const self).cast::<T>().read() }
    }
}

/// Functions for C, each of which returns a status, and the list `FACE` of them. A body gives its status, or refuses by
/// one.
macro_rules! face {
    ($(
        $(#[$doc:meta])*
        fn $name:ident($($argument:ident: $type:ty),* $(,)?) $body:block
    )*) => {
        $(
            $(#[$doc])*
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($argument: $type),*) -> i32 {
                #[inline(always)]
                unsafe fn answer($($argument: $type),*) -> Result<i32, i32> $body
                // SAFETY: guaranteed by the caller.
                match unsafe { answer($($argument),*) } {
                    Ok(status) | Err(status) => status,
                }
            }
        )*

        pub(crate) const FACE: &[crate::Prototype] = &[$(crate::Prototype {
            name: stringify!($name),
            arguments: &[$((stringify!($argument), stringify!($type))),*],
            call: |_next| {
                // SAFETY: guaranteed by the caller.
                unsafe {
                    $name($(_next(stringify!($argument), stringify!($type)).read::<$type>()),*)
                }
            },
        }),*];
    };
}
