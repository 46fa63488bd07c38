//! Addresses of the STM32G474's registers, and the fields that only it has at their places (RM0440). The chapter is
//! given with each peripheral, by its abbreviation there, because its numbers differ from revision to revision.

use crate::bus::Register;

/// Reset and clock control (RCC).
pub(crate) mod rcc {
    use super::Register;
    pub(crate) use crate::registers::rcc::*;

    const BASE: Register = Register::at(0x4002_1000);
    pub(crate) const CR: Register = BASE;
    pub(crate) const CFGR: Register = BASE.offset(0x08);
    pub(crate) const PLLCFGR: Register = BASE.offset(0x0c);
    pub(crate) const CIFR: Register = BASE.offset(0x1c);
    pub(crate) const AHB1RSTR: Register = BASE.offset(0x28);
    pub(crate) const AHB2RSTR: Register = BASE.offset(0x2c);
    pub(crate) const APB1RSTR1: Register = BASE.offset(0x38);
    pub(crate) const APB2RSTR: Register = BASE.offset(0x40);
    pub(crate) const AHB1ENR: Register = BASE.offset(0x48);
    pub(crate) const AHB2ENR: Register = BASE.offset(0x4c);
    pub(crate) const APB1ENR1: Register = BASE.offset(0x58);
    pub(crate) const APB2ENR: Register = BASE.offset(0x60);
    pub(crate) const CSR: Register = BASE.offset(0x94);

    pub(crate) const CFGR_SW_HSI: u32 = 0b01;
    pub(crate) const CFGR_SW_PLL: u32 = 0b11;
    pub(crate) const CFGR_SWS_HSI: u32 = 0b01 << 2;
    pub(crate) const CFGR_SWS_PLL: u32 = 0b11 << 2;
    pub(crate) const CFGR_PRESCALERS: u32 = 0xf << 4 | 0b111 << 8 | 0b111 << 11;
    pub(crate) const CFGR_HPRE: u32 = 0xf << 4;
    pub(crate) const CFGR_HPRE_2: u32 = 0b1000 << 4;

    /// Source, M, N, R, and the outputs P, Q and R; other bits keep their reset value.
    pub(crate) const PLLCFGR_FACTORS: u32 =
        0b11 | 0xf << 4 | 0x7f << 8 | 1 << 16 | 1 << 20 | 1 << 24 | 0b11 << 25;
    pub(crate) const PLLCFGR_HSE: u32 = 0b11;
    pub(crate) const PLLCFGR_M: u32 = 4;
    pub(crate) const PLLCFGR_N: u32 = 8;
    pub(crate) const PLLCFGR_REN: u32 = 1 << 24;
    pub(crate) const PLLCFGR_R_2: u32 = 0;

    /// The oscillator has failed.
    pub(crate) const CIFR_CSSF: u32 = 1 << 8;

    pub(crate) const AHB1_DMA1: u32 = 1;
    pub(crate) const AHB1_DMAMUX1: u32 = 1 << 2;
    pub(crate) const AHB2_DAC3: u32 = 1 << 18;
    /// The comparators, too.
    pub(crate) const APB2_SYSCFG: u32 = 1;
    pub(crate) const APB2_TIM1: u32 = 1 << 11;

    pub(crate) const CSR_RMVF: u32 = 1 << 23;
}

/// The flash's interface (FLASH).
pub(crate) mod flash {
    use super::Register;

    const BASE: Register = Register::at(0x4002_2000);
    pub(crate) const ACR: Register = BASE;
    pub(crate) const KEYR: Register = BASE.offset(0x08);
    pub(crate) const SR: Register = BASE.offset(0x10);
    pub(crate) const CR: Register = BASE.offset(0x14);
    pub(crate) const ECCR: Register = BASE.offset(0x18);
    pub(crate) const OPTR: Register = BASE.offset(0x20);

    pub(crate) const ACR_LATENCY: u32 = 0xf;

    /// Every error, those of fast programming, the reading protection and the options included.
    pub(crate) const SR_ERRORS: u32 = 0b1100_0011_1111_1010;
    /// The same, and the end of an operation.
    pub(crate) const SR_ENDED: u32 = SR_ERRORS | 1;

    pub(crate) const CR_PER: u32 = 1 << 1;
    pub(crate) const CR_PNB: u32 = 3;

    /// Two errors in a word, in either half of a line of a single bank, or in a word of two banks. Ones clear.
    pub(crate) const ECCR_DAMAGED: u32 = 1 << 29 | 1 << 31;

    /// Level of the brown-out reset: from zero, 1.7 V, to four, 2.8 V.
    pub(crate) const OPTR_BOR_LEV: u32 = 8;
    /// Two banks with pages of 2 KiB; otherwise one with pages of 4 KiB.
    pub(crate) const OPTR_DBANK: u32 = 1 << 22;
}

/// Power control (PWR).
pub(crate) mod pwr {
    use super::Register;

    const BASE: Register = Register::at(0x4000_7000);
    pub(crate) const CR2: Register = BASE.offset(0x04);
    pub(crate) const SR2: Register = BASE.offset(0x14);
    pub(crate) const CR5: Register = BASE.offset(0x80);

    pub(crate) const CR2_PVDE: u32 = 1;
    pub(crate) const CR2_PLS: u32 = 0b111 << 1;
    /// The highest threshold of the supply; all ones is a voltage at a pin.
    pub(crate) const CR2_PLS_6: u32 = 0b110 << 1;
    pub(crate) const SR2_PVDO: u32 = 1 << 11;
    /// Without the boost of the core's voltage.
    pub(crate) const CR5_R1MODE: u32 = 1 << 8;
}

/// External interrupts (EXTI).
pub(crate) mod exti {
    use super::Register;

    const BASE: Register = Register::at(0x4001_0400);
    pub(crate) const IMR1: Register = BASE;
    pub(crate) const RTSR1: Register = BASE.offset(0x08);
    pub(crate) const PR1: Register = BASE.offset(0x14);
}

/// System configuration (SYSCFG).
pub(crate) mod syscfg {
    use super::Register;

    pub(crate) const CFGR2: Register = Register::at(0x4001_001c);

    /// A processor that is locked up after a fault within a fault breaks the timers' outputs.
    pub(crate) const CFGR2_CLL: u32 = 1;
    /// The supply's detector does; its settings are kept until a reset.
    pub(crate) const CFGR2_PVDL: u32 = 1 << 2;
}

/// Behaviour while a debugger halts the processor (DBG).
pub(crate) mod dbgmcu {
    use super::Register;

    pub(crate) const APB1FZR1: Register = Register::at(0xe004_2008);
    pub(crate) const APB2FZR: Register = Register::at(0xe004_2010);

    pub(crate) const APB1FZR1_IWDG: u32 = 1 << 12;
    pub(crate) const APB2FZR_TIM1: u32 = 1 << 11;
}

/// Channel 1 of DAC3, which has no pin (DAC).
pub(crate) mod dac {
    use super::Register;

    const BASE: Register = Register::at(0x5000_1000);
    pub(crate) const CR: Register = BASE;
    pub(crate) const DHR12R1: Register = BASE.offset(0x08);
    pub(crate) const MCR: Register = BASE.offset(0x3c);

    pub(crate) const CR_EN1: u32 = 1;
    /// To peripherals on the chip, without a buffer.
    pub(crate) const MCR_MODE1_INTERNAL: u32 = 0b011;
    /// The bus runs at more than 160 MHz.
    pub(crate) const MCR_HFSEL_160: u32 = 0b10 << 14;
}

/// COMP3 (COMP).
pub(crate) mod comp {
    use super::Register;

    pub(crate) const C3CSR: Register = Register::at(0x4001_0208);

    pub(crate) const EN: u32 = 1;
    /// Channel 1 of DAC3 (COMP).
    pub(crate) const INMSEL_DAC3_CH1: u32 = 0b100 << 4;
}

/// Fields that only an STM32G4's TIM1 has (TIM1).
pub(crate) mod tim1 {
    /// Trigger 4, which is TIM5's (TIM1): bits 4 and 3 of the selection lie apart.
    pub(crate) const SMCR_TS_ITR4: u32 = 1 << 20;
    pub(crate) const SR_SBIF: u32 = 1 << 13;
    pub(crate) const AF1: u32 = 0x60;
    pub(crate) const AF1_BKCMP3E: u32 = 1 << 3;
}

/// USART2 (USART).
pub(crate) mod usart {
    use super::Register;

    const BASE: Register = Register::at(0x4000_4400);
    pub(crate) const CR1: Register = BASE;
    pub(crate) const CR3: Register = BASE.offset(0x08);
    pub(crate) const BRR: Register = BASE.offset(0x0c);
    pub(crate) const ISR: Register = BASE.offset(0x1c);
    pub(crate) const ICR: Register = BASE.offset(0x20);
    pub(crate) const RDR: Register = BASE.offset(0x24);
    pub(crate) const TDR: Register = BASE.offset(0x28);

    pub(crate) const CR1_UE: u32 = 1;
}

/// Channel 1 of DMA1 and of its multiplexer (DMA and DMAMUX).
pub(crate) mod dma {
    use super::Register;

    const BASE: Register = Register::at(0x4002_0000);
    pub(crate) const ISR: Register = BASE;
    pub(crate) const IFCR: Register = BASE.offset(0x04);
    pub(crate) const CCR1: Register = BASE.offset(0x08);
    pub(crate) const CNDTR1: Register = BASE.offset(0x0c);
    pub(crate) const CPAR1: Register = BASE.offset(0x10);
    pub(crate) const CMAR1: Register = BASE.offset(0x14);
    /// Register of the multiplexer, whose channel 0 serves channel 1.
    pub(crate) const C0CR: Register = Register::at(0x4002_0800);

    /// Flag of channel 1, in ISR and IFCR alike. The flag for all of them would clear one that was not seen yet.
    pub(crate) const TCIF1: u32 = 1 << 1;
    pub(crate) const HTIF1: u32 = 1 << 2;
    pub(crate) const TEIF1: u32 = 1 << 3;

    pub(crate) const CCR_EN: u32 = 1;
    pub(crate) const CCR_CIRC: u32 = 1 << 5;
    pub(crate) const CCR_MINC: u32 = 1 << 7;
    pub(crate) const CCR_PL_HIGHEST: u32 = 0b11 << 12;

    /// The request of USART2's reception (DMAMUX).
    pub(crate) const REQUEST_USART2_RX: u32 = 26;
}
