"""Experiments: on logs, on the simulated servo, on many servos."""

import tomllib
from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from os import PathLike, fspath
from pathlib import Path as File
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, Unpack

import numpy as np
import numpy.typing as npt

from . import _frames, _native, _read, _scenario
from ._keywords import Conditions, Form, JointOptions, LogOptions, keywords
from ._results import Columns, Commissioning, Gains, Prediction, Result, Sweep, columns, text_of
from ._scenario import Scenario

if TYPE_CHECKING:
    from distributed import Client
    from pandas import DataFrame

Path: TypeAlias = str | PathLike[str]
Log: TypeAlias = "Path | Mapping[str, npt.ArrayLike] | DataFrame | npt.ArrayLike | Sequence[Any]"
"""A file or several; or columns: position, command or goal, and time where the samples are not ``sample_time`` apart."""

Law: TypeAlias = Literal["fit", "gauss-newton", "gradient"]

_ROLES = ("time", "position", "command", "reference", "goal", "velocity", "known_torque")

_OF_LOOP = {"kp", "kd", "limit", "loop_time", "integrator", "cutoff"}
"""Keywords of a servo's own loop."""

_BATCH = 200
"""Servos of a batch: seconds of work, so that its way to a worker costs nothing beside it."""


@keywords
def identify(
    log: Log,
    *logs: Log,
    joint: str | int | None = None,
    scenario: Scenario | None = None,
    law: Law | str | None = None,
    identifier: Mapping[str, Any] | None = None,
    trace: bool = True,
    **options: Unpack[LogOptions],
) -> Result:
    """The servo behind a log of position and command.

    ``log`` is a file as :func:`read_log` takes it, of which ``joint`` is identified, or a data frame or mapping of columns:
    ``position`` and ``command``, the total that acted, with ``time`` (s) or ``sample_time=``. Columns of other names, or of none, as
    in ``identify(q, u, sample_time=1e-3)`` and an array of rows and columns, are recognised as those of a file. The units of either
    are found; ``result.findings`` says how. What a log does not show is asked for by a ``ValueError`` that names the keyword.

    Several files are logs of one servo.

    A servo that closes its own loop has a ``goal`` in place of a command, and that loop is ``kp``, ``kd``, ``limit``,
    ``loop_time``, ``integrator`` and ``cutoff``; a column ``velocity`` is the one it acts on.

    ``torque_constant`` or ``inertia``, or ``command_unit``, put the result in physical units: ``result.physical``,
    ``result.voltage_gains``. ``law`` is the estimator, ``fit`` by default; ``identifier`` has further keys of that table.

    With a ``scenario``, its ``[log]`` names the columns and nothing else may be stated.
    """
    log = (log, *logs) if logs else log
    estimator = estimator_of(law or "fit", identifier) if law or identifier else {}
    if scenario is not None:
        stated = [*options, *estimator]
        if stated:
            raise ValueError(f"{', '.join(stated)}: not allowed together with a scenario: state it there")
        text, reading, findings = _scenario.read(scenario), None, ()
        # It has the sample time, wherever that is.
        sources, _ = _sources(log, joint, {"sample_time": None, **tomllib.loads(text[1]).get("log", {})})
    else:
        sources, options = _sources(log, joint, options)
        text, reading, findings = _recognised(sources, options, estimator)
    found, samples, picture, servo = _native.identify_log(*text, sources, reading, trace=trace)
    return Result(found, columns(samples), findings, picture, text, servo)


def predict(result: Result, log: Log, *, joint: str | int | None = None) -> Prediction:
    """The motion of an identified servo over another log with the same columns, driven by that log's commands alone."""
    if result.servo is None:
        raise ValueError("there is no servo that could predict: identify a log, until the verdict is not aborted or unexplained")
    sources, _ = _sources(log, joint, tomllib.loads(result.scenario[1])["log"])
    return Prediction(*_native.predict(*result.scenario, result.servo, sources))


@keywords
def identify_joints(
    log: Mapping[str, npt.ArrayLike],
    *,
    names: Sequence[str] | None = None,
    threads: int | None = None,
    law: Law | str | None = None,
    identifier: Mapping[str, Any] | None = None,
    trace: bool = False,
    **options: Unpack[JointOptions],
) -> dict[str, Result]:
    """The servos of several joints, each with a column of its own in ``position`` and ``command`` (samples × joints).

    ``names`` are those of the joints, ``joint_0`` and so on by default. The keywords are those of :func:`identify`, where
    torque_constant, inertia, kp, kd and limit may be sequences, a number for each joint.

    Frames of a robot-learning data set, whose columns are ``observation.state``, ``action``, ``timestamp`` and
    ``episode_index``, are taken as they are, as a mapping, a data frame or a data set: the action is the goal of the servos'
    own loops, and nothing is carried over from one episode to the next.
    """
    if _frames.is_frames(log):
        log, between_episodes = _frames.log_of(log)
        options = {"cut": between_episodes, **options} if between_episodes else options
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
        return identify(own, law=law, identifier=identifier, trace=trace, **_of_joint(options, number, count))

    with ThreadPoolExecutor(threads) as pool:
        return dict(zip(names, pool.map(one, range(count))))


@keywords
def read_log(
    log: Log, *, joint: str | int | None = None, scenario: Scenario | None = None, **options: Unpack[LogOptions]
) -> Columns:
    """The samples of a log in SI: time, position, and command and reference where it has them.

    A log is a text (.csv, .csv.gz), a bag of ROS (a folder, .db3, .mcap, .bag), .wpilog, .ulg, .parquet, .mat, .npz or .json: a
    list of records or an object of lists. Its columns are found or stated as for :func:`identify`; of several joints one
    is stated, by its name or number.
    """
    sources, options = _sources(log, joint, options)
    text = _recognised(sources, options)[0] if scenario is None else _scenario.read(scenario)
    return columns(_native.read_log(*text, sources))


@keywords
def page(log: Log, *, joint: str | int | None = None, width: int = 100, **options: Unpack[LogOptions]) -> str:
    """The page that the program ``servo-id identify`` prints."""
    sources, options = _sources(log, joint, options)
    return _native.page(sources, _as_options(options), width)


def estimator_of(law: str, identifier: Mapping[str, Any] | None) -> dict[str, Any]:
    """The table of an estimator. Every servo has Coulomb friction, which the gradient needs a gamma and bounds for."""
    every = {"parameters": ["a", "b", "coulomb", "load"]} if law == "gauss-newton" else {}
    return {"law": law, **every, **(identifier or {})}


def _sources(log: Log, joint: str | int | None, options: Mapping[str, Any]) -> tuple[list[Any], Mapping[str, Any]]:
    """The recordings of a log as the native half takes them, each a text, or a name and columns. And what is stated of them, with the
    quantities that columns in memory are named by."""
    named = [str(options[role]) for role in _ROLES if role in options]
    if isinstance(log, (str, PathLike)):
        path = fspath(log)
        if not _read.is_text(File(path)):
            return [(path, list(part.items())) for part in _read.columns_of(File(path), joint, named)], options
        if joint is not None:
            raise ValueError(f"{path}: joint: a text log has no joints: state the columns position and command")
        return [path], options
    if isinstance(log, (list, tuple)) and log and all(isinstance(one, (str, PathLike)) for one in log):
        return [source for one in log for source in _sources(one, joint, options)[0]], options
    found = _read.shaped(log)
    names = [name for name, _ in found]
    if joint is None and set(names) <= set(_ROLES) and not named:
        _check_roles(names, options)
        return [("log", _read.float_columns(found))], {role: role for role in names} | options
    if joint is None and "" in names:
        if len(found) < 2:
            raise ValueError("log: it has one column: pass position and command, as in identify(q, u, sample_time=0.001)")
        return [("log", _read.float_columns(found))], options
    # By name: columns without numbers are left out.
    numbered = {role: options[role] for role in _ROLES if isinstance(options.get(role), int)}
    by_name = {role: names[number - 1] for role, number in numbered.items() if str(number) not in names and 0 < number <= len(names)}
    return [("log", list(part.items())) for part in _read.columns_of(dict(found), joint, named)], {**options, **by_name}


def _as_options(stated: Mapping[str, Any]) -> dict[str, str]:
    return {name: str(value) for name, value in stated.items()}


def _recognised(
    sources: list[Any], options: Mapping[str, Any], estimator: Mapping[str, Any] | None = None
) -> tuple[tuple[str, str], str, tuple[tuple[str, str], ...]]:
    """The scenario of a log without one, its name and its text, and how the log is taken, as JSON and as sentences."""
    lists = {name: value for name, value in options.items() if name in ("bridge_gaps", "cut")}
    named = {name: value for name, value in options.items() if name not in lists}
    text, reading, found = _native.recognise_log(sources, _as_options(named))
    if lists or estimator:
        tables = tomllib.loads(text)
        tables["log"] |= lists
        tables["identifier"] |= estimator or {}
        text = _scenario.read(tables)[1]
    first = sources[0]
    return (f"the scenario of {first if isinstance(first, str) else first[0]}", text), reading, tuple(found)


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


@keywords
def tune(
    result: Result,
    *,
    form: Form | str | None = None,
    accept_unconverged: bool = False,
    **conditions: Unpack[Conditions],
) -> Gains:
    """PID gains for a servo, with their predicted response.

    The goal is ``response_time`` or ``bandwidth``, by default as stiff as the servo allows.

    ``form`` states them in the form of a drive's firmware too (``gains.form``), with ``torque_constant``, ``bus_voltage`` or
    ``max_current`` where that form needs it.

    ``encoder_on`` ("motor" or "load") and ``resonance`` (rad/s, ``inf`` for none) bound a resonance that the log does not
    show. ``command_sign`` is asked for where the motion goes against the log's command.
    """
    if {"response_time", "bandwidth"} <= conditions.keys():
        raise ValueError("response_time and bandwidth are two goals: state only one")
    stated = {name: str(value) for name, value in conditions.items()}
    text, assumptions = _native.tune(text_of(result), stated, form, accept_unconverged)
    return Gains(text, tuple(assumptions))


def _check_roles(log: Collection[str], options: Mapping[str, Any]) -> None:
    """Refuses columns with the names of their quantities that are none of a log, or lack one."""
    has_goal = "goal" in log
    for role in ("position", "goal" if has_goal or _OF_LOOP & options.keys() else "command"):
        if role not in log:
            raise ValueError(f"the log has no {role}: it has {', '.join(log) or 'nothing'}")
    if has_goal and ("command" in log or "reference" in log):
        raise ValueError("goal: a log has either a goal, or a command and a reference; leave out the others")
    if "time" not in log and "sample_time" not in options:
        raise ValueError("sample_time is missing: state the time from one sample to the next, s, or a column time")


def _of_joint(stated: Mapping[str, Any], number: int, count: int) -> dict[str, Any]:
    """The statements for one joint of several."""

    def one(name: str, value: Any) -> Any:
        if isinstance(value, str) or np.ndim(value) == 0:
            return value
        if len(value) != count:
            raise ValueError(f"{name} has {len(value)} entries for {count} joints: state one for each or one for all")
        return value[number]

    own = ("torque_constant", "inertia", "kp", "kd", "limit")
    return {name: one(name, value) if name in own else value for name, value in stated.items()}
