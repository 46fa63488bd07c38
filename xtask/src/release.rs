//! Everything that is handed out: built, and then tried in an empty folder, where nothing of the project, of Cargo and of
//! Python's packages is in reach.

use std::env::temp_dir;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{add_target, built, cargo, root, run};
use crate::{playground, python};

/// The log that a part is tried with, and a name for it elsewhere.
const LOG: &str = "host-sim/logs/simulated-servo.csv.gz";
const COPY: &str = "log.csv.gz";

/// A static program runs on every Linux of this processor.
const PROGRAM: &str = "x86_64-unknown-linux-musl";

/// What nothing here can run, and is checked all the same.
const WINDOWS: &str = "x86_64-pc-windows-gnu";

/// The wheels: for every Linux since 2014, one per processor, each linked by zig.
const WHEELS: [&str; 2] = ["x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu"];

/// Builds and tries all of it. What cannot be built or tried on this machine is named.
pub(crate) fn make() -> Result<(), String> {
    let artefacts = built().join("release-artefacts");
    let _ = fs::remove_dir_all(&artefacts);
    fs::create_dir_all(&artefacts).map_err(|error| at(&artefacts, error))?;
    program(&artefacts)?;
    windows()?;
    wheels(&artefacts)?;
    libraries()?;
    arduino(&artefacts)?;
    page(&artefacts)?;
    book(&artefacts)?;
    crates(&artefacts)
}

fn program(artefacts: &Path) -> Result<(), String> {
    add_target(PROGRAM)?;
    let build = format!("build --release --locked -p servo-id --target {PROGRAM}");
    run(cargo(&build).env("CARGO_PROFILE_RELEASE_STRIP", "true"))?;
    let linked = built().join(PROGRAM).join("release/servo-id");
    let program = copied(&linked, artefacts, &format!("servo-id-{PROGRAM}"))?;
    let folder = empty("program")?;
    copied(&root().join(LOG), &folder, COPY)?;
    let mine = copied(&program, &folder, "servo-id")?;
    let identify = format!("identify {COPY} --json result.json --require converged");
    run(&mut alone(&mine, &folder, &identify))?;
    run(&mut alone(&mine, &folder, "tune result.json"))?;
    made(&program, "identifies and tunes")
}

fn windows() -> Result<(), String> {
    add_target(WINDOWS)?;
    run(&mut cargo(&format!(
        "check --locked -p servo-id --target {WINDOWS}"
    )))?;
    println!("servo-id for {WINDOWS}: types checked; .github/workflows/release.yml builds it");
    Ok(())
}

fn wheels(artefacts: &Path) -> Result<(), String> {
    const READS: &str = "import servo_id\nprint(servo_id.identify('log.csv.gz'))\n";
    let Some(environment) = python::environment(&["maturin[zig]>=1.9,<2", python::PACKER])? else {
        return Ok(());
    };
    for target in WHEELS {
        add_target(target)?;
        let how = [
            "--zig",
            "--compatibility",
            "manylinux2014",
            "--target",
            target,
        ];
        let wheel = python::wheel(&environment, &how)?;
        let name = wheel.file_name().unwrap_or_default().to_string_lossy();
        let wheel = copied(&wheel, artefacts, &name)?;
        if !target.starts_with(std::env::consts::ARCH) {
            made(&wheel, "not tried: it is for another processor")?;
            continue;
        }
        let folder = empty("wheel")?;
        copied(&root().join(LOG), &folder, COPY)?;
        run(python3("-m venv own").current_dir(&folder))?;
        // What it depends on comes from the registry, by the settings of this machine.
        let mut pip = Command::new(folder.join("own/bin/pip"));
        run(pip
            .args(["install", "--quiet"])
            .arg(&wheel)
            .current_dir(&folder))?;
        written(&folder.join("reads.py"), READS)?;
        run(&mut alone(
            &folder.join("own/bin/python"),
            &folder,
            "-I reads.py",
        ))?;
        made(&wheel, "identifies in a new environment")?;
    }
    Ok(())
}

/// The library for C, for every target in the table of its guide.
fn libraries() -> Result<(), String> {
    let guide = root().join("docs/guide-c.md");
    let text = fs::read_to_string(&guide).map_err(|error| at(&guide, error))?;
    let first = |line: &'_ str| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_owned());
    for target in text
        .lines()
        .filter_map(first)
        .filter(|of| of.contains("-none-"))
    {
        let build = "run --quiet --locked -p identifier-ffi --bin c-library -- --target";
        run(cargo(build).arg(target))?;
    }
    Ok(())
}

fn arduino(artefacts: &Path) -> Result<(), String> {
    const USES: &str = "#include \"servo_id.h\"\nservo_id_gradient one;\n";
    let folder = empty("arduino")?;
    let build = "run --quiet --locked -p identifier-ffi --bin c-library -- --arduino --out";
    run(cargo(build).arg(&folder))?;
    let archive = zipped(&folder, "ServoId", &artefacts.join("ServoId-arduino.zip"))?;
    let folder = empty("arduino")?;
    run(python3("-m zipfile -e").args([&archive, &folder]))?;
    written(&folder.join("uses.c"), USES)?;
    let compiler = Path::new("cc");
    if !is_there(compiler) {
        return made(&archive, "not tried: there is no C compiler");
    }
    let strict = "-std=c11 -Wall -Wextra -Werror -IServoId/src -c uses.c";
    run(&mut alone(compiler, &folder, strict))?;
    made(&archive, "its header compiles")
}

fn page(artefacts: &Path) -> Result<(), String> {
    let folder = empty("playground")?;
    playground::build(&folder)?;
    let page = copied(&folder.join("index.html"), artefacts, "playground.html")?;
    let text = fs::read_to_string(&page).map_err(|error| at(&page, error))?;
    let loads = |from: &&str| text.contains(*from);
    if let Some(from) = ["src=\"", "href=\"http", "@import"]
        .iter()
        .find(|from| loads(from))
    {
        return Err(format!(
            "{}: {from} loads something from elsewhere",
            page.display()
        ));
    }
    made(
        &page,
        "loads nothing; the program's tests operate it in a browser",
    )
}

fn book(artefacts: &Path) -> Result<(), String> {
    if !is_there(Path::new("mdbook")) {
        println!("book: skipped, there is no mdbook (cargo install --locked mdbook)");
        return Ok(());
    }
    let folder = empty("book")?;
    let book = folder.join("servo-identifier");
    let mut mdbook = Command::new("mdbook");
    run(mdbook
        .args(["build", "--dest-dir"])
        .arg(&book)
        .current_dir(root()))?;
    playground::build(&book.join("playground"))?;
    let archive = artefacts.join("servo-identifier-book.zip");
    made(&zipped(&folder, "servo-identifier", &archive)?, "made")
}

/// The packages of the registry, each compiled from what its archive has.
fn crates(artefacts: &Path) -> Result<(), String> {
    let folder = built().join("crates");
    let publish = "publish --workspace --dry-run --locked --allow-dirty";
    run(cargo(publish).env("CARGO_TARGET_DIR", &folder))?;
    let archives = folder.join("package/tmp-crate");
    let found = fs::read_dir(&archives).map_err(|error| at(&archives, error))?;
    for archive in found.flatten().map(|found| found.path()) {
        let name = archive.file_name().unwrap_or_default().to_string_lossy();
        made(
            &copied(&archive, artefacts, &name)?,
            "compiles from its archive",
        )?;
    }
    Ok(())
}

/// A program with these words where only the system's own programs are in reach.
fn alone(program: &Path, folder: &Path, words: &str) -> Command {
    let mut command = Command::new(program);
    command
        .args(words.split_whitespace())
        .current_dir(folder)
        .env_clear()
        .envs([
            ("HOME", folder.as_os_str()),
            ("PATH", "/usr/bin:/bin".as_ref()),
        ]);
    command
}

fn python3(words: &str) -> Command {
    let mut python = Command::new("python3");
    python.args(words.split_whitespace());
    python
}

fn is_there(program: &Path) -> bool {
    let told = Command::new(program).arg("--version").output();
    told.is_ok_and(|told| told.status.success())
}

/// An empty folder outside of the project.
fn empty(name: &str) -> Result<PathBuf, String> {
    let folder = temp_dir().join(format!("servo-id-release-{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|error| at(&folder, error))?;
    Ok(folder)
}

fn written(file: &Path, text: &str) -> Result<(), String> {
    fs::write(file, text).map_err(|error| at(file, error))
}

fn copied(from: &Path, folder: &Path, name: &str) -> Result<PathBuf, String> {
    let to = folder.join(name);
    fs::copy(from, &to).map_err(|error| at(from, error))?;
    Ok(to)
}

/// Packs a folder within another.
fn zipped(within: &Path, name: &str, archive: &Path) -> Result<PathBuf, String> {
    let mut pack = python3("-m zipfile -c");
    run(pack.arg(archive).arg(name).current_dir(within))?;
    Ok(archive.to_owned())
}

/// Prints what was made, its size, and what it was seen to do.
fn made(artefact: &Path, does: &str) -> Result<(), String> {
    let bytes = fs::metadata(artefact)
        .map_err(|error| at(artefact, error))?
        .len();
    println!("{}: {bytes} bytes; {does}", artefact.display());
    Ok(())
}

fn at(path: &Path, error: std::io::Error) -> String {
    format!("{}: {error}", path.display())
}
