//! The effects of a finished model: which stay, and which are certain.

use std::f64::consts::TAU;

use crate::fit::{Effect, Fitted};

use super::candidate::effects;
use super::effect_selection::{EffectSelection, MIN_GAIN};
use super::model::{Entered, Model};
use crate::cause::Cause;
use crate::parallel;

/// The gain below which an effect goes again.
const MIN_KEPT_GAIN: f64 = 25.0;

/// The same for one of a single unknown within 2.5 standard errors of nothing.
const MIN_UNSURE_GAIN: f64 = 10.0;
const MIN_STD_ERRORS: f64 = 2.5;

/// The part of an effect's gain below which another effect may be the error of its form. No effect matches its textbook
/// form to better than a fifth.
const FORM_ERROR: f64 = 0.2 * 0.2;

/// Standard errors below which a delay may be backlash, whose time differs between motions. Among 37 delays of drawn
/// servos 28 were above it. Among eight that were backlash, two were.
const MIN_DELAY_STD_ERRORS: f64 = 8.0;

/// Delays below this are none, of the reciprocal of the motion's bandwidth.
const MIN_DELAY: f64 = 0.002;

impl EffectSelection<'_> {
    /// Removes effects that the others have made superfluous. It marks those that may be the error of another's form.
    pub(super) fn prune(&self, model: &mut Model) {
        let mut losses: Vec<(Cause, f64)> = Vec::new();
        let mut kept = 0;
        loop {
            let rest = model.entered.iter().skip(kept);
            let causes: Vec<Cause> = rest.map(|entry| entry.cause).collect();
            let fits = parallel::map(&causes, |&cause| self.reduced(model, cause));
            let mut fits: Vec<Option<Reduced>> = fits.collect();
            let superfluous = |fit: &Option<Reduced>| fit.as_ref().is_some_and(|fit| fit.explains);
            // Where one goes, those after it are asked again without it.
            let first = fits.iter().position(superfluous);
            let goes = first.and_then(|place| fits.swap_remove(place));
            fits.truncate(first.unwrap_or(fits.len()));
            kept += fits.len();
            let stay = causes.into_iter().zip(fits);
            losses.extend(stay.filter_map(|(cause, fit)| Some((cause, fit?.loss))));
            let Some(reduced) = goes else { break };
            model.free = reduced.free;
            model.fitted = reduced.fitted;
            model.entered.remove(kept);
        }
        let most = losses.iter().max_by(|one, other| one.1.total_cmp(&other.1));
        let Some(&(strongest, most)) = most else {
            return;
        };
        for (cause, loss) in losses {
            let entry = model.entered.iter_mut().find(|entry| entry.cause == cause);
            if let Some(entry) = entry.filter(|_| loss < FORM_ERROR * most) {
                entry.error_of = Some(strongest);
            }
        }
    }

    /// Marks waves of which the motion shows less than a period. They may be any force, or any change of the gain, that
    /// depends on the angle.
    pub(super) fn mark_short_waves(&self, model: &mut Model) {
        let values = &model.fitted.values;
        for entry in &mut model.entered {
            let (order, other) = match entry.cause {
                Cause::Ripple => {
                    let orders = values.ripples().map(|(_, order)| order);
                    (orders.fold(f64::INFINITY, f64::min), Cause::Gravity)
                }
                Cause::TorqueRipple => (values.gain_order, Cause::VaryingInertia),
                _ => continue,
            };
            if order * self.range.angle < TAU {
                entry.error_of.get_or_insert(other);
            }
        }
    }

    /// The delay with its standard error, as an effect of the record. Every model has it. None if the record does not
    /// show it.
    pub(super) fn delay(&self, model: &Model, std_error: f64) -> Option<Entered> {
        let delay = model.fitted.values.get(Effect::Delay);
        let is_small = delay * self.fitter.statistics.bandwidth < MIN_DELAY;
        // A command that was recorded late is told by itself.
        if self.fitter.earliest < 0.0 || is_small || delay <= MIN_STD_ERRORS * std_error {
            return None;
        }
        let (.., gain) = self.without(model, Cause::Delay, &[Effect::Delay])?;
        // The twist of a shaft is its whole motion at low frequencies alone; what is left looks like a delay.
        let mut entered = model.entered.iter().map(|entered| entered.cause);
        let shaft = entered.find(|&cause| cause == Cause::Resonance);
        let is_clear = delay > MIN_DELAY_STD_ERRORS * std_error;
        let error_of = shaft.or((!is_clear).then_some(Cause::Backlash));
        (gain >= MIN_GAIN).then(|| Entered {
            error_of,
            ..Entered::certain(Cause::Delay, gain)
        })
    }

    /// The model without the effects of a cause. None if they are certain and the only ones that entered, or if the fit
    /// diverges.
    fn reduced(&self, model: &Model, cause: Cause) -> Option<Reduced> {
        let own = own(model, cause);
        let is_sure = is_sure(model, &own);
        if is_sure && model.entered.len() == 1 {
            return None;
        }
        let is_pair = own.len() > 1 || cause == Cause::HiddenLimit;
        let least = if is_sure || is_pair {
            MIN_KEPT_GAIN
        } else {
            MIN_UNSURE_GAIN
        };
        let (fitted, free, loss) = self.without(model, cause, &own)?;
        Some(Reduced {
            fitted,
            free,
            loss,
            explains: loss < least,
        })
    }

    /// A fit of the model without the effects of a cause, and its free effects. The last value is the increase of −2 ln
    /// L in independent rows.
    fn without(
        &self,
        model: &Model,
        cause: Cause,
        own: &[Effect],
    ) -> Option<(Fitted, Vec<Effect>, f64)> {
        let mut values = model.fitted.values;
        for &effect in effects(cause) {
            if effect != Effect::LowSpeedVelocity {
                values.set(effect, 0.0);
            }
        }
        if cause == Cause::HiddenLimit {
            values.set(Effect::LimitSlope, 0.0);
        }
        let mut free = model.free.clone();
        free.retain(|effect| !own.contains(effect));
        let without = self.fit(&values, &free, &model.fitted)?;
        let loss = model.gain_over(&without);
        Some((without, free, loss))
    }
}

/// A model without the effects of a cause.
struct Reduced {
    fitted: Fitted,
    free: Vec<Effect>,
    /// By how much −2 ln L is larger, in independent rows.
    loss: f64,
    /// True if it explains the record as well.
    explains: bool,
}

/// The effects of a cause that are free in a model.
fn own(model: &Model, cause: Cause) -> Vec<Effect> {
    let all = effects(cause).iter().copied();
    all.filter(|effect| model.free.contains(effect)).collect()
}

/// True if one of some effects differs from nothing.
fn is_sure(model: &Model, own: &[Effect]) -> bool {
    let errors = model.fitted.std_errors();
    let mut free = model.free.iter().zip(errors);
    free.any(|(effect, error)| {
        let value = model.fitted.values.get(*effect);
        own.contains(effect) && value.abs() > MIN_STD_ERRORS * error
    })
}
