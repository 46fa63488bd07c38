//! Tells the program which commit it was built from.

use std::path::Path;
use std::process::Command;

/// The file of a package that names the commit it was made from.
const PACKAGED: &str = ".cargo_vcs_info.json";

/// Where the sources are that the program is built from, from here.
const SOURCES: [&str; 3] = ["../../host-sim/src", "../../identifier-core/src", ".."];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // A development build after every commit builds nothing anew for its name.
    let is_release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let mut version = env!("CARGO_PKG_VERSION").to_owned();
    if let Some(commit) = is_release.then(commit).flatten() {
        version += &format!(" ({commit})");
    }
    println!("cargo::rustc-env=SERVO_ID_VERSION={version}");
}

/// The commit, with a plus where files differ from it; none outside a repository and a package of one.
fn commit() -> Option<String> {
    if let Ok(packaged) = std::fs::read_to_string(PACKAGED) {
        let (_, rest) = packaged.split_once("\"sha1\": \"")?;
        return Some(
            rest.chars()
                .take_while(char::is_ascii_hexdigit)
                .take(12)
                .collect(),
        );
    }
    // The sources may lie in a repository that is not theirs.
    git(&["ls-files", "--error-unmatch", "Cargo.toml"])?;
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    for watched in SOURCES.into_iter().chain([log.as_str()]) {
        if Path::new(watched).exists() {
            println!("cargo::rerun-if-changed={watched}");
        }
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let changed = git(&["status", "--porcelain", "--untracked-files=no"])?;
    Some(if changed.is_empty() {
        commit
    } else {
        commit + "+"
    })
}

/// The output of git; none where it is missing or fails.
fn git(arguments: &[&str]) -> Option<String> {
    let told = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(told.stdout).ok()?;
    told.status.success().then(|| text.trim().to_owned())
}
