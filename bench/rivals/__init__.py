"""Methods for comparison: one module each, with NAME, LICENCE, NEEDS (packages) and fit(log) -> Found."""

from dataclasses import dataclass, field

# In the order of the tables.
NAMES = [
    "servo_id",
    "output_error",
    "filtered_derivatives",
    "mujoco_sysid",
    "unscented_kalman",
    "sysidentpy_narx",
    "sippy_armax",
    "nfoursid_subspace",
    "px4_arx_rls",
    "efoc_rls",
]


@dataclass
class Found:
    """Values of a, b and where the method has them c, d and delay (s); their standard errors; its own verdict."""

    values: dict
    errors: dict = field(default_factory=dict)
    converged: bool = True
    # (A, B, C, D, means of position and command) of a model that is linear, which then predicts in place of the values.
    linear: tuple = None
