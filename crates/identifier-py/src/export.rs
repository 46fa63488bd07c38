//! Robot models from results.

use identifier_log::physical::Scale;
use identifier_log::result::KeptResult;
use pyo3::prelude::*;
use servo_id::export::{Identified, JointFormat};

use crate::fault::value_error;

/// A joint: its name and its result's JSON; torque of a unit of command, N·m; or inertia, kg·m²; inertia that the links
/// of the model have already, kg·m²; largest command.
type Stated = (String, String, Option<f64>, Option<f64>, f64, Option<f64>);

/// Joints in a format. Without torque constant or inertia, the scale of each result is used. `ratios` exports an
/// inertia of 1. `resistance` is that of the motor's winding, Ω, if the command is its voltage.
///
/// # Errors
/// `ValueError`: a format that there is not, a result that has not converged unless that is accepted, or what it lacks.
#[pyfunction]
pub(crate) fn export(
    joints: Vec<Stated>,
    format: &str,
    ratios: bool,
    resistance: Option<f64>,
    accept_unconverged: bool,
) -> PyResult<String> {
    let format: JointFormat =
        (format.parse()).map_err(|names| value_error(format!("format = {format}: {names}")))?;
    let joints = joints.iter().map(|(name, result, constant, inertia, links, limit)| {
        let kept = KeptResult::read(result).map_err(value_error)?;
        let identified = Identified::new(&kept, *limit).map_err(value_error)?;
        if let Some(reservation) = identified.reservation().filter(|_| !accept_unconverged) {
            return Err(value_error(format!(
                "{name}: {reservation}: its model would be a guess; correct that first, or pass accept_unconverged=True"
            )));
        }
        let scale = constant.map(Scale::TorqueConstant);
        let scale = scale.or(inertia.map(Scale::Inertia));
        let scale = scale.or(ratios.then_some(Scale::Ratios)).or(identified.scale());
        let scale = scale.ok_or_else(|| {
            value_error(format!(
                "{name}: the log does not determine torques: state torque_constant (N·m per command unit) or inertia \
                 (kg·m²), or ratios=True for an inertia of 1"
            ))
        })?;
        let joint = identified.joint(name, scale, *links).map_err(value_error)?;
        match resistance {
            Some(resistance) => joint.with_resistance(resistance).map_err(value_error),
            None => Ok(joint),
        }
    });
    let joints = joints.collect::<PyResult<Vec<_>>>()?;
    format.of(&joints).map_err(value_error)
}
