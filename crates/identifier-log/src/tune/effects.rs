//! What each effect of a result does to the loop that its gains close: it is used, it bounds what the loop can do, or there
//! are no gains.

use identifier_core::parameters::{IdentifiedServo, Unknown};
use identifier_core::tuning::{
    AxisForces, HiddenMode, Mode, Resonance, Shown, Tuner, Tuning, TuningError, TuningSettings,
};

use crate::result::{KeptEffect, SecondMode};
use crate::verdict::Cause;

/// The servo that gains are for, with all that its result shows.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopModel {
    /// Five numbers; their errors hold what changes them.
    pub servo: IdentifiedServo,
    /// The forces that the predicted response has.
    pub forces: AxisForces,
    /// The resonance that it shows.
    pub resonance: Option<Resonance>,
    /// The modes that its motion leaves open, by frequency; none where it does not say.
    pub hidden: Option<Vec<HiddenMode>>,
    /// The command from which on the amplifier gives no more, command units.
    pub limit: f64,
    /// What bounds the loop.
    pub bounds: Vec<Bound>,
    /// Why there are no gains.
    pub refusal: Option<String>,
}

/// What an effect leaves of a loop's exactness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// A command up to this, command units, moves nothing.
    DeadBand(f64),
    /// The play between motor and encoder, rad.
    Backlash(f64),
    /// The share of friction that is worn off or added over the log.
    FrictionDrift(f64),
    /// Part of the log's load steps: gains hold each of them, the feed-forward the last alone.
    LoadSteps,
}

impl Bound {
    /// In a sentence without an end, for gains.
    #[must_use]
    pub fn sentence(&self, tuning: &Tuning) -> String {
        match *self {
            Self::DeadBand(band) => format!(
                "the dead band of {band:.3} command units leaves the position open to ± {:.2e} rad, in which the integral \
                 may hunt; steps below that move nothing at first",
                band / tuning.kp
            ),
            Self::Backlash(play) => format!(
                "the backlash of {play:.2e} rad lies between motor and encoder: the position is open to that, and the \
                 loop may hunt in it"
            ),
            Self::FrictionDrift(share) => format!(
                "friction changed by {:.0} % over the log: the predicted response is that of its mean",
                100.0 * share
            ),
            Self::LoadSteps => {
                "the load stepped: the feed-forward's constant is that of the last load".to_owned()
            }
        }
    }
}

/// The sizes of an effect by the names of a result, its terms among them.
pub(super) struct Sizes<'a> {
    effect: Option<&'a KeptEffect>,
    estimates: &'a dyn Fn(&str) -> f64,
}

impl Sizes<'_> {
    /// Zero where there is none.
    fn get(&self, name: &str) -> f64 {
        let own = self.effect.and_then(|effect| effect.sizes.get(name));
        own.copied().unwrap_or_else(|| (self.estimates)(name))
    }

    fn amplitude(&self, sine: &str, cosine: &str) -> f64 {
        self.get(sine).hypot(self.get(cosine))
    }

    /// The relative error of a size; one that has none is open by a factor of two.
    fn relative_error(&self, name: &str) -> f64 {
        const OPEN: f64 = std::f64::consts::LN_2;
        let own = self.effect.and_then(|effect| effect.std_errors.get(name));
        own.map_or(OPEN, |error| (error / self.get(name)).abs().min(OPEN))
    }
}

impl LoopModel {
    /// The change of b relative to itself from which on there are no gains for one b.
    const LARGEST_CHANGE: f64 = 0.5;

    /// Of the servo of a result, before its effects.
    pub(super) fn new(servo: IdentifiedServo) -> Self {
        Self {
            servo,
            forces: AxisForces::default(),
            resonance: None,
            hidden: None,
            limit: f64::INFINITY,
            bounds: Vec::new(),
            refusal: None,
        }
    }

    /// The tuner of its gains.
    ///
    /// # Errors
    /// A setting out of its range, or too uncertain a servo.
    pub fn tuner(&self, settings: &TuningSettings) -> Result<Tuner, TuningError> {
        let tuner = Tuner::for_response(settings, &self.servo, self.resonance.as_ref())?;
        Ok(tuner.with_forces(self.forces))
    }

    /// What its motion has shown.
    pub(super) fn shown(&self) -> Shown<'_> {
        self.hidden.as_deref().map_or(Shown::Nothing, Shown::Modes)
    }

    /// Its gains.
    ///
    /// # Errors
    /// As the tuner's.
    pub fn tune(&self, settings: &TuningSettings) -> Result<Tuning, TuningError> {
        self.tuner(settings)?.run(self.shown())
    }

    /// The frequency from which on its motion leaves a resonance open, rad/s.
    pub(super) fn hidden_from(&self) -> Option<f64> {
        let hidden = self.hidden.as_deref()?;
        let is_open = |mode: &&HiddenMode| {
            let [least, largest] = mode.ratios;
            least <= Mode::ON_LOAD || largest >= 0.5 * TuningSettings::HIDDEN_RATIO
        };
        let last = hidden.last()?.frequency;
        Some(
            hidden
                .iter()
                .find(is_open)
                .map_or(last, |mode| mode.frequency),
        )
    }

    /// Takes in the effects of a fit and the terms that were estimated.
    ///
    /// # Errors
    /// The name that is no effect.
    pub(super) fn take(
        &mut self,
        effects: &[KeptEffect],
        estimates: &[(Unknown, f64)],
    ) -> Result<(), String> {
        let cause = |effect: &KeptEffect| {
            let mut all = Cause::ALL.iter().copied();
            let found = all.find(|cause| cause.name() == effect.name);
            found.ok_or_else(|| effect.name.clone())
        };
        let mut causes = Vec::new();
        for effect in effects {
            causes.push((cause(effect)?, Some(effect)));
        }
        let terms = estimates
            .iter()
            .filter_map(|(unknown, _)| Cause::lacking(*unknown));
        for cause in terms {
            if causes.iter().all(|(known, _)| *known != cause) {
                causes.push((cause, None));
            }
        }
        let of_name = |name: &str| {
            let mut all = estimates.iter();
            let found = all.find(|(unknown, _)| unknown.name() == name);
            found.map_or(0.0, |(_, value)| *value)
        };
        for (cause, effect) in causes {
            let estimates = &of_name;
            self.act(cause, &Sizes { effect, estimates });
        }
        Ok(())
    }

    /// What an effect of these sizes does. One without an answer does not compile.
    fn act(&mut self, cause: Cause, of: &Sizes<'_>) {
        let servo = &self.servo;
        match cause {
            // Numbers of the servo.
            Cause::Coulomb | Cause::Load | Cause::Delay => {}
            // It brakes, and what brakes damps.
            Cause::QuadraticFriction => {}
            Cause::CurrentLoop => self.servo.delay += of.get("time_constant_s"),
            Cause::Jitter => self.widen(IdentifiedServo::DELAY, of.get("deviation_s")),
            Cause::Asymmetry => self.reaches(IdentifiedServo::A, of.get("asymmetry")),
            Cause::LowSpeedFriction => {
                self.forces.low_speed = of.get("low-speed").max(0.0);
                self.forces.per_low_speed_velocity = 1.0 / of.get("velocity_rad_per_s").max(1e-9);
            }
            Cause::Gravity => self.wave([of.get("gravity-sine"), of.get("gravity-cosine")], 1.0),
            Cause::Ripple => {
                for [sine, cosine, order] in [
                    ["ripple-sine", "ripple-cosine", "order"],
                    ["sine_2", "cosine_2", "order_2"],
                    ["sine_3", "cosine_3", "order_3"],
                    ["sine_4", "cosine_4", "order_4"],
                ] {
                    self.wave([of.get(sine), of.get(cosine)], of.get(order));
                }
            }
            Cause::GainDrift => self.varies("over the log", 0.5 * of.get("size")),
            Cause::LoadFriction => self.varies("with the load", of.get("size")),
            Cause::GainAsymmetry => self.varies("with its direction", of.get("size")),
            Cause::TorqueRipple => self.varies("with the angle", of.amplitude("sine", "cosine")),
            Cause::VaryingInertia => {
                let change = of.amplitude("sine", "cosine");
                self.varies("with the angle", change / (1.0 - change.min(0.9)));
            }
            Cause::Eccentricity => {
                self.varies("with the angle", of.amplitude("sine_rad", "cosine_rad"));
            }
            Cause::FrictionDrift => {
                let share = of.get("size").abs();
                let change = 0.5 * share * servo.parameters.coulomb;
                self.reaches(IdentifiedServo::COULOMB, change);
                self.bounds.push(Bound::FrictionDrift(share));
            }
            Cause::HiddenLimit => self.limit = self.limit.min(of.get("limit")),
            Cause::DeadBand => self.bounds.push(Bound::DeadBand(of.get("dead-band"))),
            Cause::Backlash => self.bounds.push(Bound::Backlash(of.get("play_rad"))),
            Cause::LoadSteps => self.bounds.push(Bound::LoadSteps),
            // The twist of a shaft alone is that of a resonance that its motion did not show.
            Cause::Resonance if of.get("twist_s2") > 0.0 => {}
            Cause::Resonance => self.resonance = Some(resonance(of)),
        }
    }

    /// A number of the servo that may be off by so much: the possible servos reach it.
    fn reaches(&mut self, place: usize, change: f64) {
        self.widen(place, change / IdentifiedServo::STANDARD_ERRORS);
    }

    fn widen(&mut self, place: usize, std_error: f64) {
        self.servo.covariance[place][place] += std_error * std_error;
    }

    /// A gain that changes by a part of itself.
    fn varies(&mut self, with: &str, part: f64) {
        if part.abs() >= Self::LARGEST_CHANGE {
            self.refusal = Some(format!(
                "b changes by {:.0} % {with}, and no gains for one b keep their margins: identify where the axis works",
                100.0 * part.abs()
            ));
            return;
        }
        self.reaches(IdentifiedServo::B, part * self.servo.parameters.b);
    }

    /// A force that changes with the angle: the steepest of several is predicted.
    fn wave(&mut self, wave: [f64; 2], order: f64) {
        let [sine, cosine] = wave;
        if sine.hypot(cosine) * order > self.forces.wave_amplitude() * self.forces.order {
            (self.forces.wave, self.forces.order) = (wave, order);
        }
    }

    /// Takes in what a record says of further modes.
    pub(super) fn hide(&mut self, modes: &[SecondMode]) {
        /// Standard errors by which a mode may differ from what a record says of it. It enters a fit at some five of them.
        const OPEN: f64 = 5.0;
        /// Distance from a resonance within which its own numbers explain a mode, ln ω, and the errors of ln ω and ln ζ up to
        /// which they are known.
        const OWN: f64 = 0.3;
        const KNOWN: [f64; 2] = [0.01, 0.3];
        let is_known = |own: &Resonance| own.errors[0] < KNOWN[0] && own.errors[1] < KNOWN[1];
        let own = self.resonance.filter(is_known);
        let own = own.map(|own| own.mode.frequency);
        // What a record shows and no model of it has makes it say less of everything (Birge, Physical Review 40, 1932).
        let deviations = modes.iter().map(|mode| (mode.ratio / mode.std_error).abs());
        let unexplained = (deviations.fold(0.0, f64::max) / OPEN).max(1.0);
        let hidden = modes.iter().map(|mode| {
            let is_own = own.is_some_and(|own| (mode.rad_per_s / own).ln().abs() < OWN);
            let off = unexplained * OPEN * mode.std_error;
            HiddenMode {
                frequency: mode.rad_per_s,
                ratios: match is_own {
                    true => [0.0; 2],
                    false => [mode.ratio - off, mode.ratio + off],
                },
            }
        });
        self.hidden = Some(hidden.collect()).filter(|hidden: &Vec<_>| !hidden.is_empty());
    }
}

/// The mode of a second mass.
fn resonance(of: &Sizes<'_>) -> Resonance {
    let share = of.get("load_share");
    Resonance {
        mode: Mode {
            frequency: of.get("resonance_rad_per_s"),
            damping: of.get("damping"),
            ratio: match of.get("encoder_on_load") > 0.0 {
                true => Mode::ON_LOAD,
                false => share / (1.0 - share),
            },
        },
        errors: ["resonance_rad_per_s", "damping"].map(|name| of.relative_error(name)),
        friction_on_motor: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use identifier_core::parameters::ServoParameters;

    /// The servo of effects, `name size=value …` each.
    fn with(effects: &[(&str, &[(&str, f64)])]) -> Result<LoopModel, String> {
        let parameters = ServoParameters::new(0.2, 250.0, 10.0, 0.0);
        let mut model = LoopModel::new(IdentifiedServo::known(parameters, 1e-3));
        let effects: Vec<_> = (effects.iter())
            .map(|(name, sizes)| KeptEffect {
                name: (*name).to_owned(),
                sizes: (sizes.iter())
                    .map(|(name, size)| ((*name).to_owned(), *size))
                    .collect(),
                std_errors: Default::default(),
            })
            .collect();
        model.take(&effects, &[])?;
        Ok(model)
    }

    fn one(name: &str, sizes: &[(&str, f64)]) -> LoopModel {
        with(&[(name, sizes)]).expect("an effect")
    }

    /// How far b is open, as a part of it.
    fn of_b(model: &LoopModel) -> f64 {
        let error = model.servo.standard_error(IdentifiedServo::B);
        IdentifiedServo::STANDARD_ERRORS * error / model.servo.parameters.b
    }

    #[test]
    fn a_gain_that_changes_opens_b_as_far_as_it_does() {
        for (cause, sizes) in [
            (Cause::LoadFriction, &[("size", 0.2)][..]),
            (Cause::GainAsymmetry, &[("size", -0.2)]),
            (Cause::TorqueRipple, &[("sine", 0.12), ("cosine", -0.16)]),
            (Cause::GainDrift, &[("size", 0.4)]),
            (Cause::Eccentricity, &[("sine_rad", 0.2)]),
        ] {
            let open = of_b(&one(cause.name(), sizes));
            assert!((open - 0.2).abs() < 1e-12, "{}: {open}", cause.name());
        }
        // By both at once it changes further.
        let sizes = &[("size", 0.2)][..];
        let both = with(&[
            (Cause::LoadFriction.name(), sizes),
            (Cause::GainAsymmetry.name(), sizes),
        ]);
        assert!(of_b(&both.expect("effects")) > 0.28);
        let most = one(Cause::GainAsymmetry.name(), &[("size", 0.6)]);
        assert!(most.refusal.expect("no gains").contains("60 %"));
    }

    #[test]
    fn effects_change_delay_limit_forces_and_what_is_said() {
        let lag = one(Cause::CurrentLoop.name(), &[("time_constant_s", 5e-4)]);
        assert!((lag.servo.delay - 1.5e-3).abs() < 1e-12);
        let jitter = one(Cause::Jitter.name(), &[("deviation_s", 1e-4)]);
        let error = jitter.servo.standard_error(IdentifiedServo::DELAY);
        assert!((error - 1e-4).abs() < 1e-12);
        let limited = one(Cause::HiddenLimit.name(), &[("limit", 3.0)]);
        assert!((limited.limit - 3.0).abs() < 1e-12);
        let gravity = one(Cause::Gravity.name(), &[("gravity-sine", 5.0)]);
        assert!((gravity.forces.wave_amplitude() - 5.0).abs() < 1e-12);
        for (cause, sizes) in [
            (Cause::DeadBand, &[("dead-band", 0.1)][..]),
            (Cause::Backlash, &[("play_rad", 0.01)]),
            (Cause::FrictionDrift, &[("size", 0.3)]),
            (Cause::LoadSteps, &[]),
        ] {
            assert_eq!(one(cause.name(), sizes).bounds.len(), 1, "{}", cause.name());
        }
    }

    #[test]
    fn a_resonance_is_that_of_its_side_and_a_twist_is_none() {
        let sizes = [
            ("resonance_rad_per_s", 600.0),
            ("damping", 0.02),
            ("load_share", 0.6),
            ("encoder_on_load", 0.0),
        ];
        let name = Cause::Resonance.name();
        let ratio = |sizes: &[_]| one(name, sizes).resonance.map(|of| of.mode.ratio);
        assert!((ratio(&sizes).expect("a mode") - 1.5).abs() < 1e-12);
        let mut on_load = sizes;
        on_load[3].1 = 1.0;
        assert!((ratio(&on_load).expect("a mode") - Mode::ON_LOAD).abs() < 1e-12);
        assert_eq!(ratio(&[("twist_s2", 1e-5)]), None);
        let unknown = with(&[("tides", &[])]);
        assert_eq!(unknown.err().as_deref(), Some("tides"));
    }

    /// Within five errors, more where the record shows what no model has; an own resonance explains what is about it.
    #[test]
    fn modes_are_open_as_far_as_their_record_leaves_them() {
        let mode = |rad_per_s, ratio, std_error| SecondMode {
            rad_per_s,
            ratio,
            std_error,
        };
        let mut model = one(Cause::Resonance.name(), &[("resonance_rad_per_s", 600.0)]);
        let resonance = model.resonance.as_mut().expect("a mode");
        resonance.errors = [0.001, 0.1];
        let modes = [mode(590.0, 0.4, 0.1), mode(900.0, 0.1, 0.1)];
        model.hide(&modes);
        let open = model.hidden.take().expect("modes");
        assert!(open[0].ratios.iter().all(|ratio| ratio.abs() < 1e-12));
        assert!((open[1].ratios[0] + 0.4).abs() < 1e-12 && (open[1].ratios[1] - 0.6).abs() < 1e-12);
        model.hide(&[modes[1], mode(1500.0, 1.0, 0.1)]);
        let open = model.hidden.take().expect("modes");
        assert!((open[0].ratios[1] - 1.1).abs() < 1e-12, "{open:?}");
        model.hide(&[]);
        assert_eq!(model.hidden, None);
    }
}
