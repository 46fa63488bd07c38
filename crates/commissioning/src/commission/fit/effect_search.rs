use super::comparison::{Comparison, sizes_of};
use super::effect::{Effect, SIZES, Sizes};
use super::motion::MotionRecord;
use super::prediction::PredictionErrors;
use super::scales::RecordScales;
use super::servo_fit::ServoFit;
use super::servo_fitter::ServoFitter;
use super::{ALL, B, PARAMETERS, POSITION, UNKNOWNS, VELOCITY};
use identifier_core::fit::ROUNDING;
use identifier_core::fit::{Descent, DescentSettings, Explanation};
use identifier_core::model::FrictionStep;
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;

/// The search for the effect that best explains the rest of a motion beyond the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Diagnosis {
    /// The reason that names it.
    pub reason: Reason,
    /// The part of the squared errors that it explains, 0 to 1. The servo's own parameters are fitted with it and
    /// without it.
    pub share: f64,
    /// The dead band, where one alone explains much of them, command units; else zero.
    pub dead_band: f64,
}

/// A search for it under way. The model is fitted to the record again, with each of the effects in turn.
///
/// An effect whose size is not linear in the motion, as a frequency, is searched from many first sizes. A pass from
/// each predicts its gain, and the fit continues from the most promising.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EffectSearch<N> {
    resolution: N,
    scales: RecordScales,
    own_bounds: [[N; UNKNOWNS]; 2],
    /// These with the bounds of the sizes of the present effect.
    bounds: [[N; ALL]; 2],
    /// The servo's own unknowns, from which each effect is looked for.
    own: [N; UNKNOWNS],
    /// The place among the effects, and the first size that is tried.
    place: usize,
    start: u32,
    /// The most promising so far, and its remaining cost.
    promising: Option<(u32, f64)>,
    comparison: Option<Comparison<N>>,
    descent: Descent<N, ALL>,
    /// The squared errors that are left without an effect.
    without: f64,
    /// The reason that names the best effect, and its remaining cost; the same of a dead band.
    found: Option<(Reason, f64)>,
    dead_band: (f64, f64),
}

impl<N: Number> EffectSearch<N> {
    /// The fit with an effect.
    const DESCENT: DescentSettings = DescentSettings {
        damping: 1e-3,
        max_passes: 16,
        min_change: 1e-3,
    };
    /// A motion is explained if the variance of the errors is below this many times the encoder's.
    const EXPLAINED: f64 = 1.5;
    /// A dead band may exist too. It must explain this part of the errors and leave at most this multiple of the best
    /// effect's remainder.
    const DEAD_BAND: f64 = 0.8;
    const ALIKE: f64 = 3.0;
    /// Largest displacement by the effect at the beginning of a record, counts. Also its largest speed, over the mean
    /// speed.
    const PLACE: f64 = 20.0;
    const SPEED: f64 = 0.3;

    /// From unknowns of a servo, within bounds.
    pub(super) fn new<const W: usize>(
        own: &[N; UNKNOWNS],
        bounds: &[[N; UNKNOWNS]; 2],
        resolution: f64,
        motion: &MotionRecord<N, W>,
    ) -> Self {
        let scales = RecordScales::from_record(motion, own[B]);
        Self {
            resolution: N::from_f64(resolution),
            own_bounds: *bounds,
            bounds: [[N::ZERO; ALL]; 2],
            scales,
            own: *own,
            place: 0,
            start: 0,
            promising: None,
            comparison: None,
            descent: Descent::begin(&Self::DESCENT),
            without: 0.0,
            found: None,
            dead_band: (0.0, f64::MAX),
        }
    }

    /// Continues by a block of the record, or by the work between two passes. Returns once there is no more
    /// to do; with nothing if no effect explains anything.
    pub(super) fn advance<const W: usize>(
        &mut self,
        step: &FrictionStep<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<Option<Diagnosis>> {
        let Some(&effect) = Effect::ALL.get(self.place) else {
            return Some(self.diagnosis());
        };
        match &mut self.comparison {
            None => self.begin(effect),
            Some(comparison) => {
                if comparison.advance(step, motion) {
                    self.end_pass(effect, motion);
                }
            }
        }
        None
    }

    /// True if the first size is still to be chosen.
    fn is_choosing(&self, effect: Effect) -> bool {
        self.start < effect.starts() && effect.starts() > 1
    }

    /// Begins to look for an effect, from the first size that is next.
    fn begin(&mut self, effect: Effect) {
        let chosen = self.promising.map_or(0, |(start, _)| start);
        let start = if self.is_choosing(effect) {
            self.start
        } else {
            chosen
        };
        let first = effect.first(start, &self.scales);
        self.bounds = self.bounds_of(effect, &first);
        self.begin_pass(effect, &joined(&self.own, &first));
    }

    fn bounds_of(&self, effect: Effect, first: &Sizes) -> [[N; ALL]; 2] {
        let sizes = effect.bounds(first, &self.scales);
        let mut bounds: [[N; ALL]; 2] =
            core::array::from_fn(|end| joined(&self.own_bounds[end], &sizes[end]));
        if effect == Effect::Resonance {
            // One that swings on its spring need not stand.
            let speed = Self::SPEED * self.scales.speed;
            for (bound, sign) in bounds.iter_mut().zip([-1.0, 1.0]) {
                bound[POSITION] = N::from_f64(sign * Self::PLACE);
                bound[VELOCITY] = N::from_f64(sign * speed);
            }
        }
        bounds
    }

    fn begin_pass(&mut self, effect: Effect, unknowns: &[N; ALL]) {
        let [low, high] = &self.bounds;
        let unknowns = core::array::from_fn(|i| unknowns[i].limited(low[i], high[i]));
        let own = self.scales.changes().map(N::from_f64);
        let sizes = effect.changes(&sizes_of(&unknowns), &self.scales);
        let changes = joined(&own, &sizes);
        let begun = Comparison::new(effect, self.resolution, &unknowns, &changes);
        self.comparison = Some(begun);
    }

    fn end_pass<const W: usize>(&mut self, effect: Effect, motion: &MotionRecord<N, W>) {
        let Some(pass) = self.comparison.take() else {
            return;
        };
        if self.is_choosing(effect) {
            let left = pass.promises();
            if left.is_finite() && self.promising.is_none_or(|(_, least)| left < least) {
                self.promising = Some((self.start, left));
            }
            self.start += 1;
            return;
        }
        let pass = Explanation {
            unknowns: pass.unknowns,
            equations: pass.equations,
            sums: (),
        };
        let next = self.next_trial(pass);
        let (Some(mut next), Some(best)) = (next, self.descent.best()) else {
            self.conclude(effect, motion.len());
            return;
        };
        let most = effect.most(&sizes_of(&best.unknowns));
        for i in 0..SIZES {
            let (at, most) = (best.unknowns[UNKNOWNS + i], N::from_f64(most[i]));
            let size = &mut next[UNKNOWNS + i];
            *size = size.limited(at - most, at + most);
        }
        self.begin_pass(effect, &next);
    }

    /// The unknowns of the next pass within bounds; none if this one was the last.
    fn next_trial(&mut self, pass: Explanation<N, ALL>) -> Option<[N; ALL]> {
        let [low, high] = &self.bounds;
        let descent = &mut self.descent;
        let mut next = descent.descend(&Self::DESCENT, pass, [true; ALL], [low, high])?;
        // A gain does not change its sign, nor its size at once.
        let gain = descent.best()?.unknowns[B];
        let [half, three] = [0.5, 3.0].map(N::from_f64);
        next[B] = next[B].limited(half * gain, three * gain);
        Some(next)
    }

    /// Takes the result of a fit with an effect, and continues with the next.
    fn conclude(&mut self, effect: Effect, blocks: usize) {
        let mut explained = false;
        if let Some(best) = self.descent.best() {
            let left = best.equations.cost().to_f64();
            let sizes = sizes_of(&best.unknowns);
            explained = left < Self::EXPLAINED * ROUNDING * blocks as f64;
            match effect.reason() {
                Some(_) if !effect.is_material(&sizes) => {}
                None => {
                    self.without = left;
                    self.own.copy_from_slice(&best.unknowns[..UNKNOWNS]);
                }
                Some(reason) => {
                    if self.found.is_none_or(|(_, least)| left < least) {
                        self.found = Some((reason, left));
                    }
                    if effect == Effect::DeadBand {
                        self.dead_band = (sizes[0], left);
                    }
                }
            }
        }
        // An effect that explains everything needs no rival.
        self.place = if explained {
            Effect::ALL.len()
        } else {
            self.place + 1
        };
        self.start = 0;
        self.promising = None;
        self.descent = Descent::begin(&Self::DESCENT);
    }

    /// The largest squared errors of a model that contains the cause. They are those of rounding, and of the part of
    /// the range that any model may lack. A load that changes with the angle fits much of any large misfit, but leaves
    /// more. A true second mass leaves more as well, because the search has its friction on both masses alike.
    fn max_left(&self) -> f64 {
        let share = PredictionErrors::SHARE * self.scales.range;
        let rounding = PredictionErrors::ERRORS * PredictionErrors::ERRORS * ROUNDING;
        (rounding + share * share) * self.scales.blocks
    }

    fn diagnosis(&self) -> Option<Diagnosis> {
        let (reason, left) = self.found.filter(|&(reason, left)| {
            reason == Reason::LacksResonance || left <= self.max_left()
        })?;
        let (dead_band, alone) = self.dead_band;
        let is_there =
            alone <= Self::ALIKE * left && alone <= (1.0 - Self::DEAD_BAND) * self.without;
        let part = left / self.without.max(f64::MIN_POSITIVE);
        Some(Diagnosis {
            reason,
            share: 1.0 - part.min(1.0),
            dead_band: if is_there { dead_band } else { 0.0 },
        })
    }
}

/// A servo's parameters with the place and the velocity of one at rest.
fn at_rest<N: Number>(parameters: &[N; PARAMETERS]) -> [N; UNKNOWNS] {
    core::array::from_fn(|i| parameters.get(i).copied().unwrap_or(N::ZERO))
}

/// A servo's own unknowns with sizes.
fn joined<N: Number>(own: &[N; UNKNOWNS], sizes: &Sizes) -> [N; ALL] {
    core::array::from_fn(|i| match i.checked_sub(UNKNOWNS) {
        None => own[i],
        Some(size) => N::from_f64(sizes[size]),
    })
}

impl<N: Number> ServoFitter<N> {
    /// Begins the search for an unmodelled effect of a servo in a motion.
    #[must_use]
    pub(crate) fn begin_diagnosis<const W: usize>(
        &self,
        servo: &IdentifiedServo,
        motion: &MotionRecord<N, W>,
    ) -> EffectSearch<N> {
        self.diagnosing(&at_rest(&self.parameters(servo)), motion)
    }

    /// The same for a fit without a plausible servo; none if it had nothing to begin with.
    #[must_use]
    pub(crate) fn begin_diagnosis_of<const W: usize>(
        &self,
        fit: &ServoFit<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<EffectSearch<N>> {
        // Where the fit went to may be far away.
        let first = at_rest(&fit.linear_estimate());
        (first[B] > N::ZERO).then(|| self.diagnosing(&first, motion))
    }

    /// Continues by a block of the record, or by the work between two passes. Returns once it has ended,
    /// with nothing if no effect explains anything.
    pub(crate) fn diagnose<const W: usize>(
        &self,
        diagnosing: &mut EffectSearch<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<Option<Diagnosis>> {
        diagnosing.advance(&self.step, motion)
    }

    fn diagnosing<const W: usize>(
        &self,
        own: &[N; UNKNOWNS],
        motion: &MotionRecord<N, W>,
    ) -> EffectSearch<N> {
        let bounds = self.bounds(motion, self.speed_at_first(motion, true));
        let bounds = bounds.map(|bound| bound.map(N::from_f64));
        EffectSearch::new(own, &bounds, self.resolution(), motion)
    }
}
