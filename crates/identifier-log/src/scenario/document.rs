//! What a text of TOML is read into.

use super::kind::{Key, When};
use super::read;
use super::source::Source;
use super::{Fault, Options, ScenarioError};

/// Settings that are read from a text: [`Options`], or these and more.
pub trait Document: AsRef<Options> + AsMut<Options> + 'static {
    /// False if a text may have keys that are not among these.
    const IS_WHOLE: bool = true;

    /// All keys, in the order in which they are read.
    fn keys() -> &'static [Key<Self>]
    where
        Self: Sized;

    /// True if the defaults of a table hold that the text does not state. `states` tells which tables it does.
    fn holds(&self, when: When, states: &dyn Fn(&str) -> bool) -> bool;

    /// Reads a text into this document, of which nothing is stated yet, and checks it by `complete`. Errors show `name`
    /// as the file.
    ///
    /// # Errors
    /// File, line, key and what is allowed there.
    fn read(
        self,
        name: &str,
        text: &str,
        complete: impl FnOnce(Self) -> Result<Self, Fault>,
    ) -> Result<Self, ScenarioError>
    where
        Self: Sized,
    {
        let source = Source::new(name, text)?;
        read::document(&source, self)
            .and_then(complete)
            .map_err(|fault| source.locate::<Self>(fault))
    }
}
