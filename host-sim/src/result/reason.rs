use identifier_core::reason::Reason;
use serde::{Serialize, Serializer};

/// A reason of the core's catalogue.
pub(super) fn serialize<S: Serializer>(
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
