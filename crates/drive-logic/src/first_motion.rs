//! The command of a servo until its encoder shows that it moves: what moves it is not seen if that is dead, and a load of
//! before may be gone.

use commissioning::CommandRamp;
use identifier_core::number::Number;

/// Has the command grow no faster than in the first motion of a commissioning: that of an unknown servo until it has moved,
/// and the one that balances a load from nothing, unless the servo moves before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FirstMotion {
    /// True until the servo has moved, if it is unknown.
    is_awaited: bool,
    /// The command that is to balance the load, while it grows.
    growing: Option<f32>,
    /// One of both: the command is not the controller's.
    acts: bool,
    ramp: CommandRamp<f32>,
    /// The command from which it grows, and its distance from there, with its sign.
    from: f32,
    given: f32,
}

/// The command that balances a load has stopped growing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Balance {
    /// All of it acts, as the servo rests under it or needs it.
    Acts,
    /// It has moved the servo: the load is another.
    Refuted,
}

impl FirstMotion {
    /// For an unknown servo, with these limits of the command, at a sample time (s).
    pub(crate) fn new([low, high]: [f64; 2], sample_time: f64) -> Self {
        Self {
            is_awaited: true,
            growing: None,
            acts: true,
            ramp: CommandRamp::new(high.min(-low), sample_time),
            from: 0.0,
            given: 0.0,
        }
    }

    /// Samples beyond the breakaway within which it must move.
    pub(crate) fn patience(&self) -> u32 {
        self.ramp.jammed()
    }

    /// Takes over with a command that holds the servo.
    pub(crate) fn take_over(&mut self, command: f32) {
        self.from = command;
    }

    /// Begins with a command that held the servo in a run before.
    pub(crate) fn grow(&mut self, balance: f32) {
        (self.growing, self.acts) = (Some(balance), true);
    }

    /// The servo is identified.
    pub(crate) fn know(&mut self) {
        (self.is_awaited, self.acts) = (false, self.grows());
    }

    /// The command is not the controller's.
    #[inline]
    pub(crate) fn acts(&self) -> bool {
        self.acts
    }

    /// True while the command that balances the load grows.
    fn grows(&self) -> bool {
        self.growing.is_some()
    }

    /// The command that acts in place of the controller's, after the servo has moved in this direction since its start, or
    /// not (0).
    pub(crate) fn ramped(&mut self, command: f32, moved: f32) -> (f32, Option<Balance>) {
        if moved != 0.0 {
            (self.is_awaited, self.acts) = (false, false);
            return match self.growing.take() {
                Some(balance) if moved * balance > 0.0 => (0.0, Some(Balance::Refuted)),
                growing => (command, growing.map(|_| Balance::Acts)),
            };
        }
        let wanted = command - self.from;
        // To the other side it grows anew.
        let distance = if wanted * self.given > 0.0 {
            self.given.abs()
        } else {
            0.0
        };
        let most = distance + self.ramp.step(distance);
        self.given = wanted.limited(-most, most);
        let is_all = wanted.abs() <= most;
        let over = self.growing.take_if(|_| is_all).map(|_| Balance::Acts);
        self.acts = self.is_awaited || self.grows();
        (self.from + self.given, over)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_begins_anew_from_where_it_rests_when_the_command_turns() {
        for from in [0.0, 2.0] {
            let mut motion = FirstMotion::new([-10.0, 10.0], 1e-3);
            motion.take_over(from);
            let first = motion.ramped(9.0, 0.0).0 - from;
            let grown = (0..200).map(|_| motion.ramped(9.0, 0.0).0 - from).last();
            assert!(
                first > 0.0 && grown > Some(10.0 * first),
                "{first} {grown:?}"
            );
            let turned = motion.ramped(-9.0, 0.0).0 - from;
            assert!((turned + first).abs() < 1e-6, "{from}: {first} {turned}");
        }
    }
}
