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
