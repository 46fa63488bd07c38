//! The playground. It is the core, the virtual servo and the command line's library as WebAssembly in one page that
//! needs no server.
//!
//! The page's parts are in `docs/playground`. The module is packed by gzip, which a browser unpacks, and written in base 64.

use std::fs;
use std::path::{Path, PathBuf};

use crate::command::{add_target, built, cargo, root, run};

const TARGET: &str = "wasm32-unknown-unknown";

/// The largest page, bytes.
const MAX_PAGE: usize = 466_500;

/// Builds the page into a folder, as `index.html`.
pub(crate) fn build(folder: &Path) -> Result<(), String> {
    let module = module()?;
    let parts = root().join("docs/playground");
    let read = |name: &str| {
        let path = parts.join(name);
        fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let packed =
        packed(&module).map_err(|error| format!("the module cannot be packed: {error}"))?;
    let mut page = brief(&read("page.html")?);
    for name in ["page.css", "worker.js", "draw.js", "page.js"] {
        page = filled(&page, &format!("/* {name} */\n"), &brief(&read(name)?))?;
    }
    page = filled(&page, "PACKED_MODULE", &as_text(&packed))?;
    if page.len() > MAX_PAGE {
        let length = page.len();
        return Err(format!(
            "the page has {length} bytes, at most {MAX_PAGE} are allowed: leave something out of the module"
        ));
    }
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let file = folder.join("index.html");
    fs::write(&file, &page).map_err(|error| format!("{}: {error}", file.display()))?;
    println!(
        "{}: {} bytes; the module has {}, packed {}",
        file.display(),
        page.len(),
        module.len(),
        packed.len()
    );
    Ok(())
}

/// Where the page is built unless another folder is asked for.
pub(crate) fn usual_folder() -> PathBuf {
    built().join("playground")
}

/// Builds the module; its profile leaves out names and all that nothing runs by.
fn module() -> Result<Vec<u8>, String> {
    // No path of this machine is in the page, so that every machine builds the same.
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".cargo")));
    let home = home.ok_or("neither CARGO_HOME nor HOME is set")?;
    let flags = format!("--remap-path-prefix={}=cargo", home.display());
    add_target(TARGET)?;
    let build = "rustc --quiet --locked --package playground --crate-type cdylib --profile playground --target";
    run(cargo(build)
        .arg(TARGET)
        .env("CARGO_ENCODED_RUSTFLAGS", &flags))?;
    let file = built().join(TARGET).join("playground/playground.wasm");
    fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))
}

fn packed(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut packed = Vec::new();
    zopfli::compress(
        zopfli::Options::default(),
        zopfli::Format::Gzip,
        bytes,
        &mut packed,
    )?;
    Ok(packed)
}

/// Bytes as text that HTML leaves as it is: five digits to the base 85 for four bytes, of the last ones one more than there are.
/// The page reads it back (`unpacked` in page.js).
fn as_text(bytes: &[u8]) -> String {
    let digits: Vec<char> = ('#'..='z').filter(|one| !"&<\\".contains(*one)).collect();
    let group = |bytes: &[u8]| {
        let mut four = [0; 4];
        four[..bytes.len()].copy_from_slice(bytes);
        let value = u32::from_be_bytes(four) as usize;
        let digit = |place| digits[value / 85_usize.pow(place) % 85];
        let text: String = (0..5).rev().map(digit).take(bytes.len() + 1).collect();
        text
    };
    bytes.chunks(4).map(group).collect()
}

/// A part without indentation, empty lines and lines of comment.
fn brief(part: &str) -> String {
    let lines = part.lines().map(str::trim);
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with("//"));
    lines.fold(String::new(), |text, line| text + line + "\n")
}

fn filled(page: &str, place: &str, part: &str) -> Result<String, String> {
    match page.matches(place).count() {
        1 => Ok(page.replacen(place, part, 1)),
        count => Err(format!(
            "docs/playground/page.html has {place:?} {count} times, not once"
        )),
    }
}
