"""Frames of robot-learning data sets as logs of position and goal."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

POSITION = "observation.state"
GOAL = "action"
TIME = "timestamp"
_EPISODE = "episode_index"

_PAUSE = 1.0
"""Time between two episodes in the log, s, which is left out: nothing is carried over from one to the next."""

_MAX_BREAKS = 100
"""As of ``log.cut``."""


def log_of(frames: Any) -> tuple[dict[str, npt.NDArray[np.float64]], list[list[float]]]:
    """The log of frames with a column ``observation.state`` (frames × joints), ``action`` alike, ``timestamp`` (s, of the
    episode) and, for several episodes, ``episode_index``; and the ranges of its time that are left out.

    A frame has the action that is given when its state has been seen.
    """
    for name in (GOAL, TIME):
        if name not in names(frames):
            raise ValueError(f"the frames have no {name}: they have {', '.join(names(frames))}")
    position, goal = _wide(frames[POSITION]), _wide(frames[GOAL])
    if position.shape != goal.shape:
        raise ValueError(
            f"{POSITION} has the shape {position.shape} but {GOAL} has {goal.shape}: pass the columns of the joints only"
        )
    time = np.array(frames[TIME], dtype=np.float64)
    episode = np.array(frames[_EPISODE]) if _EPISODE in names(frames) else np.zeros(len(time))
    cut = []
    for begin in np.flatnonzero(np.diff(episode)) + 1:
        last = time[begin - 1]
        time[begin:] += last + _PAUSE - time[begin]
        cut.append([last + 0.25 * _PAUSE, last + 0.75 * _PAUSE])
    if len(cut) > _MAX_BREAKS:
        raise ValueError(f"the frames have {len(cut) + 1} episodes: pass at most {_MAX_BREAKS + 1}")
    return {"time": time, "position": position, "goal": goal}, cut


def names(table: Any) -> list[Any]:
    """The columns of a mapping, a structured array, or a table that lists them. None of anything else."""
    listed = getattr(table, "column_names", getattr(table, "columns", getattr(getattr(table, "dtype", None), "names", None)))
    return list(table if listed is None and isinstance(table, Mapping) else () if listed is None else listed)


def is_frames(log: Any) -> bool:
    """True for frames, whose positions have another name than a log's."""
    return POSITION in names(log)


def _wide(column: Any) -> npt.NDArray[np.float64]:
    """A column of vectors, which a data frame has as objects."""
    rows = np.asarray(column)
    return np.stack(list(rows)).astype(np.float64) if rows.dtype == object else rows.astype(np.float64)
