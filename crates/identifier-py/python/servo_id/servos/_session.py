"""A servo in the hand of a program: what it moves and writes, and how all of it comes back."""

import json
import os
import re
import signal
from collections.abc import Callable
from pathlib import Path
from threading import Event, Thread, current_thread, main_thread
from time import monotonic
from types import TracebackType
from typing import Self

import numpy as np
import numpy.typing as npt

from ._registers import Fault, Lost, Reading, Refused, Servo

Rows = npt.NDArray[np.float64]
"""Columns: time, s; the goal that acted and the position, counts; the load as a share of the supply."""


class Interrupted(Fault):
    """The user ended the motion."""


class Journal:
    """The file of old numbers of registers: written before the first of them changes, removed after the last is back."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.old: dict[str, int] = json.loads(file.read_text()) if file.exists() else {}

    def note(self, name: str, number: int) -> None:
        if name not in self.old:
            self.old[name] = number
            self._save()

    def forget(self, *names: str) -> None:
        self.old = {name: number for name, number in self.old.items() if name not in names}
        self._save()

    def _save(self) -> None:
        self.file.parent.mkdir(parents=True, exist_ok=True)
        beside = self.file.with_suffix(".new")
        with beside.open("w") as file:
            json.dump(self.old, file)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(self.file)

    def remove(self) -> None:
        self.old = {}
        self.file.unlink(missing_ok=True)


class Session:
    """A motion within a travel about where the servo is. At its end, however it ends, the servo holds its position and every
    register is as it was found."""

    AHEAD = 0.03
    """The travel ends where the servo would be so much later, s."""
    HEALTH = 25
    """Readings from one look at torque and temperature to the next."""
    LONGEST_SAG = 0.25
    """Part of the travel that load and friction may take the servo from its goal."""

    def __init__(
        self, servo: Servo, folder: Path, travel: float, *, yes: bool = False, stall: float = 0.1,
        say: Callable[[str], object] = print, ask: Callable[[str], str] = input,
    ) -> None:
        self.servo, self.travel, self.stall = servo, travel, stall
        self.say, self.yes, self._ask = say, yes, ask
        self.interrupted = self.is_moving = self.has_stalled = False
        self.pull = 0.0
        """Distance to the goal at rest times P, counts."""
        self.last: Reading | None = None
        say(servo.description())
        self.journal = Journal(folder / f"{servo.name}.json")
        if self.journal.old:
            self._restore_of_last_time()
        self.gains = servo.gains()
        self.start = servo.reading().position
        low, high = servo.read("lowest"), servo.read("highest")
        if not low <= self.start - 0.5 * travel <= self.start + 0.5 * travel <= high:
            raise Refused(
                f"the servo is at {self.start} of {low} to {high} counts: less than half a travel of {travel:.0f} is left to one side; "
                "move it by hand or state a smaller --travel"
            )

    def agrees(self, question: str) -> bool:
        if self.yes:
            return True
        try:
            return self._ask(f"{question} [y/N] ").strip().lower() in ("y", "yes")
        except EOFError:
            return False

    def _restore_of_last_time(self) -> None:
        old = ", ".join(f"{name} {number}" for name, number in self.journal.old.items())
        self.say(f"The last run did not end: {self.journal.file} has what was found then: {old}.")
        if "torque" in self.journal.old:
            self.say("Torque was off then: support the arm.")
        if not self.agrees("Write it back?"):
            raise Refused(f"write it back first, or remove {self.journal.file} if this is another servo")
        self._restore()
        self.say("It is written back.")

    def __enter__(self) -> Self:
        self.handlers = {}
        if current_thread() is main_thread():
            for name in ("SIGINT", "SIGTERM", "SIGHUP"):
                # The last is not on every system.
                if one := getattr(signal, name, None):
                    self.handlers[one] = signal.signal(one, lambda *_: setattr(self, "interrupted", True))
        self.ended = Event()
        Thread(target=self._watch, daemon=True).start()
        try:
            self._take()
        except BaseException as error:
            self.__exit__(type(error), error, None)
            raise
        return self

    def _take(self) -> None:
        """Holds the servo where it is, with goals that act at once."""
        servo = self.servo
        self.was_off = servo.read("torque") == 0
        if self.was_off:
            # There are servos that a goal switches on.
            self.journal.note("torque", 0)
        if not servo.maker.lock:
            # Gains of RAM go with the power.
            for name, number in self.gains.items():
                self.journal.note(name, number)
        for name in ("acceleration", "speed"):
            # None: a goal acts at once.
            self.change(name, 0)
        self.pull = 0.0 if self.was_off else self.gains["p"] * (servo.read("goal") - self.start)
        if abs(self.sag) > self.LONGEST_SAG * self.travel:
            raise Fault(f"the servo is {self.sag:.0f} counts from its goal: free it, or state a larger --travel")
        if self.was_off:
            servo.change("goal", self.start)
            self.change("torque", 1)
        for _ in range(3):
            rest = self.follow(lambda _: 0.0, 0.3)[-10:]
            most = self.LONGEST_SAG * self.travel * max(self.gains["p"], 1)
            pull = self.pull + self.gains["p"] * (self.start - rest[:, 2].mean())
            self.pull = max(min(pull, most), -most)

    @property
    def sag(self) -> float:
        """What a goal has to be beyond the position at rest, counts."""
        return self.pull / max(self.gains["p"], 1)

    def change(self, name: str, number: int) -> None:
        """Writes a register after its old number is in the journal."""
        self.journal.note(name, self.servo.read(name))
        self.servo.change(name, number)

    def set_gains(self, gains: dict[str, int]) -> None:
        if self.servo.maker.lock:
            self.change("lock", 0)
        for name, number in gains.items():
            if number != self.gains[name]:
                self.change(name, number)
                self.gains[name] = number
        self.hold()

    def follow(self, course: Callable[[float], float], seconds: float) -> Rows:
        """Sends goals, counts from the start, at the rate of the bus, and reads what the servo does."""
        self.servo.called, self.is_moving = monotonic(), True
        try:
            return self._followed(course, seconds)
        finally:
            self.is_moving = False

    def _followed(self, course: Callable[[float], float], seconds: float) -> Rows:
        clock, servo = self.servo.clock, self.servo
        rows: list[tuple[float, float, float, float]] = []
        acting = self.start + course(0.0) + self.sag
        servo.goal(acting)
        begin = clock.now()
        period = 0.0
        while (elapsed := clock.now() - begin) < seconds:
            reading = self._watched()
            rows.append((reading.time - begin, round(acting), reading.position, reading.load))
            acting = self.start + course(elapsed) + self.sag
            servo.goal(acting)
            if len(rows) % self.HEALTH == 0:
                self._check_health()
            # An even clock, as fast as the bus is with a little to spare.
            used = clock.now() - begin - elapsed
            period = period or 1e-3 * np.ceil(1.25e3 * used)
            clock.sleep(period * np.ceil((elapsed + used) / period) - elapsed - used)
        return np.array(rows)

    def _watched(self) -> Reading:
        reading = self.servo.reading()
        if self.interrupted:
            raise Interrupted("interrupted")
        if self.has_stalled:
            raise Fault(f"the program stood still for {self.stall} s and the servo was held: close other programs")
        if self.servo.error:
            raise Fault(f"the servo reports {self.servo.error}")
        before, self.last = self.last, reading
        later = float(reading.position)
        if before is not None and 0.0 < reading.time - before.time < 0.1:
            later += self.AHEAD * (reading.position - before.position) / (reading.time - before.time)
        if max(abs(later - self.start), abs(reading.position - self.start)) > 0.5 * self.travel:
            raise Fault("the servo is about to leave its travel")
        return reading

    def _check_health(self) -> None:
        servo = self.servo
        if servo.read("torque") == 0:
            raise Fault("the torque went off: power was lost, or a protection acted")
        if (heat := servo.read("temperature")) >= servo.read("highest_temperature"):
            raise Fault(f"the servo has {heat} °C: let it cool")

    def hold(self) -> None:
        """Stops where the servo is."""
        self.servo.goal(self.servo.reading().position + self.sag)

    def _watch(self) -> None:
        while not self.ended.wait(0.25 * self.stall):
            with self.servo.lock:
                if self.is_moving and monotonic() - self.servo.called > self.stall:
                    self.has_stalled = True
                    try:
                        self.hold()
                    except Fault:
                        self.ended.set()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.ended.set()
        try:
            self.hold()
            self._restore(home=not isinstance(error, Lost) and not self.servo.error)
            if self.servo.wear:
                self.say(f"{self.servo.wear} writes of EEPROM.")
        except Fault as fault:
            self.say(f"{fault}. Not all is back: {self.journal.file} keeps it, and the next start writes it.")
        finally:
            for one, handler in self.handlers.items():
                signal.signal(one, handler)

    def _restore(self, home: bool = False) -> None:
        """Writes every register of the journal back, the last one first, so that torque goes last."""
        servo, old = self.servo, self.journal.old
        if "lock" in old:
            servo.change("lock", 0)
        for name in [name for name in reversed(old) if name != "torque"]:
            servo.change(name, old[name])
        if home:
            self.gains |= {name: old[name] for name in self.gains if name in old}
            self.hold()
        if "torque" in old:
            if home:
                self._go_home()
                if abs(self.sag) > 2.0 and not self.agrees("A load pulls the servo. Support it. Torque off?"):
                    self.say("No answer: the servo is where it was found, and its torque goes off as it was.")
            servo.change("torque", old["torque"])
        self.journal.remove()

    def _go_home(self) -> None:
        """Slowly to where torque was off."""
        clock, servo = self.servo.clock, self.servo
        away = servo.reading().position - self.start
        begin = clock.now()
        while (part := (clock.now() - begin) / 1.5) < 1.0:
            servo.goal(self.start + away * (1.0 - part) + self.sag)
            clock.sleep(0.02)


def as_counts(travel: str, counts: int) -> float:
    """A travel such as 20deg, 0.3rad or 200counts."""
    units = {"deg": counts / 360.0, "rad": counts / (2.0 * np.pi), "counts": 1.0}
    if found := re.fullmatch(r"(\d*\.?\d+)(deg|rad|counts)", travel):
        return float(found[1]) * units[found[2]]
    raise Refused(f"--travel {travel}: state a number with its unit, such as 20deg, 0.3rad or 200counts")
