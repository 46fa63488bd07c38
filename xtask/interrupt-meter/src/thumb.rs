//! What an instruction is, as far as its time goes: Thumb-2 of the ARMv7E-M with the single-precision
//! FPv4 (ARMv7-M Architecture Reference Manual, A5 and A6), with the cycles of the Cortex-M4 TRM r0p1,
//! tables 3-1 and 7-1.

/// An instruction at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Instruction {
    pub(crate) address: u32,
    /// Bytes: 2 or 4.
    pub(crate) length: u32,
    pub(crate) effect: Effect,
}

/// What an instruction does that takes time or makes a neighbour wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Effect {
    /// Cycles by itself, without a refill of the pipeline, memory without wait states.
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
}

/// Who executes it.
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

/// Where it may lead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    /// On to the next.
    On,
    /// Perhaps elsewhere.
    Jump,
    /// Perhaps into a function.
    Call,
    /// Perhaps out of a function.
    Return,
}

/// Stack pointer, link register and program counter.
const SP: u32 = 13;
const LR: u32 = 14;
const PC: u32 = 15;

impl Instruction {
    /// From its half-words; the second of a short one does not matter.
    pub(crate) fn decode(address: u32, first: u16, second: u16) -> Self {
        let (first, second) = (u32::from(first), u32::from(second));
        let (length, effect) = if is_wide(first) {
            (4, wide(first, second))
        } else {
            (2, narrow(first))
        };
        Self {
            address,
            length,
            effect,
        }
    }

    /// Where the next one is, unless this one leads elsewhere.
    pub(crate) fn end(&self) -> u32 {
        self.address.wrapping_add(self.length)
    }
}

impl Effect {
    /// A cycle of the core, and nothing that anybody waits for.
    const ONE: Self = Self {
        cycles: 1,
        unit: Unit::Core,
        flow: Flow::On,
        address_from: 0,
        writes: 0,
        floats_read: 0,
        floats_late: 0,
    };

    fn leading(flow: Flow) -> Self {
        Self { flow, ..Self::ONE }
    }

    fn computing(writes: u32) -> Self {
        Self {
            writes,
            ..Self::ONE
        }
    }

    fn taking(self, cycles: u32) -> Self {
        Self { cycles, ..self }
    }

    fn load(writes: u32, address_from: u32) -> Self {
        Self {
            cycles: 2,
            unit: Unit::Load,
            writes,
            address_from,
            ..Self::ONE
        }
    }

    /// The address of a store is made in its only cycle, unless it is made of two registers.
    fn store(address_from: u32) -> Self {
        Self {
            cycles: if address_from.count_ones() > 1 { 2 } else { 1 },
            unit: Unit::Store,
            address_from,
            ..Self::ONE
        }
    }

    fn several(registers: u32, base: u32) -> Self {
        Self {
            cycles: 1 + registers,
            unit: Unit::Several,
            address_from: bit(base),
            ..Self::ONE
        }
    }

    fn float(cycles: u32, floats_read: u32, floats_late: u32) -> Self {
        Self {
            cycles,
            unit: Unit::Float,
            floats_read,
            floats_late,
            ..Self::ONE
        }
    }
}

/// Whether a half-word begins an instruction of two.
pub(crate) fn is_wide(first: u32) -> bool {
    first >> 11 >= 0b11101
}

fn bit(register: u32) -> u32 {
    1 << register
}

/// A result in the core: none where the field says the program counter, as in a comparison.
fn result(register: u32) -> u32 {
    if register == PC { 0 } else { bit(register) }
}

fn narrow(code: u32) -> Effect {
    let low = |shift: u32| bit(code >> shift & 7);
    match code >> 12 {
        // Shifts, additions and subtractions.
        0x0 | 0x1 => Effect::computing(low(0)),
        // CMP with an immediate has no result.
        0x2 | 0x3 if code & 0x1800 == 0x0800 => Effect::ONE,
        0x2 | 0x3 => Effect::computing(low(8)),
        0x4 if code & 0x0800 != 0 => Effect::load(low(8), 0),
        0x4 if code & 0x0400 == 0 => match code >> 6 & 0xf {
            // TST, CMP, CMN.
            8 | 10 | 11 => Effect::ONE,
            _ => Effect::computing(low(0)),
        },
        0x4 => narrow_high(code),
        // An offset in a register.
        0x5 if code >> 9 & 7 < 3 => Effect::store(low(3) | low(6)),
        0x5 => Effect::load(low(0), low(3) | low(6)),
        0x6..=0x9 => {
            let of_stack = code >> 12 == 0x9;
            let (value, base) = if of_stack {
                (low(8), bit(SP))
            } else {
                (low(0), low(3))
            };
            if code & 0x0800 == 0 {
                Effect::store(base)
            } else {
                Effect::load(value, base)
            }
        }
        0xa => Effect::computing(low(8)),
        0xb => narrow_miscellaneous(code),
        0xc => Effect::several((code & 0xff).count_ones(), code >> 8 & 7),
        _ => Effect::leading(Flow::Jump),
    }
}

/// ADD, CMP, MOV, BX and BLX with any register.
fn narrow_high(code: u32) -> Effect {
    let target = code >> 4 & 8 | code & 7;
    let source = code >> 3 & 0xf;
    let leading = Effect::leading(if source == LR {
        Flow::Return
    } else {
        Flow::Jump
    });
    match code >> 8 & 3 {
        1 => Effect::ONE,
        3 if code & 0x80 != 0 => Effect::leading(Flow::Call),
        3 => leading,
        _ if target == PC => leading,
        _ => Effect::computing(bit(target)),
    }
}

fn narrow_miscellaneous(code: u32) -> Effect {
    let registers = (code & 0x1ff).count_ones();
    match code >> 8 & 0xf {
        0x0 => Effect::computing(bit(SP)),
        // CBZ, CBNZ.
        0x1 | 0x3 | 0x9 | 0xb => Effect::leading(Flow::Jump),
        // Extensions and reversals.
        0x2 | 0xa => Effect::computing(bit(code & 7)),
        // PUSH, POP.
        0x4 | 0x5 | 0xc => Effect::several(registers, SP),
        0xd => Effect {
            flow: Flow::Return,
            ..Effect::several(registers, SP)
        },
        // CPS takes one or two.
        0x6 => Effect::ONE.taking(2),
        // Hints, IT.
        _ => Effect::ONE,
    }
}

fn wide(first: u32, second: u32) -> Effect {
    let [base, high, low] = [first & 0xf, second >> 12, second >> 8 & 0xf];
    match first >> 9 & 0xf {
        // 1110 100x: several registers, exclusive, tables.
        0x4 if first & 0x40 == 0 => wide_several(first, second),
        0x4 if first & 0xfff0 == 0xe8d0 && second & 0xffe0 == 0xf000 => {
            // TBB, TBH: two for the load, one for the addition, and the branch; nothing pipelines.
            Effect {
                cycles: 4,
                unit: Unit::Several,
                address_from: bit(base) | bit(second & 0xf),
                ..Effect::leading(Flow::Jump)
            }
        }
        // Exclusive ones: 2.
        0x4 if first & 0x0120 == 0 => Effect::several(1, base),
        // LDRD, STRD.
        0x4 => Effect {
            writes: if first & 0x10 == 0 {
                0
            } else {
                result(high) | result(low)
            },
            ..Effect::several(2, base)
        },
        // 1110 101x: computing with a shifted register.
        0x5 => Effect::computing(result(low)),
        // 111x 11xx: the FPU.
        0x6 | 0x7 | 0xe | 0xf => float(first, second),
        // 1111 0xxx: computing with an immediate, branches, control.
        0x8..=0xb if second & 0x8000 == 0 => Effect::computing(result(low)),
        0x8..=0xb => wide_control(first, second),
        // 1111 100x: loads and stores of one register.
        0xc if first & 0x10 == 0 => Effect::store(single_address(first, second)),
        0xc if high == PC && first & 0x60 != 0x40 => Effect::ONE,
        0xc if high == PC => Effect {
            flow: if base == SP { Flow::Return } else { Flow::Jump },
            ..Effect::load(0, single_address(first, second))
        },
        0xc => Effect::load(bit(high), single_address(first, second)),
        // 1111 101x: computing with registers, multiplying, dividing.
        _ if first & 0xffd0 == 0xfb90 && second & 0xf0 == 0xf0 => {
            Effect::computing(result(low)).taking(12)
        }
        _ if first & 0xff80 == 0xfb80 => Effect::computing(result(high) | result(low)),
        _ => Effect::computing(result(low)),
    }
}

/// What the address of a load or a store of one register is made of.
fn single_address(first: u32, second: u32) -> u32 {
    let base = first & 0xf;
    let by_register = first & 0x80 == 0 && second & 0x0fc0 == 0 && base != PC;
    let offset = if by_register { bit(second & 0xf) } else { 0 };
    result(base) | offset
}

/// LDM and STM, PUSH and POP of any register.
fn wide_several(first: u32, second: u32) -> Effect {
    let base = first & 0xf;
    let leads = first & 0x10 != 0 && second & bit(PC) != 0;
    Effect {
        flow: match (leads, base) {
            (false, _) => Flow::On,
            (true, SP) => Flow::Return,
            (true, _) => Flow::Jump,
        },
        ..Effect::several(second.count_ones(), base)
    }
}

/// Branches, barriers and special registers.
fn wide_control(first: u32, second: u32) -> Effect {
    match second >> 12 & 0b101 {
        // BL.
        0b101 => Effect::leading(Flow::Call),
        // B with a long way.
        0b001 => Effect::leading(Flow::Jump),
        0b000 if first >> 7 & 7 != 7 => Effect::leading(Flow::Jump),
        // MSR and MRS take one or two.
        0b000 if first & 0xffe0 == 0xf380 => Effect::ONE.taking(2),
        0b000 if first & 0xffe0 == 0xf3e0 => Effect::computing(result(second >> 8 & 0xf)).taking(2),
        // ISB refills the pipeline.
        0b000 if first == 0xf3bf && second & 0xf0 == 0x60 => Effect::ONE.taking(1 + 2),
        _ => Effect::ONE,
    }
}

/// Registers of single precision in the fields of an instruction of the FPU.
fn floats(first: u32, second: u32) -> [u32; 3] {
    let register = |four: u32, one: u32| bit((four & 0xf) << 1 | one & 1);
    [
        register(second >> 12, first >> 6),
        register(first, second >> 7),
        register(second, second >> 5),
    ]
}

fn float(first: u32, second: u32) -> Effect {
    let [d, n, m] = floats(first, second);
    if first & 0x0200 == 0 {
        return float_memory(first, second);
    }
    if second & 0x10 != 0 {
        // VMOV between a core register and one of the FPU; VMRS and VMSR read none.
        let to_core = first & 0x10 != 0;
        let special = first & 0xe0 == 0xe0;
        let reads = if to_core && !special { n } else { 0 };
        return Effect {
            writes: if to_core { result(second >> 12) } else { 0 },
            ..Effect::float(1, reads, 0)
        };
    }
    match first >> 4 & 0b1011 {
        // VMLA, VMLS, VNMLA, VNMLS; VFMA, VFMS, VFNMA, VFNMS.
        0b0000 | 0b0001 | 0b1001 | 0b1010 => Effect::float(3, d | n | m, d),
        // VMUL, VNMUL; VADD, VSUB.
        0b0010 | 0b0011 => Effect::float(1, n | m, d),
        // VDIV.
        0b1000 => Effect::float(14, n | m, d),
        // VMOV of an immediate.
        _ if second & 0x40 == 0 => Effect::float(1, 0, 0),
        _ => match (first & 0xf, second >> 7 & 1) {
            // VSQRT.
            (1, 1) => Effect::float(14, m, d),
            // VMOV, VABS, VNEG.
            (0 | 1, _) => Effect::float(1, m, 0),
            // VCMP with a register or with zero.
            (4, _) => Effect::float(1, d | m, 0),
            (5, _) => Effect::float(1, d, 0),
            // Conversions between fixed and floating point read what they write.
            (0xa | 0xb | 0xe | 0xf, _) => Effect::float(1, d, d),
            // VCVT.
            _ => Effect::float(1, m, d),
        },
    }
}

/// Loads and stores of the FPU, and its moves of two registers at once.
fn float_memory(first: u32, second: u32) -> Effect {
    let base = first & 0xf;
    let words = second & 0xff;
    let to_core_or_load = first & 0x10 != 0;
    let two = |start: u32| 0b11 << start.min(30);
    let is_pair = second & 0x100 != 0;
    if first & 0xffe0 == 0xec40 {
        let start = if is_pair {
            (second & 0xf) << 1
        } else {
            (second & 0xf) << 1 | second >> 5 & 1
        };
        return Effect {
            writes: if to_core_or_load {
                bit(second >> 12) | bit(base)
            } else {
                0
            },
            ..Effect::float(2, if to_core_or_load { two(start) } else { 0 }, 0)
        };
    }
    let [d, ..] = floats(first, second);
    let is_one = first & 0x0120 == 0x0100;
    let read = match (to_core_or_load, is_one, is_pair) {
        (true, ..) => 0,
        (false, true, false) => d,
        (false, true, true) => two(second >> 11 & 0x1e),
        // Any of them may be the late one.
        (false, false, _) => u32::MAX,
    };
    let cycles = match (is_one, is_pair) {
        (true, false) => 2,
        (true, true) => 3,
        (false, _) => 1 + words,
    };
    Effect {
        address_from: result(base),
        ..Effect::float(cycles, read, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn short(code: u16) -> Effect {
        let instruction = Instruction::decode(0x100, code, 0);
        assert_eq!(instruction.end(), 0x102);
        instruction.effect
    }

    fn long(first: u16, second: u16) -> Effect {
        let instruction = Instruction::decode(0x100, first, second);
        assert_eq!(instruction.end(), 0x104);
        instruction.effect
    }

    #[test]
    fn computing_takes_a_cycle_and_says_where_the_result_is() {
        let results = [
            // movs r6, #0; cmp r0, #12; adds r6, r0, r1; muls r1, r2; cmp r0, r1
            (short(0x2600), 1 << 6),
            (short(0x280c), 0),
            (short(0x1846), 1 << 6),
            (short(0x4351), 1 << 1),
            (short(0x4288), 0),
            // mov r8, r1; cmp r8, r1; add r5, sp, #16; sub sp, #4; uxtb r0, r0
            (short(0x4688), 1 << 8),
            (short(0x4588), 0),
            (short(0xad04), 1 << 5),
            (short(0xb081), 1 << 13),
            (short(0xb2c0), 1 << 0),
            // itt ge; nop
            (short(0xbfa4), 0),
            (short(0xbf00), 0),
            // sub.w sp, sp, #6016; movw r1, #3088; cmp.w r9, #6; eor.w r0, r1, r0, lsr #7
            (long(0xf5ad, 0x5dbc), 1 << 13),
            (long(0xf640, 0x4110), 1 << 1),
            (long(0xf1b9, 0x0f06), 0),
            (long(0xea81, 0x10d0), 1 << 0),
            // mla r1, r8, r1, r0; umull r0, r1, r2, r3; sxtah r5, r2, r0
            (long(0xfb08, 0x0101), 1 << 1),
            (long(0xfba2, 0x0103), 0b11),
            (long(0xfa02, 0xf580), 1 << 5),
            // dmb sy
            (long(0xf3bf, 0x8f5f), 0),
        ];
        for (at, (effect, writes)) in results.into_iter().enumerate() {
            assert_eq!(effect, Effect::computing(writes), "number {at}");
        }
    }

    #[test]
    fn what_takes_longer_takes_the_longest_that_the_manual_says() {
        // udiv r0, r1, r2; sdiv r0, r1, r2
        assert_eq!(long(0xfbb1, 0xf0f2), Effect::computing(1).taking(12));
        assert_eq!(long(0xfb91, 0xf0f2), Effect::computing(1).taking(12));
        // cpsid i; mrs r4, primask; msr primask, r4; isb sy
        assert_eq!(short(0xb672).cycles, 2);
        assert_eq!(long(0xf3ef, 0x8410), Effect::computing(1 << 4).taking(2));
        assert_eq!(long(0xf384, 0x8810).cycles, 2);
        assert_eq!(long(0xf3bf, 0x8f6f).cycles, 3);
    }

    #[test]
    fn loads_and_stores_say_what_their_address_is_made_of() {
        // ldr r0, [r1]; str r0, [r1]; ldr r0, [sp, #12]; str r0, [sp, #12]; ldr r0, [pc, #4]
        assert_eq!(short(0x6808), Effect::load(1, 1 << 1));
        assert_eq!(short(0x6008), Effect::store(1 << 1));
        assert_eq!(short(0x9803), Effect::load(1, 1 << 13));
        assert_eq!(short(0x9003), Effect::store(1 << 13));
        assert_eq!(short(0x4801), Effect::load(1, 0));
        // ldrsh r0, [r1, r2]; str r0, [r1, r2], which makes its address first
        assert_eq!(short(0x5e88), Effect::load(1, 0b110));
        assert_eq!(short(0x5088), Effect::store(0b110));
        assert_eq!(short(0x5088).cycles, 2);
        // ldr.w r8, [r0, r1]; ldr.w r6, [r11, #2760]; str.w r0, [r11, #2760]; ldr r0, [lr, #-8]
        assert_eq!(long(0xf850, 0x8001), Effect::load(1 << 8, 0b11));
        assert_eq!(long(0xf8db, 0x6ac8), Effect::load(1 << 6, 1 << 11));
        assert_eq!(long(0xf8cb, 0x0ac8), Effect::store(1 << 11));
        assert_eq!(long(0xf85e, 0x0c08), Effect::load(1, 1 << 14));
        // ldrb.w r0, [r11, #2944]; pld [r0] loads nothing
        assert_eq!(long(0xf89b, 0x0b80), Effect::load(1, 1 << 11));
        assert_eq!(long(0xf890, 0xf000), Effect::ONE);
    }

    #[test]
    fn several_registers_take_a_cycle_more_than_they_are() {
        // push {r4-r7, lr}; push.w {r8-r11}; stm r0!, {r1-r3}; ldm.w r1, {r2, r3, r12}
        assert_eq!(short(0xb5f0), Effect::several(5, SP));
        assert_eq!(long(0xe92d, 0x0f00), Effect::several(4, SP));
        assert_eq!(short(0xc00e), Effect::several(3, 0));
        assert_eq!(long(0xe891, 0x100c), Effect::several(3, 1));
        // strd r9, r4, [r11]; ldrd r0, r1, [sp, #8]
        assert_eq!(long(0xe9cb, 0x9400), Effect::several(2, 11));
        let pair = long(0xe9dd, 0x0102);
        assert_eq!((pair.cycles, pair.writes), (3, 0b11));
        // ldrexb r0, [r1]; strexb r2, r0, [r1]; ldrex r0, [r1]
        assert_eq!(long(0xe8d1, 0x0f4f).cycles, 2);
        assert_eq!(long(0xe8c1, 0x0f42).cycles, 2);
        assert_eq!(long(0xe851, 0x0f00).cycles, 2);
    }

    #[test]
    fn branches_calls_and_returns_are_told_apart() {
        let flows = [
            // bne; b; cbz r0; b.w; beq.w; bx r3
            (short(0xd11e), Flow::Jump),
            (short(0xe000), Flow::Jump),
            (short(0xb108), Flow::Jump),
            (long(0xf000, 0xbf26), Flow::Jump),
            (long(0xf000, 0x8724), Flow::Jump),
            (short(0x4718), Flow::Jump),
            // bl; blx r3
            (long(0xf01d, 0xfd21), Flow::Call),
            (short(0x4798), Flow::Call),
            // bx lr; pop {r7, pc}; pop.w {r4, r8, pc}; ldr pc, [sp], #4; mov pc, lr
            (short(0x4770), Flow::Return),
            (short(0xbd80), Flow::Return),
            (long(0xe8bd, 0x8110), Flow::Return),
            (long(0xf85d, 0xfb04), Flow::Return),
            (short(0x46f7), Flow::Return),
            // pop {r4}; pop.w {r8, r9}; bl's neighbour msr
            (short(0xbc10), Flow::On),
            (long(0xe8bd, 0x0300), Flow::On),
            (long(0xf384, 0x8810), Flow::On),
            // ldr pc, [r0, r1, lsl #2]
            (long(0xf850, 0xf021), Flow::Jump),
        ];
        for (at, (effect, flow)) in flows.into_iter().enumerate() {
            assert_eq!(effect.flow, flow, "number {at}");
        }
        // tbh [pc, r0, lsl #1]
        let table = long(0xe8df, 0xf010);
        assert_eq!((table.flow, table.cycles), (Flow::Jump, 4));
    }

    #[test]
    fn the_unit_for_floats_takes_what_its_table_says() {
        let s = |register: u32| 1 << register;
        let cases = [
            // vadd.f32 s0, s1, s2; vsub.f32 s0, s1, s2; vmul.f32 s0, s1, s2; vnmul.f32 s0, s1, s2
            (long(0xee30, 0x0a81), Effect::float(1, s(1) | s(2), s(0))),
            (long(0xee30, 0x0ac1), Effect::float(1, s(1) | s(2), s(0))),
            (long(0xee20, 0x0a81), Effect::float(1, s(1) | s(2), s(0))),
            (long(0xee20, 0x0ac1), Effect::float(1, s(1) | s(2), s(0))),
            // vmla.f32 s0, s1, s2; vnmls.f32 s0, s1, s2; vfma.f32 s0, s1, s2
            (
                long(0xee00, 0x0a81),
                Effect::float(3, s(0) | s(1) | s(2), s(0)),
            ),
            (
                long(0xee10, 0x0a81),
                Effect::float(3, s(0) | s(1) | s(2), s(0)),
            ),
            (
                long(0xeea0, 0x0a81),
                Effect::float(3, s(0) | s(1) | s(2), s(0)),
            ),
            // vdiv.f32 s0, s1, s2; vsqrt.f32 s0, s1
            (long(0xee80, 0x0a81), Effect::float(14, s(1) | s(2), s(0))),
            (long(0xeeb1, 0x0ae0), Effect::float(14, s(1), s(0))),
            // vmov.f32 s0, s1; vabs.f32 s0, s1; vneg.f32 s0, s1; vmov.f32 s0, #1.0
            (long(0xeeb0, 0x0a60), Effect::float(1, s(1), 0)),
            (long(0xeeb0, 0x0ae0), Effect::float(1, s(1), 0)),
            (long(0xeeb1, 0x0a60), Effect::float(1, s(1), 0)),
            (long(0xeeb7, 0x0a00), Effect::float(1, 0, 0)),
            // vcmp.f32 s0, s1; vcmp.f32 s0, #0; vcvt.f32.s32 s0, s1; vcvt.s32.f32 s0, s1
            (long(0xeeb4, 0x0a60), Effect::float(1, s(0) | s(1), 0)),
            (long(0xeeb5, 0x0a40), Effect::float(1, s(0), 0)),
            (long(0xeeb8, 0x0ae0), Effect::float(1, s(1), s(0))),
            (long(0xeebd, 0x0ae0), Effect::float(1, s(1), s(0))),
            // vmrs APSR_nzcv, fpscr; vmov s1, r2
            (long(0xeef1, 0xfa10), Effect::float(1, 0, 0)),
            (long(0xee00, 0x2a90), Effect::float(1, 0, 0)),
        ];
        for (at, (effect, expected)) in cases.into_iter().enumerate() {
            assert_eq!(effect, expected, "number {at}");
        }
        // vmov r2, s1 reads it, and vmov r0, r1, s2, s3 both
        let one = long(0xee10, 0x2a90);
        assert_eq!((one.cycles, one.floats_read, one.writes), (1, s(1), 1 << 2));
        let two = long(0xec51, 0x0a11);
        assert_eq!(
            (two.cycles, two.floats_read, two.writes),
            (2, s(2) | s(3), 3)
        );
        // vmov d1, r0, r1
        assert_eq!(long(0xec41, 0x0b11).floats_read, 0);
    }

    #[test]
    fn floats_are_loaded_and_stored() {
        // vldr s0, [r1, #4]; vldr d0, [r1, #8]; vstr s3, [r1]; vstr d1, [r1]
        let of = |effect: Effect| (effect.cycles, effect.address_from, effect.floats_read);
        assert_eq!(of(long(0xed91, 0x0a01)), (2, 1 << 1, 0));
        assert_eq!(of(long(0xed91, 0x0b02)), (3, 1 << 1, 0));
        assert_eq!(of(long(0xedc1, 0x1a00)), (2, 1 << 1, 1 << 3));
        assert_eq!(of(long(0xed81, 0x1b00)), (3, 1 << 1, 0b1100));
        // vpush {d8-d11}; vpop {d8-d11}; vstmia r0, {s0-s2}; vldr s0, [pc, #4]
        assert_eq!(of(long(0xed2d, 0x8b08)), (9, 1 << 13, u32::MAX));
        assert_eq!(of(long(0xecbd, 0x8b08)), (9, 1 << 13, 0));
        assert_eq!(of(long(0xec80, 0x0a03)), (4, 1 << 0, u32::MAX));
        assert_eq!(of(long(0xed9f, 0x0a01)), (2, 0, 0));
    }
}
