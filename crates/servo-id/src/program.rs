//! The program's name and version.

/// The name that it is installed by.
pub const NAME: &str = "servo-id";

/// Its version, with the commit where it was built for use from a repository.
pub const VERSION: &str = env!("SERVO_ID_VERSION");
