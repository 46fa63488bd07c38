"""A motion that shows the servo behind its own loop, and its log."""

from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ._session import Rows, Session


class Move(NamedTuple):
    """To a goal, as a part of the travel, and the time for it, s; none for a step, which then lasts so long."""

    goal: float
    seconds: float
    is_step: bool = False


def plan() -> list[Move]:
    """Slow moves first, then faster and wider ones with reversals and rests, then small steps."""
    moves = []
    for seconds in (1.0, 0.5, 0.3):
        for part in (0.15, 0.3):
            moves += [Move(part, seconds), Move(-part, seconds), Move(0.0, seconds), Move(0.0, 0.25)]
    random = Random(1)
    moves += [Move(random.uniform(-0.15, 0.15), random.uniform(0.12, 0.35), True) for _ in range(24)]
    return [*moves, Move(0.0, 1.0), Move(0.0, 0.3)]


def course(moves: list[Move]) -> tuple[Callable[[float], float], float]:
    """The goal at a time, as a part of the travel, and the duration."""
    ends = np.cumsum([move.seconds for move in moves])
    starts = [0.0, *(move.goal for move in moves)]

    def goal(time: float) -> float:
        number = min(int(np.searchsorted(ends, time, "right")), len(moves) - 1)
        move, start = moves[number], starts[number]
        part = min(1.0 - (ends[number] - time) / move.seconds, 1.0)
        smooth = 1.0 if move.is_step else 0.5 - 0.5 * np.cos(np.pi * part)
        return start + (move.goal - start) * smooth

    return goal, float(ends[-1])


def described() -> str:
    """The plan in words."""
    moves = plan()
    steps = sum(move.is_step for move in moves)
    seconds = sorted({move.seconds for move in moves if not move.is_step and move.goal})
    largest = max(abs(move.goal) for move in moves)
    return (
        f"{len(moves) - steps} moves and rests up to ±{100 * largest:.0f} % of the travel in {seconds[-1]} to {seconds[0]} s, and "
        f"{steps} small steps: {course(moves)[1]:.0f} s"
    )


def captured(session: Session, moves: list[Move]) -> Rows:
    """The rows of a motion, the load in the direction of the position: which one a reversed servo reports is not documented."""
    goal, seconds = course(moves)
    rows = session.follow(lambda time: session.travel * goal(time), seconds)
    rows[:, 3] *= np.sign(rows[:, 3] @ (rows[:, 1] - rows[:, 2]))
    return rows


def log_of(rows: Rows, counts: int, voltage: float) -> dict[str, npt.NDArray[np.float64]]:
    """Columns of a log: time, s, goal and position, rad, and the command from a row to the next, V. A goal is sent right after a
    row, so that the load at the next one is nearly that command; the mean of both would be late."""
    time, goal, position, load = rows.T
    angle = 2.0 * np.pi / counts
    return {"time": time, "goal": angle * goal, "position": angle * position, "command": voltage * np.append(load[1:], load[-1])}


def write(file: Path, session: Session, rows: Rows, voltage: float) -> None:
    """The log as CSV, with what its reader has to know first."""
    maker, log = session.servo.maker, log_of(rows, session.servo.maker.counts, voltage)
    gains = " ".join(f"{name.upper()} {number}" for name, number in session.gains.items())
    degrees = [np.degrees(log[name]) for name in ("goal", "position")]
    lines = [
        # Without a separator of columns.
        f"# {maker.name} {maker.models[session.servo.read('model')]} id {session.servo.identity}: {gains} at {voltage:.1f} V",
        f"# travel {session.travel:.0f} of {maker.counts} counts a revolution: " + described().replace(",", ""),
        f"# servo-id identify {file.name} --position position_deg --command command_V --counts-per-rev {maker.counts}",
        "time_s,goal_deg,position_deg,load,command_V",
    ]
    rounded = zip(log["time"], *degrees, rows[:, 3], log["command"])
    lines += [f"{time:.5f},{goal:.4f},{position:.4f},{load:.4f},{command:.5f}" for time, goal, position, load, command in rounded]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
