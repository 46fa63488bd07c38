//! Bounds from the machine code of a binary: calls, stack, and the instructions that a sample must not
//! have.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;

use thumb::{Flow, Instruction};

use crate::elf::Elf;

/// The functions of a binary by their addresses.
pub(crate) struct Listing {
    functions: BTreeMap<u64, Function>,
}

/// The calls and costs of a function.
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

/// The bounds of a function and of all that it may call.
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
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let functions = Elf::read(path)?.functions(|_| true)?;
        let functions = functions
            .into_iter()
            .map(|found| {
                let mut function = Function {
                    name: found.name,
                    ..Function::default()
                };
                for instruction in &found.instructions {
                    function.take(instruction, &found.range);
                }
                if function.name.starts_with(TO_MEMORY)
                    && let Some(target) = far_target(&found.instructions)
                {
                    function.indirect = 0;
                    function.calls.insert(target);
                }
                (found.range.start, function)
            })
            .collect();
        Ok(Self { functions })
    }

    /// The bounds of a function of this name.
    pub(crate) fn under(&self, name: &str) -> Result<Reach, String> {
        self.reach(|own| own == name, |_| false)
            .ok_or_else(|| format!("there is no function {name}"))?
    }

    /// The same without functions whose mangled names have one of these parts, and without their callees.
    pub(crate) fn under_without(&self, name: &str, parts: &[&str]) -> Result<Reach, String> {
        let left_out = |own: &str| parts.iter().any(|part| own.contains(part));
        self.reach(|own| own == name, left_out)
            .ok_or_else(|| format!("there is no function {name}"))?
    }

    /// The bounds of a method of this name.
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

    /// The stack of a function and its callees; their other bounds are added to `reach`.
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
                let callers = above.iter().map(|at| self.functions[at].name.as_str());
                let path: Vec<_> = callers.chain([function.name.as_str()]).collect();
                reach.divisions.push(path.join(" → "));
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

/// True for the mangled name of a method: its parts have their lengths before them.
fn is_method(mangled: &str, method: &str) -> bool {
    mangled.contains(&format!("{}{method}", method.len()))
}

/// The linker's name of a jump from code in flash to code in memory: MOVW, MOVT and BX of r12.
const TO_MEMORY: &str = "__Thumbv7ABSLongThunk_";

/// The target of a MOVW and a MOVT with which a function begins.
fn far_target(instructions: &[Instruction]) -> Option<u64> {
    let [low, high, ..] = instructions else {
        return None;
    };
    let address = high.immediate? << 16 | low.immediate?;
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
    fn take(&mut self, instruction: &Instruction, own: &Range<u64>) {
        self.frame += u64::from(instruction.stack);
        self.divisions += u32::from(instruction.divides);
        let target = instruction.immediate.map(u64::from);
        match (instruction.flow, target) {
            (Flow::On | Flow::Return | Flow::Table, _) => {}
            (Flow::Call | Flow::Jump, None) => self.indirect += 1,
            // Beyond the function a branch is a tail call.
            (Flow::Jump, Some(target)) if own.contains(&target) => {
                self.loops += u32::from(target <= u64::from(instruction.address));
            }
            (Flow::Call | Flow::Jump, Some(target)) => {
                self.calls.insert(target);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function at 0x100 of one instruction at 0x120.
    fn function(halves: [u16; 2]) -> Function {
        let mut function = Function::default();
        function.take(&instruction(halves), &(0x100..0x200));
        function
    }

    fn instruction(halves: [u16; 2]) -> Instruction {
        Instruction::decode(0x120, halves)
    }

    #[test]
    fn the_way_to_memory_is_followed() {
        // movw r12, #0x1001; movt r12, #0x2000
        let jump = [[0xf241, 0x0c01], [0xf2c2, 0x0c00]].map(instruction);
        assert_eq!(far_target(&jump), Some(0x2000_1000));
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
            (12, vec!["sample → law → root".to_owned()])
        );
        assert!(listing.under("nothing").is_err());
        listing.functions.insert(0x30, function("root", &[0x10]));
        assert!(listing.under("sample").is_err(), "it calls itself");
    }

    #[test]
    fn calls_loops_and_divisions_are_found() {
        // bl to itself less 0x100
        assert_eq!(function([0xf7ff, 0xff7e]).calls.first(), Some(&0x20));
        // b.n backwards by 8 and forwards, and b.w out of the function
        assert_eq!(function([0xe7fa, 0]).loops, 1);
        assert_eq!(function([0xe004, 0]).loops, 0);
        assert_eq!(function([0xf000, 0xbf26]).calls.len(), 1);
        // bx lr, bx r3, blx r3
        assert_eq!(function([0x4770, 0]).indirect, 0);
        assert_eq!(function([0x4718, 0]).indirect, 1);
        assert_eq!(function([0x4798, 0]).indirect, 1);
        // udiv r0, r1, r2; vmul.f32
        assert_eq!(function([0xfbb1, 0xf0f2]).divisions, 1);
        assert_eq!(function([0xee20, 0x0a81]).divisions, 0);
    }
}
