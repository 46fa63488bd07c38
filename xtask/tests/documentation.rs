//! The pages of the project lead where they say: links to files and headings, commands to tests and
//! scenarios.

use std::fs;
use std::path::{Path, PathBuf};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// A page: its path, and what it refers to.
#[derive(Debug, Default)]
struct Page {
    path: PathBuf,
    links: Vec<String>,
    /// Anchors of its headings.
    anchors: Vec<String>,
    /// Words of its commands.
    words: Vec<String>,
}

impl Page {
    fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).expect("readable");
        let mut page = Self {
            path,
            ..Self::default()
        };
        let mut heading = None;
        for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push(dest_url.into_string());
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    page.anchors.extend(heading.take().as_deref().map(anchor))
                }
                Event::Text(text) | Event::Code(text) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&text);
                    }
                    page.words
                        .extend(text.split_whitespace().map(str::to_owned));
                }
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

/// Files of the project that end as wanted; what is built and what is hidden is left out.
fn files(folder: &Path, end: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut found = Vec::new();
    for path in entries.map(|entry| entry.expect("an entry").path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() {
            if name != "target" && name != "results" && !name.starts_with('.') {
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
            let has_heading = |target: &PathBuf| {
                let page = pages.iter().find(|page| page.path == *target);
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

#[test]
fn every_command_names_a_test_and_files_that_exist() {
    let root = root();
    let tests: Vec<_> = files(&root, ".rs")
        .into_iter()
        .filter(|path| path.iter().any(|part| part == "tests"))
        .collect();
    let has = |end: String| tests.iter().any(|path| path.ends_with(&end));
    // A file of the folder itself, or the root of a folder in it.
    let is_test =
        |name: &str| has(format!("tests/{name}.rs")) || has(format!("tests/{name}/main.rs"));
    let is_part = |test: &str, name: &str| has(format!("tests/{test}/{name}.rs"));
    let is_file = |path: &str| root.join(path).exists();
    let (mut looked_at, mut missing) = (0, Vec::new());
    for page in pages() {
        let (mut before, mut previous) = ("", "");
        for word in &page.words {
            let part = word.strip_suffix("::").filter(|_| before == "--test");
            let exists = if previous == "--test" {
                Some(is_test(word))
            } else if let Some(part) = part {
                Some(is_part(previous, part))
            } else if word.starts_with("host-sim/scenarios/") || word.starts_with("host-sim/logs/")
            {
                Some(is_file(word))
            } else {
                None
            };
            looked_at += u32::from(exists.is_some());
            if exists == Some(false) {
                missing.push(format!("{}: {previous} {word}", page.path.display()));
            }
            (before, previous) = (previous, word);
        }
    }
    assert!(looked_at > 40, "{looked_at} names");
    assert!(missing.is_empty(), "{missing:#?}");
}
