//! Robot models from results.

use host_sim::export::{Format, Identified, Scale};
use pyo3::prelude::*;

use crate::fault::value_error;

/// A joint: its name and its result's JSON; torque of a unit of command, N·m; or inertia, kg·m²; inertia that the links
/// of the model have already, kg·m²; largest command.
type Stated = (String, String, Option<f64>, Option<f64>, f64, Option<f64>);

/// Joints in a format; without torque constant and inertia, their ratios.
///
/// # Errors
/// `ValueError`: a format that there is not, a result that has not converged unless that is accepted, or what it lacks.
#[pyfunction]
pub(crate) fn export(
    joints: Vec<Stated>,
    format: &str,
    accept_unconverged: bool,
) -> PyResult<String> {
    let format = match format {
        "mjcf" => Format::Mjcf,
        "urdf" => Format::Urdf,
        "isaac-lab" => Format::IsaacLab,
        "json" => Format::Json,
        other => {
            return Err(value_error(format!(
                "format = {other}: one of mjcf, urdf, isaac-lab, json"
            )));
        }
    };
    let joints = joints.iter().map(|(name, result, constant, inertia, links, limit)| {
        let identified = Identified::read(result, *limit).map_err(value_error)?;
        if let Some(doubt) = identified.doubt().filter(|_| !accept_unconverged) {
            return Err(value_error(format!(
                "{name}: {doubt}: a model of it would be a guess; see to that first, or accept_unconverged=True"
            )));
        }
        let scale = constant.map(Scale::TorqueConstant);
        let scale = scale.or(inertia.map(Scale::Inertia)).unwrap_or(Scale::Ratios);
        identified.joint(name, scale, *links).map_err(value_error)
    });
    let joints = joints.collect::<PyResult<Vec<_>>>()?;
    Ok(format.of(&joints))
}
