//! The firmware is a workspace of its own, with its own lock: what the project's crates are made of is one version in both,
//! or the chip would run, and compute with, something else than the tests on a PC.

use std::fs;
use std::path::Path;

#[test]
fn the_firmware_has_the_versions_that_are_tested_on_a_pc() {
    let [on_a_pc, on_the_chip] = ["Cargo.lock", "firmware-stm32/Cargo.lock"].map(packages);
    let mut parts = ["commissioning", "drive-logic", "virtual-servo"]
        .map(str::to_owned)
        .to_vec();
    let (mut looked_at, mut other) = (0, Vec::new());
    while let Some(part) = parts.get(looked_at) {
        looked_at += 1;
        let is_it = |name: &str| name == part || name.split(' ').next() == Some(part);
        let package = on_the_chip.iter().find(|(name, _)| is_it(name));
        let (name, needs) = package.expect("a locked package");
        other.extend(on_a_pc.iter().all(|(same, _)| same != name).then_some(name));
        let new = needs.iter().filter(|need| !parts.contains(need));
        parts.extend(new.cloned().collect::<Vec<_>>());
    }
    for numerics in ["fixed", "libm", "micromath"] {
        assert!(parts.contains(&numerics.to_owned()), "{parts:?}");
    }
    assert!(other.is_empty(), "`cargo update` in both: {other:?}");
}

/// The packages in a lock, by name and version, and what each needs.
fn packages(lock: &str) -> Vec<(String, Vec<String>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(lock);
    let lock = fs::read_to_string(path).expect("readable");
    let lock: toml::Table = lock.parse().expect("a lock");
    let text = |value: &toml::Value| value.as_str().expect("a text").to_owned();
    let package = |package: &toml::Value| {
        let needs = package.get("dependencies").and_then(toml::Value::as_array);
        let needs = needs.map_or(Vec::new(), |needs| needs.iter().map(text).collect());
        let name = format!("{} {}", text(&package["name"]), text(&package["version"]));
        (name, needs)
    };
    let packages = lock["package"].as_array().expect("packages");
    packages.iter().map(package).collect()
}
