//! The seal of a program of the firmware: the check sum that it compares with its flash when it boots.

use std::fmt::Display;
use std::fs;
use std::path::{Path, PathBuf};

use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol};

/// The section of the seal.
const SECTION: &str = ".seal";

/// Seals a linked program in its place, if it has room for a seal.
pub(crate) fn seal(path: &Path) -> Result<(), String> {
    let fault = |error: &dyn Display| format!("{}: {error}", path.display());
    let mut bytes = fs::read(path).map_err(|error| fault(&error))?;
    let Some((place, seal)) = found(&bytes).map_err(|error| fault(&error))? else {
        return Ok(());
    };
    bytes
        .get_mut(place..place + 4)
        .ok_or_else(|| fault(&"the section of the seal is cut off"))?
        .copy_from_slice(&seal.to_le_bytes());
    fs::write(path, bytes).map_err(|error| fault(&error))
}

/// A copy of a sealed program beside it, with another bit in its seal.
pub(crate) fn damaged(path: &Path) -> Result<PathBuf, String> {
    let fault = |error: &dyn Display| format!("{}: {error}", path.display());
    let mut bytes = fs::read(path).map_err(|error| fault(&error))?;
    let (place, _) = found(&bytes)
        .map_err(|error| fault(&error))?
        .ok_or_else(|| fault(&"it has no seal"))?;
    let byte = bytes.get_mut(place);
    *byte.ok_or_else(|| fault(&"the section of the seal is cut off"))? ^= 1;
    let copy = path.with_extension("damaged");
    fs::write(&copy, bytes).map_err(|error| fault(&error))?;
    Ok(copy)
}

/// The place of the seal in the file, and the seal.
fn found(bytes: &[u8]) -> Result<Option<(usize, u32)>, String> {
    let file: ElfFile32<'_, Endianness> =
        ElfFile32::parse(bytes).map_err(|error| error.to_string())?;
    let place = file
        .section_by_name(SECTION)
        .and_then(|section| section.file_range())
        .filter(|&(_, length)| length == 4);
    let Some((place, _)) = place else {
        return Ok(None);
    };
    let symbol = |name: &str| {
        let mut symbols = file.symbols();
        symbols
            .find(|symbol| symbol.name() == Ok(name))
            .map(|symbol| symbol.address())
            .ok_or_else(|| format!("it has no symbol {name}"))
    };
    let values = symbol("__sidata")?;
    let length = symbol("__edata")? - symbol("__sdata")?;
    // The parts that `firmware-stm32/src/image.rs` checks, in its order.
    let parts = [
        (symbol("__vector_table")?, symbol("_vectors_end")?),
        (symbol("__stext")?, symbol("__etext")?),
        (symbol("__srodata")?, symbol("__erodata")?),
        (values, values + length),
    ];
    let contents = parts
        .into_iter()
        .map(|(from, to)| loaded(&file, bytes, from, to))
        .collect::<Result<Vec<_>, _>>()?;
    let seal = drive_logic::seal(contents.iter().map(Vec::as_slice));
    Ok(Some((place as usize, seal)))
}

/// The bytes that are loaded to a range of the flash.
fn loaded(
    file: &ElfFile32<'_, Endianness>,
    bytes: &[u8],
    from: u64,
    to: u64,
) -> Result<Vec<u8>, String> {
    let endian = file.endian();
    (from..to)
        .map(|address| {
            file.elf_program_headers()
                .iter()
                .find_map(|header| {
                    let first = u64::from(header.p_paddr(endian));
                    let offset = address.checked_sub(first)?;
                    let is_inside = offset < u64::from(header.p_filesz(endian));
                    let place = u64::from(header.p_offset(endian)) + offset;
                    is_inside.then(|| bytes.get(place as usize).copied())?
                })
                .ok_or_else(|| format!("nothing is loaded to {address:#x}"))
        })
        .collect()
}
