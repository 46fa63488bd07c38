"""A servo whose state is registers, behind its maker's client."""

import importlib
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from threading import RLock
from time import monotonic, sleep
from typing import Any, NamedTuple

GAINS = ("p", "i", "d")


class Refused(ValueError):
    """What a servo or a request does not allow, with the remedy. Nothing was written."""


class Fault(RuntimeError):
    """What ended a motion."""


class Lost(Fault):
    """No answer."""


def shown(numbers: Mapping[str, int]) -> str:
    """Numbers of registers in the order of the maker's manual."""
    return ", ".join(f"{name.upper()} {number}" for name, number in numbers.items())


class Register(NamedTuple):
    """Where a number is stored."""

    address: int
    size: int = 1
    sign: int = 0
    """The bit of the sign beside a magnitude; −1 for two's complement, 0 for a number without a sign."""

    def number(self, stored: int) -> int:
        if self.sign > 0:
            magnitude = stored & ((1 << self.sign) - 1)
            return -magnitude if stored >> self.sign & 1 else magnitude
        return stored - (1 << 8 * self.size) if self.sign and stored >> (8 * self.size - 1) else stored

    def stored(self, number: int) -> int:
        if self.sign > 0:
            return abs(number) | (number < 0) << self.sign
        return number % (1 << 8 * self.size)


@dataclass(frozen=True)
class Maker:
    """What is known of a maker's servos. The names of its registers are those of every maker: model, firmware, mode, torque, p, i,
    d, goal, position, load, voltage, temperature, the lowest and highest of them, and acceleration and speed of the way to a goal."""

    name: str
    models: Mapping[int, str]
    registers: Mapping[str, Register]
    client: str
    """The module of the maker's client."""
    calls: Callable[[Any, Any], Callable[..., Any]]
    """The client's calls by name, from its module and its open port."""
    fault: Callable[[int], str]
    """What the error of an answer means, empty for none."""
    baud: int
    modes: tuple[int, ...]
    """Modes of operation that hold a position."""
    polled: tuple[str, str]
    """The first and the last register of a block that holds position and load."""
    watched: tuple[str, str]
    """The first and the last register of a block that holds all that the program changes, the mode, voltage and temperature."""
    settings: Mapping[str, int]
    """With which a goal acts at once, and by which a servo that restarts in a motion is known."""
    full_load: float
    """The load at all of the supply."""
    rate_scale: float
    """Share of the supply for a D of 1 at 1 rad/s, about: a first one is chosen by it."""
    largest_gain: int
    volt: float = 10.0
    """Of the present voltage and of its limits."""
    lock: bool = False
    """True for gains that are kept without power, behind a lock."""
    counts: int = 4096
    """Of a revolution."""

    @property
    def changed(self) -> tuple[str, ...]:
        """The registers that the program changes, in the order in which it does."""
        return ("torque", *self.settings, *(("lock",) if self.lock else ()), *GAINS)

    def allows(self, name: str, number: int) -> bool:
        """True for a number that a register, which the program changes, can have."""
        register, most = self.registers[name], self.largest_gain
        return name in self.changed and register.number(register.stored(number)) == number and (name not in GAINS or 0 <= number <= most)


class Reading(NamedTuple):
    time: float
    """Half way between question and answer, s."""
    position: int
    """Counts."""
    load: float
    """Share of the supply that drives the motor."""


class RealTime:
    """The clock of the machine."""

    now = staticmethod(monotonic)
    sleep = staticmethod(sleep)


@dataclass
class Servo:
    """One servo, and the only owner of its port: a second one damages the answers of a half-duplex bus. Every call ends
    within the deadlines of the maker's client."""

    maker: Maker
    port: str
    identity: int = 1
    baud: int = 0
    clock: Any = RealTime
    called: float = 0.0
    """When it was last called, of the machine's clock."""
    error: str = ""
    """What its last answer complained of."""
    has_written: bool = False
    wear: int = 0
    """Writes of gains that are kept without power: such memory wears."""
    lock: Any = field(default_factory=RLock)

    TRIES = 4
    QUIET = 0.1
    """Time in which a late answer comes, s: it must not be taken for the next one."""

    def __post_init__(self) -> None:
        maker, baud = self.maker, self.baud or self.maker.baud
        try:
            sdk = importlib.import_module(maker.client)
            self.client = sdk.PortHandler(self.port)
            if not self.client.setBaudRate(baud):
                raise Refused(f"{baud} baud is not a rate of this servo: state another --baud")
            self.calls = maker.calls(sdk, self.client)
            self.client.ser.exclusive = True
            # The lock stops only programs that lock; Windows opens a port once.
            with suppress(ImportError):
                from fcntl import ioctl
                from termios import TIOCEXCL

                ioctl(self.client.ser, TIOCEXCL)
            # Both makers' clients poll without a pause: a read that waits leaves the processor to others.
            self.client.ser.timeout = 0.01
        except ImportError as error:
            raise Refused(f"the maker's client is not there: pip install 'servo-id[{maker.name}]'") from error
        except OSError as error:
            if self.client.is_open:
                self.close()
            raise Refused(f"{self.port} cannot be opened: {error}; end the other program that has it, or state another --port") from error

    def close(self) -> None:
        self.client.closePort()

    def _called(self, name: str, *arguments: Any, length: int = 0) -> list[int]:
        with self.lock:
            for _ in range(self.TRIES):
                try:
                    *data, result, error = self.calls(name, self.identity, *arguments)
                except (OSError, IndexError, TypeError):
                    # The port is gone, or the client did not expect this answer.
                    result = -1
                finally:
                    self.client.is_using = False
                    self.called = monotonic()
                if result == 0 and len(data[0] if data else []) == length:
                    self.error = self.maker.fault(error)
                    return data[0] if data else []
                self.clock.sleep(self.QUIET)
                self._discard()
                self.called = monotonic()
            raise (Lost if self.has_written else Refused)(
                f"servo {self.identity} on {self.port} gives no valid answer: check cable, power, --id and --baud, and that no other "
                "servo has this id"
            )

    def _discard(self) -> int:
        """Discards bytes that nobody waits for, and counts them."""
        try:
            count = self.client.getBytesAvailable()
            self.client.clearPort()
        except OSError:
            return 0
        return count

    def read(self, name: str) -> int:
        return self._block(name, name)[name]

    def _block(self, first: str, last: str) -> dict[str, int]:
        """The numbers of neighbouring registers."""
        registers = self.maker.registers
        start, end = registers[first].address, registers[last].address + registers[last].size
        data = self._called("readTxRx", start, end - start, length=end - start)
        inside = {name: one for name, one in registers.items() if start <= one.address < end}
        part = lambda one: bytes(data[one.address - start :][: one.size])
        return {name: one.number(int.from_bytes(part(one), "little")) for name, one in inside.items()}

    def write(self, name: str, number: int) -> None:
        register = self.maker.registers[name]
        data = register.stored(number).to_bytes(register.size, "little")
        self.has_written = True
        self._called("writeTxRx", register.address, register.size, list(data))

    def change(self, name: str, number: int) -> None:
        """Writes until two answers confirm it."""
        for _ in range(self.TRIES):
            self.write(name, number)
            self.wear += self.maker.lock and name in GAINS
            if self.known(name)[name] == number:
                return
        raise Fault(f"register {name} does not take {number}: {self.error or 'it stays as it was'}")

    def reading(self) -> Reading:
        before = self.clock.now()
        block = self._block(*self.maker.polled)
        time = 0.5 * (before + self.clock.now())
        return Reading(time, block["position"], block["load"] / self.maker.full_load)

    def goal(self, position: float) -> None:
        self.write("goal", round(position))

    def known(self, *names: str) -> dict[str, int]:
        """Numbers that are relied on. A late answer is taken for the next of its length: each is read twice, with one of another
        length between."""
        for _ in range(self.TRIES):
            first, _, second = self._block(*self.maker.watched), self.reading(), self._block(*self.maker.watched)
            now = {name: second[name] for name in names if first[name] == second[name]}
            if len(now) == len(names):
                return now
        raise Fault(f"the registers {', '.join(names)} change from one answer to the next: end the other program that writes them")

    def voltage(self) -> float:
        return self.read("voltage") / self.maker.volt

    def _has_a_double(self) -> bool:
        """True if more is answered than was asked for, or something else than before."""
        self.clock.sleep(self.QUIET)
        model, mode = self.read("model"), self.read("mode")
        return self._discard() > 0 or (self.read("model"), self.read("mode")) != (model, mode)

    def description(self) -> str:
        """Model and firmware. Refuses a servo that is not known, or that cannot be moved by goals."""
        of = self.read
        # An answer may come late once.
        if all(self._has_a_double() for _ in range(2)):
            raise Refused(f"more than one servo answers to id {self.identity}: give each its own id")
        model = of("model")
        self.model = self.maker.models.get(model, "")
        if not self.model:
            known = ", ".join(self.maker.models.values())
            raise Refused(f"model {model} is not known: --drive {self.maker.name} is for {known}")
        self.check({}, Refused)
        return f"{self.model}, firmware {of('firmware')}, id {self.identity}, {self.voltage():.1f} V, {of('temperature')} °C"

    def check(self, numbers: Mapping[str, int], kind: type[Exception] = Fault) -> None:
        """What a servo that is moved must be, at the start and in a motion, and the numbers that registers must have."""
        now = self._block(*self.maker.watched)
        present, low, high = (now[name] / self.maker.volt for name in ("voltage", "lowest_voltage", "highest_voltage"))
        if now["mode"] not in self.maker.modes:
            raise kind(f"the servo is in mode {now['mode']}, which follows no position: set its mode of operation to {self.maker.modes[0]}")
        if not low <= present <= high:
            raise kind(f"the supply is {present:.1f} V: connect one of {low:.1f} to {high:.1f} V")
        if now["temperature"] >= now["highest_temperature"]:
            raise kind(f"the servo has {now['temperature']} °C: let it cool")
        if self.error:
            raise kind(f"the servo reports {self.error}: remove the cause and switch its power off and on")
        self.compare(numbers, now)

    @staticmethod
    def compare(numbers: Mapping[str, int], now: Mapping[str, int]) -> None:
        if other := {name: now[name] for name, number in numbers.items() if now[name] != number}:
            raise Fault(f"the servo has {shown(other)}, which was not written: check its supply and load, and end other programs")

    @property
    def name(self) -> str:
        """Which servo it is, whatever the system calls its port: neither maker's servos have a serial number, adapters may."""
        from serial.tools import list_ports

        serials = {os.path.realpath(one.device): one.serial_number for one in list_ports.comports()}
        return f"{self.model}-{self.identity}-{serials.get(os.path.realpath(self.port)) or 'adapter'}"
