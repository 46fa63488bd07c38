//! The keys as a JSON schema (draft 2020-12), so that an editor knows them.

use serde_json::{Map, Value, json};

use super::Document;
use super::kind::{Choice, Default, Key};

/// The schema of a document.
#[must_use]
pub fn schema<S: Document>() -> Value {
    let mut schema = table::<S>("");
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("A scenario of servo-id");
    schema
}

fn table<S: Document>(path: &str) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    let mut conditions = Vec::new();
    for key in Key::<S>::children(path) {
        let (_, name) = key.place();
        properties.insert(name.to_owned(), property(key));
        let always = key.belongs_to().is_empty();
        if always && matches!(key.default, Default::Required(_)) {
            required.push(name);
        }
        conditions.extend(conditions_of(key));
    }
    let mut table = json!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    });
    // An empty list of schemas is no schema.
    if !conditions.is_empty() {
        table["allOf"] = json!(conditions);
    }
    table
}

/// The conditions that each choice of a key puts on the keys beside it.
fn conditions_of<S: Document>(key: &Key<S>) -> Vec<Value> {
    let (table, name) = key.place();
    let choices = key.kind.choices();
    let condition = |(i, choice): (usize, &Choice)| {
        let beside = || Key::<S>::children(table);
        let foreign: Map<_, _> = beside()
            .filter(|other| other.is_foreign_to(choice, choices))
            .map(|other| (other.place().1.to_owned(), json!(false)))
            .collect();
        let required: Vec<_> = beside()
            .filter(|other| matches!(other.default, Default::Required(_)))
            .map(|other| other.place().1)
            .filter(|name| choice.takes.contains(name))
            .collect();
        // The first choice is the default: it holds where nothing is chosen, too.
        let stated = if i == 0 { vec![] } else { vec![name] };
        json!({
            "if": { "properties": { name: { "const": choice.name } }, "required": stated },
            "then": { "properties": foreign, "required": required },
        })
    };
    choices.iter().enumerate().map(condition).collect()
}

/// The schema of a key's value.
#[must_use]
pub fn property<S: Document>(key: &Key<S>) -> Value {
    let mut property = key.kind.schema(|| table::<S>(key.path));
    property["description"] = json!(match key.unit {
        "" => key.description(),
        unit => format!("{}, {unit}", key.description()),
    });
    match (key.default, key.kind.choices()) {
        (Default::Value(value) | Default::Initial(value), _) => property["default"] = json!(value),
        (Default::FirstChoice, [first, ..]) => property["default"] = json!(first.name),
        _ => {}
    }
    property
}
