//! Cycles of a Cortex-M4F in an STM32F405 at 168 MHz: the core's own, those that its neighbours add
//! and take (Cortex-M4 TRM r0p1, 3.3.2 and 7.2.2), and those of flash and buses.

use super::flash::Flash;
use crate::thumb::{Flow, Instruction, Unit};

/// Cycles from the request of an interrupt to its first instruction, eight registers stacked
/// (TRM, 3.9.1).
pub(crate) const ENTRY: u64 = 12;

/// Cycles from the return to the interrupted program's next instruction; the TRM gives none, so as
/// many as the entry takes.
pub(crate) const EXIT: u64 = 12;

/// Cycles to stack sixteen registers of the FPU and its status when a handler first uses the FPU, and to
/// restore them at its end.
pub(crate) const FLOATS: u64 = 17;

/// Where the manuals give a range, the model's choice in it, or one of its ends: the difference is the model's own error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub(crate) enum Choice {
    /// The fewest cycles.
    Least,
    /// Those of `docs/cycles.md`.
    #[default]
    Assumed,
    /// The most cycles.
    Most,
}

impl Choice {
    /// A refill of the pipeline: 1 to 3 cycles (TRM, table 3-1).
    fn refill(self) -> u64 {
        match self {
            Self::Least => 1,
            Self::Assumed => 2,
            Self::Most => 3,
        }
    }

    /// Cycles of a peripheral bus until a transfer on it begins: up to one.
    fn begin_on_bus(self) -> u64 {
        u64::from(self != Self::Least)
    }

    /// True if a load or a store overlaps with a load before it (TRM, 3.3.3).
    fn overlaps(self) -> bool {
        self != Self::Most
    }
}

/// The processor as it executes.
#[derive(Debug)]
pub(crate) struct Processor {
    choice: Choice,
    clock: u64,
    flash: Flash,
    last: Option<Instruction>,
}

impl Processor {
    pub(crate) fn new(choice: Choice) -> Self {
        Self {
            choice,
            clock: 0,
            flash: Flash::new(),
            last: None,
        }
    }

    /// Cycles since the beginning.
    pub(crate) fn clock(&self) -> u64 {
        self.clock
    }

    /// Separates the next instruction from the one before: an interrupt begins or ends, or instructions in
    /// between do not count.
    pub(crate) fn separate(&mut self) {
        self.last = None;
    }

    /// The flow of the last instruction, if it branched to this address.
    pub(crate) fn branched_to(&self, address: u32) -> Option<Flow> {
        let last = self.last.as_ref()?;
        let flow = last.flow;
        (flow != Flow::On && last.end() != address).then_some(flow)
    }

    /// Adds cycles of no instruction.
    pub(crate) fn wait(&mut self, cycles: u64) {
        self.clock += cycles;
    }

    /// Executes an instruction, without its access to memory.
    pub(crate) fn execute(&mut self, instruction: &Instruction) {
        if self.branched_to(instruction.address).is_some() {
            self.clock += self.choice.refill();
        }
        let Instruction {
            address, length, ..
        } = *instruction;
        self.clock += self.flash.fetch(address, length, self.clock);
        self.clock += self.own_cycles(instruction);
        self.last = Some(*instruction);
    }

    /// Reads memory for the instruction that is being executed.
    pub(crate) fn load(&mut self, address: u32) {
        self.clock += self.flash.load(address, self.clock) + self.bus_wait(address);
    }

    /// Cycles of an instruction beside the one before it.
    fn own_cycles(&self, instruction: &Instruction) -> u64 {
        let cycles = u64::from(instruction.cycles);
        let Some(last) = self
            .last
            .as_ref()
            .filter(|last| last.end() == instruction.address)
        else {
            return cycles;
        };
        let address_is_last = last.writes & instruction.address_from != 0;
        let follows_load = self.choice.overlaps()
            && last.unit == Unit::Load
            && matches!(instruction.unit, Unit::Load | Unit::Store)
            && !address_is_last;
        let waits_for_address = last.unit == Unit::Core && address_is_last;
        let waits_for_float = last.floats_late & instruction.floats_read != 0;
        (cycles - u64::from(follows_load && cycles > 1))
            + u64::from(waits_for_address)
            + u64::from(waits_for_float)
    }

    /// Cycles that a read waits for a peripheral. A transfer on a peripheral bus takes two of its cycles
    /// and up to one more until it begins; the buses run at a quarter of the core's clock and at half of
    /// it, the ports at all of it.
    fn bus_wait(&self, address: u32) -> u64 {
        let transfer = 2 + self.choice.begin_on_bus();
        match address {
            0x4000_0000..=0x4000_ffff => transfer * 4,
            0x4001_0000..=0x4001_ffff => transfer * 2,
            0x4002_0000..=0x5fff_ffff => 1,
            _ => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In memory, where nothing waits for the flash.
    const HERE: u32 = 0x2000_0000;

    /// Cycles of a sequence, each instruction by its half-words.
    fn cycles(codes: &[&[u16]]) -> u64 {
        let mut processor = Processor::new(Choice::Assumed);
        let mut address = HERE;
        for code in codes {
            let second = code.get(1).copied().unwrap_or(0);
            let instruction = Instruction::decode(address, [code[0], second]);
            assert_eq!(instruction.length as usize, 2 * code.len());
            processor.execute(&instruction);
            address = instruction.end();
        }
        processor.clock()
    }

    #[test]
    fn the_model_lies_between_the_ends_of_the_ranges() {
        let cycles = |choice| {
            let mut processor = Processor::new(choice);
            // Two loads, the first of a slow peripheral, and a branch that is taken.
            for (address, code) in [(HERE, 0x6808), (HERE + 2, 0x681a), (HERE + 4, 0xe7fe)] {
                processor.execute(&Instruction::decode(address, [code, 0]));
            }
            processor.load(0x4000_0424);
            processor.execute(&Instruction::decode(HERE + 4, [0xe7fe, 0]));
            processor.clock()
        };
        let assumed = cycles(Choice::Assumed);
        assert_eq!(cycles(Choice::Least), assumed - 1 - 4);
        assert_eq!(cycles(Choice::Most), assumed + 1 + 1);
    }

    const ADDS_R0_R1_R2: &[u16] = &[0x1888];
    const LDR_R0_R1: &[u16] = &[0x6808];
    const LDR_R2_R3: &[u16] = &[0x681a];
    const LDR_R3_R0: &[u16] = &[0x6803];
    const STR_R0_R3: &[u16] = &[0x6018];
    const STR_R2_R1_R3: &[u16] = &[0x50ca];
    const VADD_S0_S1_S2: &[u16] = &[0xee30, 0x0a81];
    const VMUL_S3_S0_S2: &[u16] = &[0xee60, 0x1a01];
    const VMUL_S3_S1_S2: &[u16] = &[0xee60, 0x1a81];

    #[test]
    fn loads_beside_each_other_overlap() {
        // Two, then one; three of them four; a store with a register's offset one less, too.
        assert_eq!(cycles(&[LDR_R0_R1, LDR_R2_R3]), 3);
        assert_eq!(cycles(&[LDR_R0_R1, LDR_R2_R3, LDR_R0_R1]), 4);
        assert_eq!(cycles(&[LDR_R0_R1, STR_R2_R1_R3]), 3);
        assert_eq!(cycles(&[LDR_R0_R1, STR_R0_R3]), 3);
        // Not if one makes the other's address, nor after a store.
        assert_eq!(cycles(&[LDR_R0_R1, LDR_R3_R0]), 4);
        assert_eq!(cycles(&[STR_R0_R3, LDR_R0_R1]), 3);
    }

    #[test]
    fn an_address_that_was_just_computed_costs_a_cycle() {
        assert_eq!(cycles(&[ADDS_R0_R1_R2, LDR_R3_R0]), 1 + 2 + 1);
        assert_eq!(cycles(&[ADDS_R0_R1_R2, LDR_R2_R3]), 1 + 2);
        assert_eq!(cycles(&[ADDS_R0_R1_R2, ADDS_R0_R1_R2]), 2);
    }

    #[test]
    fn a_float_that_is_used_at_once_costs_a_cycle() {
        assert_eq!(cycles(&[VADD_S0_S1_S2, VMUL_S3_S0_S2]), 3);
        assert_eq!(cycles(&[VADD_S0_S1_S2, VMUL_S3_S1_S2]), 2);
        assert_eq!(
            cycles(&[VADD_S0_S1_S2, ADDS_R0_R1_R2, VMUL_S3_S0_S2]),
            1 + 1 + 1
        );
    }

    #[test]
    fn a_branch_refills_the_pipeline_if_it_is_taken() {
        let bne = Instruction::decode(HERE, [0xd11e, 0]);
        let mut processor = Processor::new(Choice::Assumed);
        processor.execute(&bne);
        assert_eq!(processor.branched_to(bne.end()), None);
        processor.execute(&Instruction::decode(bne.end(), [0xbf00, 0]));
        assert_eq!(processor.clock(), 2);

        let mut processor = Processor::new(Choice::Assumed);
        processor.execute(&bne);
        assert_eq!(processor.branched_to(HERE + 64), Some(Flow::Jump));
        processor.execute(&Instruction::decode(HERE + 64, [0xbf00, 0]));
        assert_eq!(processor.clock(), 2 + Choice::Assumed.refill());
    }

    #[test]
    fn separate_loads_do_not_overlap() {
        let mut processor = Processor::new(Choice::Assumed);
        processor.execute(&Instruction::decode(HERE, [0x6808, 0]));
        processor.separate();
        processor.execute(&Instruction::decode(HERE + 2, [0x681a, 0]));
        assert_eq!(processor.clock(), 4);
    }

    #[test]
    fn a_register_on_a_slow_bus_is_waited_for() {
        let mut processor = Processor::new(Choice::Assumed);
        // A timer of each bus, a port, the interrupt controller, memory.
        for address in [
            0x4000_0424,
            0x4001_0044,
            0x4002_0810,
            0xe000_e100,
            0x2000_0000,
        ] {
            processor.load(address);
        }
        assert_eq!(processor.clock(), 12 + 6 + 1);
    }

    #[test]
    fn code_in_flash_waits_for_it() {
        let mut processor = Processor::new(Choice::Assumed);
        let nop = |address| Instruction::decode(address, [0xbf00, 0]);
        processor.execute(&nop(0x0800_0000));
        assert_eq!(processor.clock(), 1 + 5);
        processor.execute(&nop(0x0800_0002));
        assert_eq!(processor.clock(), 1 + 5 + 1);
        processor.load(0x0800_4000);
        assert_eq!(processor.clock(), 1 + 5 + 1 + 5);
    }
}
