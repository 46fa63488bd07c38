//! From the sources to one object without a panic.

use std::env::consts::EXE_SUFFIX;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The symbol that a panic would call: see `panic.rs`.
const PANIC: &str = "servo_id_a_panic_survived";

/// A target of a chip, for an example.
const CHIP: &str = "thumbv7em-none-eabihf";

/// Functions of C's library that a program on a PC has.
const OF_C: [&str; 5] = ["memcpy", "memmove", "memset", "memcmp", "bcmp"];

/// Where everything is built.
pub(crate) fn folder() -> PathBuf {
    let usual = || crate::own().join("../../target");
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(usual, PathBuf::from)
}

/// The target of this machine's programs.
pub(crate) fn this_machine() -> Result<String, String> {
    let version = output(Command::new("rustc").arg("-vV"))?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned)
        .ok_or_else(|| "rustc names no host".to_owned())
}

/// Builds the object for a target and returns its file.
///
/// # Errors
/// A program that it needs fails; the library can panic; or a PC's objects are of another format than ELF.
pub(crate) fn object(target: &str) -> Result<PathBuf, String> {
    if target.contains("-apple-") || target.contains("-windows-") {
        return Err(format!(
            "{target}: on PCs the library is for Linux only; for a chip name its target, such as --target {CHIP}"
        ));
    }
    let installed = output(Command::new("rustup").args(["target", "list", "--installed"]));
    if installed.is_ok_and(|list| !list.lines().any(|line| line == target)) {
        output(Command::new("rustup").args(["target", "add", target]))?;
    }
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    // The type of crate by the command: with two types in the manifest nothing is optimised across crates.
    output(
        Command::new(cargo)
            .current_dir(crate::own())
            .args([
                "rustc",
                "--quiet",
                "--locked",
                "--package",
                "identifier-ffi",
            ])
            .args([
                "--lib",
                "--features",
                "library",
                "--crate-type",
                "staticlib",
            ])
            .args(["--profile", "library", "--target", target]),
    )?;
    let built = folder().join(target).join("library");
    let names: Vec<&str> = identifier_ffi::prototypes().map(|own| own.name).collect();
    // A chip's program may have nothing of C.
    let of_c: &[&str] = if target.contains("-none-") {
        &[]
    } else {
        &OF_C
    };
    one_object(&built.join("libidentifier_ffi.a"), &built, &names, of_c)
}

/// One object of an archive with functions as its only symbols; `of_c` are defined elsewhere.
///
/// # Errors
/// A panic is in it, or anything else that is not defined.
pub(crate) fn one_object(
    archive: &Path,
    folder: &Path,
    names: &[&str],
    of_c: &[&str],
) -> Result<PathBuf, String> {
    let whole = folder.join("whole.o");
    let roots = names.iter().map(|name| format!("--undefined={name}"));
    let mut join = tool("rust-lld")?;
    join.args(["-flavor", "gnu", "--relocatable", "-o"]);
    output(join.arg(&whole).args(roots).arg(archive))?;
    refuse_panics(&whole, folder, names, of_c)?;

    let list = folder.join("functions.txt");
    fs::write(&list, names.join("\n")).map_err(|error| format!("{}: {error}", list.display()))?;
    let own = folder.join("servo_id.o");
    let mut keep = tool("rust-objcopy")?;
    // With what the compiler would optimise further by.
    keep.args([
        "--strip-debug",
        "--remove-section=.llvmbc",
        "--remove-section=.llvmcmd",
    ]);
    keep.arg(format!("--keep-global-symbols={}", list.display()));
    output(keep.arg(&whole).arg(&own))?;
    Ok(own)
}

/// Links an object into a program that defines nothing.
fn refuse_panics(
    object: &Path,
    folder: &Path,
    names: &[&str],
    of_c: &[&str],
) -> Result<(), String> {
    let mut link = tool("rust-lld")?;
    link.args(["-flavor", "gnu", "--gc-sections", "--no-undefined"]);
    link.args(names.iter().map(|name| format!("--undefined={name}")));
    link.args(of_c.iter().map(|name| format!("--defsym={name}=0")));
    let entry = names.first().copied().unwrap_or_default();
    link.arg(format!("--entry={entry}")).arg("-o");
    let linked = output(link.arg(folder.join("linked")).arg(object));
    linked.map(|_| ()).map_err(|fault| {
        let cause = if fault.contains(PANIC) {
            "a function can panic"
        } else {
            "the object is not complete"
        };
        format!("{cause}: {fault}")
    })
}

/// A program that comes with the compiler, and finds the compiler's libraries.
fn tool(name: &str) -> Result<Command, String> {
    let root = output(Command::new("rustc").args(["--print", "sysroot"]))?;
    let libraries = Path::new(root.trim()).join("lib");
    let programs = libraries.join("rustlib").join(this_machine()?).join("bin");
    let mut command = Command::new(programs.join(format!("{name}{EXE_SUFFIX}")));
    command.env("LD_LIBRARY_PATH", libraries);
    Ok(command)
}

/// Runs a program to its end and returns its output.
fn output(command: &mut Command) -> Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .stdin(Stdio::null())
        .output()
        .map_err(|error| format!("{name}: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        let fault = String::from_utf8_lossy(&output.stderr).into_owned();
        Err(format!("{name} ended with {}:\n{fault}", output.status))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A library whose only function is given, with the panic handler of ours.
    fn library(name: &str, body: &str) -> PathBuf {
        let folder = folder().join("tmp").join(name);
        fs::create_dir_all(&folder).expect("a folder");
        let handler = crate::own().join("src/panic.rs");
        let source = folder.join("source.rs");
        let text = format!(
            "#![no_std]\n#[path = {handler:?}]\nmod panic;\n\
             #[unsafe(no_mangle)]\npub extern \"C\" fn servo_id_of_test(x: u32) -> u32 {{ {body} }}\n"
        );
        fs::write(&source, text).expect("written");
        let archive = folder.join("libof_test.a");
        output(
            Command::new("rustc")
                .args([
                    "--edition=2024",
                    "--crate-type=staticlib",
                    "-Cpanic=abort",
                    "-Copt-level=3",
                ])
                .args(["-Clto=fat", "-o"])
                .arg(&archive)
                .arg(&source),
        )
        .expect("it compiles");
        archive
    }

    #[test]
    fn a_panic_is_refused() {
        for (name, body, panics) in [
            ("of-index", "[1_u32, 2, 3][x as usize]", true),
            (
                "of-table",
                "[1_u32, 2, 3].get(x as usize).copied().unwrap_or(0)",
                false,
            ),
        ] {
            let archive = library(name, body);
            let folder = archive.parent().expect("a folder");
            let found = one_object(&archive, folder, &["servo_id_of_test"], &OF_C);
            match found {
                Ok(_) => assert!(!panics, "{name}"),
                Err(fault) => assert!(
                    panics && fault.starts_with("a function can panic"),
                    "{fault}"
                ),
            }
        }
    }
}
