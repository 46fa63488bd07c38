//! Where everything is written.

use std::fs;
use std::path::Path;

use crate::{archive, build, own};

/// The name of the archive.
const LIBRARY: &str = "libservo_id.a";

/// Headers of C and C++.
const HEADERS: [&str; 2] = ["servo_id.h", "servo_id.hpp"];

/// The folders of Arduino's cores, and the targets of their chips.
const ARDUINO: [(&str, &str); 3] = [
    ("cortex-m0plus", "thumbv6m-none-eabi"),
    ("cortex-m4/fpv4-sp-d16-hard", "thumbv7em-none-eabihf"),
    ("cortex-m33/fpv5-sp-d16-hard", "thumbv8m.main-none-eabihf"),
];

/// Builds the library for a target into a folder.
pub(crate) fn library(target: &str, out: &Path) -> Result<(), String> {
    built(target, &out.join("lib").join(target))?;
    for header in HEADERS {
        copy(&own().join("include").join(header), &out.join("include"))?;
    }
    for file in ["ServoIdConfig.cmake", "ServoIdConfigVersion.cmake"] {
        copy(
            &own().join("cmake").join(file),
            &out.join("lib/cmake/ServoId"),
        )?;
    }
    Ok(())
}

/// Builds the library of the Arduino IDE into a folder.
pub(crate) fn arduino(out: &Path) -> Result<(), String> {
    let library = out.join("ServoId");
    for (folder, target) in ARDUINO {
        built(target, &library.join("src").join(folder))?;
    }
    for header in HEADERS {
        copy(&own().join("include").join(header), &library.join("src"))?;
    }
    let from = own().join("arduino/ServoId");
    for (file, to) in [
        ("library.properties", ""),
        ("src/ServoId.h", "src"),
        ("examples/Identify/Identify.ino", "examples/Identify"),
    ] {
        copy(&from.join(file), &library.join(to))?;
    }
    Ok(())
}

/// Builds the archive for a target into a folder.
fn built(target: &str, folder: &Path) -> Result<(), String> {
    let object = build::object(target)?;
    let fault = |error: std::io::Error| format!("{}: {error}", folder.display());
    let names: Vec<&str> = identifier_ffi::prototypes().map(|own| own.name).collect();
    let object = fs::read(object).map_err(fault)?;
    let archive = archive::of("servo_id.o", &object, &names);
    fs::create_dir_all(folder).map_err(fault)?;
    let file = folder.join(LIBRARY);
    fs::write(&file, &archive).map_err(fault)?;
    println!("{}: {} bytes", file.display(), archive.len());
    Ok(())
}

/// Copies a file into a folder.
fn copy(from: &Path, folder: &Path) -> Result<(), String> {
    let fault = |error: std::io::Error| format!("{}: {error}", from.display());
    fs::create_dir_all(folder).map_err(fault)?;
    let name = from.file_name().unwrap_or_default();
    fs::copy(from, folder.join(name)).map(|_| ()).map_err(fault)
}
