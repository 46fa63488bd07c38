"""The keywords of calls, which an editor, ``help`` and a notebook complete."""

import inspect
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from functools import wraps
from typing import Any, Literal, TypeAlias, TypedDict, TypeVar, get_args, get_type_hints

TimeUnit: TypeAlias = Literal["s", "ms", "us", "ns", "samples", "iso-8601"]
PositionUnit: TypeAlias = Literal["rad", "deg", "turns", "counts", "m", "mm", "own"]
CommandUnit: TypeAlias = Literal["V", "A", "Nm", "N", "other"]
Form: TypeAlias = Literal[
    "pid", "cascade", "simplefoc", "odrive", "moteus", "vesc", "dynamixel", "feetech", "wpilib", "sparkmax", "linuxcnc", "cia402"
]
Column: TypeAlias = str | int
"""A column of a log by its name, or by its number from 1."""

PerJoint: TypeAlias = float | Sequence[float]
"""One for all joints, or one for each."""


class _Log(TypedDict, total=False):
    time: Column
    """Column of the time; ``none`` if the rows are the samples."""
    time_unit: TimeUnit
    sample_time: float
    """From one row to the next, s."""
    position: Column
    """Column of the measured position."""
    position_unit: PositionUnit
    position_scale: float
    """Position units for one of the column's; below 0 for the other direction."""
    wrap: float
    """Period after which the position begins again, in its unit; 0 if it does not."""
    counts_per_rev: float
    """Encoder counts per revolution, after ×4 quadrature."""
    command: Column
    """Column of the command that acted."""
    command_scale: float
    """Command units for one of the column's; below 0 for the other direction."""
    command_unit: CommandUnit
    """V gives the feed-forward kS, kV, kA and kG; Nm, or N on a linear axis, gives inertia and friction."""
    known_torque: Column
    """Column of a known torque that acts on the joint beside the command, N·m."""
    reference: Column
    reference_unit: PositionUnit
    reference_scale: float
    goal: Column
    """Column of the position goal of a servo that closes its own loop."""
    loop_time: float
    """Its own sample time, or a simulator's step, s."""
    integrator: Literal["none", "euler", "implicit"]
    """How its command becomes motion: none for a drive, euler or implicit for a simulator's."""
    cutoff: float
    """Cut-off of the low-pass derivative that is its velocity, rad/s."""
    velocity: Column
    """Column of the measured velocity that it acts on."""
    bridge_gaps: int
    """The most missing samples in a row that straight lines bridge."""
    cut: Sequence[Sequence[float]]
    """Ranges of the log's time that are left out, s."""


class LogOptions(_Log, total=False):
    """What a log does not show."""

    torque_constant: float
    """Torque of a unit of command at the joint, N·m (N on a linear axis)."""
    inertia: float
    """Of all that moves about the joint, kg·m² (kg), where that is known instead."""
    kp: float
    """Proportional gain of the servo's own loop, command units per rad. Without it b is that of a rad from the goal."""
    kd: float
    """Its derivative gain, command units per rad/s."""
    limit: float
    """The largest command that it gives, command units."""


class JointOptions(_Log, total=False):
    """The same of several joints."""

    torque_constant: PerJoint
    inertia: PerJoint
    kp: PerJoint
    kd: PerJoint
    limit: PerJoint


class Conditions(TypedDict, total=False):
    """The goal of a tuning, and its conditions."""

    response_time: float
    """Goal: from 10 to 90 % of a step, s."""
    bandwidth: float
    """Goal: rad/s. Without a goal the gains are as stiff as the servo allows."""
    sample_time: float
    """Of the controller, s."""
    counts: float
    """Encoder counts per revolution."""
    resolution: float
    """A count, rad."""
    limit: float
    """Largest command, command units."""
    command_delay: float
    """From the reading of the encoder to the output, s."""
    cutoff: float
    """Of the velocity estimate, rad/s."""
    max_sensitivity: float
    max_noise: float
    """Of the command, as a part of the limit."""
    resonance: float
    """The lowest known, rad/s."""
    step: float
    """Of the predicted response, rad."""
    torque_constant: float
    """N·m per unit of command."""
    bus_voltage: float
    """V."""
    max_current: float
    """A."""


_F = TypeVar("_F", bound=Callable[..., Any])


def keywords(function: _F) -> _F:
    """Shows the keywords of a function's ``**options`` in its signature, and refuses others."""
    signature = inspect.signature(function)
    *own, options = signature.parameters.values()
    [typed] = get_args(options.annotation)
    known = get_type_hints(typed)
    keyword = inspect.Parameter.KEYWORD_ONLY
    shown = [inspect.Parameter(name, keyword, default=..., annotation=hint) for name, hint in known.items()]
    allowed = known.keys() | {parameter.name for parameter in own}

    @wraps(function)
    def checked(*arguments: Any, **stated: Any) -> Any:
        for name in stated.keys() - allowed:
            near = get_close_matches(name, allowed, 1)
            hint = f"; did you mean {near[0]}?" if near else f": it takes {', '.join(known)}"
            raise TypeError(f"{function.__name__} has no keyword {name}{hint}")
        return function(*arguments, **stated)

    checked.__signature__ = signature.replace(parameters=[*own, *shown])  # type: ignore[attr-defined]
    return checked  # type: ignore[return-value]
