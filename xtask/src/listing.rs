//! Bounds from the machine code of a binary: calls, stack, and the instructions that a sample must not
//! have.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use crate::elf::{Elf, mangled};
use crate::register_calls::{Code, Targets};
use crate::thumb::{Flow, Instruction};

/// The functions of a binary by their addresses.
struct Listing {
    functions: BTreeMap<u32, Function>,
}

/// The calls and costs of a function.
#[derive(Debug, Default)]
struct Function {
    name: String,
    /// Bytes pushed and reserved.
    frame: u32,
    /// Addresses called, tail calls included.
    calls: BTreeSet<u32>,
    /// Calls through a register that may lead anywhere.
    indirect: u32,
    divisions: u32,
    /// Branches backwards inside the function.
    loops: u32,
}

/// The bounds of a function and of all that it may call.
#[derive(Debug, Default)]
struct Reach {
    /// Bytes of stack at most.
    stack: u32,
    /// Functions that may run.
    functions: BTreeSet<String>,
    /// Functions with a division or a square root, and library functions that perform one.
    divisions: Vec<String>,
    /// Branches backwards.
    loops: u32,
}

impl Listing {
    /// For a binary.
    fn new(elf: &Elf) -> Self {
        let code = Code::new(elf);
        let targets = code.targets();
        let listed = elf.functions.iter().map(|found| {
            let mut function = Function {
                name: found.name.clone(),
                ..Function::default()
            };
            for instruction in code.instructions(found.range.start) {
                function.take(instruction, &found.range, &targets);
            }
            (found.range.start, function)
        });
        Self {
            functions: listed.collect(),
        }
    }

    /// The bounds of the function whose symbol fits, without functions whose symbols contain `left_out` and their
    /// callees. If there is none, the error calls it by `name`.
    fn under(
        &self,
        name: &str,
        fits: impl Fn(&str) -> bool,
        left_out: Option<&str>,
    ) -> Result<Reach, String> {
        let mut found = self.functions.iter();
        let (&start, _) = found
            .find(|(_, function)| fits(&function.name))
            .ok_or_else(|| format!("there is no function {name}: was it renamed or inlined?"))?;
        let left_out = |own: &str| left_out.is_some_and(|part| own.contains(part));
        let mut reach = Reach::default();
        reach.stack = self.descend(start, &left_out, &mut Vec::new(), &mut reach)?;
        Ok(reach)
    }

    /// The stack of a function and its callees; their other bounds are added to `reach`.
    fn descend(
        &self,
        at: u32,
        left_out: &impl Fn(&str) -> bool,
        above: &mut Vec<u32>,
        reach: &mut Reach,
    ) -> Result<u32, String> {
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

/// Bytes that the processor itself stacks for an interrupt. They include the registers of the FPU and alignment
/// (ARMv7-M Architecture Reference Manual, B1.5.7).
const EXCEPTION: u32 = 26 * 4 + 4;

/// The part of a sample outside a run: it commissions, or is at rest.
const WITHOUT_A_RUN: &str = "without_a_run";

/// Bounds of the linked drive by their names: stack in bytes at most, the processor's own included, and branches
/// backwards. A division in a sample of a run is an error, even in the one that begins a run or a commissioning.
pub(crate) fn bounds(drive: &Elf) -> Result<[(&'static str, u32); 5], String> {
    let listing = Listing::new(drive);
    let part = mangled(WITHOUT_A_RUN);
    let function = |name: &str, left_out| listing.under(name, |own| own == name, left_out);
    let sample = function("TIM5", Some(&*part))?;
    let commission = listing.under(WITHOUT_A_RUN, |own| own.contains(&part), None)?;
    if !sample.divisions.is_empty() {
        return Err(format!(
            "a sample of the drive may divide, in {}",
            sample.divisions.join(", ")
        ));
    }
    let mut stack = 2 * EXCEPTION;
    for name in ["main", "USART2", "TIM5"] {
        stack += function(name, None)?.stack;
    }
    Ok([
        // Every interrupt on top of the background.
        ("stack-bytes", stack),
        ("sample-stack-bytes", sample.stack + EXCEPTION),
        ("sample-loops", sample.loops),
        ("commission-stack-bytes", commission.stack),
        ("commission-loops", commission.loops),
    ])
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
    fn take(&mut self, instruction: &Instruction, own: &Range<u32>, targets: &Targets) {
        self.frame += instruction.stack;
        self.divisions += u32::from(instruction.divides);
        match (instruction.flow, instruction.immediate) {
            (Flow::On | Flow::Return | Flow::Table, _) => {}
            (Flow::Call | Flow::Jump, None) => match targets.get(&instruction.address) {
                Some(Some(targets)) => self.calls.extend(targets),
                _ => self.indirect += 1,
            },
            // Beyond the function a branch is a tail call.
            (Flow::Jump, Some(target)) if own.contains(&target) => {
                self.loops += u32::from(target <= instruction.address);
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
        with_targets(halves, &Targets::new())
    }

    fn with_targets(halves: [u16; 2], targets: &Targets) -> Function {
        let mut function = Function::default();
        let instruction = Instruction::decode(0x120, halves);
        function.take(&instruction, &(0x100..0x200), targets);
        function
    }

    #[test]
    fn a_call_through_a_register_is_one_of_each_function_that_it_may_call_or_refused() {
        // blx r3
        let call = [0x4798, 0];
        let found = with_targets(call, &Targets::from([(0x120, Some([0x10, 0x20].into()))]));
        assert_eq!((found.indirect, found.calls), (0, [0x10, 0x20].into()));
        for unresolved in [Targets::from([(0x120, None)]), Targets::new()] {
            let found = with_targets(call, &unresolved);
            assert_eq!((found.indirect, found.calls.len()), (1, 0));
            let listing = Listing {
                functions: BTreeMap::from([(0x10, found)]),
            };
            assert!(listing.under("own", |_| true, None).is_err());
        }
    }

    #[test]
    fn the_deepest_path_and_every_division_under_a_function_are_found() {
        let function = |name: &str, calls: &[u32]| Function {
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
        let under = |listing: &Listing, name: &str| listing.under(name, |own| own == name, None);
        let whole = under(&listing, "sample").expect("there");
        assert_eq!(
            (whole.stack, whole.divisions),
            (12, vec!["sample → law → root".to_owned()])
        );
        assert!(under(&listing, "nothing").is_err());
        listing.functions.insert(0x30, function("root", &[0x10]));
        assert!(under(&listing, "sample").is_err(), "it calls itself");
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
