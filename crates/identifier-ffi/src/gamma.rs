//! Γ of the gradient estimator, for a reference.

use identifier_core::excitation::Prbs;
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{ParameterSet, PerParameter as Each, Unknowns};
use identifier_core::settings::SettingsError;

use crate::object::{answered, given};
use crate::settings::Settings;
use crate::status::{self, Error};

/// # Safety
/// As the header says.
unsafe fn choose_gamma(
    settings: *mut Settings,
    amplitude: f64,
    hold: f64,
    samples: u32,
    with_coulomb: bool,
) -> Result<i32, Error> {
    // SAFETY: guaranteed by the caller.
    let own = unsafe { given(settings) }?;
    let chosen = if with_coulomb {
        gamma::<Unknowns<3>, 3>(own, amplitude, hold, samples)
    } else {
        gamma::<Unknowns<2>, 2>(own, amplitude, hold, samples)
    };
    let chosen = Each {
        load: 0.0,
        ..chosen?
    };
    // SAFETY: guaranteed by the caller; it was checked.
    unsafe { (&raw mut (*settings).gamma).write(chosen) };
    Ok(status::OK)
}

/// Γ for a model of P parameters.
fn gamma<S, const P: usize>(
    given: &Settings,
    amplitude: f64,
    hold: f64,
    samples: u32,
) -> Result<Each<f64>, SettingsError>
where
    S: ParameterSet<P>,
{
    /// Bits of the sequence's shift register.
    const ORDER: u32 = 9;
    let settings = given.settings();
    let reference = Prbs::<f64>::new(&settings.units()?, amplitude, hold, ORDER)?;
    settings.automatic_gamma::<LowPass<f64>, S, P>(&reference, samples)
}

face! {
    /// Γ for a reference of an amplitude (rad) that changes after `hold` s at the soonest.
    fn servo_id_settings_choose_gamma(
        settings: *mut Settings,
        amplitude: f64,
        hold: f64,
        samples: u32,
        coulomb: i32,
        error: *mut Error,
    ) {
        // SAFETY: the header's conditions.
        unsafe { answered(error, choose_gamma(settings, amplitude, hold, samples, coulomb != 0)) }
    }
}
