//! URDF: the elements within each `<joint>`. A URDF has no place for a joint's own inertia and for the delay: the remarks
//! have them.

use super::joint::Joint;
use super::number;

pub(super) fn written(joints: &[Joint]) -> String {
    joints.iter().map(elements).collect()
}

fn elements(joint: &Joint) -> String {
    let mut text: String = joint
        .remarks()
        .iter()
        .map(|line| format!("<!-- {line} -->\n"))
        .collect();
    text += &format!(
        "<dynamics damping=\"{}\" friction=\"{}\"/>\n",
        number(joint.damping.value),
        number(joint.friction.value)
    );
    if let Some(effort) = joint.effort_limit {
        text += &format!(
            "<!-- <limit> takes effort=\"{}\" besides the velocity and the ends of travel of your joint. -->\n",
            number(effort)
        );
    }
    text
}
