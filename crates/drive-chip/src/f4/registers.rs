//! Addresses of the STM32F4's registers, and the fields that only it has at their places (RM0090). The section is given
//! with each peripheral.

use crate::bus::Register;

/// Reset and clock control (7.3).
pub(crate) mod rcc {
    use super::Register;
    pub(crate) use crate::registers::rcc::*;

    const BASE: Register = Register::at(0x4002_3800);
    pub(crate) const CR: Register = BASE;
    pub(crate) const PLLCFGR: Register = BASE.offset(0x04);
    pub(crate) const CFGR: Register = BASE.offset(0x08);
    pub(crate) const AHB1RSTR: Register = BASE.offset(0x10);
    pub(crate) const APB1RSTR: Register = BASE.offset(0x20);
    pub(crate) const APB2RSTR: Register = BASE.offset(0x24);
    pub(crate) const AHB1ENR: Register = BASE.offset(0x30);
    pub(crate) const APB1ENR: Register = BASE.offset(0x40);
    pub(crate) const APB2ENR: Register = BASE.offset(0x44);
    pub(crate) const CSR: Register = BASE.offset(0x74);

    /// M, N, P and Q; other bits keep their reset value.
    pub(crate) const PLLCFGR_FACTORS: u32 = 0x3f | 0x1ff << 6 | 0b11 << 16 | 0xf << 24;
    pub(crate) const PLLCFGR_N: u32 = 6;
    pub(crate) const PLLCFGR_P_2: u32 = 0;
    pub(crate) const PLLCFGR_P_4: u32 = 1 << 16;
    pub(crate) const PLLCFGR_HSE: u32 = 1 << 22;
    pub(crate) const PLLCFGR_Q: u32 = 24;

    pub(crate) const CFGR_SW_PLL: u32 = 0b10;
    pub(crate) const CFGR_SWS_HSI: u32 = 0;
    pub(crate) const CFGR_SWS_PLL: u32 = 0b10 << 2;
    pub(crate) const CFGR_PRESCALERS: u32 = 0xf << 4 | 0b111 << 10 | 0b111 << 13;
    pub(crate) const CFGR_PPRE1_2: u32 = 0b100 << 10;
    pub(crate) const CFGR_PPRE1_4: u32 = 0b101 << 10;
    pub(crate) const CFGR_PPRE2_2: u32 = 0b100 << 13;

    pub(crate) const AHB1_DMA1: u32 = 1 << 21;
    pub(crate) const APB2_TIM1: u32 = 1;

    pub(crate) const CSR_RMVF: u32 = 1 << 24;
}

/// The flash's interface (3.9).
pub(crate) mod flash {
    use super::Register;

    const BASE: Register = Register::at(0x4002_3c00);
    pub(crate) const ACR: Register = BASE;
    pub(crate) const KEYR: Register = BASE.offset(0x04);
    pub(crate) const SR: Register = BASE.offset(0x0c);
    pub(crate) const CR: Register = BASE.offset(0x10);
    pub(crate) const OPTCR: Register = BASE.offset(0x14);

    pub(crate) const ACR_LATENCY: u32 = 0b111;

    /// End of operation and every error, the reading protection's included.
    pub(crate) const SR_ENDED: u32 = 0b1_1111_0011;
    pub(crate) const SR_ERRORS: u32 = 0b1_1111_0010;

    pub(crate) const CR_SER: u32 = 1 << 1;
    pub(crate) const CR_SNB: u32 = 3;
    pub(crate) const CR_PSIZE_32: u32 = 0b10 << 8;

    /// Level of the brown-out reset: zero is the highest, 2.7 V and more; all ones is off.
    pub(crate) const OPTCR_BOR_LEV: u32 = 0b11 << 2;
}

/// Power control (5.4).
pub(crate) mod pwr {
    use super::Register;

    pub(crate) const CR: Register = Register::at(0x4000_7000);
    pub(crate) const CSR: Register = Register::at(0x4000_7004);

    pub(crate) const CR_PVDE: u32 = 1 << 4;
    pub(crate) const CR_PLS: u32 = 0b111 << 5;
    pub(crate) const CSR_PVDO: u32 = 1 << 2;
}

/// External interrupts (12.3).
pub(crate) mod exti {
    use super::Register;

    const BASE: Register = Register::at(0x4001_3c00);
    pub(crate) const IMR: Register = BASE;
    pub(crate) const RTSR: Register = BASE.offset(0x08);
    pub(crate) const PR: Register = BASE.offset(0x14);
}

/// Behaviour while a debugger halts the processor (38.16).
pub(crate) mod dbgmcu {
    use super::Register;

    pub(crate) const APB1_FZ: Register = Register::at(0xe004_2008);
    pub(crate) const APB2_FZ: Register = Register::at(0xe004_200c);

    pub(crate) const APB1_FZ_IWDG: u32 = 1 << 12;
    pub(crate) const APB2_FZ_TIM1: u32 = 1;
}

/// USART2 (30.6).
pub(crate) mod usart {
    use super::Register;

    const BASE: Register = Register::at(0x4000_4400);
    pub(crate) const SR: Register = BASE;
    pub(crate) const DR: Register = BASE.offset(0x04);
    pub(crate) const BRR: Register = BASE.offset(0x08);
    pub(crate) const CR1: Register = BASE.offset(0x0c);
    pub(crate) const CR3: Register = BASE.offset(0x14);

    pub(crate) const CR1_UE: u32 = 1 << 13;
}

/// Stream 5 of DMA1, which serves the reception of USART2 as its channel 4 (10.3.3, table 42; 10.5).
pub(crate) mod dma {
    use super::Register;

    const BASE: Register = Register::at(0x4002_6000);
    pub(crate) const HISR: Register = BASE.offset(0x04);
    pub(crate) const HIFCR: Register = BASE.offset(0x0c);
    pub(crate) const S5CR: Register = BASE.offset(0x88);
    pub(crate) const S5NDTR: Register = BASE.offset(0x8c);
    pub(crate) const S5PAR: Register = BASE.offset(0x90);
    pub(crate) const S5M0AR: Register = BASE.offset(0x94);

    /// Flag of stream 5, in HISR and HIFCR alike.
    pub(crate) const FEIF5: u32 = 1 << 6;
    pub(crate) const DMEIF5: u32 = 1 << 8;
    pub(crate) const TEIF5: u32 = 1 << 9;
    pub(crate) const HTIF5: u32 = 1 << 10;
    pub(crate) const TCIF5: u32 = 1 << 11;

    pub(crate) const CR_EN: u32 = 1;
    pub(crate) const CR_CIRC: u32 = 1 << 8;
    pub(crate) const CR_MINC: u32 = 1 << 10;
    pub(crate) const CR_PL_HIGHEST: u32 = 0b11 << 16;
    pub(crate) const CR_CHANNEL_4: u32 = 4 << 25;
}
