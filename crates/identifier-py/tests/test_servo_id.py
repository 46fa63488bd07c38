"""The package as it is installed: same results as the command line, faults as sentences, pictures, the page's examples."""

import ast
import inspect
import json
import logging
import math
import os
import pickle
import re
import signal
import subprocess
import tempfile
import threading
import time
import tomllib
import unittest
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np

import servo_id
from servo_id import _keywords, _native

ROOT = Path(__file__).resolve().parents[3]
LOG = ROOT / "host-sim/logs/simulated-servo.csv.gz"
SCENARIOS = ROOT / "host-sim/scenarios"
SERVO = {"plant": {"a": 0.5, "b": 180.0, "load": 12.0}, "run": {"duration": 10.0}}


def columns():
    log = servo_id.read_log(LOG)
    return {name: log[name] for name in ("position", "command")}


class OnLine(unittest.TestCase):
    def test_samples_and_arrays_are_the_same_and_near_the_judged_log(self):
        log = columns()
        stated = {"sample_time": 1e-3, "counts_per_rev": 10000, "identifier": {"parameters": ["a", "b", "load"]}}
        by_sample, by_array = (servo_id.Identifier(**stated) for _ in range(2))
        for position, command in zip(log["position"].tolist(), log["command"].tolist()):
            by_sample.learn(position, command)
        for part in range(0, 8000, 1000):
            by_array.learn(log["position"][part : part + 1000], log["command"][part : part + 1000])
        self.assertEqual((by_sample.samples, by_array.samples), (8000, 8000))
        self.assertEqual(by_sample.estimates, by_array.estimates)
        judged = servo_id.identify(log, law="gauss-newton", **stated)
        self.assertEqual(by_array.estimates.keys(), judged.estimates.keys())
        for name, estimate in judged.estimates.items():
            self.assertAlmostEqual(by_array.estimates[name], estimate, delta=0.5 * judged.std_errors[name])
            chance = judged.trace[f"std_error_{name}"][-1]
            self.assertAlmostEqual(by_array.std_errors[name] / chance, 1.0, delta=0.15)
        self.assertEqual(by_array.at_bounds, [])

    def test_coulomb_friction_is_found_unless_it_is_left_out(self):
        stated = {"sample_time": 1e-3, "counts_per_rev": 10000}
        whole, bare = servo_id.Identifier(**stated), servo_id.Identifier(**stated, identifier={"parameters": ["a", "b", "load"]})
        for identifier in (whole, bare):
            identifier.learn(*columns().values())
        self.assertAlmostEqual(whole.estimates["coulomb"], 10.0, delta=3 * whole.std_errors["coulomb"])
        self.assertNotIn("coulomb", bare.estimates)

    def test_a_gap_is_joined_behind_resume(self):
        log = {name: np.delete(column, slice(4000, 4400)) for name, column in columns().items()}
        joined, jumped = (servo_id.Identifier(sample_time=1e-3, counts_per_rev=10000) for _ in range(2))
        for identifier in (joined, jumped):
            identifier.learn(log["position"][:4000], log["command"][:4000])
            if identifier is joined:
                identifier.resume()
            identifier.learn(log["position"][4000:], log["command"][4000:])
        errors = [abs(identifier.estimates["b"] / 257.7 - 1) for identifier in (joined, jumped)]
        self.assertLess(errors[0], 0.005)
        self.assertLess(errors[0], errors[1])

    def test_it_is_fed_from_another_thread(self):
        identifier = servo_id.Identifier(sample_time=1e-3, counts_per_rev=10000)
        log = columns()
        thread = threading.Thread(target=identifier.learn, args=(log["position"], log["command"]))
        thread.start()
        thread.join()
        self.assertEqual(identifier.samples, 8000)

    def test_wrong_input_is_a_sentence(self):
        for keywords, said in [
            ({"sample_time": 1e-3}, "encoder.counts_per_rev"),
            ({"sample_time": 1e-3, "counts_per_rev": 100, "law": "fit"}, "whole log"),
            ({"sample_time": 1e-3, "counts_per_rev": 100, "law": "gradient"}, "controller"),
        ]:
            with self.assertRaises(ValueError) as raised:
                servo_id.Identifier(**keywords)
            self.assertIn(said, str(raised.exception))
        with self.assertRaisesRegex(TypeError, "sample_time"):
            servo_id.Identifier(counts_per_rev=100)
        identifier = servo_id.Identifier(sample_time=1e-3, counts_per_rev=10000)
        for sample, said in [
            ((math.nan, 0.0), "position = NaN"),
            (([0.0, 1e-3], [0.0, math.nan]), "sample 1: command = NaN"),
            (([0.0, 1e-3], [0.0]), "cut them to the same length"),
        ]:
            with self.assertRaises(ValueError) as raised:
                identifier.learn(*sample)
            self.assertIn(said, str(raised.exception))


class Identification(unittest.TestCase):
    def test_a_file_and_its_columns_give_the_same(self):
        of_file = servo_id.identify(LOG)
        self.assertTrue(of_file.converged, of_file.reason)
        self.assertIn("position", dict(of_file.findings))
        of_columns = servo_id.identify(columns(), sample_time=1e-3, counts_per_rev=10000)
        # Stamps have the sample time to the last bit but one.
        for name in of_file.estimates:
            self.assertAlmostEqual(of_file.estimates[name], of_columns.estimates[name], delta=1e-12 * abs(of_file.estimates[name]))
            self.assertAlmostEqual(of_file.std_errors[name], of_columns.std_errors[name], delta=1e-9 * of_file.std_errors[name])
        self.assertAlmostEqual(of_file.estimates["b"], 257.7, delta=2 * of_file.std_errors["b"])

    def test_arrays_of_every_order_and_shape_are_the_same_log(self):
        log = servo_id.read_log(LOG)
        t, q, u = (log[name][:3000] for name in ("time", "position", "command"))
        named = servo_id.identify({"time": t, "position": q, "command": u})
        even = {"sample_time": 1e-3}
        for arrays, stated in [
            ((q, u), even),
            ((u, q), even),
            ((list(q), u[:, None]), even),
            ((t, q, u), {}),
            (([u, q, t],), {}),
            ((np.stack([t, q, u], axis=1),), {}),
            ((np.stack([t, q, u]),), {}),
            ((np.stack([t, q, u], axis=1).tolist(),), {"position": 2, "command": 3}),
            ((np.stack([q, u], axis=1), t), {"time": 3}),
            (((t * 1e9).round().astype("M8[ns]"), q, u), {}),
            ((np.rec.fromarrays([t, q, u], names="t,q,u"),), {}),
            (([{"t": row[0], "q": row[1], "u": row[2]} for row in zip(t, q, u)],), {}),
            (({"name": ["axis"] * len(q), "one": q, "other": u},), {"position": 2, "command": 3, **even}),
        ]:
            with self.subTest(arrays=[type(one).__name__ for one in arrays], **stated):
                found = servo_id.identify(*arrays, **stated)
                self.assertTrue(found.converged, found.reason)
                self.assertAlmostEqual(found.estimates["b"], named.estimates["b"], delta=1e-3)
        rest = [log[name][3000:] for name in ("position", "command")]
        self.assertLess(servo_id.identify(q, u, **even).predict(rest).relative, 0.01)

    def test_an_index_of_a_table_is_its_time_unless_it_counts_rows(self):
        try:
            import pandas
        except ImportError:
            self.skipTest("pandas is not installed")
        log = {name: column[:3000] for name, column in servo_id.read_log(LOG).items()}
        frame = pandas.DataFrame({"q": log["position"], "u": log["command"]})
        seconds = frame.set_index(pandas.Index(log["time"], name="time_s"))
        ms = frame.set_index(pandas.Index(np.arange(3000), name="t [ms]"))
        for table in [
            (seconds,),
            (seconds["q"], seconds["u"]),
            (frame.set_index(pandas.Index(log["time"])),),
            (ms,),
            (ms.rename(columns={"q": "position", "u": "command"}),),
        ]:
            found = servo_id.identify(*table)
            self.assertAlmostEqual(found.estimates["b"], 257.7, delta=0.1)
        for table in [frame, frame.iloc[::2], frame[frame.index % 50 != 3], frame.set_index(pandas.Index(1.0 * frame.index))]:
            with self.assertRaisesRegex(ValueError, "no time column: state"):
                servo_id.identify(table)

    def test_several_files_are_logs_of_one_servo(self):
        found = servo_id.identify(LOG, LOG)
        self.assertEqual([read["samples"] for read in found.json["logs"]], [8000, 8000])
        self.assertTrue(found.converged, found.reason)

    def test_the_surest_time_scale_has_the_gain_of_the_fit(self):
        found = servo_id.identify(LOG)
        surest = min(found.scales, key=lambda scale: scale["std_error"])
        self.assertAlmostEqual(surest["b"], found.estimates["b"], delta=0.02 * surest["b"])

    def test_columns_of_other_names_are_recognised_and_may_have_blanks(self):
        log = columns()
        blank = np.where(np.arange(8000) == 77, np.nan, log["command"])
        found = servo_id.identify({"elbow_angle": log["position"], "elbow_torque": blank}, sample_time=1e-3)
        self.assertAlmostEqual(found.estimates["b"], 257.7, delta=0.5)
        self.assertIn("elbow_angle", dict(found.findings)["position"])

    def test_units_and_single_precision_are_taken(self):
        log = columns()
        degrees = {"position": np.degrees(log["position"]).astype(np.float32), "command": log["command"]}
        found = servo_id.identify(degrees, sample_time=1e-3, counts_per_rev=10000, position_unit="deg")
        self.assertAlmostEqual(found.estimates["b"], 257.7, delta=0.5)
        coarse = np.round(log["position"] / (2 * np.pi / 3000)) * (2 * np.pi / 3000)
        unknown = servo_id.identify(dict(log, position=coarse), sample_time=1e-3, law="gauss-newton")
        self.assertAlmostEqual(unknown.estimates["b"], 257.7, delta=2 * unknown.std_errors["b"])
        every_other = {name: np.repeat(column, 2)[::2] for name, column in log.items()}
        stepped = servo_id.identify(every_other, sample_time=1e-3, counts_per_rev=10000)
        self.assertTrue(stepped.converged)

    def test_nothing_is_in_a_physical_unit_that_nobody_stated(self):
        log = columns()
        for position, unit, stated in [
            (np.round(log["position"] * 10000 / (2 * np.pi)), "counts", {"counts_per_rev": 10000}),
            (np.round(np.degrees(log["position"]), 2), "own units", {"position_unit": "deg"}),
        ]:
            own = {"position": position, "command": log["command"]}
            found = servo_id.identify(own, sample_time=1e-3)
            self.assertEqual((found.position_unit, found.units["b"]), (unit, f"{unit}/s² per command unit"))
            self.assertEqual((found.physical, found.voltage_gains), ({}, {}))
            self.assertIn("counts_per_rev", found.reason.replace("-", "_"))
            self.assertNotIn("rad/s²", repr(found))
            for refused in [
                lambda: servo_id.identify(own, sample_time=1e-3, torque_constant=0.1),
                lambda: servo_id.tune(found),
                lambda: servo_id.tune(found, form="simplefoc"),
                lambda: servo_id.export({"elbow": found}, "mjcf", torque_constant=0.1),
            ]:
                with self.assertRaises(ValueError) as raised:
                    refused()
                self.assertIn("counts_per_rev", str(raised.exception))
            found = servo_id.identify(own, sample_time=1e-3, torque_constant=0.1, **stated)
            self.assertAlmostEqual(found.estimates["b"], 257.7, delta=0.5)
            self.assertAlmostEqual(found.physical["inertia"].value, 0.1 / 257.7, delta=1e-6)

    def test_laws_and_a_trace(self):
        found = servo_id.identify(columns(), sample_time=1e-3, counts_per_rev=10000, law="gauss-newton")
        self.assertEqual(len(found.trace["time"]), len(columns()["position"]))
        self.assertEqual(found.trace["b"][-1], found.json["estimates"]["b"]["value"])
        self.assertEqual(servo_id.identify(LOG, trace=False).trace, {})

    def test_joints_are_identified_each(self):
        log = columns()
        both = {name: np.stack([column, column], axis=1) for name, column in log.items()}
        both["command"][:, 1] *= 2.0
        joints = servo_id.identify_joints(both, names=["hip", "knee"], sample_time=1e-3, counts_per_rev=10000)
        self.assertEqual(list(joints), ["hip", "knee"])
        ratio = joints["hip"].estimates["b"] / joints["knee"].estimates["b"]
        self.assertAlmostEqual(ratio, 2.0, delta=1e-3)
        model = servo_id.export(joints, "mjcf", torque_constant={"hip": 0.1, "knee": 0.2})
        self.assertIn("hip", model)
        self.assertIn("armature", model)

    def test_a_scale_puts_results_in_physical_units(self):
        found = servo_id.identify(
            columns(), sample_time=1e-3, counts_per_rev=10000, torque_constant=0.5, command_unit="V"
        )
        inertia = found.physical["inertia"]
        self.assertAlmostEqual(inertia.value, 0.5 / found.estimates["b"])
        self.assertGreater(inertia.std_error, 0.0)
        self.assertEqual((inertia.unit, found.physical["viscous"].unit), ("kg·m²", "N·m·s/rad"))
        self.assertAlmostEqual(found.voltage_gains["kA"].value, 1 / found.estimates["b"])
        self.assertIn("kg·m²", repr(found))
        joint = json.loads(servo_id.export(found, "json"))["joints"][0]
        self.assertEqual(joint["inertia"]["value"], inertia.value)
        actuator = json.loads(servo_id.export(found, "bam"))
        self.assertEqual((actuator["model"], actuator["kt"]), ("m1", 0.5))

    def test_goals_are_taken_with_the_loop_that_follows_them(self):
        log = columns()
        # The proportional loop whose goal gives this command.
        goal = log["position"] + log["command"] / 20.0
        goals = {"position": log["position"], "goal": goal}
        found = servo_id.identify(goals, sample_time=1e-3, counts_per_rev=10000, kp=20.0)
        expected = servo_id.identify(log, sample_time=1e-3, counts_per_rev=10000)
        self.assertAlmostEqual(found.estimates["b"], expected.estimates["b"], places=6)
        distance = servo_id.identify(goals, sample_time=1e-3, counts_per_rev=10000)
        self.assertAlmostEqual(distance.estimates["b"] / found.estimates["b"], 20.0, places=6)
        both = {name: np.stack([column, column], axis=1) for name, column in goals.items()}
        both["goal"][:, 1] = log["position"] + log["command"] / 40.0
        joints = servo_id.identify_joints(
            both, sample_time=1e-3, counts_per_rev=10000, kp=[20.0, 40.0], command_unit="Nm"
        )
        for joint in joints.values():
            self.assertAlmostEqual(joint.physical["inertia"].value * expected.estimates["b"], 1.0, places=6)
        with self.assertRaisesRegex(ValueError, "2 joints"):
            servo_id.identify_joints(both, sample_time=1e-3, kp=[20.0])
        for wrong, keywords, said in [
            (log, {"kp": 20.0}, "has no goal"),
            (dict(goals, command=goal), {"kp": 20.0}, "goal: a log has either"),
            (goals, {"kp": 20.0, "loop_time": 0.0007}, "whole multiple"),
        ]:
            with self.subTest(said), self.assertRaisesRegex(ValueError, re.escape(said)):
                servo_id.identify(wrong, sample_time=1e-3, **keywords)

    def test_frames_of_a_data_set_are_a_log_per_joint(self):
        log = columns()
        goal = log["position"] + log["command"] / 20.0
        two = lambda column: np.stack([column, column], axis=1).astype(np.float32)
        rows = np.arange(8000)
        frames = {
            "observation.state": two(log["position"]),
            "action": two(goal),
            "timestamp": ((rows % 4000) * 1e-3).astype(np.float32),
            "episode_index": rows // 4000,
        }
        kp = [20.0, 10.0]
        joints = servo_id.identify_joints(frames, kp=kp)
        whole = servo_id.identify(log, sample_time=1e-3)
        one, other = (joint.estimates["b"] for joint in joints.values())
        self.assertAlmostEqual(one / whole.estimates["b"], 1.0, delta=0.01)
        self.assertAlmostEqual(other / one, 2.0, delta=1e-3)
        [read] = joints["joint_0"].json["logs"]
        self.assertEqual(read["samples"], 8000)
        jumbled = dict(frames, episode_index=rows * 0)
        one = servo_id.identify_joints(jumbled, kp=kp)["joint_0"].estimates["b"]
        self.assertAlmostEqual(one / whole.estimates["b"], 1.0, delta=0.01)
        with self.assertRaisesRegex(ValueError, "400 episodes: pass at most 101"):
            servo_id.identify_joints(dict(frames, episode_index=rows // 20), kp=kp)
        with self.assertRaisesRegex(ValueError, "the frames have no timestamp"):
            servo_id.identify_joints({name: frames[name] for name in ("observation.state", "action")}, kp=kp)

    def test_wrong_input_is_a_sentence(self):
        log = columns()
        for wrong, keywords, said in [
            (log, {}, "sample_time is missing"),
            ({"position": log["position"]}, {"sample_time": 1e-3}, "has no command"),
            (dict(log, command=log["command"][:-1]), {"sample_time": 1e-3}, "7999 samples"),
            (dict(log, command=log["command"].astype(str)), {"sample_time": 1e-3}, "type <U32"),
            (dict(log, command=np.stack([log["command"]] * 2)), {"sample_time": 1e-3}, "identify_joints"),
            (log, {"sample_time": 1e-3, "law": "gaus"}, 'there is no "gaus"'),
            (log, {"sample_time": -1e-3}, "sample_time"),
            ({name: column[:5] for name, column in log.items()}, {"sample_time": 1e-3}, "5 samples"),
            ("nothing.csv", {}, "nothing.csv: the log cannot be read"),
            (list(log.values()), {}, "sample_time is missing"),
            ([*log.values(), 1e-3], {}, "0.001 is no column: pass columns of position and command, and one of times or sample_time="),
            ([log["position"], log["command"][1:]], {"sample_time": 1e-3}, "array 2 has 7999 samples"),
            ([log["position"], log["command"].astype(str)], {"sample_time": 1e-3}, "array 2 has the type <U32"),
            ([log["position"]], {"sample_time": 1e-3}, "one column: pass position and command"),
            (np.zeros((3, 3, 3)), {}, "shape (3, 3, 3) is no column: pass"),
            (None, {}, "None is no column: pass"),
            (dict(log, position=log["position"] * np.nan), {"sample_time": 1e-3}, "position is empty: it has no number; leave it out"),
            ({"q": log["position"], "tau": log["command"] * 0}, {"sample_time": 1e-3}, "column tau is constant"),
            ({"q": log["position"], "tau": log["command"] * np.nan}, {"sample_time": 1e-3}, "column tau is empty"),
            (LOG, {"position": "angle"}, "angle"),
        ]:
            with self.subTest(said), self.assertRaisesRegex(ValueError, re.escape(said)):
                servo_id.identify(wrong, **keywords)
        with self.assertRaises(TypeError):
            servo_id.simulate(42)

    def test_keywords_are_known_by_name_and_type(self):
        shown = inspect.signature(servo_id.identify).parameters
        self.assertEqual(shown["counts_per_rev"].annotation, float)
        self.assertIn("deg", get_args(shown["position_unit"].annotation))
        self.assertNotIn("options", shown)
        self.assertIn("wrap: Period after which the position wraps", servo_id.identify.__doc__)
        for call, arguments, near in [
            (servo_id.identify, (LOG,), {"position_units": "rad"}),
            (servo_id.tune, (None,), {"respons_time": 0.1}),
            (servo_id.read_log, (LOG,), {"colour": "red"}),
        ]:
            with self.assertRaisesRegex(TypeError, "position_unit|response_time|colour"):
                call(*arguments, **near)

    def test_keywords_are_the_options_of_the_program(self):
        for typed, options in [
            (_keywords.LogOptions, _native.LOG_OPTIONS),
            (_keywords.JointOptions, _native.LOG_OPTIONS),
            (_keywords.Conditions, _native.CONDITIONS),
        ]:
            self.assertEqual(set(get_type_hints(typed)), set(dict(options)) - {"form", "feed_forward"})

    def test_estimator_and_cuts_are_stated_of_a_file_too(self):
        of_file = servo_id.identify(LOG, law="gauss-newton", counts_per_rev=10000, cut=[[2.0, 3.0]])
        self.assertEqual(of_file.json["law"], "gauss-newton")
        self.assertLess(of_file.json["samples"], 7100)

    def test_a_covariance_is_that_of_the_scatter(self):
        log, random = columns(), np.random.default_rng(5)
        found = []
        for _ in range(40):
            noisy = log["position"] + 2e-3 * random.standard_normal(8000)
            found.append(servo_id.identify(dict(log, position=noisy), sample_time=1e-3, trace=False))
        names = ["a", "b", "coulomb", "load"]
        scatter = np.cov([[result.estimates[name] for result in found] for name in names])
        places = [list(found[0].estimates).index(name) for name in names]
        for result in found:
            covariance, errors = result.covariance, np.array(list(result.std_errors.values()))
            np.testing.assert_allclose(np.sqrt(np.diag(covariance)), errors, rtol=1e-12)
            np.testing.assert_allclose(covariance, covariance.T)
            scaled = covariance / np.outer(errors, errors)
            self.assertGreaterEqual(np.linalg.eigvalsh(scaled).min(), -1e-9)
        own = np.mean([result.covariance[np.ix_(places, places)] for result in found], axis=0)
        # It holds more than chance: what the log leaves open of other effects.
        self.assertGreater((np.diag(own) / np.diag(scatter)).min(), 0.6)
        own, scatter = (one / np.sqrt(np.outer(np.diag(one), np.diag(one))) for one in (own, scatter))
        # Of 40 pairs a correlation is known to 0.16 at most, one standard error.
        self.assertLess(np.abs(own - scatter).max(), 0.45, f"{own}\n{scatter}")
        self.assertGreater(np.abs(scatter - np.eye(4)).max(), 0.6)

    def test_a_log_is_predicted_with_every_effect_that_was_found(self):
        def run(seed):
            plant = {"a": 2.0, "b": 180.0, "coulomb": 6.0, "quadratic_friction": 0.05}
            excitation = {"seed": seed}
            encoder = {"counts_per_rev": 20000}
            done = servo_id.simulate({"plant": plant, "encoder": encoder, "excitation": excitation, "run": {"duration": 8.0}})
            return {name: done.trace[name] for name in ("time", "position", "command")}

        known, other = run(1), run(2)
        result = servo_id.identify(known, counts_per_rev=20000)
        self.assertIn("quadratic-friction", [effect["name"] for effect in result.json["fit"]["effects"]])
        predicted = result.predict(other)
        count = 2 * np.pi / 20000
        self.assertLess(predicted.rms, 0.5 * count)
        self.assertAlmostEqual(predicted.json["open_loop"]["rms"], predicted.rms)
        np.testing.assert_allclose(predicted.position + predicted.residuals, other["position"])
        # A servo is kept with its result.
        self.assertEqual(pickle.loads(pickle.dumps(result)).predict(other).rms, predicted.rms)
        recursive = servo_id.identify(known, counts_per_rev=20000, law="gauss-newton").predict(other)
        self.assertGreater(recursive.rms, 20 * predicted.rms)
        with self.assertRaisesRegex(ValueError, "record a servo that moves"):
            result.predict(dict(other, position=np.zeros_like(other["position"])))
        with self.assertRaisesRegex(ValueError, "no servo"):
            servo_id.simulate(SERVO).predict(other)

    def test_samples_and_residuals_come_as_they_are_measured(self):
        result = servo_id.identify(LOG)
        for function in (servo_id.tune, servo_id.export):
            with self.assertRaisesRegex(TypeError, "no Result"):
                function("res.json")
        known = result.residuals[np.isfinite(result.residuals)]
        self.assertGreater(len(known), 7000)
        self.assertLess(known.std(), 1e-3)
        with self.assertRaisesRegex(ValueError, "trace=True"):
            servo_id.identify(LOG, trace=False).residuals
        try:
            import pandas
        except ImportError:
            self.skipTest("pandas is not installed")
        frame = result.to_pandas()
        self.assertEqual(frame.index.name, "time")
        np.testing.assert_array_equal(frame["output_error"], result.residuals)
        again = servo_id.identify(frame.reset_index()[["time", "position", "command"]], counts_per_rev=10000)
        self.assertAlmostEqual(again.estimates["b"], result.estimates["b"], delta=0.2 * result.std_errors["b"])
        clock = frame.set_index(pandas.to_timedelta(frame.index, unit="s"))[["position", "command"]]
        self.assertAlmostEqual(servo_id.identify(clock).estimates["b"], 257.7, delta=0.5)
        self.assertEqual(len(again.predict(frame.reset_index()).to_pandas()), 8000)


class OtherVerbs(unittest.TestCase):
    def test_results_are_those_of_the_command_line(self):
        program = os.environ.get("SERVO_ID_PROGRAM")
        if not program:
            self.skipTest("SERVO_ID_PROGRAM does not name the program")
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "result.json")
            for verb, call, scenario in [
                ("run", servo_id.simulate, "friction.toml"),
                ("commission", servo_id.commission, "commission.toml"),
            ]:
                words = [program, verb, str(SCENARIOS / scenario), "--quiet", "--force", "--json", str(file)]
                subprocess.run(words, check=True, capture_output=True)
                own, its = call(SCENARIOS / scenario).json, json.loads(file.read_text())
                own.pop("origin"), its.pop("origin")
                self.assertEqual(own, its)

    def test_gains_of_a_log_are_those_of_the_command_line(self):
        program = os.environ.get("SERVO_ID_PROGRAM")
        if not program:
            self.skipTest("SERVO_ID_PROGRAM does not name the program")
        with tempfile.TemporaryDirectory() as folder:
            file = str(Path(folder, "result.json"))
            subprocess.run([program, "identify", str(LOG), "--quiet", "--json", file], check=True)
            words = [program, "tune", file, "--quiet", "--json", "-"]
            its = json.loads(subprocess.run(words, check=True, capture_output=True).stdout)
        own = servo_id.tune(servo_id.identify(LOG)).json
        # How columns were found is in the findings of Python's result, whose scenario states them.
        for column in (*own["reading"].values(), *its["reading"].values()):
            if isinstance(column, dict):
                column.pop("evidence")
        self.assertEqual(own, its)

    def test_a_simulation_is_identified_and_tuned(self):
        result = servo_id.simulate(SERVO)
        self.assertTrue(result.converged)
        self.assertEqual(result.truth["b"], 180.0)
        gains = servo_id.tune(result, response_time=0.05, resonance=float("inf"))
        self.assertAlmostEqual(gains.predicted_response["rise_time"], 0.05, delta=0.002)
        self.assertIsNone(gains.form)
        conditions = {"command_unit": "A", "max_current": 60.0, "resonance": float("inf")}
        form = servo_id.tune(result, form="vesc", response_time=0.5, **conditions).form
        self.assertEqual((form["name"], form["exactness"]), ("vesc", "exact"))
        self.assertEqual(form["parameters"][0]["name"], "p_pid_kp")
        self.assertLess(form["margins"]["sensitivity"], 1.61)
        with self.assertRaisesRegex(ValueError, "for example max_current 60"):
            servo_id.tune(result, form="vesc", command_unit="A", resonance=float("inf"))
        with self.assertRaisesRegex(ValueError, "form must be one of pid, cascade"):
            servo_id.tune(result, form="esc")
        with self.assertRaisesRegex(ValueError, "rise time of"):
            servo_id.tune(result, response_time=1e-5, resonance=float("inf"))
        with self.assertRaisesRegex(ValueError, "two goals"):
            servo_id.tune(result, response_time=0.05, bandwidth=10.0)
        for sentence in (ROOT / "identifier-core/tests/tuning/refusals.txt").read_text().splitlines():
            name, _, value, *_ = sentence.split()
            with self.assertRaisesRegex(ValueError, re.escape(sentence)):
                servo_id.tune(result, **{"resonance": float("inf"), name: float(value)})

    def test_an_unconverged_result_is_not_built_on(self):
        result = servo_id.simulate(dict(SERVO, identifier={"law": "gauss-newton"}, excitation={"kind": "none"}))
        self.assertFalse(result.converged)
        with self.assertRaisesRegex(ValueError, "accept_unconverged=True"):
            servo_id.tune(result)
        with self.assertRaisesRegex(ValueError, "accept_unconverged=True"):
            servo_id.export(result, torque_constant=0.1)

    def test_a_sweep_is_the_same_in_parts(self):
        short = {"plant": {"a": 0.5, "b": 180.0}, "run": {"duration": 2.0}}
        whole = servo_id.sweep(short, 12, seed=3)
        parts = [servo_id.sweep(short, 5, seed=3), servo_id.sweep(short, 7, seed=3, first=5)]
        joined = np.concatenate([part.columns["b"] for part in parts])
        np.testing.assert_array_equal(whole.columns["b"], joined)
        self.assertEqual(list(whole.columns["number"]), list(range(12)))
        self.assertEqual(whole.errors("b").shape, (12,))

    def test_a_sweep_on_a_cluster_is_the_same_though_a_worker_is_lost(self):
        try:
            from distributed import Client, LocalCluster
        except ImportError:
            self.skipTest("dask.distributed is not installed")
        servo = {**SERVO, "identifier": {"law": "gradient"}, "run": {"duration": 4.0}}
        alone = servo_id.sweep(servo, 1500, seed=3, first=5)
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            lost = sorted(client.run(os.getpid).values())[0]
            end = threading.Timer(0.2, os.kill, (lost, signal.SIGKILL))
            end.start()
            shared = servo_id.sweep(servo, 1500, seed=3, first=5, client=client)
            end.join()
            pids = client.run(os.getpid).values()
            client.run(logging.disable)
            with self.assertRaisesRegex(ValueError, "controller"):
                servo_id.sweep({"controler": {}}, 3, client=client)
        self.assertNotIn(lost, pids)
        self.assertEqual(alone.statuses, shared.statuses)
        for name, column in alone.columns.items():
            np.testing.assert_array_equal(column, shared.columns[name])

    def test_other_threads_run_meanwhile(self):
        counted, over = 0, threading.Event()

        def work():
            servo_id.simulate(dict(SERVO, run={"duration": 300.0}), trace=False)
            over.set()

        thread = threading.Thread(target=work)
        thread.start()
        while not over.is_set():
            counted += 1
            time.sleep(0.001)
        thread.join()
        self.assertGreater(counted, 3)

    def test_a_scale_is_stated_once(self):
        result = servo_id.simulate(SERVO)
        for keywords, said in [({}, "torque_constant"), ({"torque_constant": 0.1, "inertia": 1.0}, "is stated twice")]:
            with self.assertRaisesRegex(ValueError, said):
                servo_id.export(result, **keywords)
        with self.assertRaisesRegex(ValueError, "one of mjcf"):
            servo_id.export(result, "step", ratios=True)

    def test_scenarios_are_mappings_too(self):
        text = (SCENARIOS / "friction.toml").read_text()
        of_file = servo_id.simulate(SCENARIOS / "friction.toml", trace=False)
        of_mapping = servo_id.simulate(tomllib.loads(text), trace=False)
        self.assertEqual(of_file.estimates, of_mapping.estimates)
        with self.assertRaisesRegex(ValueError, "plant.bb: there is no such key"):
            servo_id.simulate({"plant": {"bb": 1.0}})
        with self.assertRaisesRegex(TypeError, "value for a scenario"):
            servo_id.simulate({"plant": {"a": object()}})


class Presentation(unittest.TestCase):
    def test_a_result_says_how_its_log_was_read(self):
        log = servo_id.read_log(LOG)
        own = {"t_ms": 1e3 * log["time"], "q_deg": np.degrees(log["position"]), "u": -log["command"], "i_A": 0 * log["time"]}
        result = servo_id.identify({**own, "speed": np.nan * log["time"]})
        reading = result.json["reading"]
        self.assertEqual([reading[name]["unit"] for name in ("time", "position")], ["ms", "deg"])
        # What was found is not what was stated: tune asks for the direction that nobody stated.
        self.assertEqual(reading["command"]["sign"], "inferred")
        with self.assertRaisesRegex(ValueError, "command_sign"):
            servo_id.tune(result)
        for text in (repr(result), result._repr_html_()):
            for part in ["t_ms", "in ms (by name)", "q_deg", "in deg (by name)", "inverted", "i_A is constant, column speed is empty"]:
                self.assertIn(part, text)
        kept = repr(servo_id.Result(result.text))
        self.assertIn("column q_deg, in deg (by name; unit by name)", kept)
        self.assertIn("inverted because the motion goes against it", kept)
        self.assertNotIn("column", repr(servo_id.simulate(SERVO)))

    def test_gains_in_a_form_are_the_parameters_of_that_form(self):
        gains = servo_id.tune(servo_id.simulate(SERVO), form="vesc", command_unit="A", max_current=60.0, resonance=float("inf"))
        first, *rows = repr(gains).splitlines()
        self.assertEqual(first, "vesc:")
        self.assertEqual([row.split()[0] for row in rows], [one["name"] for one in gains.form["parameters"]])
        self.assertIn(f"p_pid_kp = {gains.form['parameters'][0]['value']:.6g}", rows[0])

    def test_text_and_table(self):
        result = servo_id.identify(LOG)
        self.assertIn("converged", repr(result))
        self.assertIn("rad/s² per command unit", result._repr_html_())
        interval = f"{2.0 * result.std_errors['b']:.2g}"
        self.assertIn(f"± {interval} rad/s² per command unit", repr(result))
        self.assertIn(f"<td>{interval}</td>", result._repr_html_())
        self.assertIn("<table>", result._repr_html_())
        self.assertIn("<img", result._repr_html_())
        self.assertNotIn("<img", servo_id.identify(LOG, trace=False)._repr_html_())
        self.assertFalse(math.isnan(result.std_errors["b"]))

    def test_the_picture_is_the_one_that_the_program_draws(self):
        result = servo_id.identify(LOG)
        drawn = result.plot()
        program = os.environ.get("SERVO_ID_PROGRAM")
        if program:
            words = [program, "identify", str(LOG), "--quiet", "--plot", "-"]
            its = subprocess.run(words, check=True, capture_output=True, text=True).stdout
            self.assertEqual(drawn.svg, its)
        for title in ["Position", "Residual", "Friction over inertia", "coherence", "95 %", "Predicted step", "Sensitivity"]:
            self.assertIn(title, drawn.svg)
        with tempfile.TemporaryDirectory() as folder:
            drawn.save(Path(folder, "axis.svg"))
            self.assertEqual(Path(folder, "axis.svg").read_text(encoding="utf-8"), drawn._repr_svg_())
        with self.assertRaisesRegex(ValueError, "trace=True"):
            servo_id.simulate(SERVO, trace=False).plot()

    def test_the_examples_of_the_page_run(self):
        page = (ROOT / "crates/identifier-py/README.md").read_text()
        blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
        self.assertGreater(len(blocks), 1)
        run(blocks)

    def test_the_notebook_runs(self):
        for file in sorted((ROOT / "crates/identifier-py/examples").glob("*.ipynb")):
            cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
            space = run("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
            self.assertTrue(space["result"].converged)
            self.assertLess(space["predicted"].relative, 0.05)


def run(blocks):
    """Runs code in the project's folder, and shows the value of each last line as a notebook does."""
    before, space = os.getcwd(), {}
    os.chdir(ROOT)
    try:
        for block in blocks:
            tree = ast.parse(block)
            last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
            exec(compile(tree, "block", "exec"), space)
            if last:
                value = eval(compile(ast.Expression(last.value), "block", "eval"), space)
                getattr(value, "_repr_html_", value.__repr__)()
    finally:
        os.chdir(before)
    return space


if __name__ == "__main__":
    unittest.main()
