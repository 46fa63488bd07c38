//! The largest bandwidth that keeps everything.

use super::hidden_resonance::{HiddenResonances, ServoBelow};
use super::margins::{FrequencySweep, Margins, Progress};
use super::measured_line::MeasuredLine;
use super::placement::{Design, Placement};
use super::possible_servos::PossibleServos;
use super::resonance::Resonance;
use super::sampled_response::{SampledController, SampledResponse, SampledServo, nu_at};
use super::shown::Shown;
use super::unseen_resonance::{NearLines, UnseenResonance};
use super::{Cap, TuningSettings};
use crate::control::Notch;
use crate::number::Complex;

/// Criteria of a bandwidth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GainCheck {
    placement: Placement,
    servos: PossibleServos,
    /// The resonance of two masses, if a measured response shows them.
    resonance: Option<Resonance>,
    /// The servo as it was identified, with two masses if a measured response shows them.
    measured: SampledServo,
    hidden: HiddenResonances,
    /// The frequency at which gains may have a notch, rad/s.
    notch: Option<f64>,
    sample_time: f64,
    max_sensitivity: f64,
}

/// The check of one bandwidth, in progress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Case {
    design: Design,
    /// The servo whose loop is examined, and the sweep if it has begun. Servos of one mass come first, then those of
    /// two.
    place: usize,
    walk: Option<FrequencySweep>,
    margins: Margins,
    /// The measured line that comes next, before all servos, and those about it.
    line: usize,
    near: NearLines,
    /// The resonance that nothing has shown which comes next, before them.
    hidden: u16,
    /// True if its cut-off is lower for those.
    is_lowered: bool,
}

/// Result of the check of a bandwidth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Verdict {
    /// These gains keep everything, with these margins at worst.
    Passes(Design, Margins),
    /// This is broken.
    Fails(Cap),
}

/// A search in progress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Search {
    first: f64,
    bandwidth: f64,
    notched: bool,
    /// The largest bandwidth without the notch, once that is looked for.
    without: Option<Found>,
    /// Its check; none before it begins.
    case: Option<Case>,
    low: Option<(Design, Margins)>,
    high: Option<(f64, Cap)>,
    tried: u32,
}

/// Gains that keep everything, with their margins, and what keeps them from being faster if that was looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    pub(super) design: Design,
    pub(super) margins: Margins,
    pub(super) cap: Option<Cap>,
}

impl GainCheck {
    /// For Coulomb friction and the largest that it may be, rad/s².
    pub(super) fn new(
        servos: &PossibleServos,
        coulomb: [f64; 2],
        resonance: Option<&Resonance>,
        settings: &TuningSettings,
    ) -> Self {
        let highest = Notch::<f64>::HIGHEST / settings.sample_time;
        let mode = resonance.map(|resonance| resonance.mode);
        let notch = mode.map(|mode| mode.frequency);
        let identified = servos.identified();
        let measured = match resonance {
            Some(resonance) => SampledServo::of(
                resonance,
                &identified,
                &resonance.mode,
                settings.sample_time,
            ),
            None => SampledServo::new(&identified, None, settings.sample_time),
        };
        Self {
            measured,
            hidden: HiddenResonances::new(resonance, settings),
            notch: notch.filter(|frequency| settings.notch && *frequency <= highest),
            placement: Placement::new(servos, coulomb, settings),
            servos: *servos,
            resonance: resonance.copied(),
            sample_time: settings.sample_time,
            max_sensitivity: settings.max_sensitivity,
        }
    }

    /// True if gains may have a notch.
    pub(super) fn has_notch(&self) -> bool {
        self.notch.is_some()
    }

    /// The gains for a bandwidth, rad/s, whatever they keep.
    pub(super) fn design(&self, bandwidth: f64) -> Design {
        self.placement.design(bandwidth)
    }

    /// |S| at a frequency, rad/s: of the identified servo, with its two masses if it has them, and the largest of all.
    pub(super) fn sensitivity(&self, design: &Design, frequency: f64) -> Option<[f64; 2]> {
        let nu = nu_at(frequency, self.sample_time)?;
        let of = |servo: SampledServo| {
            let response = SampledResponse::around(design, servo, self.sample_time);
            1.0 / libm::sqrt((response.at(nu).gain() + 1.0).power())
        };
        let all = (0..).map_while(|place| Some(of(self.servo(place)?.0)));
        Some([of(self.measured), all.fold(0.0, f64::max)])
    }

    /// The highest bandwidth that is looked at, rad/s.
    pub(super) fn highest(&self) -> f64 {
        Placement::LARGEST_BANDWIDTH / self.sample_time
    }

    /// True if a controller, command units per rad at ν, bears the resonances that nothing has shown.
    pub(super) fn bears_hidden(
        &self,
        shown: Shown<'_>,
        controller: impl Fn(f64) -> Complex,
    ) -> bool {
        let mut borne = (0..).map_while(|place| self.is_borne(place, shown, &controller));
        borne.all(|is_borne| is_borne)
    }

    /// The same of those at a place in their list; none behind the last.
    fn is_borne(
        &self,
        place: usize,
        shown: Shown<'_>,
        controller: impl Fn(f64) -> Complex,
    ) -> Option<bool> {
        let servo = ServoBelow {
            sampled: &self.measured,
            delay: self.servos.identified().delay,
            sample_time: self.sample_time,
        };
        self.hidden.is_borne(place, shown, servo, controller)
    }

    /// Begins to check a bandwidth, rad/s, with or without the notch.
    pub(super) fn open(&self, bandwidth: f64, notched: bool) -> Case {
        let notch = self.notch.filter(|_| notched);
        self.open_design(Design {
            notch: notch.unwrap_or(0.0),
            ..self.design(bandwidth)
        })
    }

    /// Begins to check gains.
    pub(super) fn open_design(&self, design: Design) -> Case {
        Case {
            design,
            place: 0,
            walk: None,
            margins: Margins::AMPLE,
            line: 0,
            near: NearLines::default(),
            hidden: 0,
            is_lowered: false,
        }
    }

    /// A measured line, or the loop of a servo, or one frequency of it.
    pub(super) fn work(&self, case: &mut Case, shown: Shown<'_>) -> Option<Verdict> {
        let (lines, is_explained) = shown.lines();
        if case.line == 0
            && case.hidden == 0
            && case.place == 0
            && case.walk.is_none()
            && let Some(cap) = self.placement.forbids(&case.design)
        {
            return Some(Verdict::Fails(cap));
        }
        if let Some(measured) = lines.get(case.line) {
            let near = &mut case.near;
            if !near.look(case.line, lines, &self.measured, self.sample_time) {
                return None;
            }
            let cap = if !is_explained && !self.keeps(&case.design, measured) {
                Some(Cap::Resonance)
            } else {
                let unseen = UnseenResonance::above(case.line, &case.near);
                let borne = unseen.is_none_or(|unseen| self.bears(&case.design, &unseen));
                (!borne).then_some(Cap::UnseenResonance)
            };
            case.line += 1;
            return cap.map(Verdict::Fails);
        }
        let controller = |nu| SampledController::of(&case.design, self.sample_time, nu);
        if let Some(is_borne) = self.is_borne(case.hidden.into(), shown, controller) {
            case.hidden += 1;
            if is_borne {
                return None;
            }
            // A lower cut-off takes gain from all of them.
            let lower = self.placement.with_lower_cutoff(&case.design);
            return match lower {
                Some(design) => {
                    *case = self.open_design(design);
                    case.is_lowered = true;
                    None
                }
                None => Some(Verdict::Fails(Cap::UnseenResonance)),
            };
        }
        let Some(walk) = &mut case.walk else {
            case.walk = self.walk(&case.design, case.place);
            return (case.walk.is_none()).then_some(Verdict::Passes(case.design, case.margins));
        };
        match walk.work() {
            Progress::Continues => None,
            Progress::Fails if case.place >= PossibleServos::COUNT => {
                Some(Verdict::Fails(Cap::Resonance))
            }
            Progress::Fails => Some(Verdict::Fails(if case.is_lowered {
                Cap::UnseenResonance
            } else if case.design.smoothed {
                Cap::EncoderNoise
            } else {
                Cap::Delay
            })),
            Progress::Passes(margins) => {
                // The servos of two masses beside the measured one have a larger sensitivity, which is not part of
                // the prediction.
                if case.place <= PossibleServos::COUNT {
                    case.margins = case.margins.both(margins);
                }
                case.place += 1;
                case.walk = None;
                None
            }
        }
    }

    fn walk(&self, design: &Design, place: usize) -> Option<FrequencySweep> {
        /// The start of a sweep, as a part of the poles' magnitude.
        const FIRST: f64 = 1.0 / 32.0;
        let first = FIRST * design.bandwidth * self.sample_time;
        let (sampled, sensitivity) = self.servo(place)?;
        let response = SampledResponse::around(design, sampled, self.sample_time);
        Some(FrequencySweep::begin(response, first, sensitivity))
    }

    /// A servo by its place, those of one mass first, and the largest sensitivity with it.
    pub(super) fn servo(&self, place: usize) -> Option<(SampledServo, f64)> {
        if let Some(servo) = self.servos.get(place) {
            let sampled = SampledServo::new(servo, None, self.sample_time);
            return Some((sampled, self.max_sensitivity));
        }
        let place = place - PossibleServos::COUNT;
        let resonance = self.resonance.as_ref()?;
        let servo = resonance.servo(&self.servos, place)?;
        let sampled = SampledServo::of(resonance, &servo.servo, &servo.mode, self.sample_time);
        let sensitivity = 1.0 + servo.excess * (self.max_sensitivity - 1.0);
        Some((sampled, sensitivity))
    }

    /// True if a design keeps its distance from −1 near a resonance that the lines show between two of them.
    fn bears(&self, design: &Design, unseen: &UnseenResonance) -> bool {
        let open = SampledResponse::around(design, self.measured, self.sample_time);
        let gain = open.at(unseen.nu).gain();
        let sensitivity = 1.0 + Resonance::DIFFERING * (self.max_sensitivity - 1.0);
        // Friction and rounding blur lower lines, resonances show at higher ones.
        gain.power() > 1.0 || unseen.is_borne(gain, sensitivity)
    }

    /// True if a design keeps its distance from −1 on a measured line.
    fn keeps(&self, design: &Design, line: &MeasuredLine) -> bool {
        let Some(nu) = nu_at(line.frequency, self.sample_time) else {
            return true;
        };
        let controller = SampledController::of(design, self.sample_time, nu);
        let sensitivity = 1.0 + Resonance::DIFFERING * (self.max_sensitivity - 1.0);
        line.allows(controller, Placement::crossover(design), sensitivity)
    }
}

impl Case {
    /// The bandwidth that is checked, rad/s.
    pub(super) fn bandwidth(&self) -> f64 {
        self.design.bandwidth
    }

    /// True if its gains have the notch.
    pub(super) fn is_notched(&self) -> bool {
        self.design.notch > 0.0
    }
}

impl Search {
    /// The ratio of the two bandwidths between which the largest lies.
    const FINE: f64 = 1.005;

    /// Bandwidths that are tried at most; a range of 10¹⁵ from the first.
    const MAX_BANDWIDTHS: u32 = 50;

    /// The part by which a notch must make the bandwidth larger for gains to have one.
    const WORTH: f64 = 1.1;

    /// Begins at a bandwidth, without the notch.
    pub(super) fn from(bandwidth: f64) -> Self {
        Self {
            first: bandwidth,
            bandwidth,
            notched: false,
            without: None,
            case: None,
            low: None,
            high: None,
            tried: 0,
        }
    }

    /// Takes the largest bandwidth without the notch, and begins with it, or ends with the better of both.
    fn end(&mut self, judge: &GainCheck, found: Option<Found>) -> Option<Option<Found>> {
        let unseen = |found: Found| found.cap == Some(Cap::UnseenResonance);
        if !self.notched && judge.has_notch() && !found.is_some_and(unseen) {
            *self = Self {
                notched: true,
                without: found,
                ..Self::from(self.first)
            };
            return None;
        }
        let Some(without) = self.without else {
            return Some(found);
        };
        let is_worth =
            |with: &Found| with.design.bandwidth > Self::WORTH * without.design.bandwidth;
        Some(Some(found.filter(is_worth).unwrap_or(without)))
    }

    /// One slice: the gains for a bandwidth, or one frequency of one servo. At the end it gives the largest bandwidth,
    /// or none if there is none.
    pub(super) fn work(&mut self, judge: &GainCheck, shown: Shown<'_>) -> Option<Option<Found>> {
        let bandwidth = self.bandwidth;
        let Some(case) = &mut self.case else {
            self.case = Some(judge.open(bandwidth, self.notched));
            return None;
        };
        match judge.work(case, shown)? {
            Verdict::Passes(design, margins) => self.low = Some((design, margins)),
            Verdict::Fails(cap) => self.high = Some((bandwidth, cap)),
        }
        self.tried += 1;
        let next = match (self.low, self.high) {
            (Some((design, margins)), Some((high, cap))) => {
                if high < Self::FINE * design.bandwidth {
                    let found = Found {
                        design,
                        margins,
                        cap: Some(cap),
                    };
                    return self.end(judge, Some(found));
                }
                libm::sqrt(design.bandwidth * high)
            }
            (Some((design, _)), None) => 2.0 * design.bandwidth,
            (None, _) => 0.5 * bandwidth,
        };
        if self.tried >= Self::MAX_BANDWIDTHS {
            return self.end(judge, None);
        }
        self.bandwidth = next;
        self.case = None;
        None
    }
}
