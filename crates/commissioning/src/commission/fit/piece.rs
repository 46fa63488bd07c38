use identifier_core::fit::Block;
use identifier_core::identifier::NumberedBlock;
use identifier_core::number::Number;

/// A block of any number of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece<N> {
    pub(super) samples: N,
    pub(super) block: Block<N>,
}

impl<N: Number> Piece<N> {
    pub(super) const NONE: Self = Self {
        samples: N::ZERO,
        block: Block {
            travel: N::ZERO,
            command: N::ZERO,
            first_moment: N::ZERO,
        },
    };

    /// A recorded block.
    pub(super) fn from_block(numbered: &NumberedBlock<N>) -> Self {
        let NumberedBlock { samples, block, .. } = *numbered;
        Self { samples, block }
    }

    /// This piece and the next as one.
    pub(super) fn followed_by(&self, next: &Self) -> Self {
        let samples = self.samples + next.samples;
        let part = self.samples * samples.reciprocal();
        let rest = N::ONE - part;
        let half = N::from_f64(0.5);
        let [own, next] = [&self.block, &next.block];
        Self {
            samples,
            block: Block {
                travel: own.travel + next.travel,
                command: part * own.command + rest * next.command,
                first_moment: part * part * own.first_moment
                    + rest * rest * next.first_moment
                    + half * part * rest * (own.command - next.command),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Piece;

    use identifier_core::fit::{Blocking, Recorder};

    #[test]
    fn pieces_of_pieces_move_a_mass_as_their_samples_do() {
        let commands = [3.0, -1.0, 4.0, 1.0, -5.0, 9.0, 2.0, -6.0];
        let (mut motion_direction, mut velocity) = (0.0, 0.0);
        for command in commands {
            motion_direction += velocity + 0.5 * command;
            velocity += command;
        }
        let joined = |commands: &[f64]| {
            let mut recorder = Recorder::default();
            let blocking = Blocking::new(commands.len() as u32);
            for command in commands.iter().chain(&[0.0]) {
                recorder.push(&blocking, 1.0, *command);
            }
            Piece::from_block(&recorder.take().expect("a block"))
        };
        let Piece { samples, block } = joined(&commands[..3]).followed_by(&joined(&commands[3..]));
        assert!((samples - 8.0).abs() < 1e-12 && (block.travel - 8.0).abs() < 1e-12);
        assert!((block.command * samples - velocity).abs() < 1e-12);
        assert!(
            ((0.5 * block.command + block.first_moment) * samples * samples - motion_direction)
                .abs()
                < 1e-12
        );
    }
}
