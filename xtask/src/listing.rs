//! What the machine code of a binary says: who calls whom, how much stack each function takes, and
//! which instructions an interrupt must not have.
//!
//! Only the few Thumb-2 instructions that matter here are understood (ARMv7-M Architecture Reference
//! Manual, A7.7); everything else is skipped by its length.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

/// The functions of a binary by their addresses.
pub(crate) struct Listing {
    functions: BTreeMap<u64, Function>,
}

/// What a function does that matters here.
#[derive(Debug, Default)]
struct Function {
    name: String,
    /// Bytes pushed and reserved.
    frame: u64,
    /// Addresses called, tail calls included.
    calls: BTreeSet<u64>,
    /// Calls through a register.
    indirect: u32,
    divisions: u32,
    /// Branches backwards inside the function.
    loops: u32,
}

/// What can happen under a function.
#[derive(Debug, Default)]
pub(crate) struct Reach {
    /// Bytes of stack at most.
    pub(crate) stack: u64,
    /// Functions that may run.
    functions: BTreeSet<String>,
    /// Functions with a division or a square root, and library functions that stand for one.
    pub(crate) divisions: Vec<String>,
    /// Branches backwards.
    pub(crate) loops: u32,
}

impl Listing {
    /// Reads a binary.
    pub(crate) fn of(path: &Path) -> Result<Self, String> {
        let fault = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let data = std::fs::read(path).map_err(|error| fault(&error))?;
        let file = object::File::parse(&*data).map_err(|error| fault(&error))?;
        let mut functions = BTreeMap::new();
        for section in file.sections().filter(|s| s.kind() == SectionKind::Text) {
            let code = section.data().map_err(|error| fault(&error))?;
            let starts: BTreeMap<u64, String> = file
                .symbols()
                .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0)
                .filter(|symbol| symbol.section_index() == Some(section.index()))
                .map(|symbol| {
                    let name = symbol.name().unwrap_or("?").to_owned();
                    // The lowest bit says Thumb.
                    (symbol.address() & !1, name)
                })
                .collect();
            // Mapping symbols: $t begins code, $d data between it.
            let data_at: BTreeMap<u64, bool> = file
                .symbols()
                .filter(|symbol| symbol.section_index() == Some(section.index()))
                .filter_map(|symbol| match symbol.name() {
                    Ok(name) if name.starts_with("$d") => Some((symbol.address(), true)),
                    Ok(name) if name.starts_with("$t") => Some((symbol.address() & !1, false)),
                    _ => None,
                })
                .collect();
            let is_data = |address: u64| {
                data_at
                    .range(..=address)
                    .next_back()
                    .is_some_and(|(_, &data)| data)
            };
            let end = section.address() + section.size();
            let mut ends = starts.keys().skip(1).copied().chain([end]);
            for (&start, name) in &starts {
                let stop = ends.next().unwrap_or(end);
                let mut function = Function {
                    name: name.clone(),
                    ..Function::default()
                };
                let half = |address: u64| {
                    let at = (address - section.address()) as usize;
                    let bytes = code.get(at..at + 2)?;
                    Some(u32::from(u16::from_le_bytes([bytes[0], bytes[1]])))
                };
                let mut at = start;
                while at < stop {
                    if is_data(at) {
                        at += 2;
                        continue;
                    }
                    let Some(first) = half(at) else { break };
                    if first >> 11 >= 0b11101 {
                        let second = half(at + 2).unwrap_or(0);
                        function.take_wide(at, first, second, start..stop);
                        at += 4;
                    } else {
                        function.take_narrow(at, first, start..stop);
                        at += 2;
                    }
                }
                if name.starts_with(TO_MEMORY)
                    && let Some(target) = far_target([0, 2, 4, 6].map(|k| half(start + k)))
                {
                    function.indirect = 0;
                    function.calls.insert(target);
                }
                functions.insert(start, function);
            }
        }
        Ok(Self { functions })
    }

    /// What can happen under a function of this name.
    pub(crate) fn under(&self, name: &str) -> Result<Reach, String> {
        self.reach(|own| own == name, |_| false)
            .ok_or_else(|| format!("there is no function {name}"))?
    }

    /// The same, but for what can happen under functions whose mangled names have one of these parts.
    pub(crate) fn under_without(&self, name: &str, parts: &[&str]) -> Result<Reach, String> {
        let left_out = |own: &str| parts.iter().any(|part| own.contains(part));
        self.reach(|own| own == name, left_out)
            .ok_or_else(|| format!("there is no function {name}"))?
    }

    /// What can happen under a method of this name.
    pub(crate) fn under_method(&self, method: &str) -> Result<Reach, String> {
        self.reach(|own| is_method(own, method), |_| false)
            .ok_or_else(|| format!("there is no method {method}: was it renamed or inlined?"))?
    }

    fn reach(
        &self,
        fits: impl Fn(&str) -> bool,
        left_out: impl Fn(&str) -> bool,
    ) -> Option<Result<Reach, String>> {
        let mut found = self.functions.iter();
        let (&start, _) = found.find(|(_, function)| fits(&function.name))?;
        let mut reach = Reach::default();
        let stack = self.descend(start, &left_out, &mut Vec::new(), &mut reach);
        Some(stack.map(|stack| Reach { stack, ..reach }))
    }

    /// The stack from a function downwards; everything else goes into `reach`.
    fn descend(
        &self,
        at: u64,
        left_out: &impl Fn(&str) -> bool,
        above: &mut Vec<u64>,
        reach: &mut Reach,
    ) -> Result<u64, String> {
        // Library functions share tails: a call may lead into the middle of one.
        let Some((&at, function)) = self.functions.range(..=at).next_back() else {
            return Err(format!("a call leads to {at:#x}, where no function is"));
        };
        if left_out(&function.name) {
            return Ok(0);
        }
        if above.contains(&at) {
            return Err(format!("{} calls itself: no bound", function.name));
        }
        if function.indirect > 0 {
            return Err(format!("{} calls through a register", function.name));
        }
        if reach.functions.insert(function.name.clone()) {
            reach.loops += function.loops;
            if function.divisions > 0 || divides(&function.name) {
                reach.divisions.push(function.name.clone());
            }
        }
        above.push(at);
        let mut deepest = 0;
        for &called in &function.calls {
            let stack = self.descend(called, left_out, above, reach)?;
            deepest = deepest.max(stack);
        }
        above.pop();
        Ok(function.frame + deepest)
    }
}

/// Whether a mangled name is that of a method: its parts have their lengths before them.
fn is_method(mangled: &str, method: &str) -> bool {
    mangled.contains(&format!("{}{method}", method.len()))
}

/// How the linker names what leads from code in flash to code in memory: MOVW, MOVT and BX of r12.
const TO_MEMORY: &str = "__Thumbv7ABSLongThunk_";

/// Where a MOVW and a MOVT of r12, as their halves, lead.
fn far_target(halves: [Option<u32>; 4]) -> Option<u64> {
    let [Some(low), Some(low_rest), Some(high), Some(high_rest)] = halves else {
        return None;
    };
    let immediate = |first: u32, second: u32| {
        (first & 0xf) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff
    };
    let move_to_12 = |first: u32, second: u32, code: u32| {
        (first & 0xfbf0 == code && second & 0x8f00 == 0x0c00).then(|| immediate(first, second))
    };
    let address = move_to_12(high, high_rest, 0xf2c0)? << 16 | move_to_12(low, low_rest, 0xf240)?;
    Some(u64::from(address & !1))
}

/// Library functions that divide, and everything of a libm.
fn divides(name: &str) -> bool {
    const PARTS: [&str; 7] = [
        "libm",
        "divmod",
        "divsi",
        "divdi",
        "divdf",
        "divsf",
        "aeabi_ddiv",
    ];
    PARTS.iter().any(|part| name.contains(part))
}

impl Function {
    fn take_narrow(&mut self, at: u64, code: u32, own: std::ops::Range<u64>) {
        if code & 0xfe00 == 0xb400 {
            self.frame += 4 * u64::from((code & 0x1ff).count_ones());
        } else if code & 0xff80 == 0xb080 {
            self.frame += 4 * u64::from(code & 0x7f);
        } else if code & 0xf000 == 0xd000 && code & 0x0e00 != 0x0e00 {
            self.branch(at, signed(code & 0xff, 8) * 2, &own);
        } else if code & 0xf800 == 0xe000 {
            self.branch(at, signed(code & 0x7ff, 11) * 2, &own);
        } else if code & 0xff87 == 0x4780 {
            self.indirect += 1;
        } else if code & 0xff87 == 0x4700 && code & 0x78 != 14 << 3 {
            // Through a register that is not the link register: a tail call.
            self.indirect += 1;
        }
    }

    fn take_wide(&mut self, at: u64, first: u32, second: u32, own: std::ops::Range<u64>) {
        if first & 0xf800 == 0xf000 && second & 0x8000 != 0 {
            let sign = first >> 10 & 1;
            let (j1, j2) = (second >> 13 & 1, second >> 11 & 1);
            if second & 0x5000 == 0x0000 {
                // B<c>.W
                let bits = sign << 19 | j2 << 18 | j1 << 17 | (first & 0x3f) << 11 | second & 0x7ff;
                if first >> 6 & 0xe != 0xe {
                    self.branch(at, signed(bits, 20) * 2, &own);
                }
                return;
            }
            let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
            let bits = sign << 23 | i1 << 22 | i2 << 21 | (first & 0x3ff) << 11 | second & 0x7ff;
            let target = goal(at, signed(bits, 24) * 2);
            if second & 0x5000 == 0x5000 {
                self.calls.insert(target);
            } else if second & 0x5000 == 0x1000 {
                self.branch(at, signed(bits, 24) * 2, &own);
            }
        } else if first == 0xe92d {
            self.frame += 4 * u64::from(second.count_ones());
        } else if first == 0xf84d && second & 0x0fff == 0x0d04 {
            self.frame += 4;
        } else if matches!(first, 0xf1ad | 0xf5ad) && second & 0x0f00 == 0x0d00 {
            self.frame += expanded(first >> 10 & 1, second);
        } else if matches!(first, 0xf2ad | 0xf6ad) && second & 0x0f00 == 0x0d00 {
            let immediate = (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff;
            self.frame += u64::from(immediate);
        } else if first & 0xffbf == 0xed2d && second & 0x0e00 == 0x0a00 {
            self.frame += 4 * u64::from(second & 0xff);
        } else if is_division(first, second) {
            self.divisions += 1;
        }
    }

    /// A branch: inside the function it may be a loop, beyond it is a tail call.
    fn branch(&mut self, at: u64, offset: i64, own: &std::ops::Range<u64>) {
        let target = goal(at, offset);
        if !own.contains(&target) {
            self.calls.insert(target);
        } else if target <= at {
            self.loops += 1;
        }
    }
}

/// SDIV and UDIV, VDIV.F32 and F64, VSQRT.F32 and F64.
fn is_division(first: u32, second: u32) -> bool {
    let whole = matches!(first & 0xfff0, 0xfbb0 | 0xfb90) && second & 0xf0f0 == 0xf0f0;
    let quotient = first & 0xffb0 == 0xee80 && second & 0x0e50 == 0x0a00;
    let root = first & 0xffbf == 0xeeb1 && second & 0x0ed0 == 0x0ac0;
    whole || quotient || root
}

fn goal(at: u64, offset: i64) -> u64 {
    at.wrapping_add(4).wrapping_add_signed(offset)
}

fn signed(bits: u32, width: u32) -> i64 {
    let unused = 64 - width;
    i64::from(bits) << unused >> unused
}

/// ThumbExpandImm.
fn expanded(i: u32, second: u32) -> u64 {
    let code = i << 11 | (second >> 12 & 7) << 8 | second & 0xff;
    let byte = code & 0xff;
    u64::from(match code >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => (byte | 0x80).rotate_right(code >> 7),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: std::ops::Range<u64> = 0x100..0x200;

    fn wide(first: u32, second: u32) -> Function {
        let mut function = Function::default();
        function.take_wide(0x120, first, second, OWN);
        function
    }

    fn narrow(code: u32) -> Function {
        let mut function = Function::default();
        function.take_narrow(0x120, code, OWN);
        function
    }

    #[test]
    fn what_takes_stack_is_counted() {
        // push {r4, r5, r6, r7, lr}
        assert_eq!(narrow(0xb5f0).frame, 20);
        // sub sp, #12
        assert_eq!(narrow(0xb083).frame, 12);
        // stmdb sp!, {r8, r9, sl, fp}; the same of r4 to fp and lr
        assert_eq!(wide(0xe92d, 0x0f00).frame, 16);
        assert_eq!(wide(0xe92d, 0x4ff0).frame, 36);
        // str.w fp, [sp, #-4]!
        assert_eq!(wide(0xf84d, 0xbd04).frame, 4);
        // sub.w sp, sp, #1280; subw sp, sp, #1132
        assert_eq!(wide(0xf5ad, 0x6da0).frame, 1280);
        assert_eq!(wide(0xf2ad, 0x4d6c).frame, 1132);
        // vpush {d8-d15}
        assert_eq!(wide(0xed2d, 0x8b10).frame, 64);
    }

    #[test]
    fn the_way_to_memory_is_followed() {
        // movw r12, #0x1001; movt r12, #0x2000
        let halves = [0xf241, 0x0c01, 0xf2c2, 0x0c00].map(Some);
        assert_eq!(far_target(halves), Some(0x2000_1000));
        // To r11.
        let halves = [0xf241, 0x0b01, 0xf2c2, 0x0b00].map(Some);
        assert_eq!(far_target(halves), None);
    }

    #[test]
    fn the_deepest_path_and_every_division_under_a_function_are_found() {
        let function = |name: &str, calls: &[u64]| Function {
            name: name.to_owned(),
            frame: 4,
            calls: calls.iter().copied().collect(),
            divisions: calls.is_empty().into(),
            ..Function::default()
        };
        let mut listing = Listing {
            functions: BTreeMap::from([
                (0x10, function("sample", &[0x20, 0x30])),
                (0x20, function("law", &[0x30])),
                (0x30, function("root", &[])),
            ]),
        };
        let whole = listing.under("sample").expect("there");
        assert_eq!(
            (whole.stack, whole.divisions),
            (12, vec!["root".to_owned()])
        );
        assert!(listing.under("nothing").is_err());
        listing.functions.insert(0x30, function("root", &[0x10]));
        assert!(listing.under("sample").is_err(), "it calls itself");
    }

    #[test]
    fn calls_loops_and_divisions_are_seen() {
        // bl to itself less 0x100: f7ff ff7e at 0x120 leads to 0x120 + 4 - 0x104
        assert_eq!(wide(0xf7ff, 0xff7e).calls.first(), Some(&0x20));
        // b.n backwards by 8 and forwards
        assert_eq!(narrow(0xe7fa).loops, 1);
        assert_eq!(narrow(0xe004).loops, 0);
        // bx lr, bx r3, blx r3
        assert_eq!(narrow(0x4770).indirect, 0);
        assert_eq!(narrow(0x4718).indirect, 1);
        assert_eq!(narrow(0x4798).indirect, 1);
        // udiv r0, r1, r2; sdiv r0, r1, r2; vdiv.f32 s0, s1, s2; vsqrt.f32 s0, s1; vmul.f32
        assert_eq!(wide(0xfbb1, 0xf0f2).divisions, 1);
        assert_eq!(wide(0xfb91, 0xf0f2).divisions, 1);
        assert_eq!(wide(0xee80, 0x0a81).divisions, 1);
        assert_eq!(wide(0xeeb1, 0x0ae0).divisions, 1);
        assert_eq!(wide(0xee20, 0x0a81).divisions, 0);
    }
}
