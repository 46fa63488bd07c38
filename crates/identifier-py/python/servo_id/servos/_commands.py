"""``python -m servo_id capture`` and ``python -m servo_id tune-servo``."""

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import MAKERS, _capture, _tune
from ._registers import Fault, RealTime, Refused, Servo, shown
from ._session import Interrupted, Rows, Session, as_counts


VERBS = {"capture": "record a log of a smart servo", "tune-servo": "find gains of a smart servo and try them on it"}


def main(options: Namespace) -> int:
    """The exit status: 1 where a motion ended early, 2 where nothing was moved or written."""
    if options.port == "simulated":
        # Its pseudo-terminal is not on every system.
        from .simulated import SimulatedBus, SimulatedServo

        options.bus = SimulatedBus(SimulatedServo(MAKERS[options.drive], seed=options.seed, identity=options.id))
    try:
        return run(options)
    except KeyboardInterrupt:
        return 130
    except (ValueError, OSError, Fault) as error:
        with suppress(OSError, ValueError):
            print(f"error: {error}", file=sys.stderr)
        return 2 if isinstance(error, ValueError) else 130 if isinstance(error, Interrupted) else 1


def add_options(parser: ArgumentParser, verb: str) -> None:
    parser.add_argument("--drive", required=True, choices=sorted(MAKERS))
    parser.add_argument("--port", required=True, help="such as /dev/ttyUSB0; or simulated")
    parser.add_argument("--id", type=int, default=1)
    parser.add_argument("--baud", type=int, default=0, help="the maker's default without it")
    parser.add_argument("--travel", default="20deg", help="about where the servo is, from end to end: 20deg, 0.3rad, 200counts")
    parser.add_argument("--yes", action="store_true", help="do not ask before it moves and before torque goes off")
    parser.add_argument("--out", type=Path, required=verb == "capture", help="the log, CSV")
    parser.add_argument("--goal", choices=["settling", "load"], default="settling", help="what is to get better")
    parser.add_argument("--apply", action="store_true", help="try the gains on the servo")
    parser.add_argument("--keep", action="store_true", help="with --apply: keep gains of EEPROM after a good trial")
    parser.add_argument("--plot", type=Path, help="the step before and after, SVG")
    parser.add_argument("--seed", type=int, default=1, help="of the simulated servo")
    parser.set_defaults(bus=None, journals=Path.home() / ".servo-id", ask=input, stall=0.1)


def run(options: Namespace, say: Callable[[str], object] = print) -> int:
    """A capture or a tuning. A ``bus`` that is simulated is port and clock."""
    maker = MAKERS[options.drive]
    port, clock = (options.bus.port, options.bus) if options.bus else (options.port, RealTime)
    travel = as_counts(options.travel, maker.counts)
    servo = Servo(maker, port, options.id, options.baud, clock)
    try:
        stall = max(options.stall, 5.0) if options.bus else options.stall
        session = Session(servo, options.journals, travel, yes=options.yes, stall=stall, say=say, ask=options.ask)
        voltage = servo.voltage()
        _announce(session, options)
        with session:
            rows = _capture.captured(session, _capture.plan())
            if options.out:
                _capture.write(options.out, session, rows, voltage)
            if options.verb == "tune-servo":
                _tuned(session, options, rows, voltage)
    finally:
        servo.close()
    return 0


def _announce(session: Session, options: Namespace) -> None:
    maker = session.servo.maker
    session.say(f"{shown(session.gains)}. Travel: {options.travel} about where it is. Plan: {_capture.described()}.")
    if options.apply and maker.lock:
        session.say("Its gains are EEPROM: a trial writes each up to 8 times, and puts them back unless --keep is given.")
    if options.keep and not maker.lock:
        session.say("Its gains are RAM: they last until the power goes, with --keep too. Write them in your own program.")
    if not session.agrees("It moves now. Go on?"):
        raise Refused("nothing was moved or written")


def _tuned(session: Session, options: Namespace, rows: Rows, voltage: float) -> None:
    maker, say = session.servo.maker, session.say
    model = _tune.Model(maker, rows, session.gains, voltage, _tune.STEP * session.travel)
    b, error = model.result.estimates["b"], model.result.std_errors["b"]
    say(f"{model.result.verdict}: b = {b:.4g} ± {2 * error:.2g} rad/s² per V")
    if not options.apply:
        proposal = _tune.best(model, session.gains, options.goal)
        if proposal is None:
            say("No gains are better than these.")
            return
        say(f"Now {shown(session.gains)}; predicted: {model.predicted(session.gains)}.")
        say(f"New {shown(proposal.gains)}; predicted: {proposal.predicted}. Try them with --apply.")
        return
    before, old = _tune.tried(session)
    say(f"Now {shown(session.gains)}: {before}.")
    if "d" not in model.scales:
        _tune.with_derivative(session, model)
    found = _tune.trial(session, model, options.goal, before)
    if found is None:
        say("The old gains are back: none was better on the servo.")
        return
    proposal, _, new = found
    if options.plot:
        predicted = model.moved(proposal.gains)
        options.plot.write_text(_picture(session, {"before": old, "after": new}, predicted), encoding="utf-8")
    if options.keep or not maker.lock:
        session.keep()
        say(f"Kept: {shown(session.gains)}" + ("." if maker.lock else ", until the power goes."))
    else:
        say("The old gains are put back: --keep keeps the new ones.")


def _picture(session: Session, rows: dict[str, Rows], predicted: tuple[npt.NDArray[Any], npt.NDArray[Any], float]) -> str:
    """The first step of two trials and the predicted one, as SVG."""
    size = 0.5 * _tune.STEP * session.travel
    courses = {name: (own[:, 0], (own[:, 2] - session.start) / size) for name, own in rows.items()}
    courses["predicted"] = (predicted[0], predicted[1] / size - 1.0)
    parts = []
    for number, ((name, (time, position)), colour) in enumerate(zip(courses.items(), ("#888", "#06c", "#e70"))):
        inside = time < _tune.WINDOW
        across, up = 50 + 520 * time[inside] / _tune.WINDOW, 180 - 100 * position[inside]
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across, up))
        dashes = ' stroke-dasharray="6 4"' if name == "predicted" else ""
        parts.append(f'<polyline fill="none" stroke="{colour}" stroke-width="2"{dashes} points="{points}"/>')
        parts.append(f'<text x="480" y="{240 + 18 * number}" fill="{colour}">{name}</text>')
    labels = "".join(f'<text x="5" y="{185 - 100 * side}">{side * 360 * size / session.servo.maker.counts:.1f}°</text>' for side in (-1, 1))
    labels += f'<text x="45" y="320">0</text><text x="530" y="320">{_tune.WINDOW} s</text>'
    body = "".join(parts)
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 600 330" font-family="sans-serif" font-size="14">'
        f'<rect width="600" height="330" fill="#fff"/>{labels}{body}</svg>\n'
    )
