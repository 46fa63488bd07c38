//! Calls through registers, where the code itself says which function is called.
//!
//! At "z" the compiler loads the address of a function once and calls it by the register. The values of registers on
//! every path to such a call are computed here. A call without a certain value stays unresolved.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use crate::elf::Elf;
use crate::thumb::{Flow, Instruction, Source};

/// r0 to r14: the value that each has on every way, if it has one.
type Registers = [Option<u32>; 15];

/// Registers that a callee need not preserve: r0 to r3, r12 and the link register (AAPCS32, 6.1.1).
const SCRATCH: u32 = 0b0101_0000_0000_1111;

/// The compiler's name of a piece of code that several functions share. It may read and write every register.
const OUTLINED: &str = "OUTLINED_FUNCTION_";

/// Functions in which calls are resolved.
pub(crate) struct Code<'a> {
    elf: &'a Elf,
    functions: BTreeMap<u32, Function>,
}

struct Function {
    range: Range<u32>,
    is_outlined: bool,
    instructions: Vec<Instruction>,
}

/// Functions called through registers, by the addresses of the calls; none where one of the ways leaves it open.
pub(crate) type Targets = BTreeMap<u32, Option<BTreeSet<u32>>>;

impl<'a> Code<'a> {
    pub(crate) fn new(elf: &'a Elf) -> Self {
        let functions = elf.functions.iter().map(|function| {
            let range = function.range.clone();
            let own = Function {
                is_outlined: function.name.starts_with(OUTLINED),
                instructions: elf.instructions(&range),
                range,
            };
            (own.range.start, own)
        });
        Self {
            elf,
            functions: functions.collect(),
        }
    }

    /// The instructions of the function that begins at an address.
    pub(crate) fn instructions(&self, start: u32) -> &[Instruction] {
        self.functions
            .get(&start)
            .map_or(&[], |function| &function.instructions)
    }

    /// The functions that are called through registers.
    pub(crate) fn targets(&self) -> Targets {
        let mut targets = Targets::new();
        // Outlined code is gone through where it is called from.
        let whole = self.functions.values().filter(|own| !own.is_outlined);
        for function in whole {
            self.follow(function, &mut targets);
        }
        targets
    }

    /// Follows every way through a function until no value changes.
    fn follow(&self, function: &Function, targets: &mut Targets) {
        let instructions = &function.instructions;
        let place = |address| instructions.binary_search_by_key(&address, |own| own.address);
        let mut conditional = vec![false; instructions.len()];
        for (i, instruction) in instructions.iter().enumerate() {
            let governed = conditional.iter_mut().skip(i + 1);
            governed
                .take(instruction.conditions as usize)
                .for_each(|own| *own = true);
        }
        let mut known: Vec<Option<Registers>> = vec![None; instructions.len()];
        let mut pending = Vec::new();
        join(&mut known, &mut pending, 0, &[None; 15]);
        while let Some(i) = pending.pop() {
            let (Some(instruction), Some(Some(before))) = (instructions.get(i), known.get(i))
            else {
                continue;
            };
            let before = *before;
            let mut after = self.after(instruction, before);
            if conditional[i] {
                after = common(&before, &after);
            }
            if !ends(instruction) || conditional[i] || instruction.is_conditional {
                join(&mut known, &mut pending, i + 1, &after);
            }
            let jumps = match (instruction.flow, instruction.immediate) {
                (Flow::Jump, Some(target)) => vec![target],
                (Flow::Table, _) => {
                    let behind = Some(instruction.end());
                    let at = instruction.table;
                    let first = at.map_or(behind, |register| before[register]);
                    let table = first.map(|first| self.elf.table(instruction, first));
                    let table = table.unwrap_or_default();
                    if table.is_empty() {
                        // It may continue anywhere.
                        function.forget(targets);
                        return;
                    }
                    table
                }
                _ => Vec::new(),
            };
            for target in jumps {
                if let Ok(target) = place(target) {
                    join(&mut known, &mut pending, target, &after);
                }
            }
        }
        for (instruction, known) in instructions.iter().zip(&known) {
            if let Some(known) = known {
                self.note(instruction, known, targets);
            }
        }
    }

    /// Notes the target of a call through a register, or those in outlined code.
    fn note(&self, instruction: &Instruction, before: &Registers, targets: &mut Targets) {
        if let Some(register) = instruction.through
            && instruction.flow != Flow::Return
        {
            let target = before.get(register).copied().flatten();
            let found = targets
                .entry(instruction.address)
                .or_insert(Some(BTreeSet::new()));
            match (found.as_mut(), target) {
                (Some(all), Some(target)) => drop(all.insert(target & !1)),
                _ => *found = None,
            }
        }
        if let Some(outlined) = self.outlined(instruction) {
            let mut registers = *before;
            for instruction in &outlined.instructions {
                self.note(instruction, &registers, targets);
                registers = self.after(instruction, registers);
            }
        }
    }

    /// The outlined code that an instruction calls or jumps to.
    fn outlined(&self, instruction: &Instruction) -> Option<&Function> {
        let target = instruction
            .immediate
            .filter(|_| matches!(instruction.flow, Flow::Call | Flow::Jump))?;
        self.functions.get(&target).filter(|own| own.is_outlined)
    }

    /// The registers after an instruction.
    fn after(&self, instruction: &Instruction, before: Registers) -> Registers {
        if let Some(outlined) = self.outlined(instruction) {
            if !outlined.is_straight() {
                return [None; 15];
            }
            let mut after = before;
            for own in &outlined.instructions {
                after = self.after(own, after);
                if own.flow == Flow::Jump {
                    // Another function returns in its place.
                    after = without(after, SCRATCH);
                }
            }
            // Its call and its return.
            return without(after, 1 << 14);
        }
        let scratch = if instruction.flow == Flow::Call {
            SCRATCH
        } else {
            0
        };
        // An address with a displacement may be written back.
        let written = instruction.writes | instruction.address_from | scratch;
        let mut after = without(before, written);
        if let Some((register, source)) = instruction.sets
            && let Some(after) = after.get_mut(register)
        {
            *after = match source {
                Source::Constant(value) => Some(value),
                Source::UpperHalf(value) => {
                    before[register].map(|lower| value << 16 | (lower & 0xffff))
                }
                Source::Word(address) => self.elf.word(address),
                Source::Register(from) => before.get(from).copied().flatten(),
            };
        }
        after
    }
}

impl Function {
    /// Leaves every call of it through a register unresolved.
    fn forget(&self, targets: &mut Targets) {
        for instruction in &self.instructions {
            if instruction.through.is_some() {
                targets.insert(instruction.address, None);
            }
        }
    }

    /// True if it has one way only.
    fn is_straight(&self) -> bool {
        self.instructions.iter().all(|own| {
            let jumps = own.flow == Flow::Jump
                && own
                    .immediate
                    .is_some_and(|target| self.range.contains(&target));
            !jumps && own.conditions == 0 && !own.is_conditional && own.flow != Flow::Table
        })
    }
}

/// True for an instruction after which, unconditional, the next one in memory is not the next.
fn ends(instruction: &Instruction) -> bool {
    matches!(instruction.flow, Flow::Jump | Flow::Table | Flow::Return)
}

/// The values without those of some registers, a bit each.
fn without(registers: Registers, written: u32) -> Registers {
    std::array::from_fn(|i| registers[i].filter(|_| written & 1 << i == 0))
}

/// The values that two ways have in common.
fn common(one: &Registers, other: &Registers) -> Registers {
    std::array::from_fn(|i| one[i].filter(|value| other[i] == Some(*value)))
}

/// Joins a way to others at an instruction, which is gone through again if it changes anything.
fn join(known: &mut [Option<Registers>], pending: &mut Vec<usize>, at: usize, way: &Registers) {
    let Some(known) = known.get_mut(at) else {
        return;
    };
    let joined = known.map_or(*way, |others| common(&others, way));
    if *known != Some(joined) {
        *known = Some(joined);
        pending.push(at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ldr r4, [pc, #28]: the word at 0x120 of a function at 0x100.
    const LOAD: u16 = 0x4c07;
    /// blx r4
    const CALL: u16 = 0x47a0;
    /// bx lr
    const RETURN: u16 = 0x4770;
    /// bl to 0x140 from 0x102
    const OUTLINED_FROM_102: [u16; 2] = [0xf000, 0xf81d];

    /// The targets of a function at 0x100 with a word at 0x120, which is that of a function at 0x200.
    fn targets(halves: &[u16]) -> Targets {
        with_outlined(halves, &[])
    }

    fn with_outlined(halves: &[u16], outlined: &[u16]) -> Targets {
        let elf = Elf::of_code(&[
            ("own", 0x100, halves, true),
            ("", 0x120, &[0x0201, 0], false),
            ("OUTLINED_FUNCTION_0", 0x140, outlined, true),
        ]);
        Code::new(&elf).targets()
    }

    fn one(target: u32) -> Option<BTreeSet<u32>> {
        Some(BTreeSet::from([target]))
    }

    #[test]
    fn a_call_by_a_loaded_address_is_resolved() {
        assert_eq!(
            targets(&[LOAD, CALL, CALL, RETURN]),
            Targets::from([(0x102, one(0x200)), (0x104, one(0x200))])
        );
        // movw r12, #0x1001; movt r12, #0x2000; bx r12
        let jump = [0xf241, 0x0c01, 0xf2c2, 0x0c00, 0x4760];
        assert_eq!(targets(&jump), Targets::from([(0x108, one(0x2000_1000))]));
        // mov r9, r4; blx r9
        let copied = [LOAD, 0x46a1, 0x47c8, RETURN];
        assert_eq!(targets(&copied), Targets::from([(0x104, one(0x200))]));
    }

    #[test]
    fn a_register_that_is_written_or_of_the_callee_is_unknown() {
        for between in [
            // adds r4, #1; ldr r4, [r0]; pop {r4}; ldr r0, [r4], #4 in two halves
            &[0x3401][..],
            &[0x6804],
            &[0xbc10],
            &[0xf854, 0x0b04],
        ] {
            let halves = [&[LOAD][..], between, &[CALL, RETURN]].concat();
            let found = targets(&halves);
            assert_eq!(
                found.into_values().collect::<Vec<_>>(),
                [None],
                "{between:x?}"
            );
        }
        // ldr r3, [pc, #28]; blx r3; blx r3
        assert_eq!(
            targets(&[0x4b07, 0x4798, 0x4798, RETURN]),
            Targets::from([(0x102, one(0x200)), (0x104, None)])
        );
        // The caller's own.
        assert_eq!(targets(&[CALL, RETURN]), Targets::from([(0x100, None)]));
    }

    #[test]
    fn every_way_to_a_call_counts() {
        // cbz r0, past the load
        assert_eq!(targets(&[0xb108, 0xbf00, LOAD, CALL, RETURN]).len(), 1);
        let skipped = targets(&[0xb100, LOAD, CALL, RETURN]);
        assert_eq!(
            skipped,
            Targets::from([(0x104, None)]),
            "cbz leads behind the load"
        );
        // it eq; ldreq r4
        let maybe = targets(&[0xbf08, LOAD, CALL, RETURN]);
        assert_eq!(maybe, Targets::from([(0x104, None)]));
        // b to the call, over an instruction that changes the register
        let over = targets(&[LOAD, 0xe000, 0x3401, CALL, RETURN]);
        assert_eq!(over, Targets::from([(0x106, one(0x200))]));
        // The same where the branch may continue: beq
        let either = targets(&[LOAD, 0xd000, 0x3401, CALL, RETURN]);
        assert_eq!(either, Targets::from([(0x106, None)]));
        // A loop that changes the register behind the call: adds r4, #1; b to the call
        let again = targets(&[LOAD, CALL, 0x3401, 0xe7fc]);
        assert_eq!(again, Targets::from([(0x102, None)]));
        // Where no way leads, nothing is resolved.
        assert!(targets(&[RETURN, LOAD, CALL]).is_empty());
    }

    #[test]
    fn the_ways_of_a_table_are_followed_and_without_it_none_is_known() {
        // tbb [pc, r0] at 0x102 with two entries: the call at 0x108, or the addition before it at 0x106...
        let elf = |entries: [u8; 2], is_data| {
            let table = u16::from_le_bytes(entries);
            let own = [LOAD, 0xe8df, 0xf000, table, 0x3401, CALL, RETURN];
            let mut elf =
                Elf::of_code(&[("own", 0x100, &own, true), ("", 0x120, &[0x0201, 0], false)]);
            if is_data {
                elf.mark(0x106, false);
                elf.mark(0x108, true);
            }
            elf
        };
        let found = |elf: &Elf| Code::new(elf).targets();
        assert_eq!(
            found(&elf([2, 2], true)),
            Targets::from([(0x10a, one(0x200))])
        );
        assert_eq!(found(&elf([2, 1], true)), Targets::from([(0x10a, None)]));
        assert!(found(&elf([2, 2], false)).values().all(Option::is_none));
    }

    #[test]
    fn a_table_may_lie_at_an_address_in_a_register() {
        // adr r2, 0x124; tbb [r2, r1], which leads to the call at 0x10a, or to the addition before it.
        let found = |address: u16, entries: [u8; 2]| {
            let table = [u16::from_le_bytes(entries)];
            let own = [LOAD, address, 0xe8d2, 0xf001, 0x3401, CALL, RETURN];
            let elf = Elf::of_code(&[
                ("own", 0x100, &own, true),
                ("", 0x120, &[0x0201, 0], false),
                ("", 0x124, &table, false),
                ("next", 0x126, &[RETURN], true),
            ]);
            Code::new(&elf).targets()
        };
        let adr = 0xa208;
        assert_eq!(found(adr, [1, 1]), Targets::from([(0x10a, one(0x200))]));
        assert_eq!(found(adr, [1, 0]), Targets::from([(0x10a, None)]));
        // mov r2, r0: it may be any.
        assert!(found(0x4602, [1, 1]).values().all(Option::is_none));
    }

    #[test]
    fn outlined_code_is_followed_where_it_is_called() {
        let [bl, to] = OUTLINED_FROM_102;
        // It calls what its caller has loaded.
        let own = [LOAD, bl, to, CALL, RETURN];
        let calls = with_outlined(&own, &[CALL, RETURN]);
        assert_eq!(
            calls,
            Targets::from([(0x106, one(0x200)), (0x140, one(0x200))])
        );
        // It changes the register of its caller: adds r4, #1.
        let changes = with_outlined(&own, &[0x3401, RETURN]);
        assert_eq!(changes, Targets::from([(0x106, None)]));
        // It has more than one way: cbz.
        let branches = with_outlined(&own, &[0xb100, 0xbf00, RETURN]);
        assert_eq!(branches, Targets::from([(0x106, None)]));
        // It leaves to another function, which may change the registers of a callee: r3 is none that stays.
        let own = [0x4b07, bl, to, 0x4798, RETURN];
        let leaves = with_outlined(&own, &[0xf000, 0xbffe]);
        assert_eq!(leaves, Targets::from([(0x106, None)]));
    }
}
