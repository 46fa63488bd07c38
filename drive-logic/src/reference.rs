//! Where the servo is sent: towards an aim at a bounded speed, shaken on top.

use drive_link::Settings;
use identifier_core::error::OutOfRange;
use identifier_core::excitation::{Excitation, Prbs, PrbsState};
use identifier_core::number::Number;
use identifier_core::units::Units;

/// Order of the pseudo-random sequence: 511 decisions, longer than any time constant it meets.
const ORDER: u32 = 9;

/// The reference with its progress, counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reference {
    shaking: Option<(Prbs<f32>, PrbsState)>,
    /// Counts a sample.
    pace: f32,
    aim: f32,
    at: f32,
}

impl Reference {
    pub(crate) fn new(settings: &Settings, units: &Units) -> Result<Self, OutOfRange> {
        let shaking = if settings.shaking.amplitude == 0.0 {
            None
        } else {
            let prbs = Prbs::new(
                units,
                settings.shaking.amplitude,
                settings.shaking.hold,
                ORDER,
            )?;
            Some((prbs, Excitation::<f32>::start(&prbs)))
        };
        Ok(Self {
            shaking,
            pace: (settings.protection.speed * units.velocity()) as f32,
            aim: 0.0,
            at: 0.0,
        })
    }

    /// Sends the servo elsewhere, counts from the origin.
    pub(crate) fn aim(&mut self, aim: f32) {
        self.aim = aim;
    }

    /// Follows a move of the origin.
    pub(crate) fn shift_origin(&mut self, moved: f32) {
        self.aim -= moved;
        self.at -= moved;
    }

    /// The reference of this sample, counts from the origin.
    #[inline]
    pub(crate) fn next(&mut self) -> f32 {
        let left = self.aim - self.at;
        self.at += left.limited(-self.pace, self.pace);
        match &mut self.shaking {
            Some((prbs, state)) => self.at + prbs.process(state),
            None => self.at,
        }
    }
}
