"""Simulated smart servos that are tuned, and faults in the midst of it.

    python smart_servos.py servos [--drive feetech] [--servos 40] [--first 1] [--goal settling]
    python smart_servos.py faults [--drive feetech] [--faults 500] [--first 1]

docs/measurements.md has the results. Every servo is drawn: plant, gravity, backlash, and the scales of its gains. The makers' clients talk
to it through a pseudo-terminal. A fault comes at a drawn instant, in a motion that is cut to a few seconds; afterwards the bus is
whole again and the program starts once more.
"""

import argparse
import tempfile
from argparse import Namespace
from pathlib import Path
from random import Random

import numpy as np
from servo_id.servos import MAKERS, Fault, Session, _capture, _commands, _tune
from servo_id.servos._registers import Servo
from servo_id.servos.simulated import Killed, SimulatedBus, SimulatedServo

BAUD = 1_000_000
KINDS = (
    "lost", "late", "doubled", "damaged", "unplugged", "power lost", "over-load", "over-temperature", "interrupted", "killed",
)


def options_of(name: str, bus: SimulatedBus, folder: str, goal: str = "settling") -> Namespace:
    words = ["tune-servo", "--drive", name, "--port", "unused", "--yes", "--apply", "--keep", "--goal", goal, "--baud", str(BAUD)]
    options = _commands._options(words)
    options.bus, options.journal, options.stall = bus, Path(folder) / "journal.json", 60.0
    return options


class Recorded:
    """Takes down what a run finds and measures."""

    def __init__(self) -> None:
        self.responses: list[_tune.Response] = []
        self.result = None
        self.own = _tune.tried, _tune.Model

    def __enter__(self) -> None:
        tried, model = self.own

        def measured(session: Session) -> tuple:
            found = tried(session)
            self.responses.append(found[0])
            return found

        def modelled(*arguments: object) -> _tune.Model:
            found = model(*arguments)
            self.result = found.result
            return found

        _tune.tried, _tune.Model = measured, modelled

    def __exit__(self, *_: object) -> None:
        _tune.tried, _tune.Model = self.own


def servos(stated: Namespace) -> None:
    """Servos one by one: b in its interval, and the step before and after."""
    inside, better, worse, ratios = 0, 0, 0, []
    for seed in range(stated.first, stated.first + stated.servos):
        own = SimulatedServo(MAKERS[stated.drive], seed=seed)
        bus = SimulatedBus(own, seed=seed, baud=BAUD)
        said = []
        recorded = Recorded()
        with tempfile.TemporaryDirectory() as folder, recorded:
            try:
                _commands.run(options_of(stated.drive, bus, folder, stated.goal), said.append)
            except Fault as fault:
                said.append(f"{fault}")
        responses, result = recorded.responses, recorded.result
        truth = own.truth["b"] / 12.0
        off = (result.estimates["b"] - truth) / result.std_errors["b"] if result else np.nan
        inside += abs(off) <= 2.0
        row = f"{stated.drive} {seed}: b off by {off:.1f} standard errors ({result.verdict if result else '-'})"
        if responses:
            before = responses[0]
            proven = any(line.startswith("Kept") for line in said)
            after = responses[-1] if proven else before
            settling, error = after.settling_time / before.settling_time, (after.error + 0.5) / (before.error + 0.5)
            own_ratio, other = (settling, error) if stated.goal == "settling" else (error, settling)
            better += proven
            worse += own_ratio > 1.0 or other > 1.15
            ratios.append(own_ratio)
            row += f"; settling {before.settling_time:.3f} to {after.settling_time:.3f} s, error {before.error:.1f} to {after.error:.1f} counts"
        print(row + f"; {bus.time:.0f} s; {said[-2:]}", flush=True)
        bus.close()
    total = stated.servos
    print(f"{stated.drive}: b in its interval {inside} of {total}, better {better}, worse {worse}, median ratio {np.median(ratios):.2f}")


class Known:
    """A model that costs no time."""

    def __init__(self, *_: object) -> None:
        self.scales = {"p": 1.0, "d": 1.0}
        self.result = Namespace(verdict="converged", estimates={"b": 1.0}, std_errors={"b": 1.0})

    @staticmethod
    def best(model: "Known", gains: dict[str, int], goal: str, most: float) -> _tune.Proposal | None:
        more = gains | {"p": round(1.3 * gains["p"])}
        return _tune.Proposal(more, 1.0, _tune.Response(1.0, 1.0, 1.0, 1.0)) if most > 1.0 else None


def faults(stated: Namespace) -> None:
    """Faults at drawn instants, then a new start."""
    whole = _capture.plan
    _capture.plan = lambda: [*whole()[16:20], *whole()[-10:]]
    # What is found does not matter here: P is a third more, and the servo says whether that is better.
    _tune.WINDOW = 0.3
    _tune.Model, _tune.best = Known, Known.best
    wrong = {"gains": 0, "torque": 0, "travel": 0, "journal": 0}
    ends = {kind: [0, 0] for kind in KINDS}
    idle = 0
    for number in range(stated.first, stated.first + stated.faults):
        random = Random(f"{stated.drive} {number}")
        kind = KINDS[number % len(KINDS)]
        torque = random.randrange(2)
        own = SimulatedServo(MAKERS[stated.drive], seed=random.randrange(1, 200), torque=torque)
        if stated.drive == "dynamixel":
            own.numbers["p"] = 700
        old = {name: own.numbers[name] for name in ("p", "i", "d", "acceleration", "speed")}
        instant = random.uniform(1.0, 12.0)
        # Faults of the line come in bursts, up to what ends the run.
        burst = random.choice([1, 1, 2, 6]) if kind in KINDS[:4] else 1
        bus = SimulatedBus(own, seed=number, baud=BAUD, faults=[(instant, kind)] * burst)
        own.extremes = [own.angle, own.angle]
        start, said = own.angle, []
        with tempfile.TemporaryDirectory() as folder:
            options = options_of(stated.drive, bus, folder)
            try:
                _commands.run(options, said.append)
                ends[kind][0] += 1
            except (Fault, Killed, KeyboardInterrupt, ValueError) as fault:
                said.append(str(fault) or "killed")
                ends[kind][1] += 1
            idle += len(bus.faults) == burst
            if not options.journal.exists():
                # All is said to be back, before the power is switched off and on.
                at_end = dict(own.numbers)
            bus.restart()
            own.numbers |= {} if options.journal.exists() else {name: at_end[name] for name in old}
            servo = Servo(MAKERS[stated.drive], bus.port, 1, BAUD, bus)
            Session(servo, options.journal, 200.0, yes=True, say=said.append)
            servo.close()
            bad = ["journal"] if options.journal.exists() else []
        proven = any(line.startswith("Kept") for line in said)
        if any(own.numbers[name] != old[name] for name in old) and not proven:
            bad.append("gains")
        if own.numbers["torque"] and not torque:
            bad.append("torque")
        reach = max(own.extremes[1] - start, start - own.extremes[0])
        if reach > 1.02 * np.radians(10.0) + 2 * np.pi / 4096:
            bad.append("travel")
        for name in bad:
            wrong[name] += 1
        if bad:
            print(f"{stated.drive} {number} {kind} at {instant:.1f} s: {bad}, {reach:.3f} rad, {said[-3:]}", flush=True)
        bus.close()
        if (count := number - stated.first + 1) % 10 == 0:
            print(f"{stated.drive}: {count} faults; wrong: {wrong}; after the end: {idle}; went on, ended by kind: {ends}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=["servos", "faults"])
    parser.add_argument("--drive", default="feetech", choices=sorted(MAKERS))
    parser.add_argument("--servos", type=int, default=40)
    parser.add_argument("--faults", type=int, default=500)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--goal", default="settling", choices=["settling", "load"])
    stated = parser.parse_args()
    {"servos": servos, "faults": faults}[stated.part](stated)


if __name__ == "__main__":
    main()
