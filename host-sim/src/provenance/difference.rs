//! Differences between two results.

use serde_json::Value;

/// Differences between two results, key by key, in the order of their keys. The names of log files do not count.
pub(super) fn differences(one: &Value, other: &Value) -> Vec<String> {
    let mut found = Vec::new();
    collect("", one, other, &mut found);
    found
}

fn collect(path: &str, one: &Value, other: &Value, found: &mut Vec<String>) {
    match (one, other) {
        (Value::Object(one), Value::Object(other)) => {
            let new = other.keys().filter(|key| !one.contains_key(*key));
            for key in one.keys().chain(new) {
                let is_of_a_log = path.starts_with("logs[") || path.starts_with("predictions[");
                if is_of_a_log && key == "file" {
                    continue;
                }
                let dot = if path.is_empty() { "" } else { "." };
                let [one, other] =
                    [one, other].map(|object| object.get(key).unwrap_or(&Value::Null));
                collect(&format!("{path}{dot}{key}"), one, other, found);
            }
        }
        (Value::Array(one), Value::Array(other)) if one.len() == other.len() => {
            for (place, (one, other)) in one.iter().zip(other).enumerate() {
                collect(&format!("{path}[{place}]"), one, other, found);
            }
        }
        _ if one == other => {}
        _ => found.push(format!("{path}: {one} before, {other} now")),
    }
}

#[cfg(test)]
mod tests {
    use super::differences;
    use serde_json::json;

    #[test]
    fn the_last_bit_counts_and_the_names_of_logs_do_not() {
        let one = json!({"a": {"b": 0.3}, "logs": [{"file": "x", "samples": 1}], "list": [1]});
        assert_eq!(differences(&one, &one), Vec::<String>::new());
        let other = json!({
            "a": {"b": 0.1 + 0.2},
            "logs": [{"file": "y", "samples": 2}],
            "list": [1, 2],
            "more": true
        });
        let expected = [
            "a.b: 0.3 before, 0.30000000000000004 now",
            "logs[0].samples: 1 before, 2 now",
            "list: [1] before, [1,2] now",
            "more: null before, true now",
        ];
        let mut found = differences(&one, &other);
        found.sort();
        let mut expected = expected.map(str::to_owned).to_vec();
        expected.sort();
        assert_eq!(found, expected);
    }
}
