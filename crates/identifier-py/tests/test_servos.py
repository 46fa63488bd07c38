"""Smart servos: simulated ones behind a pseudo-terminal, through their makers' clients."""

import csv
import importlib.util
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

import servo_id
from servo_id.servos import MAKERS, Fault, Interrupted, Refused, Servo, Session, _commands, _tune
from servo_id.servos.simulated import Killed, SimulatedBus, SimulatedServo

CLIENTS = {"dynamixel": "dynamixel_sdk", "feetech": "scservo_sdk"}
BAUD = 1_000_000


class SmartServos(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.journal = self.folder / "journal.json"

    def bus(self, *servos, **options):
        client = CLIENTS[servos[0].maker.name]
        if importlib.util.find_spec(client) is None:
            self.skipTest(f"{client} is not installed")
        bus = SimulatedBus(*servos, baud=BAUD, **options)
        self.addCleanup(bus.close)
        return bus

    def run_on(self, bus, *words):
        """A whole command; what it says."""
        name = bus.servos[0].maker.name
        options = _commands._options([*words, "--drive", name, "--port", "unused", "--baud", str(BAUD), "--yes"])
        options.bus, options.journal, options.stall = bus, self.journal, 60.0
        said = []
        _commands.run(options, said.append)
        return "\n".join(said)

    def session(self, bus, **options):
        servo = Servo(bus.servos[0].maker, bus.port, 1, BAUD, bus)
        self.addCleanup(servo.close)
        stated = {"yes": True, "stall": 60.0, "say": lambda _: None} | options
        return Session(servo, self.journal, stated.pop("travel", 228.0), **stated)

    def test_a_captured_log_has_the_servo(self):
        for name in MAKERS:
            with self.subTest(name):
                own = SimulatedServo(MAKERS[name], seed=3, torque=0)
                before = own.sold | {"torque": 0}
                file = self.folder / f"{name}.csv"
                self.run_on(self.bus(own), "capture", "--out", str(file))
                lines = file.read_text().splitlines()
                self.assertGreater(len(list(csv.DictReader(lines[3:]))), 1000)
                found = servo_id.identify(file, position="position_deg", command="command_V", counts_per_rev=4096)
                error = found.estimates["b"] - own.truth["b"] / 12.0
                self.assertLess(abs(error), 3.0 * found.std_errors["b"])
                self.assertLess(abs(error), 0.1 * own.truth["b"] / 12.0)
                moved = ("goal", "position", "load")
                self.assertEqual([own.numbers[name] for name in before if name not in moved], [before[name] for name in before if name not in moved])
                self.assertFalse(self.journal.exists())

    def test_gains_that_the_servo_proves_better_stay(self):
        for name in MAKERS:
            with self.subTest(name):
                own = SimulatedServo(MAKERS[name], seed=7)
                old = [own.numbers[gain] for gain in "pid"]
                plot = self.folder / "step.svg"
                said = self.run_on(self.bus(own), "tune-servo", "--apply", "--keep", "--plot", str(plot))
                kept = [own.numbers[gain] for gain in "pid"]
                self.assertNotEqual(kept, old, said)
                self.assertEqual(plot.read_text().count("<polyline"), 3)
                self.assertFalse(self.journal.exists())
                self.assertEqual(own.numbers["lock"] if name == "feetech" else 1, 1)
                own.power(False)
                own.power(True)
                self.assertEqual([own.numbers[gain] for gain in "pid"], kept if name == "feetech" else old)

    def test_gains_that_the_servo_does_not_prove_are_taken_back(self):
        good = _tune.Response(settling_time=0.1, error=3.0, overshoot=0.1, ripple=1.0)
        worse = {"settling_time": 0.3, "error": 4.0, "overshoot": 0.5, "ripple": 9.0}
        self.assertEqual(_tune.rejection("settling", good, good, _tune.Response(0.08, 3.0, 0.1, 1.0)), "")
        self.assertNotEqual(_tune.rejection("load", good, good, _tune.Response(0.08, 3.0, 0.1, 1.0)), "")
        for name, value in worse.items():
            after = {"settling_time": 0.08, "error": 3.0, "overshoot": 0.1, "ripple": 1.0, name: value}
            self.assertNotEqual(_tune.rejection("settling", good, good, _tune.Response(**after)), "", name)
        own = SimulatedServo(MAKERS["feetech"], seed=7)
        session = self.session(self.bus(own))
        proposal = _tune.Proposal({"p": 40, "i": 0, "d": 32}, 10.0, good)
        with (
            session,
            mock.patch.object(_tune, "best", lambda model, gains, goal, most: proposal if most > 10.0 else None),
            mock.patch.object(_tune, "tried", lambda session: (_tune.Response(**worse), None)),
        ):
            self.assertIsNone(_tune.trial(session, None, "settling", good))
            self.assertEqual([own.numbers[gain] for gain in "pid"], [32, 0, 32])

    def test_a_fault_leaves_old_gains_and_torque_as_it_was(self):
        # The answers that are lost, late, doubled or damaged once do not end the motion.
        ends = {"over-load": Fault, "over-temperature": Fault, "power lost": Fault, "unplugged": Fault, "interrupted": Interrupted,
                "killed": Killed, "lost": None, "late": None, "doubled": None, "damaged": None}
        for number, (kind, end) in enumerate(ends.items()):
            name = ("feetech", "dynamixel")[number % 2]
            with self.subTest(kind):
                own = SimulatedServo(MAKERS[name], seed=7, torque=0)
                bus = self.bus(own)
                session = self.session(bus)
                new = {"p": 40, "i": 0, "d": 20}
                try:
                    with session:
                        session.set_gains(new)
                        self.assertEqual([own.numbers[gain] for gain in "pid"], [*new.values()])
                        bus.faults = [(bus.time + 0.5, kind)]
                        session.follow(lambda _: 0.0, 1.0)
                        self.assertIsNone(end)
                except (Fault, Killed) as fault:
                    self.assertIs(type(fault) if end is not Fault else Fault, end)
                cut = kind in ("power lost", "unplugged", "killed")
                self.assertEqual(self.journal.exists(), cut)
                if cut:
                    bus.restart()
                    with self.assertRaises(Refused):
                        self.session(bus, yes=False, ask=lambda _: "n")
                    self.session(bus)
                old = [own.sold[gain] for gain in "pid"]
                found = [own.numbers[gain] for gain in ("p", "i", "d", "torque", "acceleration")]
                self.assertEqual(found, [32, 0, 32, 0, 50] if name == "feetech" else [*old, 0, 50])
                self.assertFalse(self.journal.exists())

    def test_a_servo_that_would_leave_its_travel_is_stopped(self):
        own = SimulatedServo(MAKERS["feetech"], seed=7)
        session = self.session(self.bus(own))
        with self.assertRaisesRegex(Fault, "leave its travel"), session:
            session.follow(lambda time: 300.0 * time, 2.0)
        self.assertLess(abs(own.counts - session.start), 1.02 * 114.0)

    def test_a_program_that_stands_still_has_its_servo_held(self):
        own = SimulatedServo(MAKERS["feetech"], seed=7)
        bus = self.bus(own)
        session = self.session(bus)

        def goal(seconds):
            if seconds > 0.2 and not stalls:
                session.stall = 0.1
                stalls.append(own.numbers["goal"])
                time.sleep(1.0)
                held.append(own.numbers["goal"])
            return 200.0 * seconds

        stalls, held = [], []
        session.stall = 0.4
        with self.assertRaisesRegex(Fault, "stood still"), session:
            session.follow(goal, 2.0)
        self.assertLess(held[0], stalls[0])

    def test_what_cannot_be_moved_is_refused_and_nothing_is_written(self):
        stop = {"highest": 2100, "lowest": 0}
        for numbers, part in (
            ({"model": 1}, "not known"),
            ({"mode": 1}, "mode 1"),
            ({"voltage": 45}, "4.5 V"),
            (stop, "smaller --travel"),
        ):
            with self.subTest(part):
                own = SimulatedServo(MAKERS["feetech"], seed=7, **numbers)
                before = dict(own.numbers)
                own.write = mock.Mock(side_effect=AssertionError)
                with self.assertRaisesRegex(Refused, part):
                    self.session(self.bus(own), travel=1600.0)
                self.assertFalse(self.journal.exists())
                self.assertEqual({**own.numbers, "position": 0, "load": 0}, {**before, "position": 0, "load": 0})
        own = SimulatedServo(MAKERS["feetech"], seed=7)
        bus = self.bus(own, SimulatedServo(MAKERS["feetech"], seed=8))
        with self.assertRaisesRegex(Refused, "more than one servo"):
            self.session(bus)
        with self.assertRaisesRegex(Refused, "cannot be opened"):
            Servo(MAKERS["feetech"], str(self.folder / "tty"))
        with self.assertRaisesRegex(Fault, "--id"):
            Servo(MAKERS["feetech"], bus.port, 9, BAUD, bus).description()
        with self.assertRaisesRegex(Refused, "20deg"):
            self.run_on(bus, "capture", "--out", "x.csv", "--travel", "20")

    def test_who_does_not_agree_moves_nothing(self):
        own = SimulatedServo(MAKERS["feetech"], seed=7)
        bus = self.bus(own)
        own.write = mock.Mock(side_effect=AssertionError)
        words = ["capture", "--out", str(self.folder / "x.csv"), "--drive", "feetech", "--port", "unused"]
        options = _commands._options(words)
        options.bus, options.journal, options.ask = bus, self.journal, lambda _: ""
        with self.assertRaises(Refused):
            _commands.run(options, lambda _: None)


if __name__ == "__main__":
    unittest.main()
