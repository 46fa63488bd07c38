"""Robot models from results."""

from collections.abc import Mapping

from . import _native
from ._results import Result, text_of


def export(
    joints: Result | Mapping[str, Result],
    format: str = "mjcf",
    *,
    torque_constant: float | Mapping[str, float] | None = None,
    inertia: float | Mapping[str, float] | None = None,
    ratios: bool = False,
    link_inertia: float | Mapping[str, float] = 0.0,
    resistance: float | None = None,
    limit: float | None = None,
    accept_unconverged: bool = False,
) -> str:
    """Joints as text for MuJoCo (``mjcf``), ``urdf``, ``isaac-lab``, BAM (``bam``, one joint) or ``json``, with armature, damping, friction loss and
    effort limit as the simulator names them.

    A result leaves the scale of torques open unless it is in physical units: state ``torque_constant`` (N·m per command unit at the joint) or ``inertia``
    (kg·m², of all that moves about the joint), one for all joints or by name, or ``ratios=True`` for an inertia of 1.
    ``link_inertia`` is the inertia that the links of the model have already. ``resistance`` (Ω) is that of the motor's
    winding where the command is its voltage, for ``bam``.
    """
    if (torque_constant is not None) + (inertia is not None) + ratios > 1:
        raise ValueError(
            "the scale of torques is stated twice: state one of torque_constant, inertia and ratios=True"
        )
    if not isinstance(joints, Mapping):
        joints = {"joint": joints}

    def of(value: float | Mapping[str, float] | None, name: str) -> float | None:
        if not isinstance(value, Mapping):
            return value
        if name not in value:
            raise ValueError(f"{name} is not one of {', '.join(value)}: state a value for each joint")
        return value[name]

    stated = [
        (name, text_of(result), of(torque_constant, name), of(inertia, name), of(link_inertia, name), limit)
        for name, result in joints.items()
    ]
    return _native.export(stated, format, ratios, resistance, accept_unconverged)
