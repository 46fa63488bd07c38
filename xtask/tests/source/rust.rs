//! The part of Rust's syntax that these tests read.

/// The text without comments, strings and characters.
pub(crate) fn code(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let bytes = text.as_bytes();
    let mut rest = 0;
    while rest < bytes.len() {
        let here = &text[rest..];
        let skipped = if here.starts_with("//") {
            here.find('\n').unwrap_or(here.len())
        } else if here.starts_with("/*") {
            here.find("*/").map_or(here.len(), |end| end + 2)
        } else if let Some(raw) = raw_string(here) {
            raw
        } else if here.starts_with('"') {
            quoted(here)
        } else if here.starts_with('\'') {
            character(here)
        } else {
            0
        };
        if skipped > 0 {
            code.push(' ');
            rest += skipped;
        } else {
            let next = here.chars().next().expect("some text");
            code.push(next);
            rest += next.len_utf8();
        }
    }
    code
}

/// The length of a raw string that begins here.
fn raw_string(text: &str) -> Option<usize> {
    let hashes = text.strip_prefix('r')?;
    let count = hashes.bytes().take_while(|&byte| byte == b'#').count();
    let body = hashes[count..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(count));
    Some(2 + count + body.find(&end)? + end.len())
}

/// The length of a string that begins here.
fn quoted(text: &str) -> usize {
    let mut escaped = false;
    for (at, character) in text.char_indices().skip(1) {
        match character {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// The length of a character that begins here; zero for a lifetime.
fn character(text: &str) -> usize {
    let mut characters = text.char_indices().skip(1);
    match characters.next() {
        Some((_, '\\')) => text[2..].find('\'').map_or(0, |end| {
            // An escaped quote is not the end.
            if end == 0 { 4 } else { end + 3 }
        }),
        Some(_) => match characters.next() {
            Some((at, '\'')) => at + 1,
            _ => 0,
        },
        None => 0,
    }
}

/// The code without the parts that are compiled for tests only.
pub(crate) fn without_tests(code: &str) -> String {
    const MARK: &str = "#[cfg(test)]";
    let mut kept = String::new();
    let mut rest = code;
    while let Some((before, after)) = rest.split_once(MARK) {
        kept.push_str(before);
        let body = after.find('{').unwrap_or(after.len());
        let end = after.find(';').unwrap_or(after.len());
        rest = if end < body {
            &after[end..]
        } else {
            &after[body + matching(&after[body..])..]
        };
    }
    kept + rest
}

/// The length up to the brace that closes the first.
pub(crate) fn matching(text: &str) -> usize {
    let mut depth = 0;
    for (at, character) in text.char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth == 1 => return at + 1,
            '}' => depth -= 1,
            _ => {}
        }
    }
    text.len()
}

/// The paths that are imported.
pub(crate) fn imports(code: &str) -> Vec<Vec<String>> {
    uses(code).into_iter().map(|(_, path)| path).collect()
}

/// The paths that are imported, and for each whether the module passes it on.
pub(crate) fn uses(code: &str) -> Vec<(bool, Vec<String>)> {
    let mut uses = Vec::new();
    for (at, _) in code.match_indices("use ") {
        let before = &code[..at];
        if before
            .chars()
            .next_back()
            .is_none_or(|before| before.is_whitespace() || before == '}')
        {
            let tree = &code[at + 4..];
            let tree = &tree[..tree.find(';').unwrap_or(tree.len())];
            let mut paths = Vec::new();
            leaves(&[], tree, &mut paths);
            let word = before.trim_end().rsplit([';', '}', ']']).next();
            let passes_on = word.is_some_and(|word| word.trim().starts_with("pub"));
            uses.extend(paths.into_iter().map(|path| (passes_on, path)));
        }
    }
    uses
}

/// The paths of a tree of imports.
fn leaves(before: &[String], tree: &str, paths: &mut Vec<Vec<String>>) {
    let path = |text: &str| {
        let text = text.split(" as ").next().unwrap_or(text);
        let names = text
            .split("::")
            .map(str::trim)
            .filter(|name| !name.is_empty());
        let mut path = before.to_vec();
        path.extend(names.map(str::to_owned));
        path
    };
    match tree.split_once('{') {
        None if tree.trim().is_empty() => {}
        None => paths.push(path(tree)),
        Some((stem, group)) => {
            let stem = path(stem);
            let group = &group[..group.rfind('}').unwrap_or(group.len())];
            let (mut depth, mut begin) = (0, 0);
            for (at, character) in group.char_indices() {
                match character {
                    '{' => depth += 1,
                    '}' => depth -= 1,
                    ',' if depth == 0 => {
                        leaves(&stem, &group[begin..at], paths);
                        begin = at + 1;
                    }
                    _ => {}
                }
            }
            leaves(&stem, &group[begin..], paths);
        }
    }
}
