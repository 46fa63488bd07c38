//! Thumb-2 instructions of a Cortex-M4F as Capstone decodes them, reduced to their stack, their flow and their effect
//! on the core's registers.

use capstone::arch::arm::{
    ArchExtraMode, ArchMode, ArmCC, ArmInsnDetail, ArmOpMem, ArmOperandType, ArmReg,
};
use capstone::prelude::*;

/// An instruction at its address.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Instruction {
    pub(crate) address: u32,
    /// Bytes: 2 or 4.
    pub(crate) length: u32,
    pub(crate) flow: Flow,
    /// Core registers that an address is made of, a bit each.
    pub(crate) address_from: u32,
    /// Core registers that it writes, a bit each.
    pub(crate) writes: u32,
    /// Bytes of stack that it pushes or reserves.
    pub(crate) stack: u32,
    /// Its constant; the target of a branch or a call.
    pub(crate) immediate: Option<u32>,
    /// It is a division or a square root.
    pub(crate) divides: bool,
    /// A branch that may also continue with the next instruction by itself, without an IT before it.
    pub(crate) is_conditional: bool,
    /// Instructions after it that are conditional: it is an IT.
    pub(crate) conditions: u32,
    /// The core register that it sets to a value known from the code alone, and that value.
    pub(crate) sets: Option<(usize, Source)>,
    /// The core register that a jump or a call goes through.
    pub(crate) through: Option<usize>,
    /// Bytes of an entry of the table by which it jumps: 1, 2, or 0 where there is none.
    pub(crate) entry: u32,
    /// The core register with the address of that table, unless it is behind the instruction.
    pub(crate) table: Option<usize>,
}

/// A value that an instruction gives to a core register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    /// This one.
    Constant(u32),
    /// The upper half; the lower half stays.
    UpperHalf(u32),
    /// The word at this address in the code.
    Word(u32),
    /// That of another core register.
    Register(usize),
}

/// The instruction after this one, unless its condition fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Flow {
    /// The next in memory.
    #[default]
    On,
    /// One of the same function, or of another that returns in its place.
    Jump,
    /// One of a table of the same function.
    Table,
    /// The first of a function that returns here.
    Call,
    /// One after a call.
    Return,
}

/// Stack pointer, link register and program counter, as bits.
const SP: u32 = 1 << 13;
const LR: u32 = 1 << 14;
const PC: u32 = 1 << 15;

// One for all: the instructions after an IT decode as they do anywhere else.
thread_local! {
    static CAPSTONE: Option<Capstone> = Capstone::new()
        .arm()
        .mode(ArchMode::Thumb)
        .extra_mode([ArchExtraMode::MClass].into_iter())
        .detail(true)
        .build()
        .ok();
}

impl Instruction {
    /// Decodes the instruction that begins with two half-words; the second of a short one does not matter.
    pub(crate) fn decode(address: u32, [first, second]: [u16; 2]) -> Self {
        let unknown = Self {
            address,
            // ARMv7-M Architecture Reference Manual, A5.1.
            length: if first >> 11 >= 0b11101 { 4 } else { 2 },
            // ARMv7-M Architecture Reference Manual, A7.7.38.
            conditions: match (first >> 8, first & 0xf) {
                (0xbf, mask @ 1..) => 4 - mask.trailing_zeros(),
                _ => 0,
            },
            ..Self::default()
        };
        let [[a, b], [c, d]] = [first.to_le_bytes(), second.to_le_bytes()];
        let known = CAPSTONE.with(|own| Self::known(own.as_ref()?, unknown, [a, b, c, d]));
        known.unwrap_or(unknown)
    }

    /// The address after it.
    pub(crate) fn end(&self) -> u32 {
        self.address.wrapping_add(self.length)
    }

    fn known(capstone: &Capstone, unknown: Self, bytes: [u8; 4]) -> Option<Self> {
        let decoded = capstone
            .disasm_count(&bytes, unknown.address.into(), 1)
            .ok()?;
        let instruction = decoded.first()?;
        // Some of the FPU's instructions have older names here.
        let name = match instruction.mnemonic()?.split('.').next() {
            Some(name) if name.starts_with('v') => name.to_owned(),
            _ => capstone.insn_name(instruction.id())?,
        };
        let detail = capstone.insn_detail(instruction).ok()?;
        let arm = detail.arch_detail();
        let arm = arm.arm()?;
        let operands = Operands::read(&name, arm);
        let is_always = matches!(arm.cc(), ArmCC::ARM_CC_AL | ArmCC::ARM_CC_INVALID);
        Some(Self {
            flow: flow(&name, &operands),
            address_from: operands.address & !PC,
            writes: operands.written & !PC,
            stack: stack(&name, &operands),
            immediate: operands.immediate,
            divides: matches!(&*name, "sdiv" | "udiv" | "vdiv" | "vsqrt"),
            is_conditional: !is_always || matches!(&*name, "cbz" | "cbnz"),
            sets: sets(unknown.address, &name, &operands),
            through: only(operands.read).filter(|_| matches!(&*name, "bx" | "blx")),
            entry: match &*name {
                "tbb" => 1,
                "tbh" => 2,
                _ => 0,
            },
            table: only(operands.base & !PC).filter(|_| matches!(&*name, "tbb" | "tbh")),
            ..unknown
        })
    }
}

/// A register's bit among those of the core, 0 for another, and the words that it holds, 0 for one that is not pushed.
fn bit_and_words(register: RegId) -> (u32, u32) {
    let number = u32::from(register.0);
    match number {
        ArmReg::ARM_REG_SP => (SP, 1),
        ArmReg::ARM_REG_LR => (LR, 1),
        ArmReg::ARM_REG_PC => (PC, 1),
        ArmReg::ARM_REG_R0..=ArmReg::ARM_REG_R12 => (1 << (number - ArmReg::ARM_REG_R0), 1),
        ArmReg::ARM_REG_S0..=ArmReg::ARM_REG_S31 => (0, 1),
        ArmReg::ARM_REG_D0..=ArmReg::ARM_REG_D15 => (0, 2),
        _ => (0, 0),
    }
}

/// The operands of an instruction.
#[derive(Debug, Default)]
struct Operands {
    /// Registers of the core that it reads and writes, a bit each, those of an address apart.
    read: u32,
    written: u32,
    /// Words of its registers, the FPU's too.
    words: u32,
    /// Registers of which an address is made, and the one that the others are added to.
    address: u32,
    base: u32,
    has_index: bool,
    /// Bytes that are added to an address, before or after the access.
    displacement: i32,
    writes_back: bool,
    immediate: Option<u32>,
}

/// The number of the core register, if there is one and no other.
fn only(registers: u32) -> Option<usize> {
    registers
        .is_power_of_two()
        .then(|| registers.trailing_zeros() as usize)
}

impl Operands {
    fn read(name: &str, detail: &ArmInsnDetail) -> Self {
        let mut found = Self {
            writes_back: detail.writeback(),
            ..Self::default()
        };
        if name.ends_with("push") || name.ends_with("pop") {
            found.address = SP;
        }
        // The first register of these is the address.
        let mut is_base = name.contains("ldm") || name.contains("stm");
        for operand in detail.operands() {
            match operand.op_type {
                ArmOperandType::Reg(register) if is_base => {
                    is_base = false;
                    found.address = bit_and_words(register).0;
                }
                ArmOperandType::Reg(register) => {
                    let (bit, words) = bit_and_words(register);
                    let access = operand.access;
                    found.words += words;
                    if access.is_some_and(|access| access.is_readable()) {
                        found.read |= bit;
                    }
                    if access.is_some_and(|access| access.is_writable()) {
                        found.written |= bit;
                    }
                }
                ArmOperandType::Mem(memory) => found.take_address(memory),
                ArmOperandType::Imm(value) => found.immediate = Some(value.cast_unsigned()),
                _ => {}
            }
        }
        found
    }

    fn take_address(&mut self, memory: ArmOpMem) {
        let index = bit_and_words(memory.index()).0;
        self.base = bit_and_words(memory.base()).0;
        self.address = self.base | index;
        self.has_index = index != 0;
        self.displacement = memory.disp();
    }
}

fn flow(name: &str, operands: &Operands) -> Flow {
    match name {
        "b" | "cbz" | "cbnz" => Flow::Jump,
        "tbb" | "tbh" => Flow::Table,
        "bl" | "blx" => Flow::Call,
        "bx" if operands.read == LR => Flow::Return,
        "bx" => Flow::Jump,
        _ if operands.written & PC == 0 => Flow::On,
        _ if operands.address == SP || operands.read == LR => Flow::Return,
        // The compiler calls otherwise: it reaches a table of branches by this.
        "mov" => Flow::Table,
        _ => Flow::Jump,
    }
}

fn sets(address: u32, name: &str, operands: &Operands) -> Option<(usize, Source)> {
    let register = only(operands.written)?;
    // The program counter is two short instructions ahead, and its word is read.
    let base = (address & !0b11).wrapping_add(4);
    let source = match (name, operands.immediate) {
        // Capstone calls a short one "adr".
        ("adr" | "add", Some(ahead)) if operands.read & !PC == 0 => {
            Source::Constant(base.wrapping_add(ahead))
        }
        ("mov" | "movw", Some(value)) => Source::Constant(value),
        ("movt", Some(value)) => Source::UpperHalf(value),
        ("mov", None) if operands.words == 2 => Source::Register(only(operands.read)?),
        ("ldr", None) if operands.address == PC && !operands.has_index => {
            Source::Word(base.wrapping_add_signed(operands.displacement))
        }
        _ => return None,
    };
    Some((register, source))
}

fn stack(name: &str, operands: &Operands) -> u32 {
    match name {
        "push" | "vpush" => 4 * operands.words,
        "sub" | "subw" if operands.written == SP => operands.immediate.unwrap_or(0),
        _ if operands.writes_back && operands.address == SP => {
            operands.displacement.min(0).unsigned_abs()
        }
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(halves: [u16; 2]) -> Instruction {
        Instruction::decode(0x100, halves)
    }

    #[test]
    fn flow_is_distinguished() {
        for (halves, flow) in [
            // bne; cbz r0; b.w; bx r3; ldr pc, [r0, r1, lsl #2]; tbh [pc, r0]
            ([0xd11e, 0], Flow::Jump),
            ([0xb108, 0], Flow::Jump),
            ([0xf000, 0xbf26], Flow::Jump),
            ([0x4718, 0], Flow::Jump),
            ([0xf850, 0xf021], Flow::Jump),
            ([0xe8df, 0xf010], Flow::Table),
            // mov pc, r3
            ([0x469f, 0], Flow::Table),
            // bl; blx r3
            ([0xf01d, 0xfd21], Flow::Call),
            ([0x4798, 0], Flow::Call),
            // bx lr; pop {r7, pc}; pop.w {r4, r8, pc}; ldr pc, [sp], #4; mov pc, lr
            ([0x4770, 0], Flow::Return),
            ([0xbd80, 0], Flow::Return),
            ([0xe8bd, 0x8110], Flow::Return),
            ([0xf85d, 0xfb04], Flow::Return),
            ([0x46f7, 0], Flow::Return),
            // pop {r4}; msr primask, r4
            ([0xbc10, 0], Flow::On),
            ([0xf384, 0x8810], Flow::On),
        ] {
            assert_eq!(decode(halves).flow, flow, "{halves:x?}");
        }
        // b.n by -8
        assert_eq!(decode([0xe7fa, 0]).immediate, Some(0xf8));
    }

    #[test]
    fn stack_is_counted() {
        for (halves, bytes) in [
            // push {r4-r7, lr}; push.w {r4-fp, lr}; str fp, [sp, #-4]!; vpush {d8-d15}
            ([0xb5f0, 0], 20),
            ([0xe92d, 0x4ff0], 36),
            ([0xf84d, 0xbd04], 4),
            ([0xed2d, 0x8b10], 64),
            // sub sp, #12; sub.w sp, sp, #1280; subw sp, sp, #1132; add sp, #12
            ([0xb083, 0], 12),
            ([0xf5ad, 0x6da0], 1280),
            ([0xf2ad, 0x4d6c], 1132),
            ([0xb003, 0], 0),
            // str r0, [sp, #12]
            ([0x9003, 0], 0),
        ] {
            assert_eq!(decode(halves).stack, bytes, "{halves:x?}");
        }
    }

    #[test]
    fn registers_of_an_address_are_named() {
        // ldr.w r8, [r0, r1]; ldr r0, [pc, #4]; cmp r0, r1; sub sp, #4
        let load = decode([0xf850, 0x8001]);
        assert_eq!((load.address_from, load.writes), (0b11, 1 << 8));
        assert_eq!(decode([0x4801, 0]).address_from, 0);
        assert_eq!(decode([0x4288, 0]).writes, 0);
        assert_eq!(decode([0xb081, 0]).writes, SP);
    }

    #[test]
    fn values_known_from_the_code_are_distinguished() {
        for (halves, expected) in [
            // ldr r5, [pc, #76]; ldr.w r6, [pc, #-728]; ldr r5, [r1, #76]; ldrb.w r5, [pc, #8]
            ([0x4d13, 0], Some((5, Source::Word(0x150)))),
            (
                [0xf85f, 0x62d8],
                Some((6, Source::Word(0x104_u32.wrapping_sub(728)))),
            ),
            ([0x6ccd, 0], None),
            ([0xf89f, 0x5008], None),
            // movw r12, #0x1001; movt r12, #0x2000; movs r4, #1
            ([0xf241, 0x0c01], Some((12, Source::Constant(0x1001)))),
            ([0xf2c2, 0x0c00], Some((12, Source::UpperHalf(0x2000)))),
            ([0x2401, 0], Some((4, Source::Constant(1)))),
            // adr.w r2, #80; adr r2, #8; adds r2, #8
            ([0xf20f, 0x0250], Some((2, Source::Constant(0x154)))),
            ([0xa202, 0], Some((2, Source::Constant(0x10c)))),
            ([0x3208, 0], None),
            // mov r11, r3; lsls r4, r1, #2; mvn r4, #1; adds r4, #1
            ([0x469b, 0], Some((11, Source::Register(3)))),
            ([0x008c, 0], None),
            ([0xf06f, 0x0401], None),
            ([0x3401, 0], None),
            // vmov s1, r2; vmov r2, s1; umull r2, r3, r0, r1
            ([0xee00, 0x2a90], None),
            ([0xee10, 0x2a90], None),
            ([0xfba0, 0x2301], None),
        ] {
            assert_eq!(decode(halves).sets, expected, "{halves:x?}");
        }
        // The address of this one is no multiple of four: the word's is.
        let load = Instruction::decode(0x102, [0x4d13, 0]);
        assert_eq!(load.sets, Some((5, Source::Word(0x150))));
    }

    #[test]
    fn every_register_that_is_written_is_named() {
        for (halves, written) in [
            // vmov r2, s1; vmov r0, r1, s2, s3; umull r2, r3, r0, r1; ldrd r4, r5, [sp, #112]
            ([0xee10, 0x2a90], 1 << 2),
            ([0xec51, 0x0a11], 0b11),
            ([0xfba0, 0x2301], 0b1100),
            ([0xe9dd, 0x451c], 0b11_0000),
            // ldm.w r3, {r4, r5, r6}; pop {r4}; movt r12, #0x2000; mrs r4, primask
            ([0xe893, 0x0070], 0b111_0000),
            ([0xbc10, 0], 1 << 4),
            ([0xf2c2, 0x0c00], 1 << 12),
            ([0xf3ef, 0x8410], 1 << 4),
        ] {
            assert_eq!(decode(halves).writes & !SP, written, "{halves:x?}");
        }
    }

    #[test]
    fn a_branch_may_continue_and_an_it_makes_others_conditional() {
        // bne; cbz r0; b.w; bx r3
        let is_conditional = |halves| decode(halves).is_conditional;
        assert!(is_conditional([0xd11e, 0]) && is_conditional([0xb108, 0]));
        assert!(!is_conditional([0xf000, 0xbf26]) && !is_conditional([0x4718, 0]));
        // it ge; itttt eq; itte eq; nop; bx r3
        let conditions = |half| decode([half, 0]).conditions;
        assert_eq!([0xbfa8, 0xbf01, 0xbf06].map(conditions), [1, 4, 3]);
        assert_eq!([0xbf00, 0x4718].map(conditions), [0, 0]);
    }

    #[test]
    fn the_register_of_a_call_is_named() {
        // blx r3; bx r12; bx lr; bl; mov pc, r3
        let through = |halves| decode(halves).through;
        assert_eq!(through([0x4798, 0]), Some(3));
        assert_eq!(through([0x4760, 0]), Some(12));
        assert_eq!(through([0x4770, 0]), Some(14));
        assert_eq!(through([0xf01d, 0xfd21]), None);
        assert_eq!(through([0x469f, 0]), None);
    }

    #[test]
    fn the_register_of_a_table_is_named() {
        // tbh [pc, r0]; tbh [r2, r1, lsl #1]; tbb [r2, r1]; ldr r0, [r2]
        let table = |halves| decode(halves).table;
        assert_eq!(table([0xe8df, 0xf010]), None);
        assert_eq!(table([0xe8d2, 0xf011]), Some(2));
        assert_eq!(table([0xe8d2, 0xf001]), Some(2));
        assert_eq!(table([0x6810, 0]), None);
    }

    #[test]
    fn bytes_that_are_no_instruction_have_a_length() {
        assert_eq!(decode([0xffff, 0xffff]).length, 4);
    }
}
