//! Cycles that the flash of an STM32F405 adds to an instruction: five wait states at 168 MHz, behind the
//! caches and the prefetch that ST calls ART (RM0090, 3.5).
//!
//! The flash is read by lines of 128 bits. An instruction costs nothing more if it is in the line
//! that is being executed, in the next line, once its prefetch is complete, or in one of 64 cached lines.
//! Lines that were waited for are cached in place of the least recently used. Constants have eight cached
//! lines of their own.

/// Its addresses.
const START: u32 = 0x0800_0000;
const END: u32 = 0x0810_0000;

/// Bytes of a line.
const LINE: u32 = 16;

/// Wait states at 168 MHz and 2.7 V or more (RM0090, table 10), cycles.
const WAIT: u64 = 5;

/// A read of a line, cycles.
const READ: u64 = 1 + WAIT;

/// Cached lines of instructions and of constants.
const INSTRUCTION_LINES: usize = 64;
const CONSTANT_LINES: usize = 8;

/// The flash with its caches, all of them empty at first.
#[derive(Debug)]
pub(crate) struct Flash {
    /// The line being executed.
    current: Option<u32>,
    /// The line being prefetched, and the cycle at which it is complete.
    ahead: Option<(u32, u64)>,
    instructions: Cache<INSTRUCTION_LINES>,
    constants: Cache<CONSTANT_LINES>,
}

impl Flash {
    pub(crate) fn new() -> Self {
        Self {
            current: None,
            ahead: None,
            instructions: Cache::new(),
            constants: Cache::new(),
        }
    }

    /// Cycles that an instruction of this length waits that is fetched at cycle `now`.
    pub(crate) fn fetch(&mut self, address: u32, length: u32, now: u64) -> u64 {
        let last = address.wrapping_add(length - 1);
        let mut waited = 0;
        for line in address / LINE..=last / LINE {
            waited += self.fetch_line(line, now + waited);
        }
        waited
    }

    fn fetch_line(&mut self, line: u32, now: u64) -> u64 {
        if self.current == Some(line) || !is_flash(line * LINE) {
            return 0;
        }
        let waited = match self.ahead {
            Some((ahead, ready)) if ahead == line => ready.saturating_sub(now),
            _ if self.instructions.has(line) => 0,
            _ => {
                self.instructions.keep(line);
                WAIT
            }
        };
        self.current = Some(line);
        let next = line + 1;
        self.ahead = (!self.instructions.holds(next)).then_some((next, now + waited + READ));
        waited
    }

    /// Cycles that a load of a constant at cycle `now` waits.
    pub(crate) fn load(&mut self, address: u32, now: u64) -> u64 {
        let line = address / LINE;
        if !is_flash(address) || self.constants.has(line) {
            return 0;
        }
        self.constants.keep(line);
        // A constant has priority over the prefetch.
        if let Some((_, ready)) = &mut self.ahead
            && *ready > now
        {
            *ready += READ;
        }
        WAIT
    }
}

fn is_flash(address: u32) -> bool {
    (START..END).contains(&address)
}

/// Cached lines, the one used last at the end.
#[derive(Debug)]
struct Cache<const N: usize> {
    lines: Vec<u32>,
}

impl<const N: usize> Cache<N> {
    fn new() -> Self {
        Self {
            lines: Vec::with_capacity(N),
        }
    }

    fn holds(&self, line: u32) -> bool {
        self.lines.contains(&line)
    }

    /// True if a line is cached, which marks it as used.
    fn has(&mut self, line: u32) -> bool {
        let found = self.lines.iter().rposition(|&kept| kept == line);
        if let Some(at) = found {
            self.lines[at..].rotate_left(1);
        }
        found.is_some()
    }

    fn keep(&mut self, line: u32) {
        if self.lines.len() == N {
            self.lines.remove(0);
        }
        self.lines.push(line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fetches half-words one after the other, a cycle each, and answers with what each waited.
    fn straight(flash: &mut Flash, from: u32, count: u32, clock: &mut u64) -> Vec<u64> {
        (0..count)
            .map(|at| {
                let waited = flash.fetch(from + 2 * at, 2, *clock);
                *clock += waited + 1;
                waited
            })
            .collect()
    }

    #[test]
    fn straight_code_of_short_instructions_waits_only_for_its_first_line() {
        let waits = straight(&mut Flash::new(), START, 24, &mut 0);
        assert_eq!(waits.iter().sum::<u64>(), WAIT);
        assert_eq!(waits[0], WAIT);
    }

    #[test]
    fn four_instructions_a_line_are_too_fast_for_the_next_line() {
        let mut flash = Flash::new();
        let mut clock = 0;
        let waits: Vec<u64> = (0..8)
            .map(|at| {
                let waited = flash.fetch(START + 4 * at, 4, clock);
                clock += waited + 1;
                waited
            })
            .collect();
        // Four cycles of execution hide four of the six of a read.
        assert_eq!(waits, [5, 0, 0, 0, 2, 0, 0, 0]);
    }

    #[test]
    fn a_loop_waits_once() {
        let mut flash = Flash::new();
        let mut clock = 0;
        let there = START + 0x400;
        // Each jump misses once; the lines are kept.
        for expected in [WAIT, 0, 0] {
            assert_eq!(flash.fetch(START, 2, clock), expected);
            clock += 1 + expected;
            assert_eq!(flash.fetch(there, 2, clock), expected);
            clock += 1 + expected;
        }
    }

    #[test]
    fn what_came_ahead_is_not_kept() {
        let mut flash = Flash::new();
        let mut clock = 0;
        straight(&mut flash, START, 16, &mut clock);
        // Back to the second line from elsewhere.
        flash.fetch(START + 0x400, 2, clock);
        assert_eq!(flash.fetch(START + LINE, 2, clock + 100), WAIT);
    }

    #[test]
    fn the_line_used_longest_ago_makes_room() {
        let mut flash = Flash::new();
        let lines = INSTRUCTION_LINES as u32;
        // Every second line, so that none is fetched ahead.
        let at = |number: u32| START + number * 2 * LINE;
        for number in 0..lines {
            assert_eq!(flash.fetch(at(number), 2, 0), WAIT);
        }
        assert_eq!(flash.fetch(at(0), 2, 0), 0);
        assert_eq!(flash.fetch(at(lines), 2, 0), WAIT);
        // The first was used again, so it was the second that went.
        assert_eq!(flash.fetch(at(0), 2, 0), 0);
        assert_eq!(flash.fetch(at(1), 2, 0), WAIT);
    }

    #[test]
    fn an_instruction_across_two_lines_needs_both() {
        let mut flash = Flash::new();
        // The second line is on its way while the first is waited for no more.
        assert_eq!(flash.fetch(START + LINE - 2, 4, 0), WAIT + READ);
    }

    #[test]
    fn constants_are_kept_eight_lines_long_and_hold_up_what_is_ahead() {
        let mut flash = Flash::new();
        let at = |number: u32| START + 0x1000 + number * LINE;
        for number in 0..8 {
            assert_eq!(flash.load(at(number), 0), WAIT);
            assert_eq!(flash.load(at(number) + 4, 0), 0);
        }
        assert_eq!(flash.load(at(8), 0), WAIT);
        assert_eq!(flash.load(at(0), 0), WAIT);
        // Memory is not the flash's.
        assert_eq!(flash.load(0x2000_0000, 0), 0);

        assert_eq!(flash.fetch(START, 2, 0), WAIT);
        assert_eq!(flash.load(at(20), 6), WAIT);
        // It would have come at 5 + 6, and comes six later.
        assert_eq!(flash.fetch(START + LINE, 2, 12), 5);
    }
}
