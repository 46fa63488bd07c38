"""Logs that are no text, each as its own library writes it: read, joined and identified; what cannot be read is a sentence."""

import importlib.metadata
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import servo_id
import servo_id.__main__

ROOT = Path(__file__).resolve().parents[3]
LOG = ROOT / "host-sim/logs/simulated-servo.csv.gz"
TRUE_B = 257.7
START = 1_760_000_000_000_000_000
"""ns, a time of today: stamps of that size lose microseconds as float64."""


def needs(module):
    """Skips a test whose library is not installed."""
    try:
        __import__(module)
    except ImportError:
        return unittest.skip(f"skipped: {module} is not installed")
    return lambda test: test


class Logs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.log = servo_id.read_log(LOG)
        cls.stamps = START + np.round(cls.log["time"] * 1e9).astype(np.int64)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def identified(self, log, tolerance=0.01, **stated):
        """That of the log, and of its samples in SI, as they are in memory."""
        at_once = servo_id.identify(log, **stated)
        of_samples = servo_id.identify(servo_id.read_log(log, **stated))
        for found in (at_once, of_samples):
            self.assertTrue(found.converged, found.reason)
            self.assertAlmostEqual(found.estimates["b"] / TRUE_B, 1.0, delta=tolerance)
        return at_once

    def refused(self, log, *said, error=ValueError, **stated):
        """One sentence with the file and what is said."""
        with self.assertRaises(error) as raised:
            servo_id.identify(log, **stated)
        text = str(raised.exception)
        self.assertEqual(text.count("\n"), 0, text)
        for part in said:
            self.assertIn(part, text)
        return text


@needs("rosbags")
class Ros(Logs):
    def bag(self, name, topics, storage="mcap"):
        """A bag of topics: type, and messages with their stamps."""
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_JAZZY)
        path = self.folder / name
        kind = {"mcap": StoragePlugin.MCAP, "db3": StoragePlugin.SQLITE3}[storage]
        with Writer(path, version=9, storage_plugin=kind) as writer:
            for topic, (kind, messages) in topics(store.types).items():
                connection = writer.add_connection(topic, kind, typestore=store)
                for stamp, message in messages:
                    writer.write(connection, int(stamp), store.serialize_cdr(message, kind))
        return path

    def joint_states(self, types, late=0):
        """States of two joints, of which the elbow is the servo and the other half as quick."""
        state, header, time = (
            types[name] for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
        )
        for stamp, position, command in zip(self.stamps.tolist(), self.log["position"], self.log["command"]):
            own = time(sec=stamp // 10**9, nanosec=stamp % 10**9)
            # A drive that did not answer in time leaves a blank.
            position = np.nan if stamp % 10**9 == 5 * 10**8 else position
            values = [np.array([value, 0.5 * value]) for value in (position, command)]
            yield stamp + late, state(
                header=header(stamp=own, frame_id=""),
                name=["elbow", "shoulder"],
                position=values[0],
                velocity=np.array([]),
                effort=np.array([command, command]),
            )

    def test_a_joint_of_both_storages_is_identified(self):
        for storage in ("db3", "mcap"):
            with self.subTest(storage):
                topics = lambda types: {"/joint_states": ("sensor_msgs/msg/JointState", self.joint_states(types, late=10**6))}
                path = self.bag(f"bag-{storage}", topics, storage)
                found = self.identified(path, joint="elbow")
                self.assertEqual(found.json["logs"][0]["samples"], 8000)
                [read] = servo_id._read.columns_of(path, "elbow", ())
                self.assertEqual(list(read), ["time_s", "position", "effort"])
                self.assertAlmostEqual(read["time_s"][1], 1e-3, delta=1e-12)
                [file] = path.glob(f"*.{storage}")
                self.assertEqual(servo_id.identify(file, joint="elbow").estimates, found.estimates)
                self.assertIn("elbow", self.refused(path, "elbow, shoulder", "joint="))
                self.refused(path, "no joint wrist", joint="wrist")

    def test_a_bag_of_ros_1_is_read(self):
        from rosbags.rosbag1 import Writer
        from rosbags.typesys import Stores, get_typestore

        store, kind = get_typestore(Stores.ROS1_NOETIC), "std_msgs/msg/Float64"
        path = self.folder / "old.bag"
        with Writer(path) as writer:
            for topic in ("position", "command"):
                connection = writer.add_connection(f"/elbow/{topic}", kind, typestore=store)
                for stamp, value in zip(self.stamps.tolist(), self.log[topic].tolist()):
                    writer.write(connection, stamp, store.serialize_ros1(store.types[kind](data=value), kind))
        self.assertAlmostEqual(servo_id.identify(path).estimates["b"] / TRUE_B, 1.0, delta=0.01)

    def test_two_topics_are_joined_by_their_stamps(self):
        def topics(types):
            number, state = types["std_msgs/msg/Float64"], types["std_msgs/msg/String"]
            position = zip(self.stamps, map(number, self.log["position"].tolist()))
            # 0.3 ms of a sample behind, as a controller answers.
            command = zip(self.stamps + 300_000, map(number, self.log["command"].tolist()))
            return {
                "/elbow/position": ("std_msgs/msg/Float64", position),
                "/elbow/command": ("std_msgs/msg/Float64", command),
                "/rosout": ("std_msgs/msg/String", [(START, state(data="begun"))]),
            }

        path = self.bag("two", topics)
        [read] = servo_id._read.columns_of(path, None, ())
        self.assertEqual(list(read), ["time_s", "/elbow/position", "/elbow/command"])
        self.assertEqual(len(read["time_s"]), 16000)
        self.assertEqual(np.isnan(read["/elbow/position"]).sum(), 8000)
        self.assertAlmostEqual(read["time_s"][1], 300e-6, delta=1e-12)
        self.identified(path, tolerance=0.03)

    def test_headers_count_beside_messages_without(self):
        def topics(types):
            states = list(self.joint_states(types))[:100]
            # The recorder is late by up to 5 ms.
            late = [(stamp + 10**6 * (number % 6), message) for number, (stamp, message) in enumerate(states)]
            number = types["std_msgs/msg/Float64"]
            commands = [(stamp, number(data=value)) for stamp, value in zip(self.stamps[:100], self.log["command"].tolist())]
            return {
                "/joint_states": ("sensor_msgs/msg/JointState", late),
                "/elbow/command": ("std_msgs/msg/Float64", commands),
            }

        [read] = servo_id._read.columns_of(self.bag("mixed", topics), "elbow", ())
        self.assertEqual(len(read["time_s"]), 100)
        np.testing.assert_array_equal(read["position"], self.log["position"][:100])

    def test_messages_of_a_simulation_have_its_time(self):
        def topics(types):
            # Recorded at half the speed of the simulation.
            slow = [(START + 2 * (stamp - START) - 5 * 10**17, message) for stamp, message in self.joint_states(types)]
            return {"/joint_states": ("sensor_msgs/msg/JointState", slow)}

        self.identified(self.bag("slow", topics), joint="elbow")

    def test_a_bag_without_positions_is_a_sentence(self):
        text = lambda types: {"/rosout": ("std_msgs/msg/String", [(START, types["std_msgs/msg/String"](data="begun"))])}
        self.refused(self.bag("text", text), "/rosout", "/joint_states")
        number = lambda types, values: zip(self.stamps, map(types["std_msgs/msg/Float64"], values))
        one = lambda types: {"/effort": ("std_msgs/msg/Float64", number(types, self.log["command"].tolist()))}
        self.refused(self.bag("one", one), "/effort", "needs the position")
        self.refused(self.folder, "rosbags", "metadata")

    def test_a_newer_format_is_a_sentence(self):
        path = self.bag("new", lambda types: {"/joint_states": ("sensor_msgs/msg/JointState", self.joint_states(types))})
        of_bag = path / "metadata.yaml"
        of_bag.write_text(of_bag.read_text().replace("version: 9", "version: 99"))
        self.refused(path, "99", "pip install --upgrade rosbags")


class OfOthers(Logs):
    @needs("wpiutil")
    def test_a_wpilog_is_joined_by_its_stamps(self):
        from wpiutil import DataLogWriter
        from wpiutil.log import DoubleArrayLogEntry, DoubleLogEntry, StringLogEntry

        path = self.folder / "arm.wpilog"
        writer = DataLogWriter(str(path))
        position, voltage = (DoubleLogEntry(writer, name) for name in ("/arm/position", "/arm/voltage"))
        StringLogEntry(writer, "/state").append("quasistatic", 1)
        pose = DoubleArrayLogEntry(writer, "/pose")
        for number, (angle, volts) in enumerate(zip(self.log["position"], self.log["command"])):
            position.append(angle, 1 + 1000 * number)
            voltage.append(volts, 1 + 1000 * number)
            pose.append([0.0, float(number % 7)], 1 + 1000 * number)
        writer.stop()
        self.identified(path)
        content = bytearray(path.read_bytes())
        content[7] = 2
        path.write_bytes(content)
        self.refused(path, "2.0", "pip install --upgrade robotpy-wpiutil")

    @needs("pyulog")
    def test_a_ulog_is_joined_by_its_stamps(self):
        path = self.folder / "flight.ulg"
        path.write_bytes(ulog(self.log))
        from pyulog import ULog

        # By the library's own writer.
        ULog(str(path)).write_ulog(str(path))
        self.identified(path, position="position", command="control[0]")
        self.identified(path)
        content = path.read_bytes()
        for beginning, said in [(b"ULog\x01\x12\x34\x01", "pyulog"), (b"ULog\x01\x12\x35\x02", "version is 2")]:
            path.write_bytes(beginning + content[8:])
            self.refused(path, said, "pip install --upgrade pyulog")

    @needs("pyarrow")
    def test_frames_of_a_robot_are_a_log_of_a_joint(self):
        import pyarrow
        import pyarrow.parquet

        goal = self.log["position"] + self.log["command"] / 20.0
        two = lambda column: list(np.stack([0.5 * column, column], axis=1))
        rows = np.arange(8000)
        frames = pyarrow.table({
            "observation.state": two(self.log["position"]),
            "action": two(goal),
            "timestamp": (rows % 4000) * 1e-3,
            "frame_index": rows % 4000,
            "episode_index": rows // 4000,
            "task": ["reach"] * 8000,
        })
        path = self.folder / "file-000.parquet"
        pyarrow.parquet.write_table(frames, path)
        found = servo_id.identify(path, joint=1, kp=20.0)
        self.assertAlmostEqual(found.estimates["b"] / TRUE_B, 1.0, delta=0.02)
        again = servo_id.identify(servo_id.read_log(path, joint=1, kp=20.0))
        self.assertAlmostEqual(again.estimates["b"] / TRUE_B, 1.0, delta=0.02)
        self.refused(path, "joints 0, 1", "joint=0")
        plain = self.folder / "plain.parquet"
        pyarrow.parquet.write_table(pyarrow.table({name: self.log[name] for name in ("time", "position", "command")}), plain)
        self.identified(plain)
        pyarrow.parquet.write_table(frames.slice(0, 0), path)
        self.refused(path, "two columns of numbers")

    @needs("scipy")
    def test_arrays_of_matlab_are_columns(self):
        from scipy.io import savemat

        path = self.folder / "axis.mat"
        arrays = {"t": self.log["time"], "q": self.log["position"], "u": self.log["command"], "Ts": 1e-3, "gains": [1.0, 2.0]}
        savemat(path, arrays)
        self.identified(path)
        savemat(path, {"run1": arrays})
        command = re.search(r"-struct', '(\w+)'", self.refused(path, "run1"))
        self.assertEqual(command.group(1), "run1")
        path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM" + bytes(512))
        with mock.patch.dict(sys.modules, {"h5py": None}):
            self.refused(path, "7.3", "pip install h5py")

    @needs("h5py")
    def test_arrays_of_matlab_in_hdf5_are_columns(self):
        from h5py import File

        path = self.folder / "axis.mat"
        with File(path, "w", userblock_size=512) as file:
            for name, values in {"t": "time", "q": "position", "u": "command"}.items():
                file[name] = self.log[values][None, :]
            file["gains"] = [[1.0, 2.0]]
            file["notes/text"] = [1.0]
        with path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
        self.identified(path)
        with File(path, "a") as file:
            for name in ("t", "q", "u"):
                del file[name]
        self.refused(path, "notes: a structure")

    def test_arrays_of_numpy_are_columns(self):
        path = self.folder / "axis.npz"
        np.savez(path, t=self.log["time"], q=self.log["position"][:, None], tau=self.log["command"], gains=np.ones((2, 3)))
        self.identified(path)
        np.savez(path, q=np.array([{}]))
        self.refused(path, "numpy")
        np.savez(path, q=self.log["position"], u=self.log["command"][1:])
        self.refused(path, "the same length")

    def test_records_and_lists_of_json_are_columns(self):
        path = self.folder / "axis.json"
        lists = {name: self.log[name].tolist() for name in ("time", "position", "command")}
        path.write_text(json.dumps(lists))
        self.identified(path)
        records = [dict(zip(lists, row)) for row in zip(*lists.values())]
        del records[5]["position"]
        path.write_text(json.dumps(records))
        self.identified(path)
        for text, said in [("[[1, 2]]", "list of records"), ("{", "write the file again"), ("", "empty"), ("[]", "two columns")]:
            path.write_text(text)
            self.refused(path, said)
        self.refused(self.folder / "none.json", "no such file")

    def test_all_tests_of_a_sysid_file_are_one_servo(self):
        def course(volts, seed, begin):
            """Rows of time, voltage, position and velocity: kS 0.3 V, kV 2 V/(turn/s), kA 0.1 V/(turn/s²)."""
            noise = 5e-4 * np.random.default_rng(seed).standard_normal(len(volts))
            position = velocity = 0.0
            for row, voltage in enumerate(volts):
                yield [begin + 5e-3 * row, voltage, position + noise[row], velocity]
                for _ in range(25):
                    drive = voltage - 2.0 * velocity
                    friction = 0.3 * np.sign(velocity) if velocity else np.clip(drive, -0.3, 0.3)
                    after = velocity + (drive - friction) / 0.1 * 2e-4
                    velocity = 0.0 if after * velocity < 0.0 else after
                    position += velocity * 2e-4

        ramp, step = np.arange(0.0, 5.0, 0.01), np.repeat([0.0, 7.0], [4, 150])
        tests = {"slow-forward": ramp, "slow-backward": -ramp, "fast-forward": step, "fast-backward": -step}
        tests = {name: list(course(volts, seed, 10.0 * seed)) for seed, (name, volts) in enumerate(tests.items())}
        path = self.folder / "sysid_data.json"
        write = lambda **own: path.write_text(json.dumps({"sysid": True, "test": "Simple", **tests, **own}))
        write(units="Rotations", unitsPerRotation=1.0)
        found = servo_id.identify(path)
        self.assertEqual([log["samples"] for log in found.json["logs"]], [500, 500, 154, 154])
        self.assertEqual((found.position_unit, found.units["b"]), ("rad", "rad/s² per command unit"))
        turn = {name: found.voltage_gains[name].value * factor for name, factor in [("kS", 1), ("kV", 2 * np.pi), ("kA", 2 * np.pi)]}
        for name, truth in [("kS", 0.3), ("kV", 2.0), ("kA", 0.1)]:
            self.assertAlmostEqual(turn[name] / truth, 1.0, delta=0.02)
        self.assertEqual(len(servo_id.read_log(path)["time"]), 1308)
        self.assertLess(found.predict(path).relative, 0.01)
        write(units="Meters", unitsPerRotation="0.5")
        self.assertAlmostEqual(servo_id.identify(path).voltage_gains["kV"].value, 4.0, delta=0.08)
        write(**{name: [] for name in list(tests)[:2]})
        self.assertEqual([log["samples"] for log in servo_id.identify(path).json["logs"]], [154, 154])
        sides = {name: [[t, u, 2 * u, q, q, v, v, 0, 0] for t, u, q, v in rows] for name, rows in tests.items()}
        write(**sides)
        self.refused(path, "joints left, right", "joint=left")
        self.assertAlmostEqual(servo_id.identify(path, joint="right").voltage_gains["kV"].value * np.pi, 2.0, delta=0.04)
        write(**{"slow-forward": [[0.0, 1.0, 2.0]] * 20})
        self.refused(path, "slow-forward is no table of SysId: write 4 numbers a row")

    @needs("pandas")
    def test_data_frames_go_in_and_out(self):
        import pandas

        frame = pandas.DataFrame(servo_id.read_log(LOG))
        self.assertEqual(list(frame), ["time", "position", "command"])
        self.identified(frame)
        own = frame.rename(columns={"position": "elbow_angle", "command": "elbow_torque"}).drop(columns="time")
        own.index = pandas.to_datetime(self.stamps)
        self.assertEqual(dict(servo_id._read.shaped(own))["time_s"][1], 1e-3)
        self.identified(own)
        strict = servo_id.identify(frame[["position", "command"]], sample_time=1e-3, law="gauss-newton")
        self.assertEqual(len(pandas.DataFrame(strict.trace)), 8000)


class Joined(Logs):
    def series(self, count, topics=("/arm", "/leg")):
        stamps = np.arange(4)
        number = lambda place: np.full(4, np.nan) if place == 1 else np.array([0.0, place, np.nan, np.inf])
        return [servo_id._read.Series(topic, f"s{place}", None, stamps, number(place)) for topic in topics for place in range(count)]

    def test_series_have_their_own_names_where_these_are_one(self):
        read = servo_id._read._joined(self.series(4, ["/arm"]), None, ())
        self.assertEqual(list(read), ["time_s", "s2", "s3"], "those that change")
        read = servo_id._read._joined(self.series(3), None, ())
        self.assertEqual(list(read), ["time_s", "/arm.s2", "/leg.s2"])

    def test_of_many_series_two_are_stated(self):
        many = self.series(30)
        with self.assertRaisesRegex(servo_id._read.Fault, "56 series.*/arm.s7"):
            servo_id._read._joined(many, None, ("/arm.s7",))
        read = servo_id._read._joined(many, None, ("/arm.s7", "/leg.s9"))
        self.assertEqual(list(read), ["time_s", "/arm.s7", "/leg.s9"])

    def test_an_empty_file_of_every_kind_is_a_sentence(self):
        for suffix in (*servo_id._read._KINDS, ".csv"):
            path = self.folder / f"log{suffix}"
            path.touch()
            self.refused(path, "empty", "record" if suffix != ".csv" else "a row")


class Pages(Logs):
    def python(self, *words):
        words = [sys.executable, "-m", "servo_id", *map(str, words)]
        return subprocess.run(words, capture_output=True, encoding="utf-8", env=self.environment())

    def environment(self):
        """One without a terminal's width."""
        return {name: value for name, value in os.environ.items() if name != "COLUMNS"} | {"PYTHONUTF8": "1"}

    def test_the_page_is_that_of_the_program(self):
        program = os.environ.get("SERVO_ID_PROGRAM")
        if not program:
            self.skipTest("SERVO_ID_PROGRAM does not name the program")
        for words in [[], ["--torque-constant", "0.5"]]:
            own = self.python("identify", LOG, *words)
            its = [program, "identify", LOG, *words]
            its = subprocess.run(its, capture_output=True, encoding="utf-8", env=self.environment())
            self.assertEqual((own.returncode, own.stdout), (0, its.stdout))

    def test_the_command_that_the_program_names_identifies_the_file(self):
        program = os.environ.get("SERVO_ID_PROGRAM")
        if not program:
            self.skipTest("SERVO_ID_PROGRAM does not name the program")
        path = self.folder / "an axis.npz"
        np.savez(path, **{name: self.log[name] for name in ("time", "position", "command")})
        refused = [program, "identify", path]
        refused = subprocess.run(refused, capture_output=True, encoding="utf-8", env=self.environment())
        self.assertEqual(refused.returncode, 2)
        file = re.search(r'python -m servo_id identify "(.*)"', " ".join(refused.stderr.split())).group(1)
        page = self.python("identify", file)
        self.assertEqual(page.returncode, 0, page.stderr)
        self.assertIn("converged", page.stdout)

    def test_help_lists_all_commands(self):
        found = self.python("--help").stdout
        for verb in ("identify", "capture", "tune-servo"):
            self.assertRegex(found, rf"(?m)^ +{verb}\b")
            own = self.python(verb, "--help")
            self.assertEqual(own.returncode, 0, own.stderr)
            self.assertRegex(own.stdout, f"^usage: python -m servo_id {verb} ")
        self.assertIn("--position-unit", self.python("identify", "--help").stdout)

    def test_a_negative_number_is_a_value(self):
        options = servo_id.__main__.options(["identify", "axis.csv", "--command-scale", "-1e-3"])
        self.assertEqual(float(options.command_scale), -1e-3)

    def test_wrong_words_are_a_sentence(self):
        for words in [["identify", "none.db3"], ["identify", LOG, "--colour", "red"], ["identify", LOG, "--colour"], ["tune", LOG]]:
            found = self.python(*words)
            self.assertEqual((found.returncode, found.stdout), (2, ""), words)
            self.assertIn("error: ", found.stderr)


class Extras(Logs):
    def test_a_missing_library_is_named_with_the_command_that_installs_it(self):
        modules = {
            "a.db3": "rosbags.highlevel",
            "a.mcap": "rosbags.highlevel",
            "a.wpilog": "wpiutil.log",
            "a.ulg": "pyulog",
            "a.parquet": "pyarrow.parquet",
            "a.mat": "scipy.io",
        }
        needed = importlib.metadata.requires("servo-id")
        for name, module in modules.items():
            path = self.folder / name
            path.write_bytes(b"something")
            with self.subTest(name), mock.patch.dict(sys.modules, {module: None}):
                text = self.refused(path, "pip install", error=ImportError)
                [library] = re.search(r"needs ([\w-]+): pip install \1$", text).groups()
                [extra] = [re.search(r"extra == .(\w+)", one)[1] for one in needed if re.match(rf"{library}\W", one)]
                installed = subprocess.run(
                    [sys.executable, "-m", "pip", "install", "--dry-run", "--no-index", f"servo-id[{extra}]"],
                    capture_output=True,
                    encoding="utf-8",
                )
                try:
                    importlib.metadata.version(library)
                except importlib.metadata.PackageNotFoundError:
                    continue
                self.assertEqual(installed.returncode, 0, installed.stderr)
                self.assertNotIn("does not provide the extra", installed.stderr)


def ulog(log):
    """A ULog of positions and of the control of two motors, with stamps of their own."""
    import struct

    record = lambda kind, content: struct.pack("<Hc", len(content), kind) + content
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1), record(b"B", bytes(40))]
    for text in [
        b"servo_state:uint64_t timestamp;float position;uint8_t mode;",
        b"actuator_motors:uint64_t timestamp;uint64_t timestamp_sample;float[2] control;",
    ]:
        parts.append(record(b"F", text))
    parts += [record(b"A", struct.pack("<BH", 0, number) + name) for number, name in enumerate([b"servo_state", b"actuator_motors"])]
    for number, (position, command) in enumerate(zip(log["position"], log["command"])):
        stamp = 1000 * number
        parts.append(record(b"D", struct.pack("<HQfB", 0, stamp, position, 1)))
        parts.append(record(b"D", struct.pack("<HQQff", 1, stamp, stamp, command, 0.0)))
    return b"".join(parts)


if __name__ == "__main__":
    unittest.main()
