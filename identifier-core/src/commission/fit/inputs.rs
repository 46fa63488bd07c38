use super::block::Piece;
use super::motion::MotionRecord;
use crate::number::Number;

/// Where a delayed command is in the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Inputs<N> {
    /// The acting input: a piece of the record, or before it the command with which it begins.
    piece: Piece<N>,
    /// Samples for which it still acts.
    left: N,
    next: usize,
}

/// A command that acts for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HeldCommand<N> {
    /// Samples.
    pub(super) time: N,
    /// Its mean, and the additional distance per unit of gain because it came earlier than evenly
    /// spread, over the square of the time; command units.
    pub(super) command: N,
    pub(super) lead: N,
    /// By how much it falls in a sample.
    pub(super) falls: N,
    /// Step of the command at its end: before less after.
    pub(super) step: N,
}

impl<N: Number> Inputs<N> {
    /// A delay (samples) before the first piece.
    pub(super) fn delayed<const W: usize>(motion: &MotionRecord<N, W>, delay: N) -> Self {
        let first = motion.get(0).copied().unwrap_or(Piece::NONE);
        let before = Piece {
            samples: delay,
            lead: N::ZERO,
            ..first
        };
        Self {
            piece: before,
            left: delay,
            next: 0,
        }
    }

    /// Shows every command that acts over the next samples.
    pub(super) fn over<const W: usize>(
        &mut self,
        motion: &MotionRecord<N, W>,
        samples: N,
        mut act: impl FnMut(&HeldCommand<N>),
    ) {
        /// More commands than these cannot act in a piece; a bound in case of NaN.
        const MAX_COMMANDS: u32 = 64;
        let mut left = samples;
        for _ in 0..MAX_COMMANDS {
            let acting = self.take(motion, left);
            act(&acting);
            left = left - acting.time;
            if left <= N::ZERO {
                break;
            }
        }
    }

    /// The next acting input, for at most a time.
    fn take<const W: usize>(&mut self, motion: &MotionRecord<N, W>, most: N) -> HeldCommand<N> {
        let (half, twelve) = (N::from_f64(0.5), N::from_f64(12.0));
        let piece = self.piece;
        if self.left <= N::ZERO || piece.samples <= N::ZERO {
            let step = self.follow(motion);
            return HeldCommand {
                time: N::ZERO,
                command: piece.command,
                lead: N::ZERO,
                falls: N::ZERO,
                step,
            };
        }
        let per_sample = piece.samples.reciprocal();
        let falls = twelve * piece.lead * per_sample;
        let done = piece.samples - self.left;
        let ends = self.left <= most;
        let time = if ends { self.left } else { most };
        // The command falls evenly from one end of the piece to the other.
        let command = piece.command + falls * (half * (piece.samples - time) - done);
        let lead = piece.lead * time * per_sample;
        self.left = self.left - time;
        let step = if ends { self.follow(motion) } else { N::ZERO };
        HeldCommand {
            time,
            command,
            lead,
            falls,
            step,
        }
    }

    /// Continues with the next piece; returns the command before less the one after. The last acts for ever.
    fn follow<const W: usize>(&mut self, motion: &MotionRecord<N, W>) -> N {
        let end = |piece: &Piece<N>| N::from_f64(6.0) * piece.lead;
        let Some(&piece) = motion.get(self.next) else {
            self.left = N::REACH;
            self.piece = Piece {
                samples: N::REACH,
                lead: N::ZERO,
                ..self.piece
            };
            return N::ZERO;
        };
        self.next += 1;
        let step = self.piece.command - end(&self.piece) - piece.command - end(&piece);
        self.left = piece.samples;
        self.piece = piece;
        step
    }
}
