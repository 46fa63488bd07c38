//! A line of a log without what is no field.

/// A line without byte-order mark, spaces at its ends and the mark of a comment: `#`, `%` or `//`.
pub(super) fn uncommented(line: &[u8]) -> &[u8] {
    const MARK: &[u8] = b"\xef\xbb\xbf";
    let line = line.strip_prefix(MARK).unwrap_or(line).trim_ascii();
    let marks = [&b"//"[..], b"#", b"%"];
    let mark = marks.iter().find_map(|mark| line.strip_prefix(*mark));
    mark.unwrap_or(line).trim_ascii()
}

/// A row without surrounding quotation marks and without the brackets of a matrix. `[` counts at the beginning, perhaps
/// behind `name =`, and before a number, unless its `]` is within the row. `]` and `;` count at the end.
pub(super) fn bare(line: &[u8], separator: u8) -> &[u8] {
    let quoted = line
        .strip_prefix(b"\"")
        .and_then(|line| line.strip_suffix(b"\""));
    let line = quoted
        .filter(|inside| !inside.contains(&b'"'))
        .unwrap_or(line);
    let is_of_number = |byte: &u8| byte.is_ascii_digit() || b"+-.".contains(byte);
    let is_name = |name: &[u8]| name.is_empty() || name.ends_with(b"=");
    let opened = memchr::memchr(b'[', line)
        .filter(|place| is_name(line[..*place].trim_ascii()))
        .map(|place| line[place + 1..].trim_ascii_start())
        .filter(|rest| rest.first().is_some_and(is_of_number))
        .filter(|rest| {
            let closed = memchr::memchr(b']', rest).unwrap_or(rest.len());
            rest[closed..].iter().all(|byte| b"]; ".contains(byte))
        });
    let mut bare = opened.unwrap_or(line);
    while let Some((b']' | b';', rest)) = bare.split_last().map(|(last, rest)| (*last, rest)) {
        if separator == b';' && bare.last() == Some(&b';') {
            break;
        }
        // The unit of the last column may stand in brackets.
        if bare.last() == Some(&b']') && memchr::memchr(b'[', rest).is_some() {
            break;
        }
        bare = rest.trim_ascii_end();
    }
    bare
}

/// A line with one space for every run of spaces and tabs, and none at its ends nor behind the colon of a name. A comma at the
/// end of a word is a space. Text within quotation marks is unchanged.
pub(super) fn squeezed(line: &[u8]) -> Vec<u8> {
    let mut squeezed = Vec::with_capacity(line.len());
    let mut quoted = false;
    let line = line.trim_ascii();
    let line = line.strip_suffix(b",").unwrap_or(line).trim_ascii_end();
    let blank = |byte: &u8| *byte == b' ' || *byte == b'\t';
    for (place, &byte) in line.iter().enumerate() {
        quoted ^= byte == b'"';
        let ends_word = byte == b',' && line.get(place + 1).is_some_and(blank);
        let is_space = !quoted && (blank(&byte) || ends_word);
        match is_space {
            true if matches!(squeezed.last(), Some(b' ' | b':')) => {}
            true => squeezed.push(b' '),
            false => squeezed.push(byte),
        }
    }
    squeezed
}
