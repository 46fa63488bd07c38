//! Finds the beginning and the end of an interrupt handler on a Cortex-M4F, and counts its executed instructions.

use std::ops::Range;

use crate::thumb::{Flow, Instruction};

/// The code that is measured.
#[derive(Debug, Clone)]
pub(crate) struct Watched {
    /// The handler's first instruction.
    pub(crate) handler: u32,
    /// Functions that only an emulated drive has: neither they nor their callees count.
    pub(crate) left_out: Vec<Range<u32>>,
    /// Addresses that an interrupt may pass, 32 at most; those that it passed are reported.
    pub(crate) marks: Vec<u32>,
    /// The words whose writes drive the output.
    pub(crate) output: OutputWords,
}

/// Registers of the output: after a write to the one, a write to the other has the command take effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct OutputWords {
    /// Written whenever the output is driven, and only then.
    pub(crate) driven: u32,
    /// Written last.
    pub(crate) effective: u32,
}

impl Watched {
    fn leaves_out(&self, address: u32) -> bool {
        self.left_out.iter().any(|range| range.contains(&address))
    }

    /// The bit of a mark, where one is.
    fn mark_at(&self, address: u32) -> u32 {
        let found = self.marks.iter().position(|&mark| mark == address);
        found.map_or(0, |at| 1 << at)
    }
}

/// The cost of an interrupt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cost {
    /// Marks that it passed, the first of those watched in the lowest bit.
    pub(crate) marks: u32,
    /// Instructions until the command of a sample that drives the output can take effect.
    pub(crate) command: Option<u64>,
    pub(crate) instructions: u64,
}

/// Follows every instruction that is executed.
///
/// A handler begins with the instruction at its entry and ends with the return without a call of its own.
/// A taken branch shows in the address of the next instruction.
#[derive(Debug)]
pub(crate) struct Meter {
    watched: Watched,
    handler: Option<Handler>,
}

/// The running handler.
#[derive(Debug, Default)]
struct Handler {
    instructions: u64,
    marks: u32,
    /// Calls that have not returned.
    depth: u32,
    /// The depth of the code that does not count, while it runs.
    left_out: Option<u32>,
    /// It has begun to drive the output, and the instructions when it was done with that.
    drives: bool,
    has_driven: Option<u64>,
    /// The last instruction.
    last: Option<Instruction>,
}

/// The handler was entered before its return: the meter has missed the end.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Lost;

impl Meter {
    pub(crate) fn new(watched: Watched) -> Self {
        Self {
            watched,
            handler: None,
        }
    }

    /// Takes the next instruction. If an interrupt has ended before it, the result is its cost.
    pub(crate) fn execute(&mut self, instruction: &Instruction) -> Result<Option<Cost>, Lost> {
        let address = instruction.address;
        let ended = self
            .handler
            .as_mut()
            .is_some_and(|handler| handler.leads_out(address))
            .then(|| self.end())
            .flatten();
        if address == self.watched.handler {
            if self.handler.is_some() {
                return Err(Lost);
            }
            self.handler = Some(Handler::default());
        }
        let Some(handler) = &mut self.handler else {
            return Ok(ended);
        };
        handler.last = Some(*instruction);
        if handler.left_out.is_none() && self.watched.leaves_out(address) {
            handler.left_out = Some(handler.depth);
        }
        if handler.left_out.is_some() {
            return Ok(ended);
        }
        handler.instructions += 1;
        handler.marks |= self.watched.mark_at(address);
        Ok(ended)
    }

    /// Takes a write to memory by the last instruction.
    pub(crate) fn store(&mut self, address: u32) {
        let OutputWords { driven, effective } = self.watched.output;
        let Some(handler) = &mut self.handler else {
            return;
        };
        handler.drives |= address == driven;
        if address == effective && handler.drives && handler.has_driven.is_none() {
            handler.has_driven = Some(handler.instructions);
        }
    }

    fn end(&mut self) -> Option<Cost> {
        let handler = self.handler.take()?;
        Some(Cost {
            marks: handler.marks,
            command: handler.has_driven,
            instructions: handler.instructions,
        })
    }
}

impl Handler {
    /// Follows the last instruction to the next; true if it led out of the handler.
    fn leads_out(&mut self, next: u32) -> bool {
        let Some(last) = self.last.filter(|last| last.end() != next) else {
            return false;
        };
        match last.flow {
            Flow::On | Flow::Jump | Flow::Table => false,
            Flow::Call => {
                self.depth += 1;
                false
            }
            Flow::Return if self.depth == 0 => true,
            Flow::Return => {
                if self.left_out == Some(self.depth) {
                    self.left_out = None;
                }
                self.depth -= 1;
                false
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Addresses of the interrupted program, the handler, two functions.
    const BACKGROUND: u32 = 0x2000_0000;
    const HANDLER: u32 = 0x2000_0100;
    const FUNCTION: u32 = 0x2000_0200;
    const EMULATED: u32 = 0x2000_0300;
    const ITS_END: u32 = 0x2000_0400;

    /// Registers of the output.
    const OUTPUT: OutputWords = OutputWords {
        driven: 0x2000_1038,
        effective: 0x2000_1000,
    };

    const NOP: &[u16] = &[0xbf00];
    const PUSH_LR: &[u16] = &[0xb500];
    const POP_PC: &[u16] = &[0xbd00];
    const BX_LR: &[u16] = &[0x4770];
    const BL: &[u16] = &[0xf000, 0xf800];

    fn watched() -> Watched {
        Watched {
            handler: HANDLER,
            left_out: std::iter::once(EMULATED..ITS_END).collect(),
            marks: vec![FUNCTION, BACKGROUND],
            output: OUTPUT,
        }
    }

    fn cost(marks: u32, instructions: u64) -> Cost {
        Cost {
            marks,
            command: None,
            instructions,
        }
    }

    /// The costs of the interrupts of a program, each instruction with its address.
    fn costs(program: &[(u32, &[u16])]) -> Vec<Cost> {
        let mut meter = Meter::new(watched());
        program
            .iter()
            .filter_map(|&(address, code)| {
                let second = code.get(1).copied().unwrap_or(0);
                let instruction = Instruction::decode(address, [code[0], second]);
                meter.execute(&instruction).expect("no entry is missed")
            })
            .collect()
    }

    #[test]
    fn an_interrupt_is_counted_from_its_entry_to_its_return() {
        let program = [
            (BACKGROUND, NOP),
            (HANDLER, PUSH_LR),
            (HANDLER + 2, NOP),
            (HANDLER + 4, POP_PC),
            (BACKGROUND + 2, NOP),
        ];
        assert_eq!(costs(&program), [cost(0, 3)]);
    }

    #[test]
    fn callees_count_and_leave_their_marks() {
        let program = [
            (HANDLER, PUSH_LR),
            (HANDLER + 2, BL),
            (FUNCTION, NOP),
            (FUNCTION + 2, BX_LR),
            (HANDLER + 6, POP_PC),
            (BACKGROUND, NOP),
        ];
        assert_eq!(costs(&program), [cost(0b01, 5)]);
    }

    #[test]
    fn a_return_whose_condition_does_not_hold_is_none() {
        let program = [
            (HANDLER, NOP),
            // bxeq lr, after an IT, once not and once done.
            (HANDLER + 2, BX_LR),
            (HANDLER + 4, NOP),
            (HANDLER + 6, BX_LR),
            (BACKGROUND, NOP),
        ];
        let [cost] = costs(&program)[..] else {
            panic!("one interrupt");
        };
        assert_eq!(cost.instructions, 4);
    }

    #[test]
    fn interrupts_may_follow_each_other_without_a_program_between() {
        let program = [
            (HANDLER, NOP),
            (HANDLER + 2, BX_LR),
            (HANDLER, NOP),
            (HANDLER + 2, BX_LR),
            (BACKGROUND, NOP),
        ];
        let found = costs(&program);
        assert_eq!(found.len(), 2);
        assert_eq!(found[0], found[1]);
    }

    #[test]
    fn emulated_functions_cost_only_their_call() {
        let with = [
            (HANDLER, PUSH_LR),
            (HANDLER + 2, BL),
            (EMULATED, PUSH_LR),
            (EMULATED + 2, BL),
            (FUNCTION, NOP),
            (FUNCTION + 2, BX_LR),
            (EMULATED + 6, POP_PC),
            (HANDLER + 6, POP_PC),
            (BACKGROUND, NOP),
        ];
        assert_eq!(costs(&with), [cost(0, 3)]);
    }

    #[test]
    fn counting_resumes_at_the_return_of_an_emulated_function() {
        let program = [
            (HANDLER, BL),
            (EMULATED, BX_LR),
            (HANDLER + 4, BL),
            (FUNCTION, BX_LR),
            (HANDLER + 8, BX_LR),
            (BACKGROUND, NOP),
        ];
        let [cost] = costs(&program)[..] else {
            panic!("one interrupt");
        };
        assert_eq!((cost.marks, cost.instructions), (0b01, 4));
    }

    #[test]
    fn a_command_counts_from_the_entry_to_its_last_write_and_only_where_the_output_is_driven() {
        let OutputWords { driven, effective } = OUTPUT;
        let command = |writes: &[u32]| {
            let mut meter = Meter::new(watched());
            // A write of the background is none of the sample's.
            meter.store(driven);
            let instructions = (HANDLER..).step_by(2).zip(writes);
            for (address, &written) in instructions {
                let nop = Instruction::decode(address, [NOP[0], 0]);
                assert_eq!(meter.execute(&nop), Ok(None));
                meter.store(written);
            }
            let last = HANDLER + 2 * writes.len() as u32;
            let returns = Instruction::decode(last, [BX_LR[0], 0]);
            assert_eq!(meter.execute(&returns), Ok(None));
            let next = Instruction::decode(BACKGROUND, [NOP[0], 0]);
            let ended = meter.execute(&next).expect("no entry is missed");
            ended.expect("the handler has returned").command
        };
        assert_eq!(command(&[0, effective, driven]), None);
        assert_eq!(command(&[driven, 0, effective]), Some(3));
        // A second command of a sample, which ends in it, is not the one that was due.
        assert_eq!(command(&[driven, effective, driven, effective]), Some(2));
    }

    #[test]
    fn an_entry_before_the_return_is_noticed() {
        let mut meter = Meter::new(watched());
        let entry = Instruction::decode(HANDLER, [0xbf00, 0]);
        assert_eq!(meter.execute(&entry), Ok(None));
        assert_eq!(meter.execute(&entry), Err(Lost));
    }
}
