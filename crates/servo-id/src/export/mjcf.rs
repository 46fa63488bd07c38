//! MJCF: a default class for each joint, with its motor. Elements and attributes are those of MuJoCo's XML reference.
//! `armature` is added to the joint's inertia, and `damping` and `frictionloss` are in N·m s/rad and N·m. A motor's
//! torque is `gear` times its control.

use super::joint::Joint;
use super::number;

pub(super) fn written(joints: &[Joint]) -> String {
    let classes: String = joints.iter().map(class).collect();
    format!("<mujoco>\n  <default>\n{classes}  </default>\n</mujoco>\n")
}

fn class(joint: &Joint) -> String {
    let remarks: String = joint
        .remarks()
        .iter()
        .map(|line| format!("    <!-- {line} -->\n"))
        .collect();
    let limit = joint.command_limit.map(number);
    let range = limit.map_or(String::new(), |limit| {
        format!(" ctrllimited=\"true\" ctrlrange=\"-{limit} {limit}\"")
    });
    let kind = if joint.is_linear { "slide" } else { "hinge" };
    format!(
        "{remarks}    <default class=\"{}\">\n      <joint type=\"{kind}\" armature=\"{}\" damping=\"{}\" \
         frictionloss=\"{}\"/>\n      <motor gear=\"{}\"{range}/>\n    </default>\n",
        joint.name,
        number(joint.armature.value),
        number(joint.damping.value),
        number(joint.friction.value),
        number(joint.torque_constant.value),
    )
}
