"""Experiments: on logs, on the simulated servo, on many servos."""

from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from os import PathLike, fspath
from pathlib import Path as File
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _frames, _native, _read, _scenario
from ._results import Columns, Commissioning, Gains, Result, Sweep, columns
from ._scenario import Scenario

if TYPE_CHECKING:
    from distributed import Client
    from pandas import DataFrame

Path: TypeAlias = str | PathLike[str]
Log: TypeAlias = "Path | Mapping[str, npt.ArrayLike] | DataFrame"
"""A file, or columns by name: position, command or goal, and time where the samples are not ``sample_time`` apart."""

_ROLES = ("time", "position", "command", "reference", "goal", "velocity")

_BATCH = 200
"""Servos of a batch: seconds of work, so that its way to a worker costs nothing beside it."""


def identify(
    log: Log,
    *,
    joint: str | int | None = None,
    scenario: Scenario | None = None,
    trace: bool = True,
    **stated: Any,
) -> Result:
    """The servo behind a log of position and command.

    ``log`` is a file as :func:`read_log` takes it, of which ``joint`` is identified, or a mapping or data frame of columns:
    ``position`` and ``command``, the total that acted, with ``time`` (s) or ``sample_time=``. Columns of other names are
    recognised as those of a file. A servo that closes its own loop has a ``goal`` in place of a command, and that
    loop is ``inner=``: ``kp`` (command units per rad), ``kd``, ``limit``, ``sample_time`` (its own, s), ``integrator``
    (``euler`` or ``implicit``, of a simulator), ``cutoff``; a column ``velocity`` is the one it acts on. The file's columns and units are found; ``result.findings`` says how. What a log
    does not show is asked for by a ``ValueError`` that names the keyword: time, time_unit, sample_time, position,
    position_unit (rad, deg, turns, counts, m, mm), position_scale, command, command_scale, reference, counts_per_rev, wrap,
    and of a loop goal, kp, kd, limit, loop_time, integrator, cutoff, velocity. Of columns in memory these are sample_time, counts_per_rev, position_unit, position_scale, command_scale,
    time_unit, wrap, ``law`` (``fit``, the default, ``gauss-newton``, ``gradient``) and ``identifier``,
    further keys of that table.

    ``torque_constant`` (N·m per command unit) or ``inertia`` (kg·m²), or ``command_unit`` (V, A, Nm, N) put the result in
    physical units: ``result.physical``, ``result.voltage_gains``.

    With a ``scenario``, its ``[log]`` names the columns and nothing else may be stated.
    """
    if scenario is not None:
        if stated:
            raise ValueError(f"{', '.join(stated)}: not allowed together with a scenario: state it there")
        file, text, findings = *_scenario.read(scenario), ()
        source = _source(log, joint, {})
    elif not isinstance(log, (str, PathLike)) and joint is None and set(log) <= set(_ROLES):
        file, text, findings = *_scenario.read(scenario_of_columns(log, {"law": "fit", **stated})), ()
        source = _in_memory(log)
    else:
        source = _source(log, joint, stated)
        file, text, findings = _recognised(source, stated)
    found, samples, picture = _native.identify_log(file, text, source, trace=trace)
    return Result(found, columns(samples), findings, picture)


def identify_joints(
    log: Mapping[str, npt.ArrayLike],
    *,
    names: Sequence[str] | None = None,
    threads: int | None = None,
    trace: bool = False,
    **stated: Any,
) -> dict[str, Result]:
    """The servos of several joints, each with a column of its own in ``position`` and ``command`` (samples × joints).

    ``names`` are those of the joints, ``joint_0`` and so on by default; ``stated`` is as for :func:`identify`, where
    torque_constant, inertia and the numbers of ``inner`` may be sequences, a number for each joint.

    Frames of a robot-learning data set, whose columns are ``observation.state``, ``action``, ``timestamp`` and
    ``episode_index``, are taken as they are, as a mapping, a data frame or a data set: the action is the goal of the servos'
    own loops, which ``inner`` states, and nothing is carried over from one episode to the next.
    """
    if _frames.is_frames(log):
        log, between_episodes = _frames.log_of(log)
        stated = {"cut": between_episodes, **stated} if between_episodes else stated
    wide = {name: np.asarray(column, dtype=np.float64) for name, column in log.items()}
    counts = {name: column.shape[1] for name, column in wide.items() if column.ndim == 2}
    if len(set(counts.values())) != 1:
        raise ValueError(f"position and command must have one column per joint (samples × joints), but these have {counts}")
    count = next(iter(counts.values()))
    names = [f"joint_{number}" for number in range(count)] if names is None else list(names)
    if len(set(names)) != count or len(names) != count:
        raise ValueError(f"names has {len(names)} entries for {count} joints: state one name per joint")

    def one(number: int) -> Result:
        own = {name: column[:, number] if column.ndim == 2 else column for name, column in wide.items()}
        return identify(own, trace=trace, **_of_joint(stated, number, count))

    with ThreadPoolExecutor(threads) as pool:
        return dict(zip(names, pool.map(one, range(count))))


def read_log(
    log: Log, *, joint: str | int | None = None, scenario: Scenario | None = None, **stated: Any
) -> Columns:
    """The samples of a log in SI: time, position, and command and reference where it has them.

    A log is a text (.csv, .csv.gz), a bag of ROS (a folder, .db3, .mcap, .bag), .wpilog, .ulg, .parquet, .mat, .npz or .json: a
    list of records or an object of lists. Its columns are found or stated as for :func:`identify`; of several joints one
    is stated, by its name or number.
    """
    source = _source(log, joint, stated)
    file, text = _recognised(source, stated)[:2] if scenario is None else _scenario.read(scenario)
    return columns(_native.read_log(file, text, source))


def page(log: Log, *, joint: str | int | None = None, width: int = 100, **stated: Any) -> str:
    """The page that the program ``servo-id identify`` prints."""
    return _native.page(_source(log, joint, stated), _as_options(stated), width)


def _in_memory(log: Mapping[str, Any], name: str = "log") -> tuple[str, list[tuple[str, npt.NDArray[np.float64]]]]:
    return name, list(float_columns(log).items())


def _source(log: Log, joint: str | int | None, stated: Mapping[str, Any]) -> Any:
    """A log as the native half takes it: a text, or a name and columns."""
    named = [str(stated[name]) for name in _ROLES if name in stated]
    if not isinstance(log, (str, PathLike)):
        return _in_memory(_read.columns_of(log, joint, named))
    path = fspath(log)
    if not _read.is_text(File(path)):
        return _in_memory(_read.columns_of(File(path), joint, named), path)
    if joint is not None:
        raise ValueError(f"{path}: joint: a text log has no joints: state the columns position and command")
    return path


def _as_options(stated: Mapping[str, Any]) -> dict[str, str]:
    return {name: str(value) for name, value in stated.items()}


def _recognised(source: Any, stated: Mapping[str, Any]) -> tuple[str, str, tuple[tuple[str, str], ...]]:
    """The scenario of a log without one: its name, its text, and how the log is taken."""
    text, found = _native.recognise_log(source, _as_options(stated))
    return f"the scenario of {source if isinstance(source, str) else source[0]}", text, tuple(found)


def simulate(scenario: Scenario, *, trace: bool = True) -> Result:
    """Identification on the simulated servo of a scenario."""
    found, samples, picture = _native.simulate(*_scenario.read(scenario), trace=trace)
    return Result(found, columns(samples), picture=picture)


def commission(scenario: Scenario) -> Commissioning:
    """A commissioning of the simulated drive of a scenario."""
    return Commissioning(_native.commission(*_scenario.read(scenario)))


def sweep(
    scenario: Scenario, runs: int, *, seed: int = 1, first: int = 0, client: "Client | None" = None
) -> Sweep:
    """``runs`` random servos about the one of a scenario, on all cores. Servo ``first`` and those after it are the same in
    every sweep of a seed, so that machines can share one. Ctrl-C ends it between batches.

    With a ``client`` of dask.distributed the batches go to its workers, each of which needs this package; a batch whose
    worker is lost is repeated by dask. The result is the same for any number of workers.
    """
    if runs < 1:
        raise ValueError(f"runs = {runs}: it must be at least 1")
    file, text = _scenario.read(scenario)
    end = first + runs
    starts = range(first, end, _BATCH)
    counts = [min(_BATCH, end - start) for start in starts]
    one = partial(_batch, file, text, seed)
    if client is None:
        parts = [one(start, count) for start, count in zip(starts, counts)]
    else:
        parts = client.gather(client.map(one, starts, counts, pure=False))
    of_parts = [columns(part) for part, _ in parts]
    joined = {name: np.concatenate([part[name] for part in of_parts]) for name in of_parts[0]}
    return Sweep(joined, tuple(status for _, statuses in parts for status in statuses))


def _batch(file: str, text: str, seed: int, start: int, count: int) -> tuple[dict[str, bytes], list[str]]:
    return _native.sweep(file, text, start, count, seed)


def tune(
    result: Result, *, form: str | None = None, accept_unconverged: bool = False, **conditions: float
) -> Gains:
    """PID gains for a servo, with their predicted response.

    The goal is ``response_time`` (s, from 10 to 90 % of a step) or ``bandwidth`` (rad/s), by default as stiff as the servo
    allows. Further conditions: sample_time, counts or resolution, limit, command_delay, cutoff, max_sensitivity, max_noise,
    resonance, step.

    ``form`` states them in the form of a drive's firmware too (``gains.form``): pid, cascade, simplefoc, odrive, moteus,
    vesc, dynamixel, wpilib, sparkmax, linuxcnc or cia402, with torque_constant (N·m per unit of command), bus_voltage (V) or
    max_current (A) where that form needs it.
    """
    if {"response_time", "bandwidth"} <= conditions.keys():
        raise ValueError("response_time and bandwidth are two goals: state only one")
    stated = {name: float(value) for name, value in conditions.items()}
    text, assumptions = _native.tune(result.text, stated, form, accept_unconverged)
    return Gains(text, tuple(assumptions))


def scenario_of_columns(log: Collection[str], stated: dict[str, Any]) -> dict[str, Any]:
    """The scenario of columns of a ``log`` by their names, which are those of their quantities."""
    stated = dict(stated)
    inner = stated.pop("inner", None)
    has_goal = "goal" in log
    for role in ("position", "goal" if inner is not None else "command"):
        if role not in log:
            hint = "; a goal needs inner=, the gains of the servo's own loop" if has_goal and role == "command" else ""
            raise ValueError(f"the log has no {role}: it has {', '.join(log) or 'nothing'}{hint}")
    if has_goal and ("command" in log or "reference" in log):
        raise ValueError("goal: a log has either a goal, or a command and a reference; leave out the others")
    unknown = set(log) - set(_ROLES)
    if unknown:
        raise ValueError(f"{', '.join(sorted(unknown))}: not a column: it must be one of {', '.join(_ROLES)}")
    if "time" not in log and "sample_time" not in stated:
        raise ValueError("sample_time is missing: state the time from one sample to the next, s, or a column time")
    identifier = {"law": stated.pop("law"), **stated.pop("identifier", {})}
    # Zero is an encoder that nothing is known of: the log's own steps count then.
    encoder = {"counts_per_rev": float(stated.pop("counts_per_rev", 0.0))}
    units = {name: stated.pop(name) for name in ("torque_constant", "inertia", "command_unit") if name in stated}
    numbers = {name: _number(value) for name, value in stated.items()}
    columns_of_log = {"reference" if role == "goal" else role: role for role in log}
    tables = {"encoder": encoder, "identifier": identifier, "log": columns_of_log | numbers}
    if inner is not None:
        tables["inner"] = {name: _number(value) for name, value in inner.items()}
    if units:
        tables["physical"] = {name: _number(value) for name, value in units.items()}
    return tables


def _number(value: Any) -> Any:
    """A number as float, which TOML distinguishes; texts and lists unchanged."""
    return value if isinstance(value, str) or np.ndim(value) > 0 else float(value)


def _of_joint(stated: Mapping[str, Any], number: int, count: int) -> dict[str, Any]:
    """The statements for one joint of several."""

    def one(name: str, value: Any) -> Any:
        if isinstance(value, str) or np.ndim(value) == 0:
            return value
        if len(value) != count:
            raise ValueError(f"{name} has {len(value)} entries for {count} joints: state one for each or one for all")
        return value[number]

    own = {name: one(name, stated[name]) for name in ("torque_constant", "inertia") if name in stated}
    if "inner" in stated:
        own["inner"] = {name: one(f"inner[{name!r}]", value) for name, value in stated["inner"].items()}
    return {**stated, **own}


def float_columns(log: Mapping[str, Any]) -> dict[str, npt.NDArray[np.float64]]:
    """The columns as contiguous float64, without a copy where they are."""
    arrays = {}
    for name, column in log.items():
        array = np.asarray(column)
        if array.ndim != 1:
            raise ValueError(
                f"{name} has the shape {array.shape}: a column has one number per sample; use identify_joints for several joints"
            )
        if array.dtype.kind not in "fiu":
            raise ValueError(f"{name} has the type {array.dtype}: a column must have numbers")
        arrays[name] = np.ascontiguousarray(array, dtype=np.float64)
    return arrays
