//! Isaac Lab: a dictionary of actuators. The fields are those of its `ActuatorBaseCfg`. `armature` is added to the
//! joint's inertia, `friction` and `dynamic_friction` are torques and `viscous_friction` is in N·m s/rad. A delay is in
//! physics steps.

use super::joint::Joint;
use super::number;

pub(super) fn written(joints: &[Joint]) -> String {
    let actuators: String = joints.iter().map(actuator).collect();
    format!("from isaaclab.actuators import ImplicitActuatorCfg\n\nACTUATORS = {{\n{actuators}}}\n")
}

fn actuator(joint: &Joint) -> String {
    let mut text: String = joint
        .remarks()
        .iter()
        .map(|line| format!("    # {line}\n"))
        .collect();
    let name = &joint.name;
    text += &format!(
        "    \"{name}\": ImplicitActuatorCfg(\n        joint_names_expr=[\"{name}\"],\n        \
         # The gains of your position loop in N·m/rad and N·m·s/rad; at zero the joint takes torques.\n        \
         stiffness=0.0,\n        damping=0.0,\n        armature={:?},\n        friction={:?},\n        \
         dynamic_friction={:?},\n        viscous_friction={:?},\n",
        number(joint.armature.value),
        number(joint.friction.value),
        number(joint.friction.value),
        number(joint.damping.value),
    );
    if let Some(effort) = joint.effort_limit {
        text += &format!(
            "        # Before Isaac Lab 3: effort_limit_sim.\n        joint_effort_limit={:?},\n",
            number(effort)
        );
    }
    text + "    ),\n"
}
