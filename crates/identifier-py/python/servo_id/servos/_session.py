"""A servo in the hand of a program: what it moves and writes, and how all of it comes back."""

import json
import os
import re
import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread, current_thread, main_thread
from time import monotonic
from types import TracebackType
from typing import Self
from zlib import crc32

import numpy as np
import numpy.typing as npt

from ._registers import GAINS, Fault, Lost, Maker, Reading, Refused, Servo, shown

Rows = npt.NDArray[np.float64]
"""Columns: time, s; the goal that acted and the position, counts; the load as a share of the supply."""


class Interrupted(Fault):
    """The user ended the motion."""


class Journal:
    """The file of the numbers that registers had and get: written before each change, removed after the last is back."""

    def __init__(self, file: Path, maker: Maker) -> None:
        self.file = file
        self.numbers: dict[str, list[int]] = {}
        """Of each register: as it was found, then as it was written."""
        try:
            if file.exists():
                crc, text = file.read_text().split(" ", 1)
                self.numbers = json.loads(text)
                numbers = [(name, number) for name, own in self.numbers.items() for number in (own[0], *own)]
                if int(crc) != crc32(text.encode()) or not all(type(one) is int and maker.allows(name, one) for name, one in numbers):
                    raise ValueError
        except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
            raise Refused(f"{file} is damaged: see to {', '.join(maker.changed)} of the servo yourself, and remove the file") from error

    @property
    def old(self) -> dict[str, int]:
        return {name: own[0] for name, own in self.numbers.items()}

    def save(self, numbers: dict[str, list[int]]) -> None:
        beside, text = self.file.with_suffix(".new"), json.dumps(numbers)
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            with beside.open("w") as file:
                file.write(f"{crc32(text.encode())} {text}")
                file.flush()
                os.fsync(file.fileno())
            beside.replace(self.file)
            # Windows opens no folder.
            if os.name == "posix":
                folder = os.open(self.file.parent, os.O_RDONLY)
                os.fsync(folder)
                os.close(folder)
        except OSError as error:
            raise (Fault if self.numbers else Refused)(f"{self.file} cannot be written: {error}: make room for it") from error
        self.numbers = numbers

    def remove(self) -> None:
        self.numbers = {}
        self.file.unlink(missing_ok=True)


class Session:
    """A motion within a travel about where the servo is. At its end, however it ends, the servo holds its position and every
    register is as it was found."""

    AHEAD = 0.03
    """The travel ends where the servo would be so much later, s."""
    HEALTH = 25
    """Readings from one look at all that is watched to the next."""
    LONGEST_SAG = 0.25
    """Part of the travel that load and friction may take the servo from its goal."""

    def __init__(
        self, servo: Servo, folder: Path, travel: float, *, yes: bool = False, stall: float = 0.1,
        say: Callable[[str], object] = print, ask: Callable[[str], str] = input,
    ) -> None:
        self.servo, self.travel, self.stall = servo, travel, stall
        self.yes, self._say, self._ask = yes, say, ask
        self.interrupted = self.is_moving = self.has_stalled = False
        self.pull = 0.0
        """Distance to the goal at rest times P, counts."""
        self.last: Reading | None = None
        self.say(servo.description())
        self.numbers = servo.known(*servo.maker.changed)
        """What registers must have: as found, or as written since."""
        own = folder / f"{servo.name}.json"
        for file in sorted(folder.glob(f"{servo.model}-{servo.identity}-*.json")):
            self.journal = Journal(file, servo.maker)
            self._restore_of_last_time(is_own=file == own)
        self.journal = Journal(own, servo.maker)
        self.start = servo.reading().position
        low, high = servo.read("lowest"), servo.read("highest")
        if not low <= self.start - 0.5 * travel <= self.start + 0.5 * travel <= high:
            raise Refused(
                f"the servo is at {self.start} of {low} to {high} counts: less than half a travel of {travel:.0f} is left to one side; "
                "move it by hand or state a smaller --travel"
            )

    def say(self, text: str) -> None:
        # Registers get their numbers back with a closed terminal too.
        with suppress(OSError, ValueError):
            self._say(text)

    def agrees(self, question: str, *, by_hand: bool = False) -> bool:
        """No answer, as of a closed terminal, is no."""
        if self.yes and not by_hand:
            return True
        try:
            return self._ask(f"{question} [y/N] ").strip().lower() in ("y", "yes")
        except (EOFError, OSError, ValueError, RuntimeError):
            return False

    def _restore_of_last_time(self, is_own: bool) -> None:
        """Of this servo, if each register has a number of the journal. Only those of RAM may have lost theirs with the power."""
        file, old, now = self.journal.file, self.journal.old, self.numbers
        if old.items() <= now.items() and not is_own:
            return
        unknown = {name: now[name] for name, own in self.journal.numbers.items() if now[name] not in own}
        if self.servo.maker.lock and unknown.keys() & GAINS:
            raise Refused(f"{file} does not have {shown(unknown)}: connect the servo that it is of, or remove it")
        doubt = f" It does not have {shown(unknown)}: the servo lost its power since, or is another one." if unknown else ""
        torque = " Torque was off then: support the arm." if "torque" in old else ""
        self.say(f"The last run did not end: {file} has what was found then: {shown(old)}.{doubt}{torque}")
        if not self.agrees("Write it back?", by_hand=bool(unknown)):
            raise Refused(f"write it back first, or remove {file} if this is another servo")
        self._restore()
        self.say("It is written back.")

    def __enter__(self) -> Self:
        self.handlers = {}
        if current_thread() is main_thread():
            for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGTSTP"):
                # The last two are not on every system.
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
        servo, settings = self.servo, self.servo.maker.settings
        self.numbers = servo.known(*servo.maker.changed)
        self.was_off = self.numbers["torque"] == 0
        # There are servos that a goal switches on: their torque is noted before the first.
        found = {name: number for name, number in self.numbers.items() if name != "torque" or self.was_off}
        given = {**found, "torque": 1, "lock": 0, **settings}
        self.journal.save({name: [number, given[name]] for name, number in found.items()})
        for name, number in settings.items():
            self.change(name, number)
        self.pull = 0.0 if self.was_off else self.gains["p"] * (servo.known("goal")["goal"] - self.start)
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

    @property
    def gains(self) -> dict[str, int]:
        return {name: self.numbers[name] for name in GAINS}

    def change(self, name: str, number: int) -> None:
        """Writes a register after the journal has its number."""
        if number not in self.journal.numbers[name]:
            self.journal.save(self.journal.numbers | {name: [*self.journal.numbers[name], number]})
        self.servo.change(name, number)
        self.numbers[name] = number

    def set_gains(self, gains: dict[str, int]) -> None:
        if self.servo.maker.lock:
            self.change("lock", 0)
        for name, number in gains.items():
            if number != self.numbers[name]:
                self.change(name, number)
        self.hold()

    def keep(self) -> None:
        """The gains that the servo has are those that come back, after a lost supply too."""
        self.servo.check(self.numbers)
        self.journal.save(self.journal.numbers | {name: [self.numbers[name], *self.journal.numbers[name]] for name in GAINS})

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
                servo.check(self.numbers)
            # An even clock, as fast as the bus is with a little to spare.
            used = clock.now() - begin - elapsed
            period = period or 1e-3 * np.ceil(1.25e3 * used)
            clock.sleep(period * np.ceil((elapsed + used) / period) - elapsed - used)
        # What a servo did that restarted is no result.
        servo.check(self.numbers)
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
            # Without a journal nothing was written.
            if self.journal.numbers:
                self.hold()
                self._restore(home=not isinstance(error, Lost) and not self.servo.error)
            if self.servo.wear:
                self.say(f"{self.servo.wear} writes of EEPROM.")
        except Fault as fault:
            raise Fault(f"{error or fault}. Not all is back: {self.journal.file} has it, and the next start writes it") from fault
        finally:
            for one, handler in self.handlers.items():
                signal.signal(one, handler)

    def _restore(self, home: bool = False) -> None:
        """Gives every register of the journal its old number, the last one first, so that torque goes last."""
        servo, old = self.servo, self.journal.old
        if "lock" in old:
            self.change("lock", 0)
        now = servo.known(*old)
        for name in [name for name in reversed(old) if name != "torque" and now[name] != old[name]]:
            self.change(name, old[name])
        # A protection may have switched torque off, which stays so.
        self.numbers = {name: number for name, number in (self.numbers | old).items() if name != "torque"}
        if home:
            self.hold()
        if "torque" in old:
            if home:
                self._go_home()
                if abs(self.sag) > 2.0 and not self.agrees("A load pulls the servo. Support it. Torque off?"):
                    self.say("No answer: the servo is where it was found, and its torque goes off as it was.")
            servo.change("torque", 0)
        servo.compare(self.numbers, servo.known(*self.numbers))
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
