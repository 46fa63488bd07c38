"""Smart servos: simulated ones behind a pseudo-terminal, through their makers' clients."""

import csv
import fcntl
import importlib.util
import io
import json
import os
import stat
import sys
import tempfile
import termios
import time
import unittest
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from unittest import mock
from zlib import crc32

import servo_id
from servo_id import __main__
from servo_id.servos import MAKERS, Fault, Interrupted, Refused, Servo, Session, _capture, _commands, _tune
from servo_id.servos.simulated import Killed, SimulatedBus, SimulatedServo

CLIENTS = {"dynamixel": "dynamixel_sdk", "feetech": "scservo_sdk"}
BAUD = 1_000_000


class SmartServos(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.journals = self.folder / "journals"
        self.servo = None
        # The bus keeps its pseudo-terminal open, which would stay exclusive.
        opened = mock.patch.object(Servo, "close", self.closed)
        opened.start()
        self.addCleanup(opened.stop)

    close = Servo.close

    @staticmethod
    def closed(servo):
        with suppress(OSError):
            fcntl.ioctl(servo.client.ser, termios.TIOCNXCL)
        SmartServos.close(servo)

    def bus(self, *servos, **options):
        client = CLIENTS[servos[0].maker.name]
        if importlib.util.find_spec(client) is None:
            self.skipTest(f"{client} is not installed")
        bus = SimulatedBus(*servos, baud=BAUD, **options)
        self.addCleanup(bus.close)
        return bus

    def has_journal(self):
        return any(self.journals.glob("*.json"))

    def run_on(self, bus, *words):
        """A whole command; what it says."""
        name = bus.servos[0].maker.name
        options = __main__.options([*words, "--drive", name, "--port", "unused", "--baud", str(BAUD), "--yes"])
        options.bus, options.journals, options.stall = bus, self.journals, 60.0
        said = []
        _commands.run(options, said.append)
        return "\n".join(said)

    def session(self, bus, **options):
        # Whoever had the port is gone: it has one owner.
        if self.servo:
            self.servo.close()
        self.servo = servo = Servo(bus.servos[0].maker, bus.port, 1, BAUD, bus)
        self.addCleanup(servo.close)
        stated = {"yes": True, "stall": 60.0, "say": lambda _: None} | options
        return Session(servo, self.journals, stated.pop("travel", 228.0), **stated)

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
                self.assertFalse(self.has_journal())

    def test_gains_that_the_servo_proves_better_stay(self):
        for name in MAKERS:
            with self.subTest(name):
                own = SimulatedServo(MAKERS[name], seed=8)
                old = [own.numbers[gain] for gain in "pid"]
                plot = self.folder / "step.svg"
                said = self.run_on(self.bus(own), "tune-servo", "--apply", "--keep", "--plot", str(plot))
                kept = [own.numbers[gain] for gain in "pid"]
                self.assertNotEqual(kept, old, said)
                self.assertEqual(plot.read_text().count("<polyline"), 3)
                self.assertFalse(self.has_journal())
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
        proposals = iter([_tune.Proposal({"p": 40, "i": 0, "d": 32}, 10.0, good)])
        with (
            session,
            mock.patch.object(_tune, "best", lambda model, gains, goal, *_: next(proposals, None)),
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
                self.assertEqual(self.has_journal(), cut)
                if cut:
                    bus.restart()
                    with self.assertRaises(Refused):
                        self.session(bus, yes=False, ask=lambda _: "n")
                    self.session(bus)
                old = [own.sold[gain] for gain in "pid"]
                found = [own.numbers[gain] for gain in ("p", "i", "d", "torque", "acceleration")]
                self.assertEqual(found, [32, 0, 32, 0, 50] if name == "feetech" else [*old, 0, 50])
                self.assertFalse(self.has_journal())

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
        rows = (
            ("an unknown model", {"model": 1}, (), "model 1 is not known: --drive {name} is for "),
            ("a servo in velocity or wheel mode", {"mode": 1}, (), "mode 1, which follows no position: set its mode"),
            ("a voltage below its range", {"voltage": 45}, (), "the supply is 4.5 V: connect one of 6.0 to 14.0 V"),
            ("limits of the servo", {"highest": 2100}, ("--travel", "140deg"), "move it by hand or state a smaller --travel"),
            ("a travel without unit", {}, ("--travel", "20"), "state a number with its unit, such as 20deg"),
            ("an id that does not answer", {}, ("--id", "9"), "servo 9 on .* check cable, power, --id and --baud"),
            ("two servos of one id", {}, (), "more than one servo answers to id 1: give each its own id"),
            ("two servos of one id that collide", {}, (), "and that no other servo has this id"),
            ("a baud rate that no servo has", {}, ("--baud", "12345"), "12345 baud is not a rate .* state another --baud"),
        )
        for name in MAKERS:
            for title, numbers, words, sentence in rows:
                with self.subTest(title, maker=name):
                    own = SimulatedServo(MAKERS[name], seed=7, **numbers)
                    others = [SimulatedServo(MAKERS[name], seed=8)] if title.startswith("two") else []
                    bus = self.bus(own, *others)
                    bus.collides = title.endswith("collide")
                    before = dict(own.numbers)
                    own.write = mock.Mock(side_effect=AssertionError)
                    words = self.words(name, "tune-servo", "--apply", *words)
                    self.assertRegex(self.refused(words, bus=bus), sentence.format(name=name))
                    own.write.assert_not_called()
                    moves = {"position": 0, "load": 0}
                    self.assertEqual(own.numbers | moves, before | moves)

    def test_answers_that_come_twice_are_no_second_servo(self):
        for name in MAKERS:
            with self.subTest(maker=name):
                bus = self.bus(SimulatedServo(MAKERS[name], seed=7))
                bus.faults = [(0.0, "doubled")] * 2
                self.session(bus)
                self.assertEqual(bus.faults, [])

    def refused(self, words, status=2, journal=False, **own):
        """What a command that ends early prints, which is one sentence."""
        with redirect_stderr(io.StringIO()) as printed, redirect_stdout(io.StringIO()):
            options = __main__.options(words)
            vars(options).update(journals=self.journals, stall=60.0, **own)
            self.assertEqual(_commands.main(options), status)
        self.assertEqual(printed.getvalue().count("\n"), 1)
        self.assertEqual(self.has_journal(), journal)
        return printed.getvalue()

    def words(self, name, verb, *more):
        return (verb, "--drive", name, "--port", "unused", "--baud", str(BAUD), "--yes", *more)

    def test_a_port_has_one_owner(self):
        bus = self.bus(SimulatedServo(MAKERS["feetech"], seed=7))
        words = ["capture", "--drive", "feetech", "--out", "x.csv", "--port", str(self.folder / "tty")]
        self.assertRegex(self.refused(words), "cannot be opened: .* state another --port")
        self.session(bus)
        self.assertRegex(self.refused(words, port=bus.port), "end the other program that has it")

    def test_a_journal_is_found_by_servo_and_adapter(self):
        bus = self.bus(SimulatedServo(MAKERS["feetech"], seed=7))
        self.assertEqual(self.session(bus).journal.file.name, "STS3215-1-adapter.json")
        adapter = mock.Mock(device=bus.port, serial_number="A50285BI")
        with mock.patch("serial.tools.list_ports.comports", lambda: [adapter]):
            self.assertEqual(self.session(bus).journal.file.name, "STS3215-1-A50285BI.json")

    def test_other_servos_of_a_bus_are_untouched(self):
        for name in MAKERS:
            with self.subTest(name):
                own, other = SimulatedServo(MAKERS[name], seed=7), SimulatedServo(MAKERS[name], seed=8, identity=2)
                bus = self.bus(own, other)
                before = dict(other.numbers)
                session = self.session(bus)
                with session:
                    session.follow(lambda time: 50.0 * time, 0.5)
                    client = session.servo.client
                    sdk = importlib.import_module(CLIENTS[name])
                    first = (client, sdk.PacketHandler(2.0)) if name == "dynamixel" else (sdk.sms_sts(client),)
                    place = MAKERS[name].registers["goal"]
                    both = sdk.GroupSyncRead(*first, place.address, place.size)
                    both.addParam(1)
                    both.addParam(2)
                    self.assertEqual(both.txRxPacket(), 0)
                    both = [both.getData(identity, place.address, place.size) for identity in (1, 2)]
                    self.assertEqual(both, [own.numbers["goal"], before["goal"]])
                moves = {"position": 0, "load": 0}
                self.assertEqual(other.numbers | moves, before | moves)

    def test_every_drive_mode_is_read_and_restored(self):
        # Reversed with its load, a profile in times, switched on by a goal.
        for mode in (0x01, 0x04, 0x08):
            with self.subTest(mode):
                own = SimulatedServo(MAKERS["dynamixel"], seed=7, drive_mode=mode, torque=0)
                own.side_of_load = -1 if mode & 0x01 else 1
                before = dict(own.numbers)
                session = self.session(self.bus(own))
                with session:
                    rows = _capture.captured(session, _capture.plan()[:2])
                scales = _tune.scales(MAKERS["dynamixel"], rows, {"p": 800, "i": 0, "d": 0})
                self.assertLess(abs(scales["p"] / own.scales["p"] - 1.0), 0.1)
                kept = ("torque", "acceleration", "speed", "p", "i", "d", "drive_mode")
                self.assertEqual([own.numbers[name] for name in kept], [before[name] for name in kept])

    def test_a_servo_that_a_goal_switches_on_is_switched_off(self):
        own = SimulatedServo(MAKERS["dynamixel"], seed=7, drive_mode=0x08, torque=0)
        session = self.session(self.bus(own))
        # It ends before it has switched torque on itself.
        with mock.patch.object(Session, "LONGEST_SAG", -1.0), self.assertRaises(Fault):
            session.__enter__()
        self.assertEqual(own.numbers["torque"], 0)
        self.assertFalse(self.has_journal())

    def test_who_does_not_agree_moves_nothing(self):
        own = SimulatedServo(MAKERS["feetech"], seed=7)
        bus = self.bus(own)
        own.write = mock.Mock(side_effect=AssertionError)
        words = ["capture", "--out", str(self.folder / "x.csv"), "--drive", "feetech", "--port", "unused"]
        options = __main__.options(words)
        options.bus, options.journals, options.ask = bus, self.journals, lambda _: ""
        with self.assertRaises(Refused):
            _commands.run(options, lambda _: None)

    def test_a_servo_that_restarts_proves_no_gains(self):
        # One whose torque a goal switches on, with gains of its own, and with nothing that differs from what it restarts with.
        for gains in ({"p": 900}, {}):
            with self.subTest(gains):
                own = SimulatedServo(MAKERS["dynamixel"], seed=7, drive_mode=0x08, acceleration=0, speed=0)
                bus = self.bus(own)
                session = self.session(bus)
                with self.assertRaises(Fault), session:
                    session.set_gains(session.gains | gains)
                    bus.faults = [(bus.time + 4.8, "brown-out")]
                    _tune.tried(session)
                self.assertEqual([own.numbers["p"], bus.faults], [800, []])
                self.assertFalse(self.has_journal())

    def test_the_exit_status_is_0_only_if_all_is_back(self):
        for name in MAKERS:
            with self.subTest(name):
                bus = self.bus(SimulatedServo(MAKERS[name], seed=7, torque=0))
                words = self.words(name, "capture", "--out", str(self.folder / "x.csv"))
                with mock.patch.object(_capture, "write", lambda *_: setattr(bus, "is_connected", False)):
                    self.refused(words, status=1, journal=True, bus=bus)
                bus.restart()
                self.session(bus)

    def test_a_closed_terminal_is_an_answer(self):
        def closed(*_):
            if is_closed:
                raise error

        for error in (EOFError(), OSError(5, "EIO"), BrokenPipeError(), ValueError("closed file"), RuntimeError("lost sys.stdin")):
            with self.subTest(error):
                own, is_closed = SimulatedServo(MAKERS["feetech"], seed=7, torque=0), False
                says = {"say": closed} if isinstance(error, (OSError, ValueError)) else {}
                session = self.session(self.bus(own), yes=False, ask=closed, **says)
                with session:
                    is_closed = True
                    session.pull = 5.0 * session.gains["p"]
                self.assertEqual(own.numbers["torque"], 0)
                self.assertFalse(self.has_journal())

    def killed(self, own, gains, *, adapter=None, keeps=False):
        """A session that ends in the midst of a trial."""
        bus = self.bus(own)
        adapters = [mock.Mock(device=bus.port, serial_number=adapter)] if adapter else []
        with mock.patch("serial.tools.list_ports.comports", lambda: adapters), self.assertRaises(Killed), self.session(bus) as session:
            session.set_gains(session.gains | gains)
            if keeps:
                session.keep()
            bus.is_alive = False
        bus.restart()
        return bus

    def test_a_journal_is_not_written_into_another_servo(self):
        for name, adapter in (("feetech", None), ("feetech", "A50285BI"), ("dynamixel", None)):
            with self.subTest(name, adapter=adapter):
                self.killed(SimulatedServo(MAKERS[name], seed=7, p=20), {"p": 26}, adapter=adapter)
                other = SimulatedServo(MAKERS[name], seed=7, p=48)
                other.write = mock.Mock(side_effect=AssertionError)
                with self.assertRaises(Refused):
                    self.session(self.bus(other), ask=lambda _: "")
                self.assertTrue(self.has_journal())
                next(self.journals.glob("*.json")).unlink()

    def test_a_journal_follows_its_servo_to_another_adapter(self):
        own = SimulatedServo(MAKERS["feetech"], seed=7)
        bus = self.killed(own, {"p": 26}, adapter="A50285BI")
        self.assertEqual(self.session(bus).gains["p"], 32)
        self.assertEqual(own.sold["p"], 32)
        self.assertFalse(self.has_journal())
        # What a journal of another adapter has as found may be any servo of its model.
        self.killed(own, {"p": 26}, adapter="A50285BI")
        self.session(self.bus(SimulatedServo(MAKERS["feetech"], seed=8)))
        self.assertTrue(self.has_journal())

    def test_numbers_that_went_with_the_power_are_written_back_by_a_person(self):
        for keeps, back in ((False, 700), (True, 900)):
            with self.subTest(keeps=keeps):
                own = SimulatedServo(MAKERS["dynamixel"], seed=7)
                own.numbers["p"] = 700
                bus = self.killed(own, {"p": 900, "d": 5}, keeps=keeps)
                own.power(False)
                own.power(True)
                with self.assertRaises(Refused):
                    self.session(bus, yes=keeps, ask=lambda _: "n")
                self.assertEqual(own.numbers["p"], 800)
                self.session(bus, yes=keeps, ask=lambda _: "y")
                self.assertEqual(own.numbers["p"], back)

    def test_what_another_program_writes_is_not_kept(self):
        for name in MAKERS:
            with self.subTest(name):
                own = SimulatedServo(MAKERS[name], seed=7)
                bus = self.bus(own)
                old = own.numbers["p"]
                with self.assertRaises(Fault), self.session(bus) as session:
                    session.follow(lambda time: own.numbers.update(p=old + 7) or 0.0, 0.3)
                self.assertEqual(own.numbers["p"], old)
                with self.session(bus) as session:
                    session.set_gains(session.gains | {"p": old + 3})
                    session.keep()
                    own.numbers["p"] = old + 7
                self.assertEqual(own.numbers["p"], old + 3)

    @unittest.skipUnless(sys.platform == "linux", "TIOCGEXCL")
    def test_no_other_program_opens_the_port(self):
        is_exclusive = lambda file: fcntl.ioctl(file, 0x80045440, bytes(4)) != bytes(4)
        bus = self.bus(SimulatedServo(MAKERS["feetech"], seed=7))
        self.assertFalse(is_exclusive(bus.other))
        self.session(bus)
        self.assertTrue(is_exclusive(bus.other))

    def test_a_late_answer_is_no_old_number(self):
        for name in MAKERS:
            for instant in range(2, 42, 4):
                with self.subTest(name, instant=instant):
                    own = SimulatedServo(MAKERS[name], seed=7)
                    old = [own.numbers[gain] for gain in "pid"]
                    # It may end the motion, as a position far away does.
                    with suppress(Fault, Refused), self.session(self.bus(own, faults=[(1.1 + 1e-3 * instant, "later")])) as session:
                        self.assertEqual([session.gains[gain] for gain in "pid"], old)
                    found = [own.numbers[gain] for gain in ("p", "i", "d", "acceleration", "speed", "torque")]
                    self.assertEqual(found, [*old, 50, 200, 1])

    def test_what_refuses_a_start_ends_a_motion(self):
        for name in MAKERS:
            for change in ({"voltage": 45}, {"voltage": 150}, {"mode": 1}, {"temperature": 70}):
                with self.subTest(name, **change):
                    own = SimulatedServo(MAKERS[name], seed=7)
                    session = self.session(self.bus(own))
                    with self.assertRaises(Fault), session:
                        own.numbers |= change
                        session.follow(lambda _: 0.0, 0.5)
                    own = SimulatedServo(MAKERS[name], seed=7, **change)
                    with self.assertRaises(Refused):
                        self.session(self.bus(own))

    def test_a_damaged_journal_is_refused(self):
        signed = lambda numbers: f"{crc32(json.dumps(numbers).encode())} {json.dumps(numbers)}"
        good = {"p": [32, 40], "acceleration": [50, 0]}
        bad = ({"mode": [1]}, {"p": [300]}, {"p": [255]}, {"p": [-1]}, {"p": ["32"]}, {"p": [True]}, {"p": []}, {"p": 32}, [], 1)
        files = ["", "[]", "null", '{"mode": 1}', '{"p": 20}', "\xff", signed(good)[:-4], signed(good).replace("40", "41"), *map(signed, bad)]
        own = SimulatedServo(MAKERS["feetech"], seed=7)
        bus = self.bus(own)
        self.journals.mkdir()
        for text in files:
            with self.subTest(text), mock.patch.object(own, "write", side_effect=AssertionError) as write:
                (self.journals / "STS3215-1-adapter.json").write_text(text, "latin-1")
                self.refused(self.words("feetech", "tune-servo"), journal=True, bus=bus)
                write.assert_not_called()
        (self.journals / "STS3215-1-adapter.json").write_text(signed(good))
        self.session(bus)
        self.assertFalse(self.has_journal())

    def test_a_full_disk_changes_nothing(self):
        def full(file):
            places.append(stat.S_ISDIR(os.fstat(file).st_mode))
            if len(places) > last:
                raise OSError(28, "No space left on device")

        for name in MAKERS:
            for last in (0, 2):
                with self.subTest(name, last=last):
                    own, places = SimulatedServo(MAKERS[name], seed=7, torque=0), []
                    before, goal = dict(own.numbers), {"goal": 0, "position": 0, "load": 0}
                    session = self.session(self.bus(own))
                    with mock.patch("os.fsync", full), self.assertRaises(Fault if last else Refused), session:
                        session.set_gains(session.gains | {"p": 40})
                    self.assertEqual(places, [False, True, False][: last + 1])
                    self.assertEqual(own.numbers | goal, before | goal)
                    self.assertFalse(self.has_journal())


if __name__ == "__main__":
    unittest.main()
