//! For the binary `constants`: certifies and builds the loop on the PC, and writes it as constants. A firmware whose settings
//! are a scenario has `servo-id export --firmware rust` for this.

#[path = "src/settings.rs"]
mod settings;

use std::{env, fs};
use std::path::Path;

use identifier_core::constants::words;

fn main() {
    let built = settings::build().expect("certified");
    let mut all = Vec::new();
    words(&built, |word| all.push(word));
    let out = env::var("OUT_DIR").expect("set by cargo");
    fs::write(Path::new(&out).join("words.rs"), format!("&{all:?}")).expect("written");
    println!("cargo:rerun-if-changed=src/settings.rs");
}
