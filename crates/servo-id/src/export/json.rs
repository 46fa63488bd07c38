use serde_json::json;

use super::joint::Joint;

pub(super) fn written(joints: &[Joint]) -> String {
    format!("{:#}\n", json!({ "joints": joints }))
}
