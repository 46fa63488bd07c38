//! BAM, the "better actuator models" of Rhoban (M. Duclusaud, G. Passault and others, "Extended Friction Models for the
//! Physics Simulation of Servo Actuators", 2024, github.com/Rhoban/bam). It is the parameter file of its model m1:
//! Coulomb and viscous friction. `load_model` reads its keys by name and ignores others.
//!
//! An actuator of BAM driven by a voltage has the torque kt V/R − kt²/R q̇. kt and R need the motor's resistance.
//! Without it the command is taken as a current, kt is the torque of a unit of it and R is omitted.

use identifier_log::physical::PhysicalQuantity;
use serde_json::{Value, json};

use super::joint::Joint;
use super::number;

/// The values of a result for which BAM has no parameter.
const WITHOUT_PLACE: &str = "The constant load and the largest command have no parameter in BAM: its test bench and \
                             its actuator class hold them. m1 has neither low-speed friction nor friction that grows \
                             with the load (m2 to m6 do).";

pub(super) fn written(joint: &Joint) -> String {
    let motor = joint.motor.as_ref();
    let [kt, viscous] = motor.map_or([joint.torque_constant, joint.damping], |motor| {
        [motor.torque_constant, motor.damping]
    });
    let parameters = [
        ("kt", kt),
        ("armature", joint.armature),
        ("friction_base", joint.friction),
        ("friction_viscous", viscous),
        ("command_delay", joint.delay),
    ];
    let error = |(name, quantity): &(&str, PhysicalQuantity)| {
        let error = quantity.std_error.map(number);
        (
            (*name).to_owned(),
            json!({ "std_error": error, "unit": quantity.unit }),
        )
    };
    let errors: serde_json::Map<String, Value> = parameters.iter().map(error).collect();
    let mut remarks = joint.remarks();
    remarks.push(WITHOUT_PLACE.to_owned());
    remarks.push(match motor {
        Some(_) => "The command is the motor's voltage: friction_viscous excludes the part kt²/R."
            .to_owned(),
        None => "The command is taken as a current, with kt its torque per unit; R is unknown and left out."
            .to_owned(),
    });
    let mut file = json!({ "model": "m1", "actuator": joint.name() });
    for (name, quantity) in parameters {
        file[name] = number(quantity.value).into();
    }
    if let Some(motor) = motor {
        file["R"] = number(motor.resistance).into();
    }
    file["servo_id"] = json!({ "errors": errors, "remarks": remarks, "origin": joint.origin });
    format!("{file:#}\n")
}
