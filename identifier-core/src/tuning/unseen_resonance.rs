//! A resonance between two measured lines. The lines show it, but no fit has identified it.
//!
//! Let x = 1 − cos ωT, which is (ωT)²/2 far below the sampling frequency. A second mass with the share β changes the
//! sampled response of a servo. About its resonance ω₂ the factor is 1 + γ x/(x − x₂), γ = 2β x₂/(ω₂T)². At the
//! resonance it is at most γ x₂/(ζ ω₂T sin ω₂T). A line shows the real part of this change with its own deviation. An
//! image of a resonance beyond half of the sampling frequency is one of 2π − ω₂T.

use core::f64::consts::TAU;

use super::measured_line::MeasuredLine;
use super::sampled_response::{SampledServo, nu_at};
use crate::number::Complex;

/// The resonance that fits the lines about a frequency best: ν = tan(ω₂T/2), x₂ and γ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UnseenResonance {
    pub(super) nu: f64,
    x: f64,
    gamma: f64,
}

/// The lines on either side of a place, which goes up line by line.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct NearLines {
    /// x of a line, the real part of the change that it shows, and its variance.
    changes: [Option<[f64; 3]>; 2 * UnseenResonance::NEAR],
    /// Lines that were looked at.
    count: usize,
}

impl NearLines {
    /// Looks at the next line; true once all of those about the resonance above a place are known.
    pub(super) fn look(
        &mut self,
        place: usize,
        lines: &[MeasuredLine],
        servo: &SampledServo,
        sample_time: f64,
    ) -> bool {
        let last = place + UnseenResonance::NEAR;
        let next = self.count % self.changes.len();
        if self.count <= last
            && let Some(change) = self.changes.get_mut(next)
        {
            let line = lines.get(self.count);
            *change = line.and_then(|line| Self::change(line, servo, sample_time));
            self.count += 1;
        }
        self.count > last
    }

    fn change(line: &MeasuredLine, servo: &SampledServo, sample_time: f64) -> Option<[f64; 3]> {
        let nu = nu_at(line.frequency, sample_time)?;
        let expected = servo.at(nu);
        let variance = 0.5 * line.deviation * line.deviation / expected.power();
        let x = 2.0 * nu * nu / (1.0 + nu * nu);
        Some([x, (line.gain / expected).re - 1.0, variance])
    }

    fn at(&self, place: usize) -> Option<[f64; 3]> {
        let change = self.changes.get(place % self.changes.len());
        change.copied().flatten()
    }
}

impl UnseenResonance {
    /// Lines on either side that show it.
    const NEAR: usize = 2;

    /// The standard deviations by which it changes these lines at least.
    const SEEN: f64 = 3.0;

    /// Its damping ratio at worst, and the least share of a second mass that matters.
    const DAMPING: f64 = 0.005;
    const LEAST: f64 = 0.1;

    /// The resonance above the line at a place, halfway to the next line or to half of the sampling frequency. None if
    /// the lines about it show none.
    pub(super) fn above(place: usize, lines: &NearLines) -> Option<Self> {
        let [below, ..] = lines.at(place)?;
        let next = lines.at(place + 1).map_or(2.0, |[next, ..]| next);
        // Two lines may be the same.
        let x = (next > below).then_some(0.5 * (below + next))?;
        let (mut sum, mut weight) = (0.0, 0.0);
        for near in (place + 1).saturating_sub(Self::NEAR)..=place + Self::NEAR {
            if let Some([at, seen, variance]) = lines.at(near) {
                let of_one = at / (at - x);
                sum += of_one * seen / variance;
                weight += of_one * of_one / variance;
            }
        }
        let is_shown = sum > Self::SEEN * libm::sqrt(weight);
        is_shown.then(|| Self {
            nu: libm::sqrt(x / (2.0 - x)),
            x,
            gamma: sum / weight,
        })
    }

    /// True if a loop with this gain without it stays away from −1, at whatever phase it resonates.
    pub(super) fn is_borne(&self, gain: Complex, max_sensitivity: f64) -> bool {
        let size = libm::sqrt(gain.power());
        let distance = libm::sqrt((gain + 1.0).power());
        let angle = 2.0 * libm::atan(self.nu);
        let sine = 2.0 * self.nu / (1.0 + self.nu * self.nu);
        [angle, TAU - angle].into_iter().all(|angle| {
            let peak = self.gamma * self.x / (Self::DAMPING * angle * sine);
            let least = Self::LEAST * 2.0 * self.x / (angle * angle);
            self.gamma < least || distance - size * peak >= 1.0 / max_sensitivity
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{IdentifiedServo, ServoParameters};
    use crate::tuning::placement::Design;
    use crate::tuning::sampled_response::SampledResponse;
    use crate::tuning::{Cap, Mode, PossibleServo, Shown, Tuner, Tuning, TuningSettings};
    use std::vec::Vec;

    const TIME: f64 = 1e-3;

    const ONE_MASS: PossibleServo = PossibleServo {
        a: 0.2,
        b: 200.0,
        delay: TIME,
    };

    fn sampled(mode: Option<&Mode>) -> SampledServo {
        SampledServo::new(&ONE_MASS, mode, TIME)
    }

    /// Lines of a servo with this relative deviation at 500 Hz. The deviation falls with the square of the frequency.
    fn lines(mode: Option<&Mode>, deviation: f64) -> Vec<MeasuredLine> {
        let of = |place: i32| {
            let hertz = 6.0 * libm::pow(495.0 / 6.0, f64::from(place) / 31.0);
            let frequency = TAU * hertz;
            let gain = sampled(mode).at(nu_at(frequency, TIME).expect("below a half"));
            let part = deviation * (hertz / 500.0) * (hertz / 500.0);
            MeasuredLine {
                frequency,
                gain,
                deviation: part * libm::sqrt(gain.power()),
            }
        };
        (0..32).map(of).collect()
    }

    /// The gains for one mass with lines of the true servo.
    fn tuned(lines: &[MeasuredLine]) -> Tuning {
        let PossibleServo { a, b, delay } = ONE_MASS;
        let servo = IdentifiedServo::known(ServoParameters::new(a, b, 0.0, 0.0), delay);
        let settings = TuningSettings::new(TIME, 1e-6, 10.0, 0.1);
        let tuner = Tuner::new(&settings, &servo).expect("a servo");
        let mut state = tuner.start();
        let found =
            core::iter::from_fn(|| Some(tuner.work_with(&mut state, Shown::Lines(lines, true))));
        found.flatten().next().expect("it ends").expect("gains")
    }

    /// The largest |S| about a resonance.
    fn sensitivity(tuning: &Tuning, mode: &Mode) -> f64 {
        let response =
            SampledResponse::around(&Design::from_tuning(tuning), sampled(Some(mode)), TIME);
        let half = TAU / (2.0 * TIME);
        let image = half - libm::fabs(half - mode.frequency);
        let near = (-400..=400).map(|place| image * (1.0 + 1e-4 * f64::from(place)));
        let of = |nu| 1.0 / libm::sqrt((response.at(nu).gain() + 1.0).power());
        near.filter_map(|omega| nu_at(omega, TIME))
            .map(of)
            .fold(0.0, f64::max)
    }

    fn mode(hertz: f64, ratio: f64) -> Mode {
        Mode {
            frequency: TAU * hertz,
            damping: 0.01,
            ratio,
        }
    }

    #[test]
    fn lines_of_one_mass_leave_gains_as_they_are() {
        let free = tuned(&[]);
        assert_eq!(free.cap, Some(Cap::Delay));
        for deviation in [0.05, 0.5, 5.0] {
            let with_lines = tuned(&lines(None, deviation));
            assert_eq!(with_lines.cap, free.cap, "{deviation}");
            assert!((with_lines.bandwidth / free.bandwidth - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn gains_bear_a_resonance_that_the_lines_about_it_show() {
        let free = tuned(&[]);
        let mut harmful = 0;
        // The image of the last is one of 470 Hz.
        for hertz in [205.0, 300.0, 330.0, 440.0, 530.0] {
            let mode = mode(hertz, 0.5);
            let slower = tuned(&lines(Some(&mode), 0.2));
            assert_eq!(slower.cap, Some(Cap::UnseenResonance), "{hertz} Hz");
            let [slower, free] = [&slower, &free].map(|tuning| sensitivity(tuning, &mode));
            assert!(slower < 1.8, "{hertz} Hz: {slower} {free}");
            harmful += i32::from(free > 1.9);
        }
        assert!(harmful >= 2, "{harmful}");
    }

    #[test]
    fn its_share_is_that_which_the_lines_show() {
        let shown = |ratio: f64, deviation: f64| {
            let mode = mode(300.0, ratio);
            let lines = lines(Some(&mode), deviation);
            let below = lines.partition_point(|line| line.frequency < mode.frequency) - 1;
            let mut near = NearLines::default();
            while !near.look(below, &lines, &sampled(None), TIME) {}
            UnseenResonance::above(below, &near).map(|found| found.gamma)
        };
        let angle = TAU * 300.0 * TIME;
        let expected = 0.3 * 2.0 * (1.0 - libm::cos(angle)) / (angle * angle);
        let found = shown(0.3, 0.1).expect("two lines show it");
        assert!((found / expected - 1.0).abs() < 0.3, "{found} {expected}");
        assert_eq!(shown(0.3, 10.0), None);
        assert_eq!(shown(0.001, 0.1), None);
    }
}
