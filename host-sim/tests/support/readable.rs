//! Requirements on every message about a scenario.

/// A message names file and line, in a user's words, and quotes little of the file.
pub(crate) fn assert_readable(answer: &str, text: &str) {
    /// Characters of the input that a message may show in a row.
    const MAX_VALUE_CHARS: usize = 80;
    let line = answer
        .strip_prefix("s.toml:")
        .and_then(|rest| rest.split_once(':'));
    let line: Option<usize> = line.and_then(|(line, _)| line.parse().ok());
    let lines = text.split('\n').count();
    let is_one = line.is_some_and(|line| (1..=lines).contains(&line));
    assert!(is_one, "no line: {answer}");
    let mut controls = answer.chars().filter(|c| c.is_control());
    assert!(
        controls.all(|c| c == '\n'),
        "a control character: {answer:?}"
    );
    let foreign = "expected f64|expected u|expected i|expected a |struct|invalid type|missing field|unknown field|variant|\
                   visitor|NaN %|Some(|None";
    for word in foreign.split('|') {
        assert!(!answer.contains(word), "{word:?}: {answer}");
    }
    let shown: Vec<char> = answer.chars().collect();
    for piece in shown.windows(MAX_VALUE_CHARS + 1) {
        let piece: String = piece.iter().collect();
        assert!(!text.contains(&piece), "too much is shown: {piece}");
    }
}
