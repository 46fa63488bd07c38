//! Enumerations whose values have a name in a scenario.

/// Declares an enumeration with the names of its values in scenarios and results. The default is first. Each has the
/// keys of its table that belong to it alone.
#[macro_export]
macro_rules! named {
    (
        $(#[$meta:meta])*
        pub enum $type:ident {
            $($(#[$doc:meta])* $variant:ident = $name:literal $(takes $keys:expr)?,)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $type {
            $($(#[$doc])* $variant,)*
        }

        impl $type {
            /// All of them, the default first.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Their names and keys, in the same order.
            pub const CHOICES: &'static [$crate::scenario::Choice] = &[$(
                $crate::scenario::Choice {
                    name: $name,
                    takes: $crate::named!(@keys $($keys)?),
                }
            ),*];

            /// Its name in scenarios and results.
            #[must_use]
            pub const fn name(self) -> &'static str {
                Self::CHOICES[self as usize].name
            }
        }

        impl std::str::FromStr for $type {
            /// All names.
            type Err = String;

            fn from_str(word: &str) -> Result<Self, String> {
                let found = Self::ALL.iter().find(|one| one.name() == word);
                found.copied().ok_or_else(|| {
                    let names: Vec<_> = Self::ALL.iter().map(|one| one.name()).collect();
                    format!("one of {}", names.join(", "))
                })
            }
        }
    };
    (@keys) => { &[] };
    (@keys $keys:expr) => { $keys };
}
pub(super) use crate::named;
