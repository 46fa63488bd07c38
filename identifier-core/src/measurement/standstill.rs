//! Detection of standstill, from counts and time alone.

use crate::constants::{Encode, encode};
use crate::number::Arithmetic;
use crate::scales::FullScales;
use crate::units::Units;

/// A servo is at standstill once it has stayed within [`Standstill::SLIP`] counts of one place for
/// [`Standstill::PATIENCE`].
///
/// No estimate takes part. With too large a friction estimate every velocity would count as standstill. The model would
/// be kept at the servo's position, and the estimate would never be corrected. A servo with friction under a constant
/// reference sometimes breaks away by a count or two, as the controller's integral grows. That does not count as
/// motion: within one or two counts the encoder does not show how the servo moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Standstill<N> {
    slip: N,
    /// Samples.
    patience: u32,
    pause: u32,
    hidden: N,
}

encode! {
    [N: Encode] Standstill<N> as "Standstill" { slip, patience, pause, hidden }
}

/// The state of the detection.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rest<N> {
    /// Distance of the servo from the place at which it may be at standstill, position units.
    away: N,
    /// Samples since it reached that place.
    still: u32,
    /// Samples of standstill although the command should move it.
    pushed: u32,
}

impl<N: Arithmetic> Standstill<N> {
    /// Largest slip of a servo at standstill, counts (position units).
    pub(crate) const SLIP: f64 = 4.0;

    /// Time within the slip that makes a standstill, s.
    pub(crate) const PATIENCE: f64 = 0.1;

    /// The part of that time after which a model that friction holds is set to the servo's position,
    /// s.
    pub(crate) const PAUSE: f64 = 0.02;

    /// For a loop with these units.
    pub(crate) fn new(units: &Units, scales: &FullScales) -> Self {
        let patience = libm::ceil(Self::PATIENCE / units.sample_time());
        let hidden = 2.0 * Self::SLIP / (patience * patience);
        Self {
            slip: N::signal(Self::SLIP, scales.velocity),
            patience: patience as u32,
            pause: libm::ceil(Self::PAUSE / units.sample_time()) as u32,
            hidden: N::signal(hidden, scales.velocity),
        }
    }

    /// A servo at standstill from the start.
    pub(crate) fn at_rest(&self) -> Rest<N> {
        Rest {
            away: N::ZERO,
            still: self.patience,
            pushed: 0,
        }
    }

    /// True if the servo has stayed within a slip for a [`Standstill::PAUSE`].
    #[inline(always)]
    pub(crate) fn is_paused(&self, rest: &Rest<N>) -> bool {
        rest.still >= self.pause
    }

    /// True if a servo at standstill has not moved for a [`Standstill::PATIENCE`] although its command should move it.
    /// `should_move` is true if it should in this sample.
    pub(crate) fn is_stuck_under_command(&self, rest: &mut Rest<N>, should_move: bool) -> bool {
        if !should_move {
            rest.pushed = 0;
            return false;
        }
        let is_stuck_under_command = rest.pushed >= self.patience;
        if !is_stuck_under_command {
            rest.pushed += 1;
        }
        is_stuck_under_command
    }

    /// The acceleration (machine units) that moves a servo by no more than a slip within that time.
    pub(crate) fn hidden_acceleration(&self) -> N {
        self.hidden
    }

    /// Takes the increment of a sample; true at standstill.
    #[inline(always)]
    pub(crate) fn is_still(&self, rest: &mut Rest<N>, increment: N) -> bool {
        rest.away = rest.away + increment;
        if rest.away.magnitude() > self.slip {
            *rest = Rest::default();
            return false;
        }
        self.waits(rest)
    }

    /// The same for a servo without friction, which does not slip: any count is motion.
    #[inline(always)]
    pub(crate) fn is_at_rest(&self, rest: &mut Rest<N>, increment: N) -> bool {
        if increment != N::ZERO {
            (rest.still, rest.pushed) = (0, 0);
            return false;
        }
        self.waits(rest)
    }

    #[inline(always)]
    fn waits(&self, rest: &mut Rest<N>) -> bool {
        let is_still = rest.still >= self.patience;
        if !is_still {
            rest.still += 1;
        }
        is_still
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_takes_a_time_and_not_a_number_of_samples() {
        for sample_time in [4e-3, 1e-3, 5e-5] {
            let units = Units::new(sample_time, 1e-3).expect("valid");
            let standstill = Standstill::<f32>::new(&units, &FullScales::NONE);
            let (mut slipping, mut resting) = (Rest::default(), Rest::default());
            for _ in 0..3 {
                assert!(!standstill.is_still(&mut slipping, -5.0));
                assert!(!standstill.is_at_rest(&mut resting, -1.0));
                let waited = (0..10_000).position(|_| {
                    let is_still = standstill.is_still(&mut slipping, 0.0);
                    assert_eq!(standstill.is_at_rest(&mut resting, 0.0), is_still);
                    is_still
                });
                let time = waited.expect("it stands") as f64 * sample_time;
                let off = (time - Standstill::<f32>::PATIENCE).abs();
                assert!(off <= sample_time, "{time}");
            }
        }
    }

    #[test]
    fn a_slip_of_a_few_counts_is_no_motion_and_a_creeping_servo_moves() {
        let units = Units::new(1e-3, 1e-3).expect("valid");
        let standstill = Standstill::<f32>::new(&units, &FullScales::NONE);
        let mut rest = Rest::default();
        let stood = |rest: &mut Rest<f32>, increment: &dyn Fn(u32) -> f32| {
            let is_still = |k: &u32| standstill.is_still(rest, increment(*k));
            (200..20_000).filter(is_still).count()
        };
        // Three counts forth and back, three times a second.
        let slips = stood(&mut rest, &|k| match k % 333 {
            0 => 3.0,
            150 => -3.0,
            _ => 0.0,
        });
        assert!(slips > 19_000, "{slips}");
        // Sixty counts a second.
        let mut rest = Rest::default();
        let creeps = stood(&mut rest, &|k| if k % 16 == 0 { 1.0 } else { 0.0 });
        assert!(creeps == 0, "{creeps}");
    }
}
