"""Identification while samples are taken."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _native, _read, _scenario
from ._experiments import estimator_of
from ._keywords import PositionUnit


class Identifier:
    """An identifier beside a loop of your own: it learns from each sample as it is taken.

    >>> identifier = servo_id.Identifier(sample_time=1e-3, counts_per_rev=10000)
    >>> identifier.learn(position, command)  # in every sample, or with arrays of them
    >>> identifier.estimates["b"], identifier.std_errors["b"]

    ``command`` is the total that acts from this sample to the next. ``gauss-newton`` finds viscous and Coulomb friction, gain
    and load; ``identifier`` has further keys of a scenario's table, such as ``parameters``. There is no verdict on line: the
    standard errors of ``gauss-newton`` tell how far an estimate is known, and :func:`identify` judges a log.
    """

    def __init__(
        self,
        *,
        sample_time: float,
        counts_per_rev: float = 0.0,
        position_unit: PositionUnit = "rad",
        position_scale: float = 1.0,
        command_scale: float = 1.0,
        law: Literal["gauss-newton", "gradient"] | str = "gauss-newton",
        identifier: Mapping[str, Any] | None = None,
    ) -> None:
        log = {
            "position": "position",
            "command": "command",
            "sample_time": sample_time,
            "position_unit": position_unit,
            "position_scale": position_scale,
            "command_scale": command_scale,
        }
        encoder = {"counts_per_rev": counts_per_rev}
        scenario = {"encoder": encoder, "identifier": estimator_of(law, identifier), "log": log}
        self._native = _native.Online(*_scenario.read(scenario))

    def learn(self, position: npt.ArrayLike, command: npt.ArrayLike) -> None:
        """A sample, or as many as two arrays have."""
        if np.ndim(position) == 0 == np.ndim(command):
            self._native.learn(float(position), float(command))
            return
        arrays = _read.float_columns([("position", position), ("command", command)])
        self._native.learn_columns(*(array for _, array in arrays))

    def resume(self) -> None:
        """Joins the motion anew behind a gap between samples; the estimates are kept."""
        self._native.resume()

    @property
    def samples(self) -> int:
        """The samples so far."""
        return self._native.found()[0]

    @property
    def estimates(self) -> dict[str, float]:
        """a (1/s), b (rad/s² per command unit), coulomb and load (rad/s²) as far as the estimator estimates them."""
        return self._native.found()[1]

    @property
    def std_errors(self) -> dict[str, float] | None:
        """Their standard errors; none if the estimator has none."""
        return self._native.found()[2]

    @property
    def at_bounds(self) -> list[str]:
        """The names of the estimates at a bound."""
        return self._native.found()[3]

    def __repr__(self) -> str:
        numbers = ", ".join(f"{name} = {value:.6g}" for name, value in self.estimates.items())
        return f"Identifier after {self.samples} samples: {numbers}"
