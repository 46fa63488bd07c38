//! Finds the memory map, and turns the paper's scenario into constants: the chip runs the
//! experiment that the simulator runs, from the same file.

use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

use toml::{Table, Value};

fn main() {
    let here = env::var("CARGO_MANIFEST_DIR").expect("set by cargo");
    let root = Path::new(&here).parent().expect("the workspace");
    println!("cargo:rustc-link-search={}", root.display());
    println!("cargo:rerun-if-changed={}", root.join("memory.x").display());
    // For the binaries of the chip only: a host has no memory map.
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
        println!("cargo:rustc-link-arg-bins=--nmagic");
        if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
            println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
        }
    }

    let path = root.join("host-sim/scenarios/paper.toml");
    println!("cargo:rerun-if-changed={}", path.display());
    let text = fs::read_to_string(&path).expect("the paper's scenario");
    let scenario: Table = text.parse().expect("a scenario");
    let number = |table: &str, key: &str| as_number(&scenario[table][key]);
    let mut constants = String::new();
    for (name, table, key) in [
        ("A", "plant", "a"),
        ("B", "plant", "b"),
        ("LOAD", "plant", "load"),
        ("COUNTS_PER_REV", "encoder", "counts_per_rev"),
        ("LIMIT", "amplifier", "limit"),
        ("KP", "controller", "kp"),
        ("KD", "controller", "kd"),
        ("KI", "controller", "ki"),
        ("SAMPLE_TIME", "controller", "sample_time"),
        ("POWER", "excitation", "power"),
        ("HOLD", "excitation", "sample_time"),
        ("SEED", "excitation", "seed"),
        ("MU", "identifier", "mu"),
        ("DURATION", "run", "duration"),
    ] {
        let value = number(table, key);
        writeln!(constants, "pub(crate) const {name}: f64 = {value:?};").expect("a string");
    }
    let cutoff = as_number(&scenario["controller"]["velocity_filter"]["cutoff"]);
    writeln!(constants, "pub(crate) const CUTOFF: f64 = {cutoff:?};").expect("a string");
    let identifier = &scenario["identifier"];
    for (name, pair) in [
        ("GAMMA", &identifier["gamma"]),
        ("BOUNDS_A", &identifier["bounds"]["a"]),
        ("BOUNDS_B", &identifier["bounds"]["b"]),
        ("BOX_A", &identifier["plant_box"]["a"]),
        ("BOX_B", &identifier["plant_box"]["b"]),
    ] {
        let pair: Vec<f64> = pair
            .as_array()
            .expect("two numbers")
            .iter()
            .map(as_number)
            .collect();
        writeln!(constants, "pub(crate) const {name}: [f64; 2] = {pair:?};").expect("a string");
    }
    let initial = [&identifier["initial"]["a"], &identifier["initial"]["b"]].map(as_number);
    writeln!(
        constants,
        "pub(crate) const INITIAL: [f64; 2] = {initial:?};"
    )
    .expect("a string");
    let out = env::var("OUT_DIR").expect("set by cargo");
    fs::write(Path::new(&out).join("paper.rs"), constants).expect("the constants are written");
}

fn as_number(value: &Value) -> f64 {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|whole| whole as f64))
        .expect("a number")
}
