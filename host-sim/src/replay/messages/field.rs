//! A number within a message of JSON, by its path.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

/// Where a number is within a message: the names of fields, and the places in lists, from the outside in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FieldPath(Vec<Step>);

#[derive(Debug, Clone, PartialEq, Eq)]
enum Step {
    Name(String),
    Place(usize),
}

impl FieldPath {
    /// Reads `effort[0]`, `pose.position.x`.
    pub(super) fn read(text: &str) -> Option<Self> {
        let mut steps = Vec::new();
        for part in text.split('.') {
            let (name, places) = part.split_at(part.find('[').unwrap_or(part.len()));
            if !name.is_empty() {
                steps.push(Step::Name(name.to_owned()));
            }
            for place in places.split_inclusive(']') {
                let number = place.strip_prefix('[')?.strip_suffix(']')?;
                steps.push(Step::Place(number.parse().ok()?));
            }
            if part.is_empty() {
                return None;
            }
        }
        Some(Self(steps))
    }

    /// The paths of all numbers of a message, at most so many.
    pub(super) fn all_of(message: &Value, most: usize) -> Vec<String> {
        let mut found = Vec::new();
        collect(message, String::new(), most, &mut found);
        found
    }
}

fn collect(value: &Value, path: String, most: usize, found: &mut Vec<String>) {
    if found.len() == most {
        return;
    }
    match value {
        Value::Number(_) => found.push(path),
        Value::Array(items) => {
            for (place, item) in items.iter().enumerate() {
                collect(item, format!("{path}[{place}]"), most, found);
            }
        }
        Value::Object(fields) => {
            for (name, field) in fields {
                let dot = if path.is_empty() { "" } else { "." };
                collect(field, format!("{path}{dot}{name}"), most, found);
            }
        }
        _ => {}
    }
}

/// Takes the numbers at some paths out of a message, without the rest.
///
/// # Errors
/// If the message is no JSON.
pub(super) fn take(
    message: &[u8],
    paths: &[FieldPath],
    found: &mut [Option<f64>],
) -> Result<(), serde_json::Error> {
    let wanted: Vec<usize> = (0..paths.len()).collect();
    let mut text = serde_json::Deserializer::from_slice(message);
    Taker {
        paths,
        wanted,
        depth: 0,
        found,
    }
    .deserialize(&mut text)?;
    text.end()
}

/// Takes those of the paths that lead through this value.
struct Taker<'a> {
    paths: &'a [FieldPath],
    wanted: Vec<usize>,
    depth: usize,
    found: &'a mut [Option<f64>],
}

impl Taker<'_> {
    fn number(&mut self, number: f64) {
        for &path in &self.wanted {
            if self.paths[path].0.len() == self.depth {
                self.found[path] = Some(number);
            }
        }
    }

    /// Those that go on with a step.
    fn through(&self, is_step: impl Fn(&Step) -> bool) -> Vec<usize> {
        let goes_on = |path: &&usize| self.paths[**path].0.get(self.depth).is_some_and(&is_step);
        self.wanted.iter().filter(goes_on).copied().collect()
    }

    fn inner(&mut self, wanted: Vec<usize>) -> Taker<'_> {
        Taker {
            paths: self.paths,
            wanted,
            depth: self.depth + 1,
            found: self.found,
        }
    }
}

impl<'de> DeserializeSeed<'de> for Taker<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, value: D) -> Result<(), D::Error> {
        value.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Taker<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a message")
    }

    fn visit_f64<E>(mut self, number: f64) -> Result<(), E> {
        self.number(number);
        Ok(())
    }

    fn visit_u64<E>(mut self, number: u64) -> Result<(), E> {
        self.number(number as f64);
        Ok(())
    }

    fn visit_i64<E>(mut self, number: i64) -> Result<(), E> {
        self.number(number as f64);
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<(), A::Error> {
        let mut place = 0;
        loop {
            let wanted = self.through(|step| *step == Step::Place(place));
            let more = if wanted.is_empty() {
                list.next_element::<IgnoredAny>()?.map(|_| ())
            } else {
                list.next_element_seed(self.inner(wanted))?
            };
            if more.is_none() {
                return Ok(());
            }
            place += 1;
        }
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut fields: A) -> Result<(), A::Error> {
        while let Some(field) = fields.next_key::<std::borrow::Cow<'de, str>>()? {
            let wanted = self.through(|step| matches!(step, Step::Name(name) if *name == *field));
            if wanted.is_empty() {
                fields.next_value::<IgnoredAny>()?;
            } else {
                fields.next_value_seed(self.inner(wanted))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(message: &str, paths: &[&str]) -> Option<Vec<Option<f64>>> {
        let paths: Vec<_> = paths
            .iter()
            .filter_map(|path| FieldPath::read(path))
            .collect();
        let mut found = vec![None; paths.len()];
        take(message.as_bytes(), &paths, &mut found).ok()?;
        Some(found)
    }

    #[test]
    fn numbers_are_found_at_any_depth_and_nothing_else() {
        let message =
            r#"{"t":1,"pose":{"position":{"x":-2.5}},"effort":[3,[4e1]],"name":["a"],"ok":true}"#;
        let paths = [
            "pose.position.x",
            "effort[1][0]",
            "t",
            "effort[2]",
            "name[0]",
            "ok",
            "pose",
        ];
        let found = vec![Some(-2.5), Some(40.0), Some(1.0), None, None, None, None];
        assert_eq!(taken(message, &paths), Some(found));
        assert_eq!(taken("3.5", &[]), Some(vec![]));
        for wrong in ["", "{", "{\"t\":1} 2", "nan"] {
            assert_eq!(taken(wrong, &["t"]), None, "{wrong}");
        }
    }

    #[test]
    fn a_number_is_the_one_that_was_written_to_the_last_bit() {
        for number in [
            0.1 + 0.2,
            1.0 / 3.0,
            2.2250738585072014e-308,
            123_456_789.123_456_78,
        ] {
            let message = format!("{{\"q\":{number}}}");
            assert_eq!(taken(&message, &["q"]), Some(vec![Some(number)]));
        }
    }

    #[test]
    fn a_path_is_names_and_places() {
        for wrong in ["", "a..b", "a[", "a[x]", "a[1]b", "a[-1]"] {
            assert_eq!(FieldPath::read(wrong), None, "{wrong}");
        }
        let message = serde_json::json!({"a": [1, {"b": 2}], "c": "word"});
        assert_eq!(FieldPath::all_of(&message, 9), ["a[0]", "a[1].b"]);
        assert_eq!(FieldPath::all_of(&message, 1), ["a[0]"]);
    }
}
