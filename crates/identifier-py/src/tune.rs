//! Gains from a result.

use std::collections::BTreeMap;

use identifier_log::result::KeptResult;
use identifier_log::tune::{Conditions, Form, IdentifiedResult, KnownConditions, NoGains, Tuned};
use pyo3::prelude::*;

use crate::fault::value_error;

/// Gains for a result's JSON under named conditions, as JSON, with their assumptions. If a firmware is named, the gains
/// are in its form.
///
/// # Errors
/// `ValueError`: an unconverged result that is not accepted, an unknown or wrong condition, or the reason why there are
/// no gains.
#[pyfunction]
pub(crate) fn tune(
    py: Python<'_>,
    result: &str,
    conditions: BTreeMap<String, String>,
    form: Option<&str>,
    accept_unconverged: bool,
) -> PyResult<(String, Vec<String>)> {
    py.detach(|| {
        let kept = KeptResult::read(result).map_err(value_error)?;
        let identified = IdentifiedResult::new(&kept).map_err(value_error)?;
        if let Some(reservation) = identified.reservation.as_ref().filter(|_| !accept_unconverged) {
            return Err(value_error(format!(
                "{reservation}: its gains would be a guess; correct that first, or pass accept_unconverged=True"
            )));
        }
        let mut stated = Conditions::default();
        for (name, value) in conditions {
            let taken = stated.answer(&name, &value);
            taken.map_err(|why| value_error(format!("{name}: {why}")))?;
        }
        let form = form.map(str::parse::<Form>).transpose();
        stated.form = form.map_err(|names| value_error(format!("form must be {names}")))?;
        let known = KnownConditions::of_result(&kept, identified.has_delay);
        let settings = stated.settings(stated.goal(), &identified, &known);
        let settings = settings.map_err(value_error)?;
        let tuned = Tuned::of_conditions(&identified, &known, &stated, &settings);
        let tuned = tuned.map_err(|error| refusal(&error))?;
        let json = serde_json::to_string(&tuned.result()).map_err(value_error)?;
        Ok((json, stated.assumptions(&known)))
    })
}

fn refusal(error: &NoGains) -> PyErr {
    match error {
        NoGains::TooFast {
            cap,
            most,
            rise_time,
        } => {
            let instead = rise_time.map(|least| format!(", with a rise time of {least:.4} s"));
            value_error(format!(
                "{cap} allows {most:.2} rad/s{}: ask for less, or state no goal to get the stiffest gains",
                instead.unwrap_or_default()
            ))
        }
        NoGains::Error(error) => value_error(error),
        NoGains::Form(error) => value_error(error),
    }
}
