"""Simulated smart servos that are tuned, and faults in the midst of it.

    python smart_servos.py servos --drive feetech [--count 40] [--first 1] [--goal settling] >> servos.jsonl
    python smart_servos.py faults --drive feetech [--count 500] [--first 1] >> faults.jsonl
    python smart_servos.py page servos.jsonl faults.jsonl

The last one writes the table of docs/measurements.md. Every servo is drawn: plant, gravity, backlash, and the scales of its gains.
The makers' clients talk to it through a pseudo-terminal. A fault comes at a drawn instant, in a motion that is cut to a few seconds;
afterwards the bus is whole again and the program starts once more.
"""

import argparse
import fcntl
import json
import os
import signal
import tempfile
import termios
from argparse import Namespace
from collections.abc import Callable
from datetime import date
from pathlib import Path
from random import Random
from unittest import mock

import numpy as np
from servo_id.servos import MAKERS, Fault, Session, _capture, _commands, _tune
from servo_id.servos._registers import Servo
from servo_id.servos.simulated import Killed, SimulatedBus, SimulatedServo

BAUD = 1_000_000
TRAVEL = 20 * 4096 / 360
LINE = ("lost", "late", "later", "doubled", "damaged")
KINDS = (*LINE, "unplugged", "power lost", "brown-out", "low supply", "over-load", "over-temperature", "interrupted", "killed",
         "second program", "closed terminal", "full disk")
PAGE = Path(__file__).parents[3] / "docs/measurements.md"


def options_of(name: str, bus: SimulatedBus, folder: str, goal: str = "settling") -> Namespace:
    words = ["tune-servo", "--drive", name, "--port", "unused", "--yes", "--apply", "--keep", "--goal", goal, "--baud", str(BAUD)]
    options = _commands._options(words)
    options.bus, options.journals, options.stall = bus, Path(folder), 60.0
    return options


class Recorded:
    """Takes down what a run finds."""

    def __enter__(self) -> "Recorded":
        self.own, self.result = _tune.Model, None

        def modelled(*arguments: object) -> _tune.Model:
            found = self.own(*arguments)
            self.result = found.result
            return found

        _tune.Model = modelled
        return self

    def __exit__(self, *_: object) -> None:
        _tune.Model = self.own


def tried(bus: SimulatedBus, gains: dict[str, int]) -> _tune.Response:
    """A trial of its own, not the one that the gains were chosen by."""
    own = bus.servos[0]
    own.numbers |= gains
    servo = Servo(own.maker, bus.port, 1, BAUD, bus)
    with tempfile.TemporaryDirectory() as folder:
        session = Session(servo, Path(folder), TRAVEL, yes=True, stall=60.0, say=lambda _: None)
        with session:
            found = _tune.tried(session)[0]
    servo.close()
    return found


def servos(stated: Namespace) -> None:
    """Servos one by one: b in its interval, and steps before and after."""
    for seed in range(stated.first, stated.first + stated.count):
        own = SimulatedServo(MAKERS[stated.drive], seed=seed)
        bus = SimulatedBus(own, seed=seed, baud=BAUD)
        said = []
        old = {name: own.numbers[name] for name in "pid"}
        with tempfile.TemporaryDirectory() as folder, Recorded() as recorded:
            try:
                _commands.run(options_of(stated.drive, bus, folder, stated.goal), said.append)
            except Fault as fault:
                said.append(f"{fault}")
        row = {"drive": stated.drive, "seed": seed, "seconds": bus.time, "kept": any(line.startswith("Kept") for line in said)}
        if recorded.result:
            b, error = recorded.result.estimates["b"], recorded.result.std_errors["b"]
            row |= {"off": (b - own.truth["b"] / 12.0) / error, "width": 2.0 * error / b, "verdict": str(recorded.result.verdict)}
        if row["kept"]:
            new = {name: own.numbers[name] for name in "pid"}
            before, after = tried(bus, old), tried(bus, new)
            row |= {"settling": [before.settling_time, after.settling_time], "error": [before.error, after.error]}
            row["ratios"] = _tune.ratios(stated.goal, before, after)
        print(json.dumps(row | {"said": said[-3:]}), flush=True)
        bus.close()


class Known:
    """A model that costs no time."""

    def __init__(self, *_: object) -> None:
        self.scales = {"p": 1.0, "d": 1.0}
        self.result = Namespace(verdict="converged", estimates={"b": 1.0}, std_errors={"b": 1.0})

    @staticmethod
    def best(model: "Known", gains: dict[str, int], goal: str, fastest: float, softest: float) -> _tune.Proposal | None:
        more = gains | {"p": round(1.3 * gains["p"])}
        return _tune.Proposal(more, 1.0, _tune.Response(1.0, 1.0, 1.0, 1.0)) if min(fastest, softest) > 1.0 else None


class Machine(SimulatedBus):
    """The bus, with the supply, terminal, disk and other programs of its machine."""

    is_closed = is_full = False
    found: dict[str, int] = {}
    """Numbers that a program finds after a fault that came before it wrote any."""

    def _inject(self, fault: str) -> None:
        super()._inject(fault)
        own = self.servos[0]
        if fault == "low supply":
            own.numbers["voltage"] = 45
        elif fault == "second program":
            own.numbers["p"] += 7
        elif fault == "closed terminal":
            self.is_closed = True
            os.kill(os.getpid(), signal.SIGHUP)
        elif fault == "full disk":
            self.is_full = True
            file = next(self.folder.glob("*.json"), None)
            self.noted = json.loads(file.read_text().split(" ", 1)[1]) if file else {}
        if fault in ("power lost", "brown-out", "second program") and not any(self.folder.glob("*.json")):
            self.found = dict(own.numbers)

    def watched(self, start: int, data: bytes) -> None:
        """Takes down what is written without a journal."""
        for name in ("p", "i", "d", "torque", "acceleration", "speed") if self.is_full else ():
            place = self.servos[0].maker.registers[name]
            if place.address == start and place.number(int.from_bytes(data, "little")) not in self.noted.get(name, []):
                self.unnoted = True
        self.own_write(start, data)

    def answer(self, said: list[str], text: str) -> str:
        if self.is_closed:
            raise BrokenPipeError
        said.append(text)
        return "y"

    def fsync(self, file: int) -> None:
        if self.is_full:
            raise OSError(28, "No space left on device")


def hung_up(*_: object) -> None:
    """A terminal that closes while the servo is not in the program's hand ends the program."""
    raise Killed


def faults(stated: Namespace) -> None:
    """Faults at drawn instants, then a new start."""
    signal.signal(signal.SIGHUP, hung_up)
    whole = _capture.plan
    _capture.plan = lambda: [*whole()[16:18], *whole()[-6:]]
    # What is found does not matter here: P is a third more, and the servo says whether that is better.
    _tune.WINDOW = 0.3
    _tune.Model, _tune.best = Known, Known.best
    for number in range(stated.first, stated.first + stated.count):
        random = Random(f"{stated.drive} {number}")
        kind = KINDS[number % len(KINDS)]
        torque = random.randrange(2)
        own = SimulatedServo(MAKERS[stated.drive], seed=random.randrange(1, 10_000), torque=torque)
        if stated.drive == "dynamixel":
            # Gains of RAM that are not those as sold.
            own.numbers["p"] = 700
        old = {name: own.numbers[name] for name in ("p", "i", "d", "acceleration", "speed")}
        instant = random.uniform(1.0, 11.0)
        # Faults of the line come in bursts, up to what ends the run.
        burst = random.choice([1, 1, 2, 6]) if kind in LINE else 1
        bus = Machine(own, seed=number, baud=BAUD, faults=[(instant, kind)] * burst)
        bus.own_write, own.write, bus.unnoted = own.write, bus.watched, False
        own.extremes = [own.angle, own.angle]
        start, said, bad, ended, proven = own.angle, [], [], False, {}
        good = lambda: own.numbers["torque"] <= torque and all(own.numbers[name] in (old[name], proven.get(name)) for name in old)

        def kept(session: Session, keep: Callable[[Session], None] = Session.keep) -> None:
            keep(session)
            proven.update(session.gains)

        with (
            tempfile.TemporaryDirectory() as folder, mock.patch("os.fsync", bus.fsync), mock.patch.object(Session, "keep", kept),
            mock.patch("builtins.print", lambda *_: None),
        ):
            bus.folder = Path(folder)
            options = options_of(stated.drive, bus, folder)
            options.yes, options.ask = False, lambda text: bus.answer(said, text)
            try:
                _commands.run(options, lambda text: bus.answer(said, text))
            except (Fault, Killed, KeyboardInterrupt, ValueError, OSError) as fault:
                said.append(f"{fault!r}")
                ended = True
            reached = len(bus.faults) < burst
            is_back = not any(Path(folder).glob("*.json"))
            old |= {name: bus.found.get(name, number) for name, number in old.items()}
            if not ended and not (good() and is_back):
                bad.append("status")
            if bus.unnoted:
                bad.append("written without a journal")
            # All is said to be back, before the power is switched off and on.
            at_end = {name: own.numbers[name] for name in old}
            bus.restart()
            own.numbers |= {"voltage": 120} | (at_end if is_back else {})
            bus.is_full = bus.is_closed = False
            # The bus keeps its pseudo-terminal open, which would stay exclusive.
            fcntl.ioctl(bus.other, termios.TIOCNXCL)
            servo = Servo(MAKERS[stated.drive], bus.port, 1, BAUD, bus)
            refused = False
            try:
                Session(servo, Path(folder), TRAVEL, yes=True, say=said.append, ask=lambda text: bus.answer(said, text))
            except ValueError as fault:
                said.append(f"{fault!r}")
                refused = True
            servo.close()
            # What another program wrote last is no number of the journal: it is refused.
            if refused and kind != "second program":
                bad.append("refused")
            if not refused and any(Path(folder).glob("*.json")):
                bad.append("journal")
        if not good() and not (ended and kind == "second program"):
            bad.append("gains or torque")
        reach = max(own.extremes[1] - start, start - own.extremes[0])
        if reach > 1.02 * np.radians(10.0) + 2 * np.pi / 4096:
            bad.append("travel")
        row = {"drive": stated.drive, "fault": number, "kind": kind, "at": instant, "burst": burst, "reached": reached, "ended": ended,
               "refused": refused, "proven": bool(proven)}
        print(json.dumps(row | {"bad": bad, "reach": reach} | ({"said": said[-4:]} if bad else {})), flush=True)
        bus.close()


def page(stated: Namespace) -> None:
    """Writes the table of the page."""
    rows = [json.loads(line) for file in stated.files for line in file.read_text().splitlines()]
    columns = []
    for drive in ("feetech", "dynamixel"):
        own = [row for row in rows if row["drive"] == drive and "seed" in row]
        struck = [row for row in rows if row["drive"] == drive and "fault" in row]
        kept = [row for row in own if row["kept"]]
        medians = lambda name, scale: ", ".join(f"{scale * np.median([row[name][part] for row in kept]):.3g}" for part in (0, 1))
        columns.append({
            "servos, from the seed": f"{len(own)}, {own[0]['seed']}",
            "b within its interval of 95 %": sum(abs(row.get("off", np.inf)) <= 2.0 for row in own),
            "half that interval, part of b, median": f"{100 * np.median([row['width'] for row in own if 'width' in row]):.2g} %",
            "new gains kept": len(kept),
            "better by 5 % or more in a second trial": sum(row["ratios"][0] <= 0.95 for row in kept),
            "worse in it": sum(row["ratios"][0] > 1.0 for row in kept),
            "the other quantity worse by more than 10 % in it": sum(row["ratios"][1] > 1.1 for row in kept),
            "settling time before and after, median": medians("settling", 1e3) + " ms",
            "distance from the goal at rest, before and after, median": medians("error", 1.0) + " counts",
            "whole run, with trials, at most": f"{max(row['seconds'] for row in own):.0f} s",
            "faults": len(struck),
            "of them before the run was over; ended the run": f"{sum(r['reached'] for r in struck)}; {sum(r['ended'] for r in struck)}",
            "neither old nor proven gains, a journal left, torque left on, or the travel left": sum(bool(row["bad"]) for row in struck),
        })
    table = [f"| {date.today()} | Feetech | Dynamixel |", "|---|---|---|"]
    table += [f"| {name} | {feetech} | {columns[1][name]} |" for name, feetech in columns[0].items()]
    text = PAGE.read_text().split("\n")
    title = text.index("## Smart servos")
    inside = [number for number in range(title, len(text)) if text[number].startswith("| ")]
    begin = inside[0]
    end = next(number for number in range(begin, len(text)) if not text[number].startswith("|"))
    PAGE.write_text("\n".join([*text[:begin], *table, *text[end:]]))
    print("\n".join(table))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=["servos", "faults", "page"])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--drive", default="feetech", choices=sorted(MAKERS))
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--goal", default="settling", choices=["settling", "load"])
    stated = parser.parse_args()
    {"servos": servos, "faults": faults, "page": page}[stated.part](stated)


if __name__ == "__main__":
    main()
