//! A linked binary.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::Range;
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind, elf};

use crate::thumb::Instruction;

/// Where the chip's flash ends and everything above is memory.
const FLASH_END: u64 = 0x1000_0000;

/// A linked binary.
#[derive(Default)]
pub(crate) struct Elf {
    pub(crate) functions: Vec<Function>,
    /// Statics, by their symbols.
    statics: BTreeMap<String, Range<u32>>,
    /// Bytes of flash and of static memory.
    pub(crate) flash: u64,
    pub(crate) memory: u64,
    /// Contents of the sections, by the addresses of their first bytes.
    contents: BTreeMap<u32, Vec<u8>>,
    /// Addresses at which code begins, and at which constants begin: false.
    is_code: BTreeMap<u32, bool>,
}

/// A function of a binary.
pub(crate) struct Function {
    pub(crate) name: String,
    /// Its bytes, the constants after it included.
    pub(crate) range: Range<u32>,
}

impl Elf {
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let fault = |error: &dyn Display| format!("{}: {error}", path.display());
        let bytes = std::fs::read(path).map_err(|error| fault(&error))?;
        let file = object::File::parse(&*bytes).map_err(|error| fault(&error))?;
        let mut read = Self::default();
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else {
                continue;
            };
            if sh_flags & u64::from(elf::SHF_ALLOC) == 0 {
                continue;
            }
            let is_flash = section.address() < FLASH_END;
            // Initial values of memory are kept in flash.
            if is_flash || section.name() == Ok(".data") {
                read.flash += section.size();
            }
            if !is_flash {
                read.memory += section.size();
            }
            let data = section.data().map_err(|error| fault(&error))?;
            // The chip has addresses of 32 bits.
            let first = section.address() as u32;
            if !data.is_empty() {
                read.contents.insert(first, data.to_owned());
            }
            for symbol in file.symbols() {
                if symbol.section_index() == Some(section.index()) {
                    read.take(&symbol);
                }
            }
        }
        Ok(read)
    }

    fn take<'a>(&mut self, symbol: &impl ObjectSymbol<'a>) {
        let name = symbol.name().unwrap_or("?");
        // The lowest bit of an address says Thumb.
        let start = symbol.address() as u32 & !1;
        // Mapping symbols: $t begins code, $d data in between.
        if name.starts_with("$t") || name.starts_with("$d") {
            self.is_code.insert(start, name.starts_with("$t"));
        } else if symbol.kind() == SymbolKind::Text && symbol.size() > 0 {
            // The bytes between two functions are filled with what would decode as a jump.
            self.functions.push(Function {
                name: name.to_owned(),
                range: start..start + symbol.size() as u32,
            });
        } else if symbol.kind() == SymbolKind::Data {
            let end = start + symbol.size() as u32;
            self.statics.insert(name.to_owned(), start..end);
        }
    }

    /// The bytes of the only static of a path.
    ///
    /// # Errors
    /// There is none, or more than one.
    pub(crate) fn static_at(&self, path: &str) -> Result<Range<u32>, String> {
        let part = mangled(path);
        let mut fitting = self.statics.iter().filter(|(name, _)| name.contains(&part));
        match (fitting.next(), fitting.next()) {
            (Some((_, range)), None) => Ok(range.clone()),
            _ => Err(format!(
                "no static {path}, or more than one: was it renamed?"
            )),
        }
    }

    /// The ranges of the functions whose symbols fit; none is an error, which calls them by `name`.
    pub(crate) fn ranges(
        &self,
        name: &str,
        fits: impl Fn(&str) -> bool,
    ) -> Result<Vec<Range<u32>>, String> {
        let fitting = self.functions.iter().filter(|own| fits(&own.name));
        let ranges: Vec<_> = fitting.map(|own| own.range.clone()).collect();
        if ranges.is_empty() {
            return Err(format!("no function {name}: was it renamed or inlined?"));
        }
        Ok(ranges)
    }

    /// The instructions of a range, without the constants in it.
    pub(crate) fn instructions(&self, range: &Range<u32>) -> Vec<Instruction> {
        let mut found = Vec::new();
        let mut at = range.start;
        while at < range.end {
            let mark = self.is_code.range(..=at).next_back();
            if mark.is_some_and(|(_, &is_code)| !is_code) {
                at += 2;
                continue;
            }
            let instruction = self.instruction(at);
            at += instruction.length;
            found.push(instruction);
        }
        found
    }

    /// The instruction at an address.
    pub(crate) fn instruction(&self, address: u32) -> Instruction {
        let half = |at| self.bytes(at).map_or(0, u16::from_le_bytes);
        Instruction::decode(address, [0, 2].map(|more| half(address + more)))
    }

    /// The word at an address.
    pub(crate) fn word(&self, address: u32) -> Option<u32> {
        self.bytes(address).map(u32::from_le_bytes)
    }

    /// The targets of a branch by a table from an address up to the next code; none without one.
    pub(crate) fn table(&self, branch: &Instruction, first: u32) -> Vec<u32> {
        let mut marks = self.is_code.range(first + 1..);
        let end = marks.find(|&(_, &is_code)| is_code);
        let mark = self.is_code.range(..=first).next_back();
        let is_data = mark.is_some_and(|(_, &is_code)| !is_code);
        // One of words lies anywhere.
        let Some((&end, _)) = end.filter(|_| is_data && branch.entry > 0) else {
            return Vec::new();
        };
        let entries = (first..end).step_by(branch.entry as usize);
        let entry = |at| match branch.entry {
            1 => self.bytes(at).map(u8::from_le_bytes).map(u32::from),
            _ => self.bytes(at).map(u16::from_le_bytes).map(u32::from),
        };
        entries
            .filter_map(entry)
            .map(|half| branch.end() + 2 * half)
            .collect()
    }

    fn bytes<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        let (first, bytes) = self.contents.range(..=address).next_back()?;
        bytes
            .get((address - first) as usize..)?
            .first_chunk()
            .copied()
    }
}

/// The end of a path in a mangled symbol: every name after its length.
pub(crate) fn mangled(path: &str) -> String {
    path.split("::")
        .map(|name| format!("{}{name}", name.len()))
        .collect()
}

#[cfg(test)]
impl Elf {
    /// A program from pieces by name, address and half-words, each code or else constants.
    pub(crate) fn of_code(pieces: &[(&str, u32, &[u16], bool)]) -> Self {
        let mut elf = Self::default();
        for &(name, start, halves, is_code) in pieces {
            let bytes: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
            if is_code {
                elf.functions.push(Function {
                    name: name.to_owned(),
                    range: start..start + bytes.len() as u32,
                });
            }
            elf.mark(start, is_code);
            elf.contents.insert(start, bytes);
        }
        elf
    }

    /// Marks the beginning of code, or of constants.
    pub(crate) fn mark(&mut self, address: u32, is_code: bool) {
        self.is_code.insert(address, is_code);
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_path_is_mangled() {
        assert_eq!(super::mangled("sampler::report"), "7sampler6report");
    }

    #[test]
    fn a_jump_to_a_register_has_no_table_behind_it() {
        const MOV_PC_R3: u16 = 0x469f;
        let elf = super::Elf::of_code(&[
            ("f", 0x100, &[MOV_PC_R3], true),
            ("", 0x102, &[4, 8], false),
            ("g", 0x106, &[0xbf00], true),
        ]);
        let jump = elf.instruction(0x100);
        assert_eq!(elf.table(&jump, jump.end()), [] as [u32; 0]);
    }
}
