//! Finds the memory map, and converts the paper's scenario into constants. The chip runs the same experiment as the
//! simulator, from the same file.

use std::path::Path;
use std::{env, fs};

use toml::{Table, Value};

fn main() {
    let here = env::var("CARGO_MANIFEST_DIR").expect("set by cargo");
    let root = Path::new(&here).parent().expect("the project");
    let out = env::var("OUT_DIR").expect("set by cargo");
    println!("cargo:rustc-link-search={out}");
    let memory = Path::new(&out).join("memory.x");
    fs::write(memory, memory_of_the_board(root)).expect("the memory map is written");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=--nmagic");
    if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }

    let path = root.join("host-sim/scenarios/paper.toml");
    println!("cargo:rerun-if-changed={}", path.display());
    let text = fs::read_to_string(&path).expect("the paper's scenario");
    let scenario: Table = text.parse().expect("a scenario");
    let constants: String = scenario.iter().map(constants).collect();
    fs::write(Path::new(&out).join("paper.rs"), constants).expect("the constants are written");
}

/// The memory map of the project, with the memories of the board in place of its own where the board has a file of them.
fn memory_of_the_board(root: &Path) -> String {
    let read = |path: &Path| {
        println!("cargo:rerun-if-changed={}", path.display());
        fs::read_to_string(path).expect("a memory map")
    };
    let map = read(&root.join("memory.x"));
    let features = env::vars().filter_map(|(name, _)| {
        let feature = name.strip_prefix("CARGO_FEATURE_")?;
        Some(format!("src/board/{}.x", feature.to_lowercase()))
    });
    let mut memories = features.filter(|file| Path::new(file).exists());
    match (memories.next(), map.split_once("\n}\n")) {
        (Some(own), Some((_, rest))) => read(Path::new(&own)) + rest,
        _ => map,
    }
}

/// A module for a table, and a constant for a number or a pair of numbers, by their names in the file.
fn constants((key, value): (&String, &Value)) -> String {
    let pair: Option<Vec<f64>> = value
        .as_array()
        .and_then(|values| values.iter().map(number).collect());
    let (kind, value) = match (value, number(value), pair) {
        (Value::Table(table), ..) => {
            let inside: String = table.iter().map(constants).collect();
            return format!("/// `{key}`.\npub mod {key} {{\n{inside}}}\n");
        }
        (_, Some(number), _) => ("f64", format!("{number:?}")),
        (_, _, Some(pair)) if pair.len() == 2 => ("[f64; 2]", format!("{pair:?}")),
        // Words.
        _ => return String::new(),
    };
    let name = key.to_uppercase();
    format!("/// `{key}`.\npub const {name}: {kind} = {value};\n")
}

fn number(value: &Value) -> Option<f64> {
    let whole = value.as_integer().map(|whole| whole as f64);
    value.as_float().or(whole)
}
