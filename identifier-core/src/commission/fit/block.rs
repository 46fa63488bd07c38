use crate::fit::{Block, NumberedBlock};
use crate::number::Number;

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

    /// A recorded block.
    pub(crate) fn from_block(numbered: &NumberedBlock<N>) -> Self {
        let Block {
            travel,
            command,
            lead,
        } = numbered.block;
        Self {
            samples: numbered.samples,
            travel,
            command,
            lead,
        }
    }

    /// This piece and the next as one.
    pub(crate) fn followed_by(&self, next: &Self) -> Self {
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

    use crate::fit::{Blocking, Recorder};

    #[test]
    fn pieces_of_pieces_move_a_mass_as_their_samples_do() {
        let commands = [3.0, -1.0, 4.0, 1.0, -5.0, 9.0, 2.0, -6.0];
        let (mut way, mut velocity) = (0.0, 0.0);
        for command in commands {
            way += velocity + 0.5 * command;
            velocity += command;
        }
        let joined = |commands: &[f64]| {
            let mut recorder = Recorder::EMPTY;
            for command in commands.iter().chain(&[0.0]) {
                recorder.push(&Blocking::new(99), 1.0, *command);
            }
            recorder.end_block();
            Piece::from_block(&recorder.take().expect("a block"))
        };
        let whole = joined(&commands[..3]).followed_by(&joined(&commands[3..]));
        let time = whole.samples;
        assert!((time - 8.0).abs() < 1e-12 && (whole.travel - 8.0).abs() < 1e-12);
        assert!((whole.command * time - velocity).abs() < 1e-12);
        assert!(((0.5 * whole.command + whole.lead) * time * time - way).abs() < 1e-12);
    }
}
