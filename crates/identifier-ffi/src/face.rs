/// A function as Rust has it.
#[derive(Debug, Clone, Copy)]
pub struct Prototype {
    /// Its symbol.
    pub name: &'static str,
    /// Names and types of its arguments.
    pub arguments: &'static [(&'static str, &'static str)],
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
        }),*];
    };
}
