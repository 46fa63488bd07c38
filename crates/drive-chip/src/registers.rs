//! Registers and fields that both families have at the same places. Those of one of them stand in its folder.

use crate::bus::Register;

/// Fields of reset and clock control at the same places in both families (RM0090, 7.3; RM0440, RCC).
pub(crate) mod rcc {
    pub(crate) const CR_HSEON: u32 = 1 << 16;
    pub(crate) const CR_HSERDY: u32 = 1 << 17;
    pub(crate) const CR_HSEBYP: u32 = 1 << 18;
    pub(crate) const CR_CSSON: u32 = 1 << 19;
    pub(crate) const CR_PLLON: u32 = 1 << 24;
    pub(crate) const CR_PLLRDY: u32 = 1 << 25;
    pub(crate) const CFGR_SW: u32 = 0b11;
    pub(crate) const CFGR_SWS: u32 = 0b11 << 2;
    pub(crate) const APB1_TIM3: u32 = 1 << 1;
    pub(crate) const APB1_TIM4: u32 = 1 << 2;
    pub(crate) const APB1_TIM5: u32 = 1 << 3;
    pub(crate) const APB1_USART2: u32 = 1 << 17;
    pub(crate) const APB1_PWR: u32 = 1 << 28;
    pub(crate) const CSR_IWDGRSTF: u32 = 1 << 29;
}

/// Fields of the flash's interface at the same places in both families (RM0090, 3.9; RM0440, FLASH).
pub(crate) mod flash {
    /// Size of an area, bytes. In an emulator, memory replaces it.
    pub(crate) const AREA: u32 = if cfg!(feature = "emulator") {
        0x2000
    } else {
        0x4000
    };

    pub(crate) const ACR_PRFTEN: u32 = 1 << 8;
    pub(crate) const ACR_ICEN: u32 = 1 << 9;
    pub(crate) const ACR_DCEN: u32 = 1 << 10;
    pub(crate) const ACR_ICRST: u32 = 1 << 11;
    pub(crate) const ACR_DCRST: u32 = 1 << 12;

    /// The keys, in this order (RM0090, 3.6.1).
    pub(crate) const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

    pub(crate) const SR_BSY: u32 = 1 << 16;

    pub(crate) const CR_PG: u32 = 1;
    pub(crate) const CR_STRT: u32 = 1 << 16;
    pub(crate) const CR_LOCK: u32 = 1 << 31;
}

/// The detector of the supply's voltage among the external interrupts (RM0090, 12.3; RM0440, EXTI).
pub(crate) mod exti {
    pub(crate) const PVD: u32 = 1 << 16;
}

/// General-purpose pins (RM0090, 8.4; RM0440, GPIO), as offsets from a port's base.
pub(crate) mod gpio {
    /// From a port to the next one, bytes.
    pub(crate) const STRIDE: u32 = 0x400;
    pub(crate) const MODER: u32 = 0x00;
    pub(crate) const OTYPER: u32 = 0x04;
    pub(crate) const PUPDR: u32 = 0x0c;
    pub(crate) const IDR: u32 = 0x10;
    pub(crate) const BSRR: u32 = 0x18;
    pub(crate) const AFRL: u32 = 0x20;
}

/// Timers (RM0090, 17.4 and 18.4; RM0440, TIM1 and TIM2 to TIM5). TIM1 lies elsewhere in each family.
pub(crate) mod timer {
    use super::Register;

    /// The registers of one timer.
    #[derive(Debug, Clone, Copy)]
    pub struct Timer(u32);

    pub(crate) const TIM3: Timer = Timer(0x4000_0400);
    pub(crate) const TIM4: Timer = Timer(0x4000_0800);
    pub(crate) const TIM5: Timer = Timer(0x4000_0c00);

    impl Timer {
        /// The timer at an address.
        pub(crate) const fn new(address: u32) -> Self {
            Self(address)
        }

        /// The register at an offset.
        pub(crate) const fn at(self, offset: u32) -> Register {
            Register::at(self.0).offset(offset)
        }
    }

    pub(crate) const CR1: u32 = 0x00;
    pub(crate) const CR2: u32 = 0x04;
    pub(crate) const SMCR: u32 = 0x08;
    pub(crate) const DIER: u32 = 0x0c;
    pub(crate) const SR: u32 = 0x10;
    pub(crate) const EGR: u32 = 0x14;
    pub(crate) const CCMR1: u32 = 0x18;
    pub(crate) const CCMR2: u32 = 0x1c;
    pub(crate) const CCER: u32 = 0x20;
    pub(crate) const CNT: u32 = 0x24;
    pub(crate) const ARR: u32 = 0x2c;
    pub(crate) const CCR1: u32 = 0x34;
    pub(crate) const CCR2: u32 = 0x38;
    pub(crate) const CCR3: u32 = 0x3c;
    pub(crate) const BDTR: u32 = 0x44;

    pub(crate) const CR1_CEN: u32 = 1;
    pub(crate) const CR1_UDIS: u32 = 1 << 1;
    pub(crate) const CR1_URS: u32 = 1 << 2;
    pub(crate) const CR2_MMS_ENABLE: u32 = 0b001 << 4;
    pub(crate) const SMCR_ENCODER_3: u32 = 0b011;
    pub(crate) const SMCR_EXTERNAL: u32 = 0b111;
    pub(crate) const SMCR_TS_TI1: u32 = 0b101 << 4;
    pub(crate) const SMCR_TRIGGER: u32 = 0b110;
    pub(crate) const DIER_UIE: u32 = 1;
    pub(crate) const SR_UIF: u32 = 1;
    pub(crate) const SR_CC2IF: u32 = 1 << 2;
    pub(crate) const SR_CC3IF: u32 = 1 << 3;
    pub(crate) const SR_CC2OF: u32 = 1 << 10;
    pub(crate) const SR_BIF: u32 = 1 << 7;
    pub(crate) const EGR_UG: u32 = 1;
    pub(crate) const CCMR1_OC1PE: u32 = 1 << 3;
    pub(crate) const CCMR1_OC1M_PWM_1: u32 = 0b110 << 4;
    pub(crate) const CCMR1_OC2PE: u32 = 1 << 11;
    pub(crate) const CCMR1_OC2M_PWM_1: u32 = 0b110 << 12;
    pub(crate) const CCMR1_CC1S_TI1: u32 = 0b01;
    pub(crate) const CCMR1_IC1F: u32 = 4;
    pub(crate) const CCMR1_CC2S_TI2: u32 = 0b01 << 8;
    pub(crate) const CCMR1_IC2F: u32 = 12;
    pub(crate) const CCMR2_CC3S_TI3: u32 = 0b01;
    pub(crate) const CCMR2_IC3F: u32 = 4;
    pub(crate) const CCER_CC1E: u32 = 1;
    pub(crate) const CCER_CC2E: u32 = 1 << 4;
    pub(crate) const CCER_CC2P: u32 = 1 << 5;
    pub(crate) const CCER_CC2NP: u32 = 1 << 7;
    pub(crate) const CCER_CC3E: u32 = 1 << 8;
    pub(crate) const CCER_CC2NE: u32 = 1 << 6;
    pub(crate) const BDTR_LOCK_1: u32 = 0b01 << 8;
    pub(crate) const BDTR_OSSI: u32 = 1 << 10;
    pub(crate) const BDTR_OSSR: u32 = 1 << 11;
    pub(crate) const BDTR_BKE: u32 = 1 << 12;
    pub(crate) const BDTR_BKP: u32 = 1 << 13;
    pub(crate) const BDTR_MOE: u32 = 1 << 15;
}

/// Fields of USART2 at the same places in both families (RM0090, 30.6; RM0440, USART).
pub(crate) mod usart {
    pub(crate) const SR_FE: u32 = 1 << 1;
    pub(crate) const SR_ORE: u32 = 1 << 3;
    #[cfg(all(feature = "emulator", target_os = "none"))]
    pub(crate) const SR_RXNE: u32 = 1 << 5;
    pub(crate) const SR_TXE: u32 = 1 << 7;
    pub(crate) const CR1_RE: u32 = 1 << 2;
    pub(crate) const CR1_TE: u32 = 1 << 3;
    pub(crate) const CR1_RXNEIE: u32 = 1 << 5;
    pub(crate) const CR1_TXEIE: u32 = 1 << 7;
    pub(crate) const CR3_DMAR: u32 = 1 << 6;
}

/// The independent watchdog (RM0090, 21.4; RM0440, IWDG).
pub(crate) mod iwdg {
    use super::Register;

    const BASE: Register = Register::at(0x4000_3000);
    pub(crate) const KR: Register = BASE;
    pub(crate) const PR: Register = BASE.offset(0x04);
    pub(crate) const RLR: Register = BASE.offset(0x08);
    pub(crate) const SR: Register = BASE.offset(0x0c);

    pub(crate) const KEY_START: u32 = 0xcccc;
    pub(crate) const KEY_ACCESS: u32 = 0x5555;
    pub(crate) const KEY_FEED: u32 = 0xaaaa;
    pub(crate) const PR_4: u32 = 0b000;
}

/// The processor's interrupt controller (PM0214, 4.3), as offsets of word 0.
pub(crate) mod nvic {
    use super::Register;

    pub(crate) const ISER: Register = Register::at(0xe000_e100);
    pub(crate) const ISPR: Register = Register::at(0xe000_e200);
    pub(crate) const IPR: Register = Register::at(0xe000_e400);
}

/// The processor's own timer (PM0214, 4.5).
pub(crate) mod systick {
    use super::Register;

    pub(crate) const CSR: Register = Register::at(0xe000_e010);
    pub(crate) const RVR: Register = Register::at(0xe000_e014);
    pub(crate) const CVR: Register = Register::at(0xe000_e018);

    pub(crate) const CSR_ENABLE: u32 = 1;
    pub(crate) const CSR_TICKINT: u32 = 1 << 1;
    pub(crate) const CSR_PROCESSOR: u32 = 1 << 2;
}

/// The processor's system control block (PM0214, 4.4).
pub(crate) mod scb {
    use super::Register;

    /// Priorities of PendSV and, in the highest byte, of SysTick.
    pub(crate) const SHPR3: Register = Register::at(0xe000_ed20);
    pub(crate) const SHPR3_SYSTICK: u32 = 24;
}
