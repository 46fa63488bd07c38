//! The library in C, C++, CMake and Arduino: the bits of Rust, a status for each wrong call, and the guide's commands.
//!
//! A test without its compiler prints that it was skipped.

#[path = "c/reference.rs"]
mod reference;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Flags of every compilation.
const STRICT: [&str; 5] = ["-Wall", "-Wextra", "-Werror", "-O2", "-ffp-contract=off"];

/// Those that find a wrong use of memory, and arithmetic without a result.
const SANITIZED: [&str; 2] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

fn own() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A folder of its own for a test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// True if a compiler is there; prints that a test is skipped without it.
fn has(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output();
    let found = found.is_ok_and(|output| output.status.success());
    if !found {
        println!("skipped: there is no {program}");
    }
    found
}

/// Runs a program to its end and returns its output.
fn run(command: &mut Command) -> String {
    let output = command.output().expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {printed}{complaint}");
    printed
}

/// Builds the library as a user does, and returns the folder that it is in.
fn library(arguments: &[&str]) -> PathBuf {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("servo-id");
    let mut build = Command::new(env!("CARGO_BIN_EXE_c-library"));
    run(build.args(arguments).arg("--out").arg(&out));
    out
}

/// The library of this machine, once.
fn of_this_machine() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| library(&[]))
}

/// The only archive of a PC.
fn archive() -> PathBuf {
    let entries = fs::read_dir(of_this_machine().join("lib")).expect("a folder");
    let folders = entries.map(|entry| entry.expect("an entry").path());
    let mut of_pc = folders.filter(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name != "cmake" && !name.contains("-none-")
    });
    of_pc.next().expect("the library").join("libservo_id.a")
}

/// A program of a source and the library.
fn compile(compiler: &str, standard: &str, source: &Path, more: &[&str], name: &str) -> PathBuf {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    run(Command::new(compiler)
        .args([standard, "-pedantic"])
        .args(STRICT)
        .args(more)
        .arg("-I")
        .arg(of_this_machine().join("include"))
        .arg(source)
        .arg(archive())
        .arg("-lm")
        .arg("-o")
        .arg(&program));
    program
}

/// A folder with `constants.h`, as an option of a compiler.
fn constants(name: &str) -> String {
    let folder = folder(name);
    fs::write(folder.join("constants.h"), reference::constants()).expect("written");
    format!("-I{}", folder.display())
}

#[test]
fn c_has_the_bits_of_rust() {
    if !has("cc") {
        return;
    }
    let source = own().join("tests/c/same_bits.c");
    let expected = reference::lines();
    let constants = constants("constants");
    for (name, flags) in [("same-bits", &[][..]), ("same-bits-sanitized", &SANITIZED)] {
        let flags = &[&[&*constants], flags].concat();
        let program = compile("cc", "-std=c11", &source, flags, name);
        assert_eq!(run(&mut Command::new(program)), expected, "{name}");
    }
}

/// A chip that is emulated.
struct Chip {
    target: &'static str,
    flags: &'static [&'static str],
    board: &'static str,
    flash: u32,
    memory: u32,
}

/// A chip without FPU, whose code runs on a Cortex-M3 too, and two with one.
const CHIPS: [Chip; 3] = [
    Chip {
        target: "thumbv6m-none-eabi",
        flags: &["-mcpu=cortex-m0plus", "-mfloat-abi=soft"],
        board: "mps2-an385",
        flash: 0,
        memory: 0x2000_0000,
    },
    Chip {
        target: "thumbv7em-none-eabihf",
        flags: &["-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
        board: "olimex-stm32-h405",
        flash: 0x0800_0000,
        memory: 0x2000_0000,
    },
    Chip {
        target: "thumbv8m.main-none-eabihf",
        flags: &["-mcpu=cortex-m33", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16"],
        board: "mps2-an505",
        flash: 0x1000_0000,
        memory: 0x3800_0000,
    },
];

#[test]
fn chips_have_the_bits_of_rust() {
    if !has("arm-none-eabi-gcc") || !has("qemu-system-arm") {
        return;
    }
    let expected = reference::lines();
    let constants = constants("constants-of-chips");
    let from = own().join("tests/c");
    for chip in CHIPS {
        let library = library(&["--target", chip.target]);
        let program = folder(chip.target).join("same-bits.elf");
        run(Command::new("arm-none-eabi-gcc")
            .args(chip.flags)
            .args([
                "-mthumb",
                "-std=gnu11",
                "-nostartfiles",
                "-Wl,--gc-sections",
            ])
            .args(["-Wl,--no-warn-execstack", "-Wl,--no-warn-rwx-segments"])
            .args(STRICT)
            .arg(&constants)
            .arg(format!("-Wl,--defsym=flash_begin={}", chip.flash))
            .arg(format!("-Wl,--defsym=memory_begin={}", chip.memory))
            .arg("-I")
            .arg(library.join("include"))
            .args(["same_bits.c", "chip.c"].map(|file| from.join(file)))
            .arg(library.join("lib").join(chip.target).join("libservo_id.a"))
            .arg("-T")
            .arg(from.join("chip.ld"))
            .arg("-o")
            .arg(&program));
        let printed = run(Command::new("qemu-system-arm")
            .args([
                "-M",
                chip.board,
                "-nographic",
                "-monitor",
                "none",
                "-serial",
                "null",
            ])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(&program));
        assert_eq!(printed, expected, "{}", chip.target);
    }
}

/// Nothing but the samples is linked into a program whose objects are of constants: no certificate and no settings.
#[test]
fn a_program_of_constants_links_little() {
    if !has("cc") || !has("size") {
        return;
    }
    let bytes = |name: &str, init: &str| {
        let program = folder("links-little").join(name);
        let functions = [init, "process", "machine_estimates"];
        run(Command::new("cc")
            .args([
                "-nostdlib",
                "-Wl,--gc-sections",
                "-Wl,--unresolved-symbols=ignore-all",
            ])
            .args(functions.map(|of| format!("-Wl,--undefined=servo_id_{name}_{of}")))
            .arg(format!("-Wl,--entry=servo_id_{name}_process"))
            .arg(archive())
            .arg("-o")
            .arg(&program));
        let table = run(Command::new("size").arg(program));
        let text = table
            .lines()
            .nth(1)
            .and_then(|line| line.split_whitespace().next());
        text.and_then(|bytes| bytes.parse::<u32>().ok())
            .expect("a number")
    };
    for (name, most) in [
        ("gradient_loop", 16),
        ("gradient_coulomb_loop", 19),
        ("fixed_loop", 16),
        ("fixed_coulomb_loop", 20),
        ("gauss_newton_loop", 27),
    ] {
        let [built, of_constants] = ["init", "init_from_constants"].map(|init| bytes(name, init));
        println!("{name}: {of_constants} bytes of constants, {built} from settings");
        // The settings alone, with their checks, are more than this.
        let of_settings = 20 * 1024;
        assert!(
            of_constants < 1024 * most && of_constants + of_settings < built,
            "{name}"
        );
    }
}

#[test]
fn wrong_calls_have_a_status() {
    if !has("cc") {
        return;
    }
    let source = own().join("tests/c/wrong_calls.c");
    run(&mut Command::new(compile(
        "cc",
        "-std=c11",
        &source,
        &SANITIZED,
        "wrong-calls",
    )));
}

#[test]
fn the_wrapper_has_every_function() {
    if !has("c++") {
        return;
    }
    let source = own().join("tests/c/wrapper.cpp");
    let flags = [&SANITIZED[..], &["-fno-exceptions", "-fno-rtti"]].concat();
    run(&mut Command::new(compile(
        "c++",
        "-std=c++17",
        &source,
        &flags,
        "wrapper",
    )));
}

#[test]
fn only_the_functions_of_the_header_are_seen() {
    if !has("nm") {
        return;
    }
    let printed = run(Command::new("nm")
        .args(["--extern-only", "--defined-only"])
        .arg(archive()));
    let mut seen: Vec<&str> = printed
        .lines()
        .filter_map(|line| line.split_whitespace().nth(2))
        .collect();
    let mut own: Vec<&str> = identifier_ffi::prototypes().map(|own| own.name).collect();
    seen.sort_unstable();
    own.sort_unstable();
    assert_eq!(seen, own);
}

#[test]
fn a_sketch_identifies_its_motor() {
    if !has("c++") {
        return;
    }
    let from = own().join("tests/arduino");
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sketch");
    run(Command::new("c++")
        .args(["-std=c++17", "-fno-exceptions", "-fno-rtti"])
        .args(STRICT)
        .args(SANITIZED)
        .args(
            ["include", "arduino/ServoId/src", "tests/arduino"].map(|folder| format!("-I{folder}")),
        )
        .args([
            "-x",
            "c++",
            "arduino/ServoId/examples/Identify/Identify.ino",
        ])
        .arg(from.join("main.cpp"))
        .args(["-x", "none"])
        .arg(archive())
        .arg("-o")
        .arg(&program)
        .current_dir(own()));
    let printed = run(&mut Command::new(program));
    let last = printed.lines().last().expect("a line a second");
    let values: Vec<f64> = last
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect();
    let [a, a_error, b, b_error, coulomb, ..] = values[..] else {
        panic!("{printed}");
    };
    println!("{last}");
    assert!((b / 90.0 - 1.0).abs() < 0.03 && b_error < 3.0, "{printed}");
    assert!((a - 8.0).abs() < 1.0 && a_error < 1.0, "{printed}");
    assert!((coulomb / 30.0 - 1.0).abs() < 0.1, "{printed}");
}

/// The commands of the guide's blocks for a shell.
fn guide() -> Vec<String> {
    let page = fs::read_to_string(own().join("../../docs/guide-c.md")).expect("the guide");
    let blocks = page.split("```sh\n").skip(1);
    blocks
        .filter_map(|block| block.split_once("```"))
        .map(|(block, _)| block.to_owned())
        .collect()
}

#[test]
fn the_commands_of_the_guide_do_what_it_says() {
    let folder = folder("guide");
    let blocks = guide();
    let needs = ["cc", "cmake", "arduino-cli"];
    assert_eq!(blocks.len(), needs.len());
    of_this_machine();
    for (block, needs) in blocks.iter().zip(needs) {
        assert!(block.lines().count() <= 4, "{block}");
        if !has(needs) {
            continue;
        }
        let folder = folder.join(needs);
        fs::create_dir_all(&folder).expect("a folder");
        // The user's copy of the project is this one, and its program is built.
        let root = own().join("../..").canonicalize().expect("the project");
        run(Command::new("ln")
            .arg("-s")
            .arg(root)
            .arg(folder.join("servo-identifier")));
        let commands = block.replace("cargo c-library", env!("CARGO_BIN_EXE_c-library"));
        let printed = run(Command::new("sh")
            .args(["-e", "-c", &commands])
            .current_dir(&folder));
        println!("{printed}");
        if needs == "cc" {
            let shown = fs::read_to_string(own().join("../../docs/guide-c.md")).expect("the guide");
            assert!(
                printed
                    .lines()
                    .all(|line| shown.contains(line) || line.starts_with('/')),
                "{printed}"
            );
        }
    }
}
