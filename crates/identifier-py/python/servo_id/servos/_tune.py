"""Gains for a servo's own loop from its log, and their trial on the servo."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _native, _scenario
from .._experiments import identify
from .._results import Result
from ._capture import captured, log_of, plan
from ._registers import Fault, Maker, shown
from ._session import Rows, Session

STEP = 0.3
"""Of a trial, part of the travel."""
WINDOW = 0.8
"""From one step of a trial to the next, s."""
ARRIVED = 0.25
"""Part of a step within which a servo rests about its goal; one that does not get there does not settle."""
OTHER = 1.1
"""Factor by which what is not the goal may get worse."""
TRIALS, SLOWER = 3, 0.75
"""Trials at most, and the part of its bandwidth, or of its error at rest, that the next one has."""
DAMPING = (0.5, 0.7, 1.0)
"""Damping ratios of the loops that are considered."""
MAX_SENSITIVITY, MAX_OVERSHOOT, LESS = 1.7, 0.2, 0.9
"""Of a proposal; the last is the part of what the servo has now that is allowed where that is more."""
FIRMWARE_DELAY = 1.5e-3
"""From the reading of the encoder to the output in a firmware, which no maker documents, s."""


@dataclass(frozen=True)
class Response:
    """Steps out and back: means, and the largest overshoot."""

    settling_time: float
    """Until it stays within 5 % of the step, or 2.5 counts, of where it comes to rest, s."""
    error: float
    """From the goal at rest, counts."""
    overshoot: float
    """Part of the step."""
    ripple: float
    """From end to end at rest, counts."""

    def __str__(self) -> str:
        return (
            f"settles in {1e3 * self.settling_time:.0f} ms, overshoots by {100 * self.overshoot:.0f} %, rests "
            f"{self.error:.1f} counts from its goal"
        )


@dataclass(frozen=True)
class Proposal:
    """Gains with the response that is predicted for them."""

    gains: dict[str, int]
    bandwidth: float
    predicted: Response


def response(time: npt.NDArray[Any], position: npt.NDArray[Any], goals: list[float]) -> Response:
    """The response to goals that follow one another after a window each; the first is where the motion starts."""
    parts = []
    for number, (before, goal) in enumerate(pairwise(goals)):
        inside = (time >= number * WINDOW) & (time < (number + 1) * WINDOW)
        own, since = position[inside], time[inside] - number * WINDOW
        rest = own[since > 0.75 * WINDOW]
        if len(rest) < 3:
            raise Fault("too few answers in a trial: check the cable")
        beyond = (own - rest.mean()) / (goal - before)
        outside = since[np.abs(own - rest.mean()) > max(0.05 * abs(goal - before), 2.5)]
        arrives = abs(goal - rest.mean()) < ARRIVED * abs(goal - before)
        parts.append((outside.max(initial=0.0) if arrives else WINDOW, abs(goal - rest.mean()), beyond.max(), np.ptp(rest)))
    settling, error, overshoot, ripple = zip(*parts)
    return Response(float(np.mean(settling)), float(np.mean(error)), float(max(overshoot)), float(max(ripple)))


class Model:
    """The servo that was found behind a log, with the scales of its firmware's gains."""

    def __init__(self, maker: Maker, rows: Rows, gains: dict[str, int], voltage: float, step: float) -> None:
        self.maker, self.voltage, self.step = maker, voltage, step
        log = log_of(rows, maker.counts, voltage)
        columns = {name: log[name] for name in ("time", "position", "command")}
        self.result: Result = identify(columns, counts_per_rev=maker.counts, command_unit="V")
        if not self.result.estimates["b"] > 0.0:
            raise Fault(f"the log does not show the servo: {self.result.reason}")
        # The command of a row is the load half a period later than on average.
        shift = 0.5 * float(np.median(np.diff(rows[:, 0])))
        self.delay = min(max(self.result.estimates.get("delay", 0.0) - shift, 0.0) + FIRMWARE_DELAY, 0.02)
        """From the reading of the encoder to the motor, s."""
        self.scales = scales(maker, rows, gains)
        """Share of the supply for a unit of a gain at 1 rad, or rad/s, or rad s. A gain that was 0 has none."""

    def proposals(self, gains: dict[str, int]) -> Iterator[Proposal]:
        """Gains whose closed loop has two poles of a bandwidth and a damping, as far as the registers reach. A derivative that
        is 0 stays so: its scale is not known."""
        a, b = self.result.estimates["a"], self.voltage * self.result.estimates["b"]
        most, per_rate = self.maker.largest_gain, self.scales.get("d", 0.0)
        most_sensitive = max(MAX_SENSITIVITY, LESS * self.sensitivity(gains))
        for bandwidth in np.geomspace(4.0, 150.0, 30):
            for damping in DAMPING:
                d = min(max((2.0 * damping * bandwidth - a) / b / per_rate, 0.0), most) if per_rate else 0.0
                p = bandwidth**2 / b / self.scales["p"]
                whole = gains | {"p": round(p)} | ({"d": round(d)} if per_rate else {})
                if 1 <= round(p) <= most and self.sensitivity(whole) < most_sensitive:
                    yield Proposal(whole, float(bandwidth), self.predicted(whole))

    def sensitivity(self, gains: dict[str, int]) -> float:
        """The largest of the loop of these gains, without friction."""
        found = self.result.estimates
        s = 1j * np.geomspace(1.0, 2000.0, 400)
        controller = gains["p"] * self.scales["p"] + gains["d"] * self.scales.get("d", 0.0) * s
        servo = self.voltage * found["b"] / (s * (s + max(found["a"], 0.0))) * np.exp(-s * self.delay)
        return float((1.0 / np.abs(1.0 + controller * servo)).max())

    def predicted(self, gains: dict[str, int]) -> Response:
        """The response of the servo to steps out and back, with the error that friction and load leave at most."""
        found = self.result.estimates
        held = (max(found["coulomb"], 0.0) + abs(found["load"])) / found["b"] / self.voltage
        error = held / (gains["p"] * self.scales["p"]) * self.maker.counts / (2.0 * np.pi)
        time, position, sag = self.moved(gains)
        return replace(response(time, position, [sag, sag + self.step, sag]), error=error)

    def moved(self, gains: dict[str, int]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], float]:
        """Time, s, and position, counts, of that response, and how far the load takes the servo from its goal."""
        found = self.result.estimates
        plant = {name: max(found[name], 0.0) for name in ("a", "b", "coulomb")} | {"load": found["load"]}
        plant["delay"] = self.delay
        servo = _native.SimulatedServo(*_scenario.read({"plant": plant, "controller": {"sample_time": 1e-3}}))
        count = 2.0 * np.pi / self.maker.counts
        per_count = gains["p"] * self.scales["p"] * count
        per_rate = gains["d"] * self.scales.get("d", 0.0)
        sag = -found["load"] / found["b"] / self.voltage / per_count
        angle = velocity = 0.0
        positions = []
        for number in range(round(2.0 * WINDOW / 1e-3)):
            wanted = sag + (self.step if number < WINDOW / 1e-3 else 0.0)
            duty = per_count * (wanted - round(angle / count)) - per_rate * velocity
            angle, velocity = servo.step(self.voltage * max(min(duty, 0.97), -0.97))
            positions.append(angle / count)
        return 1e-3 * np.arange(len(positions)), np.array(positions), sag


def scales(maker: Maker, rows: Rows, gains: dict[str, int]) -> dict[str, float]:
    """The scales of the gains that are not 0, by least squares of the load over error, rate and sum of a log."""
    time, goal, position, load = rows.T
    angle = 2.0 * np.pi / maker.counts
    error = angle * (goal - position)
    rate, slope = np.gradient(angle * position, time), np.gradient(angle * goal, time)
    parts = {
        "p": gains["p"] * error,
        "d": -gains["d"] * rate,
        "i": gains["i"] * np.cumsum(error) * np.median(np.diff(time)),
    }
    known = {name: column for name, column in parts.items() if gains[name]}
    # Where the goal jumps, a derivative of the error kicks for a moment; where the load is at its limit, it follows nothing.
    moves = np.abs(slope) * np.median(np.diff(time)) < 10.0 * angle
    inside = moves & (np.abs(load) < 0.9) & (np.abs(goal - position) > 2.0)
    table = np.column_stack([*known.values(), np.ones(len(time)), slope])[inside]
    solved = np.linalg.lstsq(table, load[inside], rcond=None)[0]
    found = {name: float(value) for name, value in zip(known, solved) if value > 0.0}
    if "p" not in found:
        raise Fault("the load does not follow the error of the position: the servo is not in its position loop, or hangs on a stop")
    return found


def tried(session: Session) -> tuple[Response, Rows]:
    """Two steps out and back on the servo."""
    size = 0.5 * STEP * session.travel
    goals = [-size, size, -size, size, -size]
    session.follow(lambda time: -size * min(time / 0.5, 1.0), 1.0)
    rows = session.follow(lambda time: goals[min(int(time / WINDOW), 3) + 1], 4 * WINDOW)
    session.follow(lambda time: -size * max(1.0 - time / 0.5, 0.0), 0.7)
    return response(rows[:, 0], rows[:, 2] - session.start, [goal + session.sag for goal in goals]), rows


def with_derivative(session: Session, model: Model) -> None:
    """Measures the scale of a derivative that was 0 in a motion with a little of it."""
    found = model.result.estimates
    rate = 0.3 * max(found["a"], 10.0) / found["b"] / model.voltage
    probed = session.gains | {"d": min(max(round(rate / model.maker.rate_scale), 1), model.maker.largest_gain)}
    before = dict(session.gains)
    session.set_gains(probed)
    measured = scales(model.maker, captured(session, plan()[16:]), probed)
    session.set_gains(before)
    if "d" in measured:
        model.scales["d"] = measured["d"]


def liveliness(before: Response, predicted: Response, after: Response) -> str:
    """How a servo moves too much, empty if it does not."""
    if after.ripple > max(5.0, 1.5 * before.ripple):
        return "the servo oscillates"
    return "the servo overshoots more than predicted" if after.overshoot > predicted.overshoot + 0.2 else ""


def rejection(goal: str, before: Response, predicted: Response, after: Response) -> str:
    """Why gains are not kept after their trial, empty if they are."""
    if reason := liveliness(before, predicted, after):
        return reason
    if after.settling_time > 1.6 * predicted.settling_time + 0.08:
        return "the servo settles later than predicted"
    own, other = ratios(goal, before, after)
    return "the servo is no better with them" if own > 0.95 or other > OTHER else ""


def ratios(goal: str, before: Response, after: Response) -> tuple[float, float]:
    """What a change of gains does to the goal and to the other quantity, as far as a trial resolves them."""
    settling = (after.settling_time + 5e-3) / (before.settling_time + 5e-3)
    error = (after.error + 0.5) / (before.error + 0.5)
    return (settling, error) if goal == "settling" else (error, settling)


def trial(session: Session, model: Model, goal: str, before: Response) -> tuple[Proposal, Response, Rows] | None:
    """The gains that the servo proves better, in its registers; otherwise the old ones are."""
    old, fastest, softest = dict(session.gains), np.inf, np.inf
    for _ in range(TRIALS):
        proposal = best(model, old, goal, fastest, softest)
        if proposal is None:
            break
        session.say(f"Trial of {shown(proposal.gains)}; predicted: {proposal.predicted}.")
        session.set_gains(proposal.gains)
        after, rows = tried(session)
        reason = rejection(goal, before, proposal.predicted, after)
        session.say(f"Measured: {after}." + (f" Rejected: {reason}." if reason else ""))
        if not reason:
            return proposal, after, rows
        session.set_gains(old)
        if liveliness(before, proposal.predicted, after):
            fastest = SLOWER * proposal.bandwidth
        else:
            # Friction holds it more than the model says.
            softest = SLOWER * proposal.predicted.error
    return None


def best(
    model: Model, gains: dict[str, int], goal: str, fastest: float = np.inf, softest: float = np.inf
) -> Proposal | None:
    """The proposal with the best predicted response up to a bandwidth, rad/s, and an error at rest, counts."""
    now = model.predicted(gains)
    of = {"settling": lambda one: one.settling_time, "load": lambda one: one.error}
    other = of["load" if goal == "settling" else "settling"]
    proposals = [
        one for one in model.proposals(gains)
        if one.bandwidth <= fastest and one.predicted.error <= softest and other(one.predicted) <= OTHER * other(now)
        and one.predicted.overshoot < max(MAX_OVERSHOOT, LESS * now.overshoot)
    ]
    return min(proposals, key=lambda one: of[goal](one.predicted), default=None)
