"""The keywords of calls, which an editor, ``help`` and a notebook complete."""

import inspect
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from functools import wraps
from typing import Any, Literal, TypeAlias, TypedDict, TypeVar, get_args, get_type_hints

from . import _native

TimeUnit: TypeAlias = Literal["s", "ms", "us", "ns", "min", "h", "samples", "iso-8601"]
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
    time_unit: TimeUnit
    sample_time: float
    position: Column
    position_unit: PositionUnit
    position_scale: float
    wrap: float
    counts_per_rev: float
    command: Column
    command_scale: float
    command_unit: CommandUnit
    known_torque: Column
    reference: Column
    reference_unit: PositionUnit
    reference_scale: float
    goal: Column
    loop_time: float
    integrator: Literal["none", "euler", "implicit"]
    cutoff: float
    velocity: Column
    bridge_gaps: int
    cut: Sequence[Sequence[float]]


class LogOptions(_Log, total=False):
    """What a log does not show."""

    torque_constant: float
    inertia: float
    kp: float
    kd: float
    limit: float


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
    bandwidth: float
    sample_time: float
    counts: float
    resolution: float
    limit: float
    command_delay: float
    cutoff: float
    max_sensitivity: float
    max_noise: float
    resonance: float
    encoder_on: Literal["motor", "load"]
    command_sign: Literal["inverted", "as-logged"]
    command_unit: str
    step: float
    torque_constant: float
    bus_voltage: float
    max_current: float


_F = TypeVar("_F", bound=Callable[..., Any])


def keywords(function: _F) -> _F:
    """Shows the keywords of a function's ``**options`` in its signature and help, and refuses others."""
    signature = inspect.signature(function)
    *own, options = signature.parameters.values()
    [typed] = get_args(options.annotation)
    known = get_type_hints(typed)
    keyword = inspect.Parameter.KEYWORD_ONLY
    shown = [inspect.Parameter(name, keyword, default=..., annotation=hint) for name, hint in known.items()]
    allowed = known.keys() | {parameter.name for parameter in own}
    sentences = dict(_native.CONDITIONS if typed is Conditions else _native.LOG_OPTIONS)
    told = [f"    {name}:{sentences[name]}" for name in known if name in sentences]

    @wraps(function)
    def checked(*arguments: Any, **stated: Any) -> Any:
        for name in stated.keys() - allowed:
            near = get_close_matches(name, allowed, 1)
            hint = f"; did you mean {near[0]}?" if near else f": it takes {', '.join(known)}"
            raise TypeError(f"{function.__name__} has no keyword {name}{hint}")
        return function(*arguments, **stated)

    checked.__doc__ = "\n".join([inspect.cleandoc(function.__doc__ or ""), "", *told])
    checked.__signature__ = signature.replace(parameters=[*own, *shown])  # type: ignore[attr-defined]
    return checked  # type: ignore[return-value]
