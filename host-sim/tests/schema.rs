//! The schema of a scenario says what its reader says.

use serde_json::Value;
use toml::de::{DeTable, DeValue};

use host_sim::scenario::keys::KEYS;
use host_sim::scenario::{Default, Kind, Purpose, Scenario};
use identifier_log::scenario::schema::{property, schema};

type Key = identifier_log::scenario::Key<Scenario>;

fn json(value: &DeValue<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::from(&**text),
        DeValue::Integer(number) => Value::from(number.as_str().parse::<i64>().expect("short")),
        DeValue::Float(number) => Value::from(number.as_str().parse::<f64>().expect("number")),
        DeValue::Boolean(value) => Value::from(*value),
        DeValue::Datetime(date) => Value::from(date.to_string()),
        DeValue::Array(list) => list.iter().map(|entry| json(entry.get_ref())).collect(),
        DeValue::Table(table) => document(table),
    }
}

fn document(table: &DeTable<'_>) -> Value {
    let entry = |(name, value): (&toml::Spanned<_>, &toml::Spanned<_>)| {
        let name: &std::borrow::Cow<'_, str> = name.get_ref();
        (name.to_string(), json(value.get_ref()))
    };
    Value::Object(table.iter().map(entry).collect())
}

/// Validates a value by the words of draft 2020-12 that the schema is made of.
fn valid(schema: &Value, value: &Value) -> bool {
    let Value::Object(words) = schema else {
        return *schema == true;
    };
    let each = |schemas: &Value| -> Vec<bool> {
        let schemas = schemas.as_array().expect("a list of schemas");
        // Draft 2020-12 asks for one at least.
        assert!(!schemas.is_empty(), "no schema");
        schemas.iter().map(|schema| valid(schema, value)).collect()
    };
    let number = |word: &Value| word.as_f64().expect("a number");
    let (size, list) = (value.as_f64(), value.as_array());
    let count = list.map(|list| list.len() as f64);
    let length = value.as_str().map(|text| text.chars().count() as f64);
    words.iter().all(|(name, word)| match name.as_str() {
        "$schema" | "title" | "description" | "default" | "then" | "additionalProperties" => true,
        "type" => match word.as_str() {
            Some("object") => value.is_object(),
            Some("array") => value.is_array(),
            Some("string") => value.is_string(),
            Some("number") => value.is_number(),
            Some("integer") => value.is_i64() || value.is_u64(),
            other => panic!("type {other:?}"),
        },
        "const" => value == word,
        "enum" => word.as_array().is_some_and(|names| names.contains(value)),
        "minimum" => size.is_none_or(|size| size >= number(word)),
        "exclusiveMinimum" => size.is_none_or(|size| size > number(word)),
        "maximum" => size.is_none_or(|size| size <= number(word)),
        "minItems" => count.is_none_or(|size| size >= number(word)),
        "maxItems" => count.is_none_or(|size| size <= number(word)),
        "minLength" => length.is_none_or(|size| size >= number(word)),
        "maxLength" => length.is_none_or(|size| size <= number(word)),
        "uniqueItems" => {
            list.is_none_or(|list| (0..list.len()).all(|i| !list[..i].contains(&list[i])))
        }
        "items" => list.is_none_or(|list| list.iter().all(|entry| valid(word, entry))),
        "anyOf" => each(word).contains(&true),
        "allOf" => !each(word).contains(&false),
        "if" => !valid(word, value) || valid(&words["then"], value),
        "required" => value.as_object().is_none_or(|table| {
            let mut names = word.as_array().expect("names").iter();
            names.all(|name| table.contains_key(name.as_str().expect("a name")))
        }),
        "properties" => value.as_object().is_none_or(|table| {
            let closed = words.get("additionalProperties") == Some(&Value::from(false));
            table.iter().all(|(name, value)| match word.get(name) {
                Some(schema) => valid(schema, value),
                None => !closed,
            })
        }),
        other => panic!("{other} is not checked"),
    })
}

fn accepts(text: &str) -> bool {
    let table = DeTable::parse(text).expect("TOML");
    valid(&schema::<Scenario>(), &document(table.get_ref()))
}

#[test]
fn every_scenario_of_the_repository_is_accepted() {
    let names = "compare drift friction geared_axis minimal paper-least-squares paper replay sweep";
    for name in names.split(' ') {
        let text = std::fs::read_to_string(format!("scenarios/{name}.toml"));
        assert!(accepts(&text.expect("a scenario")), "{name}");
    }
}

/// Schema and reader say the same of every kind of fault that a schema can know of.
#[test]
fn the_schema_refuses_every_shape_that_the_reader_refuses() {
    let plant = "[plant]\na = 0.5\nb = 200.0\n";
    for wrong in [
        "laod = 1.0",
        "[motor]\nx = 1",
        "[run]\nduration = \"long\"",
        "gravity = [1.0]",
        "ripple_order = 0",
        "resonance = 9.0\ninertia_ratio = 1",
        "[run]\nduration = 0",
        "[encoder]\ncounts_per_rev = -1",
        "[controller]\nkp = 1e10",
        "[controller]\nvelocity_filter = { kind = \"difference\", cutoff = 5.0 }",
        "[excitation]\nkind = \"prbs\"\nhold = 0.1",
        "[excitation]\nperiod = 1.0",
        "[excitation]\nseed = -1",
        "[excitation]\nkind = \"magic\"",
        "[identifier]\nlaw = \"window\"\nmu = 1.0",
        "[identifier]\nrelay = 1.0",
        "[identifier]\nranges = { error = 1.0, velocity = 1.0, command = 1.0 }",
        "[identifier]\nparameters = [\"a\", \"a\"]",
        "[identifier]\nbounds = { a = [1.0] }",
        "[identifier]\nservo_range = { a = [0.0, 1.0] }",
        "fault = []",
        "[fault]\nkind = \"overrun\"\ntime = 1.0",
        "[[fault]]\nkind = \"overrun\"",
        "[[fault]]\ntime = 1.0",
        "[[fault]]\nkind = \"magic\"\ntime = 1.0",
        "[[fault]]\nkind = \"load-step\"\ntime = 1.0",
        "[[fault]]\nkind = \"overrun\"\ntime = 1.0\nsize = 1.0",
        "[[fault]]\nkind = \"encoder-jump\"\ntime = 1.0\nsize = 5\nduration = 1.0",
        "[[fault]]\nkind = \"overrun\"\ntime = -1.0",
        "[log]\nposition = 0",
        "[log]\nposition = 1.5",
        "[log]\nposition = 1\nposition_unit = \"inch\"",
        "[log]\nposition = 1\ncut = []",
        "[log]\nposition = 1\ncut = [[1.0]]",
        "[log]\nposition = 1\ncut = [1.0, 2.0]",
    ] {
        let text = format!("{plant}{wrong}\n");
        let read = Scenario::parse("s", &text, Purpose::Run);
        assert!(read.is_err() && !accepts(&text), "{wrong}");
    }
    for right in [
        "",
        "[[fault]]\nkind = \"load-step\"\ntime = 1.0\nsize = 5.0\nduration = 2.0\n\
         [[fault]]\nkind = \"overrun\"\ntime = 1.0",
        "[log]\nposition = 1\ncut = [[1.0, 2.0]]",
    ] {
        assert!(accepts(&format!("{plant}{right}\n")), "{right}");
    }
}

/// The example of each required key is one that may be copied.
#[test]
fn examples_are_valid() {
    for key in KEYS.iter() {
        let Default::Required(example) = key.default else {
            continue;
        };
        let text = format!("x = {example}\n");
        let table = DeTable::parse(&text).expect("TOML");
        let value = json(table.get_ref()["x"].get_ref());
        assert!(valid(&property(key), &value), "{}: {example}", key.path);
    }
}

/// The columns of the table agree with each other.
#[test]
fn every_key_of_a_choice_is_there() {
    for key in KEYS.iter() {
        for choice in key.kind.choices() {
            for name in choice.takes {
                let beside = format!("{}.{name}", key.place().0);
                assert!(Key::at(&beside).is_some(), "{}: {beside}", choice.name);
            }
        }
        let (table, _) = key.place();
        let before = KEYS.iter().take_while(|other| other.path != key.path);
        assert!(
            table.is_empty() || before.clone().any(|other| other.path == table),
            "{} stands before its table",
            key.path
        );
        assert!(before.clone().all(|other| other.path != key.path), "twice");
        let follows = matches!(key.default, Default::Derived(text) if !text.is_empty());
        let fits = match key.kind {
            Kind::Number(..) | Kind::Whole(..) => !matches!(key.default, Default::FirstChoice),
            Kind::Choice(..) => {
                matches!(key.default, Default::FirstChoice | Default::Required(_))
            }
            Kind::Table(_) => follows,
            _ => follows || matches!(key.default, Default::Required(_)),
        };
        assert!(fits, "{}: a default of another kind", key.path);
    }
}
