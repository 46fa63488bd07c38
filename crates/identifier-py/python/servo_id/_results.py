"""Results of experiments."""

import html
import json
from base64 import b64encode
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _native

if TYPE_CHECKING:
    from pandas import DataFrame

    from ._experiments import Log

_SIDES = 2.0
"""Standard errors to either side of an estimate that are its interval of 95 %, as everywhere else."""

Columns: TypeAlias = dict[str, npt.NDArray[np.float64]]


def columns(of_bytes: dict[str, bytes]) -> Columns:
    """Columns of float64 without a copy."""
    return {name: np.frombuffer(data) for name, data in of_bytes.items()}


def _number(value: float | None) -> float:
    """A number of a result, in whose JSON one that is not finite is null."""
    return float("nan") if value is None else value


class Quantity(NamedTuple):
    """A quantity in physical units."""

    value: float
    std_error: float
    """NaN for one that was stated or whose error is not known."""
    unit: str


def _quantities(found: dict[str, Any] | None) -> dict[str, Quantity]:
    known = {name: one for name, one in (found or {}).items() if one is not None}
    return {name: Quantity(_number(one["value"]), _number(one["std_error"]), one["unit"]) for name, one in known.items()}


@dataclass(frozen=True, repr=False)
class Result:
    """The servo that an identification found."""

    text: str
    """The result as ``servo-id`` writes it with ``--json``."""
    trace: Columns = field(default_factory=dict)
    """The samples: time, reference, position, command, output_error; a, b, coulomb, load as they were estimated then, and
    std_error_a … if the estimator has them. Empty where no trace was asked for."""
    findings: tuple[tuple[str, str], ...] = ()
    """How a log without a scenario was taken: columns, time, position, each with its evidence."""
    picture: str = ""
    """The picture of ``servo-id --plot`` as SVG. Empty where no trace was asked for."""
    scenario: tuple[str, str] = ("", "")
    """Name and text of the scenario that gives this result with ``servo-id identify --scenario``."""
    servo: bytes | None = None
    """The servo as :meth:`predict` takes it; None if there is none."""

    @cached_property
    def json(self) -> dict[str, Any]:
        """The whole result; its keys are documented with the command line."""
        return json.loads(self.text)

    @cached_property
    def _known(self) -> dict[str, dict[str, Any]]:
        return {name: one for name, one in self.json["estimates"].items() if one is not None}

    @property
    def estimates(self) -> dict[str, float]:
        """a (1/s), b (rad/s² per command unit), coulomb and load (rad/s²), or as ``units`` has it, as far as the estimator estimates them, and the
        optional terms that entered."""
        return {name: _number(one["value"]) for name, one in self._known.items()}

    @property
    def std_errors(self) -> dict[str, float]:
        """Their standard errors; NaN where one is not known."""
        return {name: _number(one.get("std_error")) for name, one in self._known.items()}

    @property
    def covariance(self) -> npt.NDArray[np.float64]:
        """Their covariance, in the order of ``estimates``; NaN where one is not known. The diagonal has the squares of
        ``std_errors``, and the rest is of the same parts: noise, and effects that the log leaves open."""
        names = list(self.estimates)
        found = self.json.get("covariance") or {"names": [], "matrix": []}
        places = [found["names"].index(name) if name in found["names"] else None for name in names]
        entry = lambda row, column: None if row is None or column is None else found["matrix"][row][column]
        return np.array([[_number(entry(row, column)) for column in places] for row in places])

    @property
    def scales(self) -> list[dict[str, float]]:
        """b by the equation of motion over windows of ``time_s``, the shortest first, with its ``std_error`` and the part ``explained`` of
        the acceleration. One rigid inertia has the same b at all of them. Empty for estimators other than the fit."""
        return list(self.json.get("scales", []))

    @property
    def residuals(self) -> npt.NDArray[np.float64]:
        """The measured position minus the model's in every sample, in ``position_unit``. The model of a fit runs free in windows, and is NaN
        until its start in one is known; of other laws it follows the measurement."""
        if not self.trace:
            raise ValueError("there are no residuals: identify or simulate with trace=True")
        return self.trace["output_error"]

    def to_pandas(self) -> "DataFrame":
        """The samples as a data frame over time: what was measured, and the residual in output_error. Needs pandas."""
        return _frame(self.trace)

    def predict(self, log: "Log", *, joint: str | int | None = None) -> "Prediction":
        """The motion of this servo over another log with the same columns, driven by that log's commands alone."""
        from ._experiments import predict

        return predict(self, log, joint=joint)

    @property
    def position_unit(self) -> str:
        """Unit of positions and residuals: rad or m if it was stated, otherwise counts, own units or own units·s."""
        return self.json["position_unit"]

    @property
    def units(self) -> dict[str, str]:
        """Their units."""
        return {name: one["unit"] for name, one in self._known.items()}

    @property
    def physical(self) -> dict[str, Quantity]:
        """inertia, viscous and coulomb friction, load and torque_constant, where the scale of torques is stated. That needs
        a stated unit of the position."""
        return _quantities(self.json.get("physical"))

    @property
    def voltage_gains(self) -> dict[str, Quantity]:
        """kS, kV, kA and kG of a servo whose command is in V."""
        return _quantities(self.json.get("voltage_gains"))

    @property
    def verdict(self) -> str:
        """converged, partial, unexplained, no-information, moving or aborted."""
        return self.json["status"]

    @property
    def reason(self) -> str:
        """The verdict's reason with parameter, figure and remedy."""
        return self.json["reason"]

    @property
    def converged(self) -> bool:
        """True for estimates that may be relied on."""
        return self.verdict == "converged"

    @property
    def truth(self) -> dict[str, float] | None:
        """The true servo of a simulation."""
        return self.json["truth"]

    def _rows(self) -> list[tuple[str, str, str, str]]:
        errors, units = self.std_errors, self.units
        known = [(name, value, errors[name], units[name]) for name, value in self.estimates.items()]
        known += [(name, *one) for name, one in (self.physical | self.voltage_gains).items()]
        return [(name, f"{value:.6g}", f"{_SIDES * error:.2g}", unit) for name, value, error, unit in known]

    def _read_as(self) -> list[str]:
        """How the log was read, in lines: its columns, their units and signs, each with its evidence."""
        return [f"{about}: {text}" for about, text in self.findings] or _native.reading(self.text)

    def __repr__(self) -> str:
        rows = [f"  {name} = {value} ± {error} {unit}" for name, value, error, unit in self._rows()]
        return "\n".join([f"{self.verdict}: {self.reason}", *rows, *(f"  {line}" for line in self._read_as())])

    def _repr_html_(self) -> str:
        cells = lambda tag, row: "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in row)
        rows = "".join(f"<tr>{cells('td', row)}</tr>" for row in self._rows())
        heading = cells("th", ("quantity", "estimate", "± (95 %)", "unit"))
        return (
            f"<p><b>{html.escape(self.verdict)}</b>: {html.escape(self.reason)}</p>"
            f"<table><tr>{heading}</tr>{rows}</table>"
            f"<p>{'<br>'.join(map(html.escape, self._read_as()))}</p>"
            + _image(self.picture)
        )

    def plot(self) -> "Picture":
        """The picture of ``servo-id --plot``, which needs a trace. Of a fit: the model beside the measurement and what it
        leaves, friction by velocity, the response with its coherence, the estimates with their intervals of 95 %, and the step
        and the margins of gains for it. Of other laws: the estimates over time."""
        if not self.picture:
            raise ValueError("there is no trace to plot: identify or simulate with trace=True")
        return Picture(self.picture)


def text_of(result: Result) -> str:
    """The text of a result, which its functions take."""
    if not isinstance(result, Result):
        raise TypeError(
            f"{result!r} is no Result: pass what identify or simulate returned, or Result(text) with the text of a file that "
            "servo-id wrote with --json"
        )
    return result.text


@dataclass(frozen=True, repr=False)
class Prediction:
    """A log beside a servo that its commands alone drive. Its start is fitted, and nothing else."""

    text: str
    """The entry of ``predictions`` that ``servo-id identify --predict`` writes."""
    samples: dict[str, bytes] = field(repr=False)

    @cached_property
    def json(self) -> dict[str, Any]:
        """The whole entry; its keys are documented with the command line."""
        return json.loads(self.text)

    @cached_property
    def trace(self) -> Columns:
        """time, reference, position, command, and output_error: the measured position minus the servo's."""
        return columns(self.samples)

    @property
    def position(self) -> npt.NDArray[np.float64]:
        """The servo's, in the ``position_unit`` of its result."""
        return self.trace["position"] - self.residuals

    @property
    def residuals(self) -> npt.NDArray[np.float64]:
        """The measured position minus the servo's, in that unit."""
        return self.trace["output_error"]

    @property
    def rms(self) -> float:
        """Of the residuals, in that unit."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def relative(self) -> float:
        """The residuals relative to the motion from where each part of the log begins."""
        return _number((self.json["open_loop"] or {}).get("relative"))

    def to_pandas(self) -> "DataFrame":
        """The samples as a data frame over time. Needs pandas."""
        return _frame(self.trace)

    def __repr__(self) -> str:
        of_log = self.json["open_loop"]
        rms = f"{of_log['rms']:.3g} {of_log['unit']} rms"
        return f"prediction of {len(self.residuals)} samples: {rms}, {100 * self.relative:.2g} % of the motion"


def _frame(trace: Columns) -> "DataFrame":
    from pandas import DataFrame

    return DataFrame({name: column for name, column in trace.items() if not np.all(np.isnan(column))}).set_index("time")


def _image(svg: str) -> str:
    # As an image its styles and names stay its own.
    encoded = b64encode(svg.encode()).decode()
    return f'<img style="max-width: 100%" src="data:image/svg+xml;base64,{encoded}">' if svg else ""


@dataclass(frozen=True, repr=False)
class Picture:
    """A picture, which a notebook shows."""

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, file: str | PathLike[str]) -> None:
        """Writes it as SVG."""
        Path(file).write_text(self.svg, encoding="utf-8")


@dataclass(frozen=True)
class Gains:
    """PID gains and their predicted response."""

    text: str
    """The result as ``servo-id tune`` writes it with ``--json``."""
    assumptions: tuple[str, ...] = ()
    """Conditions that were taken from the log because nothing states them."""

    @cached_property
    def json(self) -> dict[str, Any]:
        """The whole result."""
        return json.loads(self.text)

    @property
    def gains(self) -> dict[str, float]:
        """kp (command units per rad), kd (per rad/s), ki (per rad s), the cutoff of the velocity estimate, rad/s, the
        time constant of the filter of the reference, s, and the notch filter of the command, rad/s, 0 for none."""
        names = ("kp", "kd", "ki", "cutoff", "reference_filter", "notch")
        return {name: self.json[name] for name in names}

    @property
    def bandwidth(self) -> float:
        """ω of the loop's double pole, rad/s."""
        return self.json["bandwidth"]

    @property
    def predicted_response(self) -> dict[str, float]:
        """Rise time, overshoot, margins and stiffness of the loop."""
        return self.json["predicted_response"]

    @property
    def form(self) -> dict[str, Any] | None:
        """The gains in the form of a drive's firmware, where one was named: name, parameters (each with name, value and
        unit), exactness, margins and steps of what the firmware stores, remarks."""
        return self.json.get("form")

    def __repr__(self) -> str:
        if self.form is None:
            return ", ".join(f"{name} = {value:.5g}" for name, value in self.gains.items())
        rows = [f"  {one['name']} = {one['value']:.6g} {one['unit']}".rstrip() for one in self.form["parameters"]]
        return "\n".join([f"{self.form['name']}:", *rows])


@dataclass(frozen=True)
class Commissioning:
    """The end of a commissioning."""

    text: str
    """The result as ``servo-id commission`` writes it with ``--json``."""

    @cached_property
    def json(self) -> dict[str, Any]:
        """The whole result."""
        return json.loads(self.text)

    @property
    def status(self) -> str:
        """applied, or how it ended otherwise."""
        return self.json["status"]

    @property
    def applied(self) -> bool:
        """True where the new gains hold the axis."""
        return self.status == "applied"

    def __repr__(self) -> str:
        return f"commissioning: {self.status}"


@dataclass(frozen=True)
class Sweep:
    """Random servos, identified."""

    columns: Columns
    """A number per servo: number, true_a, a, true_b, b, true_coulomb, coulomb, true_load, load; NaN where the law does not
    estimate it."""
    statuses: tuple[str, ...]
    """The verdict on each."""

    @property
    def converged(self) -> float:
        """The part of the servos that converged."""
        return self.statuses.count("converged") / len(self.statuses)

    def errors(self, parameter: str) -> npt.NDArray[np.float64]:
        """Estimate less truth of each servo."""
        return self.columns[parameter] - self.columns[f"true_{parameter}"]

    def __repr__(self) -> str:
        return f"{len(self.statuses)} servos, {100 * self.converged:.1f} % converged"
