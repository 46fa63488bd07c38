"""Logs that are no text: series of numbers, as the libraries of their formats read them, joined by their stamps."""

import json
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _frames

Columns: TypeAlias = dict[str, npt.NDArray[np.float64]]

TIME = "time_s"
"""The column of joined stamps, and of those whose unit a format states."""

_MAX_SERIES = 40
"""Series that compete to be position and command: the time for that grows with their square."""

_MAX_ELEMENTS = 64
"""Elements of an array that are a series each: those of an image are none."""

_ONE_CLOCK = 10**9
"""Distance of the stamps of one clock, ns."""

_OF_FRAMES = {_frames.POSITION: "position", _frames.GOAL: "goal", _frames.TIME: TIME}


class Fault(Exception):
    """The error of a log, and the remedy."""


class Series(NamedTuple):
    """Numbers over time."""

    topic: str
    """Its group, which its name has in front where others have a series of this name."""
    field: str
    joint: str | None
    """Its joint, where the log has a series of this field for each."""
    stamps: npt.NDArray[np.int64] | None
    """ns; none where the rows are the samples."""
    values: npt.NDArray[np.float64]
    part: str = ""
    """The recording that it is of, where a file has several of the servo."""


def is_text(path: Path) -> bool:
    """True for a file that is read as text."""
    return path.suffix.lower() not in _KINDS and not path.is_dir()


def columns_of(log: Any, joint: str | int | None, stated: Collection[str]) -> list[Columns]:
    """The columns of each recording of a file, or of columns by name: those of one joint, and of the ``stated`` names alone where a
    position and its command are among them. A row has the numbers of one moment, and NaN for a series that has none then."""
    try:
        parts = defaultdict(list)
        for series in _of_file(log) if isinstance(log, Path) else _table(log):
            parts[series.part].append(series)
        return [_joined(part, joint, stated) for part in parts.values() or [[]]]
    except Fault as fault:
        raise ValueError(f"{log if isinstance(log, Path) else 'log'}: {fault}") from fault.__cause__


def shaped(log: Any) -> list[tuple[str, Any]]:
    """The columns of a log in memory with their names, which those of plain arrays have not: of a table or a mapping, a structured
    array, an array whose longer side is its rows, a sequence of these, or records."""
    if isinstance(log, (list, tuple)) and log:
        if all(isinstance(row, Mapping) for row in log):
            return shaped({name: [row.get(name) for row in log] for name in dict.fromkeys(name for row in log for name in row)})
        if any(map(np.ndim, log)):
            columns: list[tuple[str, Any]] = []
            for name, column in (column for one in log for column in shaped(one)):
                # Series of one table have one index.
                if not name or not any(name == other and np.array_equal(column, of) for other, of in columns):
                    columns.append((name, column))
            lengths = {len(column) for _, column in columns}
            if any(name for name, _ in columns) or len(lengths) > 1 or len(columns) <= max(lengths):
                return columns
            log = [column for _, column in columns]
    if names := _frames.names(log):
        return [(str(name), log[name]) for name in names] + _clock(log, names)
    array, name = np.asarray(log), getattr(log, "name", None)
    if array.ndim not in (1, 2):
        what = f"an array of the shape {array.shape}" if array.ndim else f"{log!r:.60}"
        raise ValueError(f"log: {what} is no column: pass columns of position and command, and one of times or sample_time=")
    unnamed = TIME if array.dtype.kind in "mM" else ""
    columns = [(unnamed, column) for column in (array.T if len(array) > len(array.T) else np.atleast_2d(array))]
    return columns if name is None else [(str(name), array), *_clock(log, [name])]


def _clock(table: Any, names: Collection[Any]) -> list[tuple[str, Any]]:
    """The index of a data frame, or of its column, that is the time of its rows, and not their number."""
    index = getattr(table, "index", None) if hasattr(table, "iloc") else None
    times = _array(index)
    if times is None or times.shape[1] > 1 or len(times) < 2:
        return []
    steps = np.diff(times[:, 0])
    is_stamp = index.dtype.kind in "mM"
    counts_rows = hasattr(index, "step") or bool(np.all(steps % 1.0 == 0.0) and np.min(np.abs(steps)) == 1.0)
    if not np.median(steps) > 0.0 or (counts_rows and index.name is None and not is_stamp):
        return []
    name = TIME if is_stamp else "time" if index.name is None else str(index.name)
    return [] if name in names else [(name, times[:, 0])]


def _of_file(path: Path) -> list[Series]:
    reader, library = _KINDS.get(path.suffix.lower(), _KINDS[".db3"])
    if not path.exists():
        raise Fault("the log cannot be read: there is no such file or folder")
    if path.is_file() and path.stat().st_size == 0:
        raise Fault("the file is empty: record the motion of the servo")
    try:
        return list(reader(path))
    except ImportError as error:
        raise ImportError(f"{path}: this log needs {library}: pip install {library}") from error
    except Fault:
        raise
    except Exception as error:
        known = f"{library} {version(library)} cannot read it" if library else "it cannot be read"
        newer = f", or update the library if the format is newer: pip install --upgrade {library}" if library else ""
        raise Fault(f"{known} ({' '.join(str(error).split()) or type(error).__name__}): write the file again{newer}") from error


def _joined(series: list[Series], joint: str | int | None, stated: Collection[str]) -> Columns:
    having = Counter(field for _, field in {(one.topic, one.field) for one in series})
    joints = list(dict.fromkeys(one.joint for one in series if one.joint is not None))
    if joint is None and len(joints) > 1:
        raise Fault(f"it has the joints {', '.join(joints)}: state one, such as joint={joints[0]}")
    if joint is not None and str(joint) not in joints:
        raise Fault(f"there is no joint {joint}, but {', '.join(joints) or 'only one: leave joint out'}")
    chosen = {
        one.field if having[one.field] == 1 or not one.topic else f"{one.topic}.{one.field}": one
        for one in series
        if one.joint is None or joint is None or one.joint == str(joint)
    }
    if any(one.stamps is None for one in chosen.values()):
        return {name: one.values for name, one in chosen.items()}
    named = {name: one for name, one in chosen.items() if name in stated}
    moving = named if len(named) > 1 else {name: one for name, one in chosen.items() if _moves(one.values)}
    names = ", ".join(moving)
    if len(moving) > _MAX_SERIES:
        raise Fault(f"it has {len(moving)} series that change: state position and command from {names}")
    if len(moving) < 2:
        raise Fault(f"it has {names or 'no series of numbers that change'}: a log needs the position and the command that acts")
    stamps = np.unique(np.concatenate([one.stamps for one in moving.values()]))
    columns = {TIME: (stamps - stamps[0]) * 1e-9}
    for name, one in moving.items():
        columns[name] = np.full(len(stamps), np.nan)
        columns[name][np.searchsorted(stamps, one.stamps)] = one.values
    return columns


def _moves(values: npt.NDArray[np.float64]) -> bool:
    known = values[np.isfinite(values)]
    return known.size > 0 and bool(np.ptp(known) > 0.0)


def _table(columns: Mapping[str, Any]) -> list[Series]:
    """The series of columns by name, of which most are as long. Matrices of one width have a column for each joint."""
    arrays = {name: array for name, column in columns.items() if (array := _array(column)) is not None}
    lengths = Counter(len(array) for array in arrays.values() for _ in range(array.shape[1]))
    rows = max((length for length, count in lengths.items() if count > 1), default=0)
    if rows < 2:
        raise Fault("no two columns of numbers have the same length: a log has one row per sample, with position and command")
    arrays = {name: array for name, array in arrays.items() if len(array) == rows}
    widths = Counter(array.shape[1] for array in arrays.values() if array.shape[1] > 1)
    series = []
    for name, array in arrays.items():
        name = _OF_FRAMES.get(name, name) if _frames.POSITION in arrays else name
        for number, values in enumerate(array.T):
            of_joint = str(number) if widths[array.shape[1]] > 1 else None
            one = name if len(array.T) == 1 or of_joint else f"{name}[{number}]"
            series.append(Series("", one, of_joint, None, np.ascontiguousarray(values)))
    return series


def float_columns(columns: Iterable[tuple[str, Any]]) -> list[tuple[str, npt.NDArray[np.float64]]]:
    """Columns of one number per sample as contiguous float64."""
    arrays = []
    for number, (name, column) in enumerate(columns, 1):
        called, array = name or f"array {number}", _array(column)
        if array is None:
            raise ValueError(f"{called} has the type {np.asarray(column).dtype}: a column must have numbers")
        if array.shape[1] != 1:
            raise ValueError(
                f"{called} has the shape {array.shape}: a column has one number per sample; use identify_joints for several joints"
            )
        if not np.isfinite(array).any():
            raise ValueError(f"{called} is empty: it has no number; leave it out, or record it")
        if arrays and len(array) != len(arrays[0][1]):
            raise ValueError(
                f"{called} has {len(array)} samples, but the first column has {len(arrays[0][1])}: cut them to the same length"
            )
        arrays.append((name, np.ascontiguousarray(array[:, 0])))
    return arrays


def _array(column: Any) -> npt.NDArray[np.float64] | None:
    """A column of numbers, vectors or times as a matrix; none of anything else."""
    try:
        array = np.asarray(column)
        if array.dtype.kind == "O":
            array = np.array(list(array), dtype=np.float64)
    except (TypeError, ValueError):
        return None
    if array.dtype.kind in "mM":
        array = (array.astype("M8[ns]" if array.dtype.kind == "M" else "m8[ns]") - array[:1]) / np.timedelta64(1, "s")
    if array.dtype.kind not in "biuf" or array.ndim not in (1, 2):
        return None
    return (array[:, None] if array.ndim == 1 else array).astype(np.float64)


def _streams(samples: Iterable[tuple[str, int, Any]]) -> Iterator[Series]:
    """The series of names with stamps, ns, and numbers or arrays of numbers."""
    found: dict[str, tuple[list[int], list[float]]] = defaultdict(lambda: ([], []))
    for name, stamp, value in samples:
        for one, number in _elements(name, value):
            stamps, values = found[one]
            stamps.append(stamp)
            values.append(number)
    for name, (stamps, values) in found.items():
        yield Series("", name, None, np.array(stamps), np.array(values, dtype=np.float64))


def _elements(name: str, value: Any) -> Iterable[tuple[str, float]]:
    if np.ndim(value) == 0:
        return [(name, value)]
    return ((f"{name}[{number}]", one) for number, one in enumerate(value) if len(value) <= _MAX_ELEMENTS)


def _ros(path: Path) -> Iterator[Series]:
    """The fields of messages."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    stamps: dict[str, list[tuple[int, int]]] = defaultdict(list)
    found: dict[tuple[str, str, str | None], list[tuple[int, float]]] = defaultdict(list)
    with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as bag:
        # Some writers of MCAP leave the part between out.
        kinds = {of.msgtype: re.sub("^([^/]*)/([^/]*)$", r"\1/msg/\2", of.msgtype) for of in bag.connections}
        topics = {of.topic for of in bag.connections}
        known = [of for of in bag.connections if kinds[of.msgtype] in bag.typestore.fielddefs]
        for connection, received, raw in bag.messages(known) if known else ():
            topic = connection.topic
            message = bag.deserialize(raw, kinds[connection.msgtype])
            stamp = getattr(getattr(message, "header", None), "stamp", None)
            joints = getattr(message, "joint_names", getattr(message, "name", ()))
            for field, value in _numbers(message, ""):
                is_of_joints = np.ndim(value) == 1 and not isinstance(joints, str) and len(value) == len(joints)
                named = zip([(field, one) for one in joints], value) if is_of_joints else (
                    ((one, None), number) for one, number in _elements(field, value)
                )
                for (one, joint), number in named:
                    found[topic, one, joint].append((len(stamps[topic]), number))
            stamps[topic].append((stamp.sec * 10**9 + stamp.nanosec if stamp else 0, received))
    if not found:
        raise Fault(f"no topic of the bag has numbers: {_listed(topics)}; record one with positions, such as /joint_states")
    clocks = {topic: np.array(stamps[topic]) for topic, _, _ in found}
    # The messages' own clock counts where all have one or it is the recorder's.
    all_own = all(np.all(clock[:, 0] > 0) for clock in clocks.values())
    for topic, clock in clocks.items():
        is_own = all_own or np.all(np.abs(clock[:, 0] - clock[:, 1]) < _ONE_CLOCK)
        clocks[topic] = clock[:, 0 if is_own else 1]
    for (topic, field, joint), numbers in found.items():
        places, values = zip(*numbers)
        # A message of one number has the name of its topic.
        own, name = ("", topic + field) if field[:1] in ("", "[") else (topic, field)
        yield Series(own, name, joint, clocks[topic][list(places)], np.array(values, dtype=np.float64))


def _numbers(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    """The numbers and arrays of numbers of a message by the names of their fields, its stamps and layout left out."""
    if is_dataclass(value):
        if getattr(value, "__msgtype__", "").startswith("builtin_interfaces"):
            return
        for one in fields(value):
            if one.name not in ("header", "layout", "__msgtype__"):
                inner = "" if one.name == "data" else one.name
                yield from _numbers(getattr(value, one.name), ".".join(filter(None, (name, inner))))
    elif isinstance(value, (int, float)) or (isinstance(value, np.ndarray) and value.dtype.kind in "fiu"):
        yield name, value


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names)) or "none"


def _wpilog(path: Path) -> Iterator[Series]:
    from wpiutil.log import DataLogReader

    getters = {"boolean": "getBoolean", "double": "getDouble", "float": "getFloat", "int64": "getInteger"}
    getters |= {f"{kind}[]": f"{getter}Array" for kind, getter in getters.items()}
    reader = DataLogReader(str(path))
    if not reader.isValid() or reader.getVersion() >> 8 != 1:
        raise ValueError(f"its version is {reader.getVersion() / 256}: only 1.0 is supported")

    def samples() -> Iterator[tuple[str, int, Any]]:
        entries = {}
        for record in reader:
            if record.isStart():
                entry = record.getStartData()
                entries[entry.entry] = (entry.name, getters.get(entry.type))
            elif not record.isControl():
                name, getter = entries.get(record.getEntry(), ("", None))
                if getter is not None:
                    yield name, 1000 * record.getTimestamp(), getattr(record, getter)()

    return _streams(samples())


def _ulog(path: Path) -> Iterator[Series]:
    from pyulog import ULog

    with path.open("rb") as file:
        beginning = file.read(8)
        if beginning[:4] == b"ULog" and beginning[-1] > 1:
            raise ValueError(f"its version is {beginning[-1]}: only 1 is supported")
        file.seek(0)
        messages = ULog(file).data_list
    for message in messages:
        topic = f"{message.name}_{message.multi_id}" if message.multi_id else message.name
        stamps = message.data["timestamp"].astype(np.int64) * 1000
        for field, values in message.data.items():
            if not field.startswith("timestamp"):
                yield Series(topic, field, None, stamps, values.astype(np.float64))


def _parquet(path: Path) -> list[Series]:
    from pyarrow.parquet import read_table

    read = read_table(path)
    return _table({name: column.to_numpy() for name, column in zip(read.column_names, read.columns)})


def _mat(path: Path) -> list[Series]:
    from scipy.io import loadmat

    try:
        found = loadmat(path, squeeze_me=True)
        is_structure = {name: getattr(value, "dtype", np.dtype(float)).kind in "OV" for name, value in found.items()}
    except NotImplementedError:
        found, is_structure = _hdf5(path)
    try:
        return _table({name: value for name, value in found.items() if not name.startswith("__")})
    except Fault:
        structures = [name for name, value in is_structure.items() if value]
        if not structures:
            raise
        raise Fault(
            f"{', '.join(structures)}: a structure instead of arrays of numbers: save its fields in MATLAB with "
            f"save(file, '-struct', '{structures[0]}', '-v7')"
        ) from None


def _hdf5(path: Path) -> tuple[dict[str, Any], dict[str, bool]]:
    """The arrays of a MAT-file of version 7.3, which has their dimensions reversed, and which of its names are structures."""
    try:
        from h5py import Dataset, File
    except ImportError as error:
        raise Fault("this is a MAT-file of version 7.3, which needs h5py: pip install h5py") from error
    with File(path) as file:
        arrays = {name: np.squeeze(of[()].T) for name, of in file.items() if isinstance(of, Dataset) and of.dtype.kind in "biuf"}
        return arrays, {name: name not in arrays for name in file if not name.startswith("#")}


def _npz(path: Path) -> list[Series]:
    with np.load(path) as file:
        return _table(dict(file))


def _json(path: Path) -> list[Series]:
    read = json.loads(path.read_text(encoding="utf-8"))
    if isinstance(read, dict) and {"law", "status"} <= read.keys():
        raise Fault("this is a result, not a log: Result(text) has it again")
    if isinstance(read, dict) and any(test in read for test in _SYSID_TESTS):
        return [series for test in _SYSID_TESTS if read.get(test) for series in _sysid(read, test)]
    if not isinstance(read, dict) and not (isinstance(read, list) and all(isinstance(row, dict) for row in read)):
        raise Fault("it is neither a list of records nor an object of lists: write one of these, with one record per sample")
    return _table(dict(shaped(read)) if read else {})


def _sysid(read: dict[str, Any], test: str) -> Iterator[Series]:
    """The series of a test of WPILib's SysId: positions are turns, times the units of a turn. A drivetrain has two sides."""
    rows = _array(read[test])
    sides = None if rows is None else {4: (None,), 9: ("left", "right")}.get(rows.shape[1])
    if sides is None:
        raise Fault(f"{test} is no table of SysId: write 4 numbers a row, time, voltage, position and velocity, or 9 of a drivetrain")
    unit = str(read.get("units", "Rotations")).lower()
    unit = _SYSID_UNITS.get(unit, unit)
    scales = [1.0, *[float(read.get("unitsPerRotation", 1.0))] * 2]
    yield Series("", TIME, None, None, rows[:, 0], test)
    for place, (field, scale) in enumerate(zip(("voltage_V", f"position_{unit}", f"velocity_{unit}_per_s"), scales)):
        for number, side in enumerate(sides):
            yield Series("", field, side, None, scale * rows[:, 1 + len(sides) * place + number], test)


_SYSID_TESTS = ("slow-forward", "slow-backward", "fast-forward", "fast-backward")
_SYSID_UNITS = {"meters": "m", "feet": "ft", "inches": "inch", "radians": "rad", "rotations": "turns", "degrees": "deg"}


_KINDS: dict[str, tuple[Callable[[Path], Iterable[Series]], str]] = {
    ".bag": (_ros, "rosbags"),
    ".db3": (_ros, "rosbags"),
    ".mcap": (_ros, "rosbags"),
    ".wpilog": (_wpilog, "robotpy-wpiutil"),
    ".ulg": (_ulog, "pyulog"),
    ".parquet": (_parquet, "pyarrow"),
    ".mat": (_mat, "scipy"),
    ".npz": (_npz, "numpy"),
    ".json": (_json, ""),
}
"""Readers by the ends of files, each with its library. A folder is a bag."""
