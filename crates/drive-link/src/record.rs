//! The record of a drive that survives a loss of power.

use commissioning::TrialResult;
use identifier_core::identifier::ExpectedMotion;
use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::Tuning;
use serde::{Deserialize, Serialize};

use crate::message::Estimates;
use crate::settings::Settings;

/// All of it, so that nothing of one record ever holds beside something of another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The configuration; the gains are those that hold.
    pub settings: Settings,
    /// Estimates of the last run that was saved.
    pub estimates: Option<Estimates>,
    /// The commissioning that the gains come from, unless they were given.
    pub commissioned: Option<Commissioned>,
    /// A commissioning has begun since, and its end was not kept.
    pub under_way: bool,
}

/// The validated result of a commissioning.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Commissioned {
    parameters: ServoParameters,
    delay: f64,
    /// The covariance is symmetric: row by row up to the diagonal.
    covariance: [f64; ENTRIES],
    unexplained: f64,
    /// The gains and their predicted response.
    pub tuning: Tuning,
    /// The trial of the gains on the servo.
    pub trial: Option<TrialResult>,
}

/// Entries of a covariance of five unknowns that are not there twice.
const ENTRIES: usize = 15;

impl Record {
    /// The version of its bytes: another one is another meaning of them.
    pub const VERSION: u16 = 15;

    /// One with the same bytes, whose loads may have been learnt from a jam.
    pub const WITH_UNPROVEN_LOADS: u16 = 14;

    /// The same without what runs have learnt of the load.
    #[must_use]
    pub fn without_loads(mut self) -> Self {
        if let Some(estimates) = &mut self.estimates {
            estimates.servo.load = 0.0;
        }
        self
    }

    /// Writes it behind the fingerprint of its build, and returns the number of bytes; none if there is not room for it.
    #[inline(never)]
    pub fn to_bytes(&self, build: u32, room: &mut [u8]) -> Option<usize> {
        let (begin, rest) = room.split_first_chunk_mut()?;
        *begin = build.to_le_bytes();
        let used = postcard::to_slice(self, rest).ok()?;
        Some(begin.len() + used.len())
    }

    /// Reads it; none if these bytes are no record. The error is the fingerprint of another build, whose numbers mean
    /// something else here.
    #[inline(never)]
    #[must_use]
    pub fn from_bytes(build: u32, bytes: &[u8]) -> Option<Result<Self, u32>> {
        let (begin, rest) = bytes.split_first_chunk()?;
        match u32::from_le_bytes(*begin) {
            own if own == build => postcard::from_bytes(rest).ok().map(Ok),
            other => Some(Err(other)),
        }
    }
}

impl Commissioned {
    /// The record of an identified servo, with the gains for it.
    #[must_use]
    pub fn new(servo: &IdentifiedServo, tuning: Tuning, trial: Option<TrialResult>) -> Self {
        let mut covariance = [0.0; ENTRIES];
        let lower = servo
            .covariance
            .iter()
            .zip(1..)
            .flat_map(|(row, columns)| row.iter().take(columns));
        for (place, &entry) in covariance.iter_mut().zip(lower) {
            *place = entry;
        }
        Self {
            parameters: servo.parameters,
            delay: servo.delay,
            covariance,
            unexplained: servo.unexplained,
            tuning,
            trial,
        }
    }

    /// The servo that was found.
    #[must_use]
    pub fn servo(&self) -> IdentifiedServo {
        let entry = |i: usize, j: usize| {
            let (row, column) = (i.max(j), i.min(j));
            let place = row * (row + 1) / 2 + column;
            self.covariance.get(place).copied().unwrap_or_default()
        };
        IdentifiedServo {
            parameters: self.parameters,
            delay: self.delay,
            covariance: core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j))),
            unexplained: self.unexplained,
        }
    }

    /// The motion that its gains give to the servo.
    #[must_use]
    pub fn motion(&self) -> ExpectedMotion {
        ExpectedMotion {
            bandwidth: self.tuning.bandwidth,
            command: self.tuning.kp * self.tuning.predicted_response.step,
        }
    }
}
