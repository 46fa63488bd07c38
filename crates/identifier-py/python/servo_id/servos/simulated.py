"""Simulated servos on a bus behind a pseudo-terminal, in the protocols of their makers: ``--port simulated``.

The plant is the project's, with backlash, friction, gravity, delay and an encoder of 12 bits. Of the firmwares only a part is
known: scales of the gains, the derivative, and what a reversed servo reports, are drawn for each servo. Time is the bus's own. It passes with what is asked of
the bus, so that a run depends on no other program.
"""

import os
import select
import signal
import tty
from collections.abc import Iterator
from functools import reduce
from math import exp, log, pi, tau
from operator import and_
from random import Random
from threading import RLock, Thread
from typing import Any, ClassVar

from .. import _native, _scenario
from ._registers import Maker

STEP = 1e-3
"""Of plant and firmware, s."""

CLIENT_TIMEOUT = 0.05
"""After which a client waits no longer, s."""


class Killed(BaseException):
    """The program was ended from outside and runs no further."""


class SimulatedServo:
    """Plant, firmware and registers of one servo. All that is drawn follows from the seed."""

    # P, I and D as sold, and the share of the supply for a P of 1 at 1 rad and for a D of 1 at 1 rad/s, as far as it is documented.
    GAINS: ClassVar[dict[str, tuple[int, int, int, float, float]]] = {
        "feetech": (32, 0, 32, 0.166, 1.6e-3),
        "dynamixel": (800, 0, 0, 4096.0 / tau / 128.0 / 885.0, 4.6e-5),
    }

    def __init__(self, maker: Maker, seed: int = 1, identity: int = 1, **numbers: int) -> None:
        random = Random(f"{maker.name} {seed}")
        spread = lambda low, high: exp(random.uniform(log(low), log(high)))
        self.maker, self.identity = maker, identity
        p, i, d, unit_of_p, unit_of_d = self.GAINS[maker.name]
        inertia = spread(1.0, 4.0)
        a = spread(20.0, 60.0)
        b = a * random.uniform(4.0, 8.0) / inertia
        coulomb, hold, angle = b * random.uniform(0.02, 0.08), b * random.uniform(0.0, 0.12), random.uniform(-pi, pi)
        if not numbers.get("torque", 1):
            # An arm without torque lies where friction holds it.
            hold = 0.5 * coulomb
        self.truth = {"a": a / inertia, "b": b, "coulomb": coulomb}
        self.effects = {
            "gravity": [hold * value for value in (random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0))],
            "delay": random.uniform(0.3e-3, 1.5e-3),
            "backlash": random.uniform(0.05, 0.4) * tau / 360.0,
            "low_speed_friction": coulomb * random.uniform(0.0, 0.5),
            "low_speed_velocity": random.uniform(0.05, 0.2),
        }
        self.scales = {
            "p": spread(0.3, 3.0) * unit_of_p,
            "i": spread(0.3, 3.0) * unit_of_p,
            "d": spread(0.3, 3.0) * unit_of_d,
        }
        self.derives_error = random.random() < 0.5
        self.share_of_newest = 1.0 - exp(-STEP / spread(0.5e-3, 4e-3))
        # Reversed, a profile in times, and switched on by a goal.
        drive_mode = sum(bit for bit in (0x01, 0x04, 0x08) if random.random() < 0.5)
        self.side_of_load = -1 if drive_mode & 0x01 and random.random() < 0.5 else 1
        self.plant = _native.SimulatedServo(
            *_scenario.read({
                "plant": self.truth | self.effects,
                "controller": {"sample_time": STEP},
                "run": {"seed": seed},
            })
        )
        self.origin = 2048 + round(100.0 * angle)
        self.angle = self.velocity = self.duty = 0.0
        self.extremes = [0.0, 0.0]
        self.is_powered, self.alarm = True, 0
        model = next(iter(maker.models))
        self.sold = {name: 0 for name in maker.registers} | {
            "model": model, "firmware": 3, "mode": maker.modes[0], "lowest": 0, "highest": maker.counts - 1, "p": p, "i": i, "d": d,
            "lowest_voltage": 60, "highest_voltage": 140, "highest_temperature": 70, "voltage": 120, "temperature": 35,
            "start_force": 16, "dead_zone": 1, "lock": 1, "acceleration": 50, "speed": 200,
            "goal": self.origin, "drive_mode": drive_mode,
        } | numbers | {"torque": 0}
        self.numbers = self.sold | {"torque": numbers.get("torque", 1)}
        self._forget()

    def _forget(self) -> None:
        self.sum = self.rate = self.before = 0.0

    @property
    def counts(self) -> int:
        return self.origin + round(self.angle * self.maker.counts / tau)

    def power(self, on: bool) -> None:
        """Switches it; what is kept without power is as it was last written behind an open lock."""
        self.is_powered, self.alarm = on, 0
        self.numbers = dict(self.sold) | {"goal": self.counts, "torque": 0}
        self._forget()

    def tick(self) -> None:
        """A step of firmware and plant."""
        of = self.numbers
        error = of["goal"] - self.counts
        if of.get("dead_zone", 0) >= abs(error):
            error = 0
        count = tau / self.maker.counts
        moved = (error if self.derives_error else -self.counts) * count
        self.rate += self.share_of_newest * ((moved - self.before) / STEP - self.rate)
        self.before = moved
        if of["torque"] and self.is_powered:
            self.sum += error * count * STEP
            duty = self.scales["p"] * of["p"] * error * count + self.scales["d"] * of["d"] * self.rate
            duty += self.scales["i"] * of["i"] * self.sum
            least, most = 1e-3 * of.get("start_force", 0) * (error != 0), 0.2 if self.alarm else 0.97
            self.duty = max(min(duty, most), -most) if abs(duty) > least else least * (error > 0) - least * (error < 0)
            self.extremes = [min(self.extremes[0], self.angle), max(self.extremes[1], self.angle)]
        else:
            self.duty = 0.0
            self._forget()
        self.angle, self.velocity = self.plant.step(self.duty)

    def trip(self, bit: int) -> None:
        """A protection of the servo acts."""
        self.alarm = bit if self.maker.name == "feetech" else 0x80
        if self.maker.name == "dynamixel":
            self.numbers["torque"] = 0

    def read(self, start: int, length: int) -> bytes:
        load = self.side_of_load * self.duty
        self.numbers |= {"position": self.counts, "load": round(load * self.maker.full_load)}
        data = bytearray(length)
        for name, one in self.maker.registers.items():
            if start <= one.address and one.address + one.size <= start + length:
                place = one.address - start
                data[place : place + one.size] = one.stored(self.numbers[name]).to_bytes(one.size, "little")
        return bytes(data)

    def write(self, start: int, data: bytes) -> None:
        for name, one in self.maker.registers.items():
            if start <= one.address and one.address + one.size <= start + len(data):
                place = one.address - start
                self.numbers[name] = one.number(int.from_bytes(data[place : place + one.size], "little"))
                if self.maker.name == "dynamixel":
                    self._apply(name)
                if self.maker.lock and one.address < 40 and not self.numbers["lock"]:
                    self.sold[name] = self.numbers[name]

    def _apply(self, written: str) -> None:
        """What a drive mode makes of it."""
        of = self.numbers
        if of["drive_mode"] & 0x04:
            of["acceleration"] = min(of["acceleration"], of["speed"] // 2)
        if of["drive_mode"] & 0x08 and written == "goal" and not self.alarm:
            of["torque"] = 1


class _Sts:
    """The packets of Feetech's protocol."""

    @staticmethod
    def split(buffer: bytearray) -> Iterator[tuple[int, int, int, bytes]]:
        while (start := buffer.find(b"\xff\xff")) >= 0 and len(buffer) >= start + 4 and len(buffer) >= start + 4 + buffer[start + 3]:
            packet = bytes(buffer[start : start + 4 + buffer[start + 3]])
            del buffer[: start + len(packet)]
            if ~sum(packet[2:-1]) & 0xFF == packet[-1]:
                yield packet[2], packet[4], packet[5] if len(packet) > 6 else 0, packet[6:-1]

    @staticmethod
    def answer(identity: int, error: int, data: bytes) -> bytes:
        body = bytes([identity, len(data) + 2, error]) + data
        return b"\xff\xff" + body + bytes([~sum(body) & 0xFF])

    length = staticmethod(lambda data: data[0])
    identities = staticmethod(lambda data: data[1:])


class _Protocol2:
    """The packets of Dynamixel's protocol 2.0."""

    TABLE = tuple(
        reduce(lambda crc, _: (crc << 1 ^ 0x8005 if crc & 0x8000 else crc << 1) & 0xFFFF, range(8), byte << 8) for byte in range(256)
    )

    @classmethod
    def _check(cls, packet: bytes) -> bytes:
        crc = 0
        for byte in packet:
            crc = crc << 8 & 0xFFFF ^ cls.TABLE[crc >> 8 ^ byte]
        return crc.to_bytes(2, "little")

    @classmethod
    def split(cls, buffer: bytearray) -> Iterator[tuple[int, int, int, bytes]]:
        while (start := buffer.find(b"\xff\xff\xfd\x00")) >= 0 and len(buffer) >= start + 7:
            length = 7 + int.from_bytes(buffer[start + 5 : start + 7], "little")
            if len(buffer) < start + length:
                return
            packet = bytes(buffer[start : start + length])
            del buffer[: start + length]
            if cls._check(packet[:-2]) == packet[-2:]:
                body = packet[7:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
                yield packet[4], body[0], int.from_bytes(body[1:3], "little"), body[3:]

    @classmethod
    def answer(cls, identity: int, error: int, data: bytes) -> bytes:
        body = (bytes([0x55, error]) + data).replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
        packet = b"\xff\xff\xfd\x00" + bytes([identity]) + (len(body) + 2).to_bytes(2, "little") + body
        return packet + cls._check(packet)

    length = staticmethod(lambda data: int.from_bytes(data[:2], "little"))
    identities = staticmethod(lambda data: data[2:])


class SimulatedBus:
    """A half-duplex bus with its servos. It is the clock of whoever uses it, and injects faults at their times."""

    READ, WRITE, SYNC_READ = 0x02, 0x03, 0x82

    def __init__(
        self, *servos: SimulatedServo, seed: int = 1, baud: int = 0, faults: list[tuple[float, str]] | None = None
    ) -> None:
        self.servos, self.faults = servos, sorted(faults or [])
        self.random = Random(seed)
        self.protocol: Any = _Sts if servos[0].maker.name == "feetech" else _Protocol2
        self.byte_time = 10.0 / (baud or servos[0].maker.baud)
        self.time, self.steps = 0.0, 0
        self.is_connected, self.is_alive, self.collides = True, True, False
        self.late: list[tuple[float, bytes]] = []
        self.lock = RLock()
        self.own, self.other = os.openpty()
        tty.setraw(self.other)
        self.port = os.ttyname(self.other)
        self.wake, self.end = os.pipe()
        self._pass(1.0)
        self.thread = Thread(target=self._serve, daemon=True)
        self.thread.start()

    def close(self) -> None:
        os.write(self.end, b"x")
        self.thread.join()
        for file in (self.own, self.other, self.wake, self.end):
            os.close(file)

    def now(self) -> float:
        if not self.is_alive:
            raise Killed
        return self.time

    def sleep(self, seconds: float) -> None:
        with self.lock:
            self._pass(max(seconds, 0.0))
        self.now()

    def restart(self) -> None:
        """Cable and power are back, and the program is started again."""
        for servo in self.servos:
            if not servo.is_powered or servo.alarm:
                servo.power(True)
                servo.numbers["temperature"] = 35
        self.is_connected = self.is_alive = True
        self.faults, self.late = [], []

    def _pass(self, seconds: float) -> None:
        self.time += seconds
        while (self.steps + 1) * STEP <= self.time:
            self.steps += 1
            for servo in self.servos:
                servo.tick()
        for one in [one for one in self.late if one[0] <= self.time]:
            self.late.remove(one)
            os.write(self.own, one[1])

    def _serve(self) -> None:
        buffer = bytearray()
        while True:
            ready, _, _ = select.select([self.own, self.wake], [], [])
            if self.wake in ready:
                return
            buffer += os.read(self.own, 4096)
            for packet in self.protocol.split(buffer):
                with self.lock:
                    self._answer(*packet)

    def _answer(self, identity: int, instruction: int, address: int, data: bytes) -> None:
        # The adapter passes bytes on once in a millisecond.
        self._pass(self.random.uniform(0.4e-3, 1e-3) + (len(data) + 8) * self.byte_time)
        fault = self.faults.pop(0)[1] if self.faults and self.faults[0][0] <= self.time else ""
        self._inject(fault)
        identities = [identity] if instruction != self.SYNC_READ else self.protocol.identities(data)
        answer = b"".join(self._answer_of(one, instruction, address, data) for one in identities)
        if not answer:
            self._pass(CLIENT_TIMEOUT)
            return
        answer *= 2 if fault == "doubled" else 1
        self._pass(self.random.uniform(0.4e-3, 1e-3) + len(answer) * self.byte_time)
        if fault == "damaged":
            place = self.random.randrange(len(answer))
            answer = answer[:place] + bytes([answer[place] ^ 1 << self.random.randrange(8)]) + answer[place + 1 :]
        if fault in ("lost", "late", "later"):
            self._pass(CLIENT_TIMEOUT)
            # The last one comes after the next question.
            delay = self.random.uniform(0.0, 0.05) + (0.1 if fault == "later" else 0.0)
            self.late += [(self.time + delay, answer)] if fault != "lost" else []
            return
        os.write(self.own, answer)

    def _answer_of(self, identity: int, instruction: int, address: int, data: bytes) -> bytes:
        """What the line has if every servo of an id answers."""
        answers = []
        for servo in self.servos if self.is_connected and self.is_alive else ():
            if servo.identity == identity and servo.is_powered:
                if instruction == self.WRITE:
                    servo.write(address, data)
                length = 0 if instruction == self.WRITE else self.protocol.length(data)
                answers.append(self.protocol.answer(identity, servo.alarm, servo.read(address, length)))
        # Of two drivers the one wins that pulls the line low.
        return bytes(reduce(and_, together) for together in zip(*answers)) if self.collides else b"".join(answers)

    def _inject(self, fault: str) -> None:
        servo = self.servos[0]
        if fault == "unplugged":
            self.is_connected = False
        elif fault in ("power lost", "brown-out"):
            servo.power(fault == "brown-out")
        elif fault == "over-load":
            servo.trip(32)
        elif fault == "over-temperature":
            servo.numbers["temperature"] = 80
            servo.trip(4)
        elif fault == "interrupted":
            os.kill(os.getpid(), signal.SIGINT)
        elif fault == "killed":
            self.is_alive = False
