"""Inertia, friction, gain and load of servo axes.

>>> import servo_id
>>> result = servo_id.identify("axis.csv")
>>> result.verdict, result.estimates["b"], result.std_errors["b"]
>>> gains = servo_id.tune(result, response_time=0.02)

The servo is q̈ = −a q̇ + b u + d − c sign(q̇): a = viscous friction/inertia (1/s), b = gain/inertia (rad/s² per command
unit), c = Coulomb friction/inertia and d = load/inertia (rad/s²).
"""

from ._experiments import (
    commission,
    identify,
    identify_joints,
    read_log,
    simulate,
    sweep,
    tune,
)
from ._export import export
from ._native import VERSION as __version__
from ._online import Identifier
from ._results import Commissioning, Gains, Picture, Prediction, Quantity, Result, Sweep

__all__ = [
    "Commissioning",
    "Gains",
    "Identifier",
    "Picture",
    "Prediction",
    "Quantity",
    "Result",
    "Sweep",
    "__version__",
    "commission",
    "export",
    "identify",
    "identify_joints",
    "read_log",
    "simulate",
    "sweep",
    "tune",
]
