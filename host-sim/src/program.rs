//! What the program calls itself.

use std::path::Path;
use std::sync::OnceLock;

/// Its version, with the commit where it was built for use from a repository.
pub const VERSION: &str = env!("HOST_SIM_VERSION");

/// The name that it is known by where none was typed.
const NAME: &str = "host-sim";

/// The name that was typed to start it, without folder and ending.
#[must_use]
pub fn name() -> &'static str {
    static TYPED: OnceLock<Option<String>> = OnceLock::new();
    let typed = TYPED.get_or_init(|| {
        let path = std::env::args_os().next()?;
        let name = Path::new(&path).file_stem()?.to_str()?;
        (!name.is_empty()).then(|| name.to_owned())
    });
    typed.as_deref().unwrap_or(NAME)
}
