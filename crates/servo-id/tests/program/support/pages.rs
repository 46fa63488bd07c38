//! The project's pages, and the blocks in them that show the program's output. `BLESS_PAGES=1` rewrites the blocks
//! that differ.

use std::fs;
use std::path::{Path, PathBuf};

/// The project's root.
pub(crate) fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.canonicalize().expect("the project's root")
}

/// Asserts that the block of a page whose first line begins with `begin`, behind any space, equals the lines of
/// `output` from the one that begins so.
pub(crate) fn assert_block_is_printed(page: &Path, begin: &str, output: &str) {
    let text = fs::read_to_string(page).expect("a page");
    let mut lines: Vec<&str> = text.lines().collect();
    let first = (1..lines.len())
        .find(|&line| {
            lines[line - 1].starts_with("```") && lines[line].trim_start().starts_with(begin)
        })
        .unwrap_or_else(|| panic!("{}: no block {begin:?}", page.display()));
    let length = lines[first..].iter().position(|line| *line == "```");
    let block = first..first + length.expect("the block ends");
    let printed: Vec<&str> = output
        .lines()
        .map(str::trim_end)
        .skip_while(|line| !line.trim_start().starts_with(begin))
        .take(block.len())
        .collect();
    if lines[block.clone()] == printed {
        return;
    }
    if std::env::var_os("BLESS_PAGES").is_some() && !printed.is_empty() {
        drop(lines.splice(block, printed));
        fs::write(page, lines.join("\n") + "\n").expect("the page is written");
        return;
    }
    panic!(
        "{}:{} shows\n{}\nand the program prints\n{}\n(BLESS_PAGES=1 rewrites the page)",
        page.display(),
        first + 1,
        lines[block].join("\n"),
        printed.join("\n")
    );
}
