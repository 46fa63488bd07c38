//! A linked binary.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::Range;
use std::path::{Path, PathBuf};

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind, elf};
use thumb::Instruction;

/// Where the chip's flash ends and everything above is memory.
const FLASH_END: u64 = 0x1000_0000;

/// A linked binary.
pub(crate) struct Elf {
    path: PathBuf,
    bytes: Vec<u8>,
}

/// A function of a binary.
pub(crate) struct Function {
    pub(crate) name: String,
    /// Its bytes, the constants after it included.
    pub(crate) range: Range<u64>,
    pub(crate) instructions: Vec<Instruction>,
}

/// Bytes that a binary takes.
pub(crate) struct Sizes {
    pub(crate) flash: u64,
    pub(crate) memory: u64,
}

impl Elf {
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self {
            path: path.to_owned(),
            bytes,
        })
    }

    fn fault(&self, error: &dyn Display) -> String {
        format!("{}: {error}", self.path.display())
    }

    fn parsed(&self) -> Result<object::File<'_>, String> {
        object::File::parse(&*self.bytes).map_err(|error| self.fault(&error))
    }

    /// The functions whose symbols fit, by their addresses.
    pub(crate) fn functions(&self, fits: impl Fn(&str) -> bool) -> Result<Vec<Function>, String> {
        let file = self.parsed()?;
        let mut functions = Vec::new();
        for section in file.sections() {
            let symbols = || {
                let own = Some(section.index());
                file.symbols()
                    .filter(move |symbol| symbol.section_index() == own)
                    // The lowest bit of an address says Thumb.
                    .map(|symbol| (symbol.address() & !1, symbol))
            };
            let found: BTreeMap<u64, (u64, &str)> = symbols()
                .filter(|(_, symbol)| symbol.kind() == SymbolKind::Text && symbol.size() > 0)
                .map(|(address, symbol)| (address, (symbol.size(), symbol.name().unwrap_or("?"))))
                .collect();
            // Mapping symbols: $t begins code, $d data in between.
            let is_code: BTreeMap<u64, bool> = symbols()
                .filter_map(|(address, symbol)| match symbol.name() {
                    Ok(name) if name.starts_with("$t") => Some((address, true)),
                    Ok(name) if name.starts_with("$d") => Some((address, false)),
                    _ => None,
                })
                .collect();
            for (start, (size, name)) in found {
                // The bytes between two functions are filled with what would decode as a jump.
                let end = start + size;
                if fits(name) {
                    let code = section.data().map_err(|error| self.fault(&error))?;
                    let bytes = code.get((start - section.address()) as usize..);
                    functions.push(Function {
                        name: name.to_owned(),
                        range: start..end,
                        instructions: instructions(start..end, bytes.unwrap_or(&[]), &is_code),
                    });
                }
            }
        }
        Ok(functions)
    }

    /// The ranges of functions whose symbols fit; none is an error.
    pub(crate) fn ranges(
        &self,
        name: &str,
        fits: impl Fn(&str) -> bool,
    ) -> Result<Vec<Range<u64>>, String> {
        let found = self.functions(fits)?;
        if found.is_empty() {
            let fault = format!("no function {name}: was it renamed or inlined?");
            return Err(self.fault(&fault));
        }
        Ok(found.into_iter().map(|function| function.range).collect())
    }

    /// Bytes of flash and of static memory.
    pub(crate) fn sizes(&self) -> Result<Sizes, String> {
        let mut sizes = Sizes {
            flash: 0,
            memory: 0,
        };
        for section in self.parsed()?.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else {
                continue;
            };
            if sh_flags & u64::from(elf::SHF_ALLOC) == 0 {
                continue;
            }
            let is_flash = section.address() < FLASH_END;
            // Initial values of memory are kept in flash.
            if is_flash || section.name() == Ok(".data") {
                sizes.flash += section.size();
            }
            if !is_flash {
                sizes.memory += section.size();
            }
        }
        Ok(sizes)
    }
}

/// The instructions of a range, which begins with these bytes.
fn instructions(
    range: Range<u64>,
    bytes: &[u8],
    is_code: &BTreeMap<u64, bool>,
) -> Vec<Instruction> {
    let mut found = Vec::new();
    let mut at = range.start;
    while at < range.end {
        let mark = is_code.range(..=at).next_back();
        if mark.is_some_and(|(_, &is_code)| !is_code) {
            at += 2;
            continue;
        }
        let half = |offset: u64| {
            let first = (at - range.start + offset) as usize;
            let bytes = bytes.get(first..first + 2)?;
            Some(u16::from_le_bytes(bytes.try_into().ok()?))
        };
        let halves = [0, 2].map(|offset| half(offset).unwrap_or(0));
        // The chip has addresses of 32 bits.
        let instruction = Instruction::decode(at as u32, halves);
        at += u64::from(instruction.length);
        found.push(instruction);
    }
    found
}
