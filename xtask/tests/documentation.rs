//! The references on the project's pages are valid: links to files and headings, commands to tests and
//! scenarios.

use std::fs;
use std::path::{Path, PathBuf};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// A page: its path, and its references.
#[derive(Debug, Default)]
struct Page {
    path: PathBuf,
    links: Vec<String>,
    /// Anchors of its headings.
    anchors: Vec<String>,
    /// Its code: spans, and lines of blocks.
    commands: Vec<String>,
}

impl Page {
    fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).expect("readable");
        let mut page = Self {
            path,
            ..Self::default()
        };
        let mut heading = None;
        let mut in_block = false;
        for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push(dest_url.into_string());
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    page.anchors.extend(heading.take().as_deref().map(anchor))
                }
                Event::Start(Tag::CodeBlock(_)) => in_block = true,
                Event::End(TagEnd::CodeBlock) => in_block = false,
                Event::Text(text) if in_block => {
                    page.commands.extend(text.lines().map(str::to_owned));
                }
                Event::Text(text) | Event::Code(text) if heading.is_some() => {
                    heading.get_or_insert_default().push_str(&text);
                }
                Event::Code(text) => page.commands.push(text.into_string()),
                _ => {}
            }
        }
        page
    }
}

/// The anchor that a heading gets where pages are shown.
fn anchor(heading: &str) -> String {
    heading
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric() || "-_ ".contains(*c))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    root.canonicalize().expect("the project's root")
}

/// Files of the project with an ending, without products and hidden files.
fn files(folder: &Path, end: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut found = Vec::new();
    for path in entries.map(|entry| entry.expect("an entry").path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() {
            if name != "target" && name != "results" && name != "book" && !name.starts_with('.') {
                found.extend(files(&path, end));
            }
        } else if name.ends_with(end) {
            found.push(path);
        }
    }
    found
}

fn pages() -> Vec<Page> {
    files(&root(), ".md").into_iter().map(Page::read).collect()
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let pages = pages();
    let (mut followed, mut dead) = (0, Vec::new());
    for page in &pages {
        for link in page.links.iter().filter(|link| !link.contains("://")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let folder = page.path.parent().expect("a folder");
            let target = match file {
                "" => Some(page.path.clone()),
                file => folder.join(file).canonicalize().ok(),
            };
            // A folder is shown with its README.
            let has_heading = |target: &PathBuf| {
                let readme = target.join("README.md");
                let is_shown = |page: &&Page| page.path == *target || page.path == readme;
                let page = pages.iter().find(is_shown);
                page.is_some_and(|page| page.anchors.iter().any(|anchor| anchor == heading))
            };
            followed += 1;
            if !target.is_some_and(|target| heading.is_empty() || has_heading(&target)) {
                dead.push(format!("{}: {link}", page.path.display()));
            }
        }
    }
    assert!(followed > 100, "{followed} links");
    assert!(dead.is_empty(), "{dead:#?}");
}

/// The folder of the book's pages, and its table of contents.
const BOOK: &str = "docs";
const CONTENTS: &str = "SUMMARY.md";

#[test]
fn every_page_is_once_in_the_book() {
    let folder = root().join(BOOK);
    let settings = fs::read_to_string(root().join("book.toml")).expect("readable");
    assert!(
        settings.contains(&format!("src = \"{BOOK}\"")),
        "{settings}"
    );
    let (contents, pages): (Vec<PathBuf>, Vec<PathBuf>) = files(&folder, ".md")
        .into_iter()
        .partition(|path| path.ends_with(CONTENTS));
    assert_eq!(contents, [folder.join(CONTENTS)]);
    let mut listed = Page::read(folder.join(CONTENTS)).links;
    let mut there: Vec<String> = pages
        .iter()
        .map(|page| page.strip_prefix(&folder).expect("in the folder"))
        .map(|page| page.display().to_string())
        .collect();
    assert!(there.len() > 15, "{there:?}");
    listed.sort_unstable();
    there.sort_unstable();
    assert_eq!(listed, there);
}

/// A book makes `.html` of every `.md`, and writes its own pages alone, without contents and with the first as
/// `index.html`: a link to a page elsewhere has to name its folder.
#[test]
fn no_page_of_the_book_links_a_page_that_the_book_does_not_write() {
    let folder = root().join(BOOK);
    let mut wrong = Vec::new();
    let is_chapter =
        |page: &&Page| page.path.starts_with(&folder) && !page.path.ends_with(CONTENTS);
    for page in pages().iter().filter(is_chapter) {
        for link in page.links.iter().filter(|link| !link.contains("://")) {
            let file = link.split('#').next().unwrap_or_default();
            let target = page.path.parent().expect("a folder").join(file);
            let leaves = target
                .canonicalize()
                .is_ok_and(|target| !target.starts_with(&folder));
            let is_no_page = file == CONTENTS || file == "README.md";
            if is_no_page || leaves && file.ends_with(".md") {
                wrong.push(format!("{}: {link}", page.path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_command_names_a_test_and_files_that_exist() {
    let root = root();
    let tests: Vec<_> = files(&root, ".rs")
        .into_iter()
        .filter(|path| path.iter().any(|part| part == "tests"))
        .collect();
    let is_target = |name: &str| {
        tests.iter().any(|path| {
            path.ends_with(format!("tests/{name}.rs"))
                || path.ends_with(format!("tests/{name}/main.rs"))
        })
    };
    // A filter selects some tests of a target: a part of the name of a module or of a function.
    let is_filter = |filter: &str| {
        let module = filter.trim_end_matches("::");
        tests.iter().any(|path| {
            path.file_stem().is_some_and(|stem| stem == module)
                || fs::read_to_string(path)
                    .expect("readable")
                    .lines()
                    .any(|line| {
                        let name = line.trim_start().strip_prefix("fn ");
                        name.is_some_and(|name| name.contains(module))
                    })
        })
    };
    let (mut looked_at, mut missing) = (0, Vec::new());
    for page in pages() {
        for command in &page.commands {
            let mut words = command.split_whitespace().peekable();
            let mut exists = Vec::new();
            while let Some(word) = words.next() {
                if word == "--test" {
                    exists.push(words.next().is_some_and(is_target));
                    let filter = words.peek().filter(|word| !word.starts_with('-'));
                    exists.extend(filter.map(|filter| is_filter(filter)));
                } else if ["host-sim/scenarios/", "host-sim/logs/"]
                    .iter()
                    .any(|folder| word.starts_with(folder))
                {
                    exists.push(root.join(word).exists());
                }
            }
            looked_at += exists.len();
            if exists.contains(&false) {
                missing.push(format!("{}: {command}", page.path.display()));
            }
        }
    }
    assert!(looked_at > 40, "{looked_at} names");
    assert!(missing.is_empty(), "{missing:#?}");
}
