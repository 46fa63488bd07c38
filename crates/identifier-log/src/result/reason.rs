use identifier_core::reason::Reason;
use serde::{Serialize, Serializer};

/// Serialises a reason of the core's catalogue with its number, cause and remedy.
///
/// # Errors
/// Those of the serialiser.
pub fn serialize_reason<S: Serializer>(
    reason: &Option<Reason>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Keys {
        number: u8,
        name: &'static str,
        cause: &'static str,
        remedy: &'static str,
    }
    let keys = reason.map(|reason| Keys {
        number: reason.number(),
        name: reason.name(),
        cause: reason.cause(),
        remedy: reason.remedy(),
    });
    keys.serialize(serializer)
}
