//! Files that are no table of text: logs that the Python package reads, and files of this program.

use std::path::Path;

use crate::scenario::TABLES;

/// A kind of file, the extra of the Python package that reads it, and the test of its first bytes.
type Kind = (&'static str, &'static str, fn(&[u8]) -> bool);

const KINDS: [Kind; 8] = [
    (BAG, ROS, |bytes| bytes.starts_with(b"SQLite format 3\0")),
    (BAG, ROS, |bytes| {
        bytes.starts_with(b"\x89MCAP0\r\n") && bytes.get(21..25) == Some(b"ros2")
    }),
    ("a ROS 1 bag", ROS, |bytes| bytes.starts_with(b"#ROSBAG V")),
    ("a WPILOG", "[wpilog]", |bytes| bytes.starts_with(b"WPILOG")),
    ("a ULog", "[ulog]", |bytes| bytes.starts_with(b"ULog\x01")),
    ("a table in Parquet", "[parquet]", |bytes| {
        bytes.starts_with(b"PAR1")
    }),
    ("a MAT-file", "[mat]", |bytes| bytes.starts_with(b"MATLAB ")),
    // Its first file is an array: the name stands behind a header of 30 bytes, in which its length is.
    ("an archive of NumPy arrays", "", |bytes| {
        let length = bytes.get(26..28).map_or(0, |of| usize::from(of[0]));
        let name = bytes.get(30..).and_then(|rest| rest.get(..length));
        bytes.starts_with(b"PK\x03\x04") && name.is_some_and(|name| name.ends_with(b".npy"))
    }),
];

const BAG: &str = "a ROS 2 bag";
const ROS: &str = "[ros]";

/// The fault of a file that is no text, of such a kind, with the command that identifies it. None for another file.
pub(super) fn fault(path: &Path, beginning: &[u8]) -> Option<String> {
    let mut kinds = KINDS.iter();
    kinds.find_map(|(what, extra, is_it)| is_it(beginning).then(|| in_python(path, what, extra)))
}

/// The fault of a text that is JSON or a scenario. None for another text.
pub(super) fn of_text(path: &Path, beginning: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(beginning);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let begins = |outer: char, inner: char| {
        let inside = text.strip_prefix(outer).map(str::trim_start);
        inside.is_some_and(|inside| inside.starts_with(inner))
    };
    // A row of units may begin with a bracket too.
    if begins('{', '"') || begins('[', '{') {
        // The keys of a result begin with its estimator and its status.
        return Some(
            match ["\"law\":", "\"status\":"]
                .iter()
                .all(|key| text.contains(key))
            {
                true => "this is a result, not a log: the verbs tune and export read it".to_owned(),
                false => in_python(path, "JSON", ""),
            },
        );
    }
    let table = |line: &str| {
        line.trim()
            .strip_prefix('[')?
            .strip_suffix(']')
            .map(str::to_owned)
    };
    let is_scenario = text
        .lines()
        .filter_map(table)
        .any(|name| TABLES.contains(&&*name));
    is_scenario.then(|| {
        "this is a scenario, not a log: state it with --scenario, beside the log".to_owned()
    })
}

/// The fault of a folder.
#[cfg(feature = "files")]
pub(super) fn of_folder(path: &Path) -> String {
    match path.join("metadata.yaml").is_file() {
        true => in_python(path, BAG, ROS),
        false => "this is a folder: a log must be a file".to_owned(),
    }
}

fn in_python(path: &Path, what: &str, extra: &str) -> String {
    format!(
        "this is {what}: use the Python package: python -m servo_id identify \"{}\" (in the project's folder: pip install \
         './crates/identifier-py{extra}')",
        path.display()
    )
}

#[cfg(test)]
mod tests {
    use super::{fault, of_text};

    #[test]
    fn files_that_python_reads_are_known_by_their_bytes() {
        let mut arrays = b"PK\x03\x04".to_vec();
        arrays.resize(26, 0);
        arrays.extend(b"\x05\0\0\0q.npy");
        let workbook = [&arrays[..30], b"q.xml"].concat();
        let bag = b"\x89MCAP0\r\n\x01\x10\0\0\0\0\0\0\0\x04\0\0\0ros2";
        let other = b"\x89MCAP0\r\n\x01\x10\0\0\0\0\0\0\0\0\0\0\0\0ros2";
        for (bytes, extra) in [
            (&b"SQLite format 3\0"[..], Some("[ros]")),
            (b"#ROSBAG V2.0\n", Some("[ros]")),
            (bag, Some("[ros]")),
            (other, None),
            (b"WPILOG\0\x01", Some("[wpilog]")),
            (b"ULog\x01\x12\x35\x01", Some("[ulog]")),
            (b"PAR1\x15\0", Some("[parquet]")),
            (b"MATLAB 7.3 MAT-file", Some("[mat]")),
            (&arrays, Some("")),
            (&workbook, None),
            (b"\x89PNG", None),
        ] {
            let found = fault("a b/log".as_ref(), bytes);
            assert_eq!(found.is_some(), extra.is_some(), "{bytes:?}");
            if let Some((extra, text)) = extra.zip(found) {
                let package = format!("'./crates/identifier-py{extra}'");
                let run = "python -m servo_id identify \"a b/log\"";
                assert!(text.contains(&package) && text.contains(run), "{text}");
            }
        }
    }

    #[test]
    fn files_of_the_program_and_json_are_named_and_a_table_is_not() {
        let named = |text: &str| of_text("log.csv".as_ref(), text.as_bytes());
        for (text, name) in [
            (
                "{\n\"law\": \"fit\",\n\"status\": \"converged\"",
                "a result",
            ),
            ("{\"t\": [0.0], \"q\": [0.0]}", "JSON"),
            ("[{\"t\": 0.0, \"q\": 0.0}]", "JSON"),
            ("# a servo\n[plant]\na = 1.0\n", "a scenario"),
            ("[log]\nposition = \"q\"\n", "a scenario"),
        ] {
            let found = named(text).unwrap_or_else(|| panic!("{text}"));
            assert!(found.contains(name), "{text}: {found}");
        }
        for begin in ["[s],[rad],[V]", "t,q,u", "[Header]\nkey = 1", "0 0 0"] {
            assert_eq!(named(&format!("{begin}\n0,0,0\n")), None, "{begin}");
        }
    }
}
