//! The mutations. Of the drivers: eight breaks that cost a servo or a record, and twenty of those that
//! `cargo mutants -p drive-chip` makes, one of each kind and place. Of the drive's logic: what keeps a
//! machine whole, taken away piece by piece.

/// A text of a file that stands there once, and what stands there in its place.
pub(super) struct Mutation {
    /// In the folder of the sources.
    pub(super) file: &'static str,
    pub(super) what: &'static str,
    pub(super) from: &'static str,
    pub(super) to: &'static str,
}

const fn mutation(
    file: &'static str,
    what: &'static str,
    from: &'static str,
    to: &'static str,
) -> Mutation {
    Mutation {
        file,
        what,
        from,
        to,
    }
}

/// Of `drive-chip`.
pub(super) const DRIVERS: [Mutation; 28] = [
    mutation(
        "clock.rs",
        "another PLL factor",
        "const VCO: u32 = 336_000_000;",
        "const VCO: u32 = 334_000_000;",
    ),
    mutation(
        "registers.rs",
        "PWM inverted",
        "CCMR1_OC1M_PWM_1: u32 = 0b110 << 4",
        "CCMR1_OC1M_PWM_1: u32 = 0b111 << 4",
    ),
    mutation(
        "pwm.rs",
        "break off",
        "const OFF: u32 = timer::BDTR_BKE | timer::BDTR_BKP",
        "const OFF: u32 = timer::BDTR_BKP",
    ),
    mutation(
        "wiring.rs",
        "emergency does nothing",
        "    board.enable.set_low(bus);\n    pwm::off(bus);",
        "    let _ = (bus, board);",
    ),
    mutation(
        "inputs.rs",
        "a limit switch ignored",
        "high_switch: self.high_switch.is_low()",
        "high_switch: true",
    ),
    mutation(
        "flash.rs",
        "no food while the flash is busy",
        "            watchdog::feed(bus);\n            let status",
        "            let status",
    ),
    mutation(
        "interrupts.rs",
        "samples below bytes",
        "const SAMPLE: u32 = 0x00;",
        "const SAMPLE: u32 = 0x90;",
    ),
    mutation(
        "registers.rs",
        "a wrong key of the flash",
        "0xcdef_89ab",
        "0xcdef_89aa",
    ),
    mutation(
        "watchdog.rs",
        "replace feed with ()",
        "    bus.write(iwdg::KR, iwdg::KEY_FEED);",
        "    let _ = bus;",
    ),
    mutation(
        "watchdog.rs",
        "replace - with + in RELOAD",
        "/ 1000 - 1;",
        "/ 1000 + 1;",
    ),
    mutation(
        "sample_timer.rs",
        "replace - with + in SampleTimer::new",
        "pwm_period - pwm_period",
        "pwm_period + pwm_period",
    ),
    mutation(
        "sample_timer.rs",
        "replace - with + in SampleTimer::start",
        "ticks - 1",
        "ticks + 1",
    ),
    mutation(
        "sample_timer.rs",
        "replace + with - in nearest",
        "f64::from(pwm::FREQUENCY) + 0.5",
        "f64::from(pwm::FREQUENCY) - 0.5",
    ),
    mutation(
        "sample_timer.rs",
        "replace != with == in is_due",
        "& timer::SR_UIF != 0",
        "& timer::SR_UIF == 0",
    ),
    mutation(
        "pwm.rs",
        "replace set_duty_cycle_fully_off with Ok(())",
        "        off(self.bus);\n        self.bus.write(TIM1.ccr1(), 0);",
        "        return Ok(());",
    ),
    mutation(
        "pwm.rs",
        "replace != with == in broke",
        "& timer::SR_BIF != 0",
        "& timer::SR_BIF == 0",
    ),
    mutation(
        "inputs.rs",
        "replace && with || in Inputs::read",
        "&& !pwm::broke(self.bus)",
        "|| !pwm::broke(self.bus)",
    ),
    mutation(
        "flash.rs",
        "replace || with && in Step::run",
        "== 0 || turns == 0",
        "== 0 && turns == 0",
    ),
    mutation(
        "flash.rs",
        "replace + with - in erase",
        "self.sectors.first + sector",
        "self.sectors.first - sector",
    ),
    mutation(
        "flash.rs",
        "replace >> with << in read",
        "word >> (8 *",
        "word << (8 *",
    ),
    mutation(
        "flash.rs",
        "replace & with | in do_step",
        "status & (flash::SR_BSY",
        "status | (flash::SR_BSY",
    ),
    mutation(
        "clock.rs",
        "replace == with != in becomes",
        "& bits == wanted",
        "& bits != wanted",
    ),
    mutation(
        "clock.rs",
        "replace == with != in to_full",
        "oscillator.kind == Kind::Clock",
        "oscillator.kind != Kind::Clock",
    ),
    mutation(
        "pins.rs",
        "replace << with >> in set_pair",
        "0b11 << shift, bits << shift",
        "0b11 << shift, bits >> shift",
    ),
    mutation(
        "pins.rs",
        "replace == with != in is_low",
        "& self.mask == 0",
        "& self.mask != 0",
    ),
    mutation(
        "interrupts.rs",
        "replace / with % in word",
        "(interrupt / 32) << 2",
        "(interrupt % 32) << 2",
    ),
    mutation(
        "serial.rs",
        "replace != with == in serve",
        "status & usart::SR_TXE != 0",
        "status & usart::SR_TXE == 0",
    ),
    mutation(
        "quadrature.rs",
        "replace << with >> in Quadrature::new",
        "FILTER << timer::CCMR1_IC2F",
        "FILTER >> timer::CCMR1_IC2F",
    ),
];

/// Of `drive-logic`.
pub(super) const LOGIC: [Mutation; 28] = [
    mutation(
        "channel.rs",
        "a stop is not counted",
        "        raise(&self.signals.stops);\n",
        "        let _ = &self.signals.stops;\n",
    ),
    mutation(
        "channel.rs",
        "what a stop overtook is obeyed",
        "if stops == self.stops() {",
        "if stops == stops {",
    ),
    mutation(
        "conversation.rs",
        "a stop waits for the requests before it",
        "            if self.stops.take(byte) {",
        "            if self.stops.take(byte) && self.waiting.len() < 12 {",
    ),
    mutation(
        "conversation.rs",
        "a run begins although a stop came while it was built",
        "            self.stops_waiting > 0\n        })",
        "            false\n        })",
    ),
    mutation(
        "conversation.rs",
        "news take the room of an answer",
        "self.must_say.is_none() && say(line, &report, LONGEST_FRAME)",
        "self.must_say.is_none() && say(line, &report, 0)",
    ),
    mutation(
        "ending.rs",
        "the host may be silent for ever",
        "|most| self.silent >= most",
        "|_| false",
    ),
    mutation(
        "ending.rs",
        "a run has no end",
        "        if self.run_left == Some(0) {",
        "        if self.run_left == Some(u32::MAX) {",
    ),
    mutation(
        "rest.rs",
        "a servo that does not come to rest is never let go",
        "self.still >= self.needed || self.left == 0",
        "self.still >= self.needed",
    ),
    mutation(
        "reference.rs",
        "a servo coming to rest is sent away",
        "        self.stays = true;\n",
        "        self.stays = false;\n",
    ),
    mutation(
        "protection.rs",
        "travel is not watched",
        "        if !is_within(gone, self.travel) {",
        "        if !is_within(gone, MOST) {",
    ),
    mutation(
        "protection.rs",
        "speed is not watched",
        "        self.speed.check(count)?;\n",
        "        let _ = self.speed.check(count);\n",
    ),
    mutation(
        "line_watch.rs",
        "a limit switch is ignored",
        "        if lines.low_switch && lines.high_switch {",
        "        if lines.low_switch || lines.high_switch {",
    ),
    mutation(
        "protection.rs",
        "a hand on the shaft is a silent encoder",
        "(sample.command - self.at_rest).abs() >= self.change",
        "sample.error.abs() > 0.0",
    ),
    mutation(
        "protection.rs",
        "dither and following error may contradict",
        "const AMPLITUDES_OF_ERROR: f64 = 3.0;",
        "const AMPLITUDES_OF_ERROR: f64 = 2.0;",
    ),
    mutation(
        "supervisor/mod.rs",
        "it starts although nobody configured it",
        "        if !self.configured {",
        "        if !self.configured && self.is_out() {",
    ),
    mutation(
        "supervisor/mod.rs",
        "what the boot found is forgotten",
        "            fault: found_at_boot.err(),",
        "            fault: found_at_boot.err().filter(|_| false),",
    ),
    mutation(
        "supervisor/runs.rs",
        "what was kept is not used",
        "            parts::begin_with(estimates, &mut settings.closed_loop.core.identifier);\n",
        "            let _ = (estimates, &mut settings);\n",
    ),
    mutation(
        "sampler.rs",
        "the watchdog is not fed",
        "        if run.has_background(&self.channel) {\n            chip.feed_watchdog();",
        "        if run.has_background(&self.channel) {\n            let _ = &chip;",
    ),
    mutation(
        "sampler.rs",
        "the watchdog is fed whatever the background does",
        "        if run.has_background(&self.channel) {",
        "        if run.has_background(&self.channel) || true {",
    ),
    mutation(
        "sampler.rs",
        "a fault discards what was learnt",
        "            self.returned = Some(Returned::Run(run));\n            self.ended = Some(ended);",
        "            self.returned = Some(Returned::Run(run)).filter(|_| ended == Ended::Stopped);\n            self.ended = Some(ended);",
    ),
    mutation(
        "commissioning.rs",
        "what strikes in a commissioning is no fault",
        "        self.fault = self.fault.or(Some(fault));\n        self.let_go(match fault {",
        "        self.let_go(match fault {",
    ),
    mutation(
        "commissioning.rs",
        "a silent host does not end a commissioning",
        "        if self.silence.is_too_long() {",
        "        if self.silence.is_too_long() && self.late {",
    ),
    mutation(
        "supervisor/commission.rs",
        "a commissioning begins without a mark",
        "        if self.keep(true).is_err() {",
        "        if self.keep(false).is_err() {",
    ),
    mutation(
        "supervisor/commission.rs",
        "what a commissioning found is not kept",
        "        if self.unkept && !self.is_out() {",
        "        if self.unkept && self.is_out() {",
    ),
    mutation(
        "supervisor/mod.rs",
        "another mode does not end a commissioning",
        "                self.channel.change_mode();\n",
        "",
    ),
    mutation(
        "supervisor/commission.rs",
        "the flash is written while a loop goes on",
        "        if self.unkept && !self.is_out() {",
        "        if self.unkept {",
    ),
    mutation(
        "closed_loop.rs",
        "a loop that goes on forgets the integral",
        "own => own.servo_loop.take_over(&mut own.state, *count, last),",
        "own => { let _ = last; own.state.begin_at(*count) },",
    ),
    mutation(
        "commissioning.rs",
        "what a commissioning beside a loop holds is let go",
        "            if self.beside.is_none() || self.fault.is_some() {",
        "            if self.beside.is_none() || self.moved.sample > 0 {",
    ),
];
