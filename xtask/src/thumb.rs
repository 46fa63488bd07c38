//! Thumb-2 instructions of a Cortex-M4F as Capstone decodes them, reduced to their time, their stack and
//! their flow.

use capstone::arch::arm::{
    ArchExtraMode, ArchMode, ArmCC, ArmInsnDetail, ArmOpMem, ArmOperandType, ArmReg,
};
use capstone::prelude::*;

/// An instruction at its address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Instruction {
    pub(crate) address: u32,
    /// Bytes: 2 or 4.
    pub(crate) length: u32,
    /// Cycles by itself, without a refill of the pipeline, memory without wait states (Cortex-M4 TRM
    /// r0p1, tables 3-1 and 7-1).
    pub(crate) cycles: u32,
    pub(crate) unit: Unit,
    pub(crate) flow: Flow,
    /// Core registers that an address is made of, a bit each.
    pub(crate) address_from: u32,
    /// Core registers that it writes, a bit each.
    pub(crate) writes: u32,
    /// Registers of the FPU that it reads, a bit each.
    pub(crate) floats_read: u32,
    /// Registers of the FPU that it writes a cycle late, a bit each.
    pub(crate) floats_late: u32,
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

/// The unit that executes an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unit {
    /// The core, without memory.
    Core,
    /// A load of one register.
    Load,
    /// A store of one register.
    Store,
    /// A load or a store of several registers, or an exclusive one.
    Several,
    /// The FPU, its loads and stores included.
    Float,
}

/// The instruction after this one, unless its condition fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    /// The next in memory.
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
            cycles: 1,
            unit: Unit::Core,
            flow: Flow::On,
            address_from: 0,
            writes: 0,
            floats_read: 0,
            floats_late: 0,
            stack: 0,
            immediate: None,
            divides: false,
            is_conditional: false,
            // ARMv7-M Architecture Reference Manual, A7.7.38.
            conditions: match (first >> 8, first & 0xf) {
                (0xbf, mask @ 1..) => 4 - mask.trailing_zeros(),
                _ => 0,
            },
            sets: None,
            through: None,
            entry: 0,
            table: None,
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
        // Of the FPU's instructions it has some by older names.
        let name = match instruction.mnemonic()?.split('.').next() {
            Some(name) if name.starts_with('v') => name.to_owned(),
            _ => capstone.insn_name(instruction.id())?,
        };
        let detail = capstone.insn_detail(instruction).ok()?;
        let arm = detail.arch_detail();
        let arm = arm.arm()?;
        let operands = Operands::read(&name, arm);
        let unit = unit(&name);
        let is_always = matches!(arm.cc(), ArmCC::ARM_CC_AL | ArmCC::ARM_CC_INVALID);
        Some(Self {
            cycles: cycles(&name, unit, &operands),
            unit,
            flow: flow(&name, &operands),
            address_from: operands.address & !PC,
            writes: operands.written.core & !PC,
            floats_read: match &*name {
                "vstr" | "vpush" | "vstmia" | "vstmdb" => operands.registers.floats,
                _ if is_float_memory(&name) => 0,
                _ => operands.read.floats,
            },
            floats_late: if has_late_result(&name) {
                operands.written.floats
            } else {
                0
            },
            stack: stack(&name, unit, &operands),
            immediate: operands.immediate,
            divides: matches!(&*name, "sdiv" | "udiv" | "vdiv" | "vsqrt"),
            is_conditional: !is_always || matches!(&*name, "cbz" | "cbnz"),
            sets: sets(unknown.address, &name, &operands),
            through: only(operands.read.core).filter(|_| matches!(&*name, "bx" | "blx")),
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

/// Registers of the core and of the FPU in single precision, a bit each.
#[derive(Debug, Clone, Copy, Default)]
struct Registers {
    core: u32,
    floats: u32,
}

impl Registers {
    fn one(register: RegId) -> Self {
        let number = u32::from(register.0);
        let (core, floats) = match number {
            ArmReg::ARM_REG_SP => (SP, 0),
            ArmReg::ARM_REG_LR => (LR, 0),
            ArmReg::ARM_REG_PC => (PC, 0),
            ArmReg::ARM_REG_R0..=ArmReg::ARM_REG_R12 => (1 << (number - ArmReg::ARM_REG_R0), 0),
            ArmReg::ARM_REG_S0..=ArmReg::ARM_REG_S31 => (0, 1 << (number - ArmReg::ARM_REG_S0)),
            ArmReg::ARM_REG_D0..=ArmReg::ARM_REG_D15 => {
                (0, 0b11 << (2 * (number - ArmReg::ARM_REG_D0)))
            }
            _ => (0, 0),
        };
        Self { core, floats }
    }

    fn add(&mut self, other: Self) {
        self.core |= other.core;
        self.floats |= other.floats;
    }

    fn count(self) -> u32 {
        self.core.count_ones() + self.floats.count_ones()
    }
}

/// The operands of an instruction.
#[derive(Debug, Default)]
struct Operands {
    read: Registers,
    written: Registers,
    /// Registers that are no part of an address, and their number.
    registers: Registers,
    count: u32,
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
                    found.address = Registers::one(register).core;
                }
                ArmOperandType::Reg(register) => {
                    let register = Registers::one(register);
                    let access = operand.access;
                    found.registers.add(register);
                    found.count += register.count();
                    if access.is_some_and(|access| access.is_readable()) {
                        found.read.add(register);
                    }
                    if access.is_some_and(|access| access.is_writable()) {
                        found.written.add(register);
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
        let index = Registers::one(memory.index()).core;
        self.base = Registers::one(memory.base()).core;
        self.address = self.base | index;
        self.has_index = index != 0;
        self.displacement = memory.disp();
    }
}

fn unit(name: &str) -> Unit {
    let is = |beginnings: &[&str]| beginnings.iter().any(|begin| name.starts_with(begin));
    if is(&["v"]) {
        Unit::Float
    } else if is(&[
        "push", "pop", "ldm", "stm", "ldrd", "strd", "ldrex", "strex", "tb",
    ]) {
        Unit::Several
    } else if is(&["ldr"]) {
        Unit::Load
    } else if is(&["str"]) {
        Unit::Store
    } else {
        Unit::Core
    }
}

fn cycles(name: &str, unit: Unit, operands: &Operands) -> u32 {
    match name {
        // The most of a range.
        "sdiv" | "udiv" => 12,
        "mrs" | "msr" | "cps" => 2,
        // Refills the pipeline.
        "isb" => 3,
        // Two for the load, one for the addition, and the branch; nothing overlaps.
        "tbb" | "tbh" => 4,
        "vdiv" | "vsqrt" => 14,
        "vmla" | "vmls" | "vnmla" | "vnmls" | "vfma" | "vfms" | "vfnma" | "vfnms" => 3,
        "vmov" if operands.registers.core.count_ones() == 2 => 2,
        _ if name.contains("rex") => 2,
        _ if unit == Unit::Several || is_float_memory(name) => 1 + operands.count,
        _ if unit == Unit::Load => 2,
        // Its address is made in its only cycle, unless it is made of two registers.
        _ if unit == Unit::Store && operands.has_index => 2,
        _ => 1,
    }
}

fn is_float_memory(name: &str) -> bool {
    ["vldr", "vstr", "vldm", "vstm", "vpush", "vpop"]
        .iter()
        .any(|begin| name.starts_with(begin))
}

/// True for arithmetic of the FPU.
fn has_late_result(name: &str) -> bool {
    !is_float_memory(name) && !matches!(name, "vmov" | "vabs" | "vneg")
}

fn flow(name: &str, operands: &Operands) -> Flow {
    match name {
        "b" | "cbz" | "cbnz" => Flow::Jump,
        "tbb" | "tbh" => Flow::Table,
        "bl" | "blx" => Flow::Call,
        "bx" if operands.read.core == LR => Flow::Return,
        "bx" => Flow::Jump,
        _ if operands.written.core & PC == 0 => Flow::On,
        _ if operands.address == SP || operands.read.core == LR => Flow::Return,
        // The compiler calls otherwise: it reaches a table of branches by this.
        "mov" => Flow::Table,
        _ => Flow::Jump,
    }
}

fn sets(address: u32, name: &str, operands: &Operands) -> Option<(usize, Source)> {
    let register = only(operands.written.core)?;
    // The program counter is two short instructions ahead, and its word is read.
    let base = (address & !0b11).wrapping_add(4);
    let source = match (name, operands.immediate) {
        // Capstone calls a short one "adr".
        ("adr" | "add", Some(ahead)) if operands.read.core & !PC == 0 => {
            Source::Constant(base.wrapping_add(ahead))
        }
        ("mov" | "movw", Some(value)) => Source::Constant(value),
        ("movt", Some(value)) => Source::UpperHalf(value),
        ("mov", None) if operands.count == 2 => Source::Register(only(operands.read.core)?),
        ("ldr", None) if operands.address == PC && !operands.has_index => {
            Source::Word(base.wrapping_add_signed(operands.displacement))
        }
        _ => return None,
    };
    Some((register, source))
}

fn stack(name: &str, unit: Unit, operands: &Operands) -> u32 {
    match name {
        "push" | "vpush" => 4 * operands.count,
        "sub" | "subw" if operands.written.core == SP => operands.immediate.unwrap_or(0),
        _ if unit != Unit::Core && operands.writes_back && operands.address == SP => {
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
    fn cycles_are_those_of_the_manual() {
        for (halves, cycles) in [
            // adds r6, r0, r1; mla r1, r8, r1, r0; udiv r0, r1, r2; it ge
            ([0x1846, 0], 1),
            ([0xfb08, 0x0101], 1),
            ([0xfbb1, 0xf0f2], 12),
            ([0xbfa4, 0], 1),
            // cpsid i; mrs r4, primask; msr primask, r4; isb sy; dmb sy
            ([0xb672, 0], 2),
            ([0xf3ef, 0x8410], 2),
            ([0xf384, 0x8810], 2),
            ([0xf3bf, 0x8f6f], 3),
            ([0xf3bf, 0x8f5f], 1),
            // ldr r0, [r1]; str r0, [r1]; str r0, [r1, r2]; pld [r0]
            ([0x6808, 0], 2),
            ([0x6008, 0], 1),
            ([0x5088, 0], 2),
            ([0xf890, 0xf000], 1),
            // push {r4-r7, lr}; stm r0!, {r1-r3}; strd r8, r8, [sp]; ldrex r0, [r1]; tbh [pc, r0]
            ([0xb5f0, 0], 6),
            ([0xc00e, 0], 4),
            ([0xe9cd, 0x880e], 3),
            ([0xe851, 0x0f00], 2),
            ([0xe8df, 0xf010], 4),
            // vadd.f32; vfma.f32; vdiv.f32; vsqrt.f32; vmrs; vmov s1, r2; vmov r0, r1, s2, s3
            ([0xee30, 0x0a81], 1),
            ([0xeea0, 0x0a81], 3),
            ([0xee80, 0x0a81], 14),
            ([0xeeb1, 0x0ae0], 14),
            ([0xeef1, 0xfa10], 1),
            ([0xee00, 0x2a90], 1),
            ([0xec51, 0x0a11], 2),
            // vldr s0; vldr d0; vpush {d8-d11}; vstmia r0, {s0-s2}
            ([0xed91, 0x0a01], 2),
            ([0xed91, 0x0b02], 3),
            ([0xed2d, 0x8b08], 9),
            ([0xec80, 0x0a03], 4),
        ] {
            assert_eq!(decode(halves).cycles, cycles, "{halves:x?}");
        }
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
    fn registers_that_a_neighbour_waits_for_are_named() {
        // ldr.w r8, [r0, r1]; ldr r0, [pc, #4]; cmp r0, r1; sub sp, #4
        let load = decode([0xf850, 0x8001]);
        assert_eq!((load.address_from, load.writes), (0b11, 1 << 8));
        assert_eq!(decode([0x4801, 0]).address_from, 0);
        assert_eq!(decode([0x4288, 0]).writes, 0);
        assert_eq!(decode([0xb081, 0]).writes, SP);
        // vfma.f32 s0, s1, s2; vabs.f32 s0, s1; vmov.f32 s0, #1.0; vstr d1, [r1]; vldr s0, [r1]
        let floats = |halves| {
            let instruction = decode(halves);
            assert_eq!(instruction.unit, Unit::Float);
            (instruction.floats_read, instruction.floats_late)
        };
        assert_eq!(floats([0xeea0, 0x0a81]), (0b111, 0b001));
        assert_eq!(floats([0xeeb0, 0x0ae0]), (0b010, 0));
        assert_eq!(floats([0xeeb7, 0x0a00]), (0, 0));
        assert_eq!(floats([0xed81, 0x1b00]), (0b1100, 0));
        assert_eq!(floats([0xed91, 0x0a01]), (0, 0));
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
    fn a_condition_ends_with_its_block() {
        // itttt eq, and then elsewhere: vfma.f32
        assert_eq!(decode([0xbf01, 0]).flow, Flow::On);
        assert_eq!(decode([0xeea0, 0x0a81]).cycles, 3);
    }

    #[test]
    fn bytes_that_are_no_instruction_have_a_length() {
        assert_eq!(decode([0xffff, 0xffff]).length, 4);
    }
}
