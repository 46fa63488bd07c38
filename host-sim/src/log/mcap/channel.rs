//! The fields of a channel with their meaning, as a JSON schema.

use serde_json::{Map, Value, json};

/// A channel of flat numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Channel {
    /// Its topic.
    pub topic: &'static str,
    /// The schema's name.
    pub schema: &'static str,
    /// Its fields: name, and meaning with unit.
    pub fields: &'static [(&'static str, &'static str)],
}

/// The topic of the joint states.
pub const JOINTS: &str = "/joint_states";

/// The name of the one joint.
pub const JOINT: &str = "servo";

impl Channel {
    /// Its schema. No field is required: unknown values are left out.
    #[must_use]
    pub fn schema(&self) -> Value {
        let field = |(name, meaning): &(&str, &str)| {
            let schema = json!({ "type": "number", "description": meaning });
            ((*name).to_owned(), schema)
        };
        let properties: Map<String, Value> = self.fields.iter().map(field).collect();
        json!({ "title": self.schema, "type": "object", "properties": properties })
    }
}

/// The schema of joint states: that of `sensor_msgs/JointState` of ROS, in JSON.
#[must_use]
pub fn joint_states() -> Value {
    let numbers = json!({ "type": "array", "items": { "type": "number" } });
    json!({
        "title": "sensor_msgs/JointState",
        "type": "object",
        "properties": {
            "header": {
                "type": "object",
                "properties": {
                    "stamp": {
                        "type": "object",
                        "properties": {
                            "sec": { "type": "integer" },
                            "nanosec": { "type": "integer" }
                        }
                    },
                    "frame_id": { "type": "string" }
                }
            },
            "name": { "type": "array", "items": { "type": "string" } },
            "position": numbers,
            "velocity": numbers,
            "effort": numbers
        }
    })
}
