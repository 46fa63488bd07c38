use crate::number::Number;

/// Successive samples condensed to the inputs of one model step over all of them, on their way from the
/// interrupt that recorded them to the background that fits to them.
///
/// A block ends where the command changes by much, so that within it the command is nearly constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MotionBlock<N> {
    /// Blocks between which nothing is missing have successive numbers.
    pub(crate) number: u32,
    pub(crate) piece: Piece<N>,
}

/// A piece of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece<N> {
    /// Samples.
    pub(crate) samples: N,
    /// The servo's increment, counts.
    pub(crate) travel: N,
    /// Mean command, command units.
    pub(crate) command: N,
    /// The additional distance per unit of gain within the piece because the command came earlier than
    /// evenly spread, over the square of its time: ∑ⱼ (m − j − ½) uⱼ/m² − ū/2 for m samples.
    pub(crate) lead: N,
}

impl<N: Number> Piece<N> {
    pub(crate) const NONE: Self = Self {
        samples: N::ZERO,
        travel: N::ZERO,
        command: N::ZERO,
        lead: N::ZERO,
    };

    /// A sample.
    pub(crate) fn of_sample(travel: N, command: N) -> Self {
        Self {
            samples: N::ONE,
            travel,
            command,
            lead: N::ZERO,
        }
    }

    /// This piece and the next as one.
    pub(crate) fn followed_by(&self, next: &Self) -> Self {
        if self.samples == N::ZERO {
            return *next;
        }
        let samples = self.samples + next.samples;
        let part = self.samples * samples.reciprocal();
        let rest = N::ONE - part;
        let half = N::from_f64(0.5);
        Self {
            samples,
            travel: self.travel + next.travel,
            command: part * self.command + rest * next.command,
            lead: part * part * self.lead
                + rest * rest * next.lead
                + half * part * rest * (self.command - next.command),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Piece;

    #[test]
    fn pieces_of_pieces_move_a_mass_as_their_samples_do() {
        let commands = [3.0, -1.0, 4.0, 1.0, -5.0, 9.0, 2.0, -6.0];
        let (mut way, mut velocity) = (0.0, 0.0);
        for command in commands {
            way += velocity + 0.5 * command;
            velocity += command;
        }
        let joined = |commands: &[f64]| {
            let pieces = commands
                .iter()
                .map(|&command| Piece::of_sample(1.0, command));
            pieces.fold(Piece::NONE, |sum, piece| sum.followed_by(&piece))
        };
        let whole = joined(&commands[..3]).followed_by(&joined(&commands[3..]));
        let time = whole.samples;
        assert!((time - 8.0).abs() < 1e-12 && (whole.travel - 8.0).abs() < 1e-12);
        assert!((whole.command * time - velocity).abs() < 1e-12);
        assert!(((0.5 * whole.command + whole.lead) * time * time - way).abs() < 1e-12);
    }
}
