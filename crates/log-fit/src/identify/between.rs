//! What acted between the rows of a log that is slower than its loop.

/// What a row has of the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Between {
    /// It was held until the next row.
    #[default]
    Held,
    /// A sample of one that changes between rows.
    Sampled,
    /// The mean since the row before.
    Averaged,
}

impl Between {
    /// What it is called in results; none of a command that was held.
    #[must_use]
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Self::Held => None,
            Self::Sampled => Some("sampled"),
            Self::Averaged => Some("averaged"),
        }
    }

    /// The commands that, held from row to row, move a mass from row to row as those of a motion do, to the fourth order of
    /// the time between rows. Of samples u the positions follow (u₋ + 10 u + u₊)/12, as Numerov's method has it; of means, a
    /// half more of what these leave out.
    pub(super) fn acted(self, commands: &[f64]) -> Vec<f64> {
        let last = commands.len().saturating_sub(1);
        let of_row = |row: usize| {
            let at = |away: isize| commands[row.saturating_add_signed(away).min(last)];
            match self {
                Self::Held => at(0),
                Self::Sampled => (7.0 * (at(0) + at(1)) - at(-1) - at(2)) / 12.0,
                Self::Averaged => (14.0 * at(1) - at(0) - at(2)) / 12.0,
            }
        };
        (0..commands.len()).map(of_row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Between;

    /// Second differences of a mass under cos ωt, in rows of time 1, beside those under the commands that stand in for it: of held
    /// commands they are ½ (u₋ + u).
    #[test]
    fn what_stands_in_for_a_command_between_rows_moves_a_mass_as_that_does() {
        for omega in [0.1_f64, 0.3, 0.6] {
            let time = |row: usize| row as f64 + 0.2;
            let samples: Vec<f64> = (0..40).map(|row| (omega * time(row)).cos()).collect();
            let mean = |row: usize| {
                ((omega * time(row)).sin() - (omega * (time(row) - 1.0)).sin()) / omega
            };
            let means: Vec<f64> = (0..40).map(mean).collect();
            let half = 0.5 * omega;
            let moved = (half.sin() / half).powi(2);
            let off = |between: Between, commands: &[f64]| {
                let acted = between.acted(commands);
                let rows = 5..35;
                let errors = rows.map(|row| {
                    let true_change = moved * (omega * time(row)).cos();
                    (0.5 * (acted[row - 1] + acted[row]) - true_change).abs()
                });
                errors.fold(0.0, f64::max)
            };
            let fourth = omega.powi(4) / 25.0;
            assert!(off(Between::Sampled, &samples) < fourth, "{omega}");
            assert!(off(Between::Averaged, &means) < fourth, "{omega}");
            assert!(off(Between::Held, &samples) > 0.3 * omega, "{omega}");
        }
    }
}
