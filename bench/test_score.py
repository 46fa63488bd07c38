"""The scores against closed forms, and a quick run: `python bench/test_score.py`."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import model
import score
import worker
from logs import Log
from rivals import Found

STEP = 1e-3


def servo(command, a=3.0, b=200.0, c=0.0, d=0.0, delay=0.0):
    command = np.asarray(command, dtype=float)
    positions = model.simulate(a, b, c, d, delay, 0.0, 0.0, command, STEP)
    truth = {name: [value] * 2 for name, value in {"a": a, "b": b, "c": c, "d": d}.items()}
    return Log("test", "test", STEP, positions, command, truth)


class Model(unittest.TestCase):
    def test_a_step_without_friction_is_the_closed_form(self):
        log = servo(np.ones(2000))
        time = np.arange(2000) * STEP
        expected = 200 / 3 * time - 200 / 9 * (1 - np.exp(-3 * time))
        np.testing.assert_allclose(log.position, expected, rtol=1e-9, atol=1e-12)

    def test_friction_stops_a_servo_where_its_energy_ends(self):
        log = servo(np.concatenate([np.ones(100), np.zeros(900)]), a=0.0, c=50.0)
        # 150 rad/s² for 0.1 s, then 50 rad/s² against 15 rad/s.
        self.assertAlmostEqual(log.position[-1], 0.5 * 150 * 0.01 + 15**2 / 100, places=9)

    def test_a_delay_shifts_the_motion(self):
        command = np.random.default_rng(1).normal(size=500)
        plain, late = servo(command), servo(np.concatenate([[command[0]] * 3, command[:-3]]))
        np.testing.assert_allclose(servo(command, delay=3.0).position, late.position)
        halfway = 0.5 * (servo(np.ones(50), delay=0.0).position + servo(np.ones(50), delay=1.0).position)
        np.testing.assert_allclose(servo(np.ones(50), delay=0.5).position, halfway, atol=1e-4)
        self.assertGreater(np.abs(plain.position - late.position).max(), 1e-3)

    def test_the_true_servo_predicts_itself_and_another_does_not(self):
        command = 0.5 * np.sin(np.arange(3000) * 0.01) + 0.2 * np.sin(np.arange(3000) * 0.037)
        log = servo(command, c=5.0, d=2.0)
        values = {name: log.truth[name][0] for name in log.truth}
        right = model.free_run_error(model.physical(values, log.command, STEP), log)
        wrong = model.free_run_error(model.physical({**values, "b": 210.0}, log.command, STEP), log)
        self.assertLess(right, 1e-6)
        self.assertGreater(wrong, 1e-3)

    def test_a_linear_model_gives_its_servo_back(self):
        a, b = 3.0, 200.0
        decay = np.exp(-a * STEP)
        A = np.array([[1.0, (1 - decay) / a], [0.0, decay]])
        B = b * np.array([(STEP - (1 - decay) / a) / a, (1 - decay) / a])
        linear = (A, B, np.array([1.0, 0.0]), 0.0, 0.0, 0.0)
        log = servo(np.random.default_rng(2).normal(size=4000).cumsum() * 0.01, a, b)
        found = model.servo_of(linear, log)
        self.assertAlmostEqual(found["a"] / a, 1.0, places=2)
        self.assertAlmostEqual(found["b"] / b, 1.0, places=2)
        self.assertLess(model.linear_error(linear, log), 1e-6)


class Scores(unittest.TestCase):
    def judged(self, errors=None, **values):
        log = servo(np.sin(np.arange(1000) * 0.02), c=5.0)
        return score.against_truth(Found({"a": 3.0, "b": 200.0, "c": 5.0, "d": 0.0, **values}, errors or {}), log)

    def test_right_is_within_two_per_cent_of_b(self):
        self.assertTrue(self.judged(b=203.9)["right"])
        self.assertFalse(self.judged(b=204.1)["right"])
        self.assertAlmostEqual(self.judged(b=210.0)["error_of_b"], 0.05)

    def test_a_standard_error_widens_the_tolerance_by_four_at_most(self):
        self.assertTrue(self.judged({"b": 5.0}, b=214.0)["right"])
        self.assertFalse(self.judged({"b": 50.0}, b=217.0)["right"])

    def test_an_interval_is_counted_where_there_is_an_error(self):
        judged = self.judged({"a": 1.0, "b": 1.0, "c": 0.1}, b=201.9, c=5.3)
        self.assertEqual((judged["covered"], judged["intervals"]), (2, 3))

    def test_what_a_method_raises_is_a_row(self):
        class Rival:
            @staticmethod
            def fit(log):
                raise ArithmeticError("no")

        row = score.scored(Rival, servo(np.ones(100)), 5)
        self.assertEqual(row["failed"], "ArithmeticError: no")

    def test_lines_are_those_with_code(self):
        self.assertEqual(worker.lines('"""Text."""\n\n# why\nx = (\n    1\n)\n'), 3)


class Quick(unittest.TestCase):
    def test_a_quick_run_writes_its_page(self):
        with tempfile.TemporaryDirectory() as folder:
            run = [sys.executable, str(Path(__file__).parent / "run.py"), "--quick", "--out", folder]
            subprocess.run(run, check=True, capture_output=True)
            page = (Path(folder) / "RESULTS.md").read_text()
        self.assertIn("| servo-id identify | 2 of 2 |", page)


if __name__ == "__main__":
    unittest.main()
