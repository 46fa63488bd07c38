//! Options of a command line, which a program that has none sets by their names.

use crate::scenario::{CommandUnit, Integrator, PositionUnit, TimeUnit};

/// A value that an option may have.
pub(crate) trait OptionValue: Sized {
    /// From a text.
    ///
    /// # Errors
    /// The allowed values.
    fn from_text(text: &str) -> Result<Self, String>;
}

impl OptionValue for f64 {
    fn from_text(text: &str) -> Result<Self, String> {
        let number = text.parse().ok().filter(|number: &Self| !number.is_nan());
        number.ok_or_else(|| "a number, such as 0.05 or 5e-2".to_owned())
    }
}

macro_rules! as_parsed {
    ($($type:ty)*) => {$(
        impl $crate::options::OptionValue for $type {
            fn from_text(text: &str) -> Result<Self, String> {
                text.parse().map_err(|allowed: <Self as std::str::FromStr>::Err| allowed.to_string())
            }
        }
    )*};
}
as_parsed! { String CommandUnit Integrator PositionUnit TimeUnit }
pub(crate) use as_parsed;

/// Options of one value, a line each: name, type, what the help shows for the value, and further settings of the option. A
/// type derives the command line's arguments from them, and takes their values by name. `more` has the others.
macro_rules! options {
    (
        $(#[$meta:meta])*
        pub struct $type:ident {
            $($(#[doc = $about:literal])* $name:ident: $value:ty = $shown:literal $({ $($setting:tt)* })?,)*
        }
        more { $($(#[doc = $of_other:literal])* #[cfg_attr($($clap:tt)*)] pub $other:ident: $of:ty,)* }
    ) => {
        $(#[$meta])*
        #[cfg_attr(feature = "clap", derive(clap::Args), command(allow_negative_numbers = true))]
        pub struct $type {
            $(
                $(#[doc = $about])*
                #[cfg_attr(feature = "clap", arg(long, value_name = $shown $(, $($setting)*)?))]
                pub $name: Option<$value>,
            )*
            $($(#[doc = $of_other])* #[cfg_attr($($clap)*)] pub $other: $of,)*
        }

        impl $type {
            /// All options by their names, and what they are.
            pub const HELP: &'static [(&'static str, &'static str)] = &[
                $((stringify!($name), concat!($($about),*)),)*
                $((stringify!($other), concat!($($of_other),*)),)*
            ];

            /// Takes the value of an option by its name, as the answer to a question is one.
            ///
            /// # Errors
            /// The allowed values.
            pub fn answer(&mut self, name: &str, answer: &str) -> Result<(), String> {
                use crate::options::OptionValue;
                match name.replace('-', "_").as_str() {
                    $(stringify!($name) => self.$name = Some(OptionValue::from_text(answer)?),)*
                    _ => return Err("no option of one value has this name".to_owned()),
                }
                Ok(())
            }
        }
    };
}
pub(crate) use options;
