"""CPU time of a million samples, ms, the least of five runs: identified and judged whole, and on line."""

import time

import numpy as np

import servo_id

SAMPLES = 1_000_000
SAMPLE_TIME = 1e-3  # s
COUNTS_PER_REV = 10_000


def log():
    """A servo that follows random steps, computed here: the simulator's would be the package's own."""
    a, b = 0.5, 200.0
    decay, count = np.exp(-a * SAMPLE_TIME), 2 * np.pi / COUNTS_PER_REV
    goals = np.repeat(np.random.default_rng(1).uniform(-1, 1, SAMPLES // 500), 500)
    angle, speed = 0.0, 0.0
    position, command = np.empty(SAMPLES), np.empty(SAMPLES)
    for sample, goal in enumerate(goals.tolist()):
        position[sample] = count * round(angle / count)
        command[sample] = 10.0 * (goal - position[sample]) - 0.8 * speed
        steady = b * command[sample] / a
        angle += steady * SAMPLE_TIME + (speed - steady) * (1 - decay) / a
        speed = steady + (speed - steady) * decay
    return {"position": position, "command": command}


def least(run):
    times = []
    for _ in range(5):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return 1e3 * min(times)


samples = log()
stated = {"sample_time": SAMPLE_TIME, "counts_per_rev": COUNTS_PER_REV}
correction = {"kp": 9.0, "kd": 0.19, "ki": 4.0}
gradient = {
    "law": "gradient",
    "identifier": {"correction": correction, "gamma": [20.0, 3000.0], "servo_range": {"a": [0.0, 10.0], "b": [100.0, 400.0]}},
}
for name, keywords in [("fit", {"law": "fit"}), ("gauss-newton", {"law": "gauss-newton"}), ("gradient", gradient)]:
    took = least(lambda: servo_id.identify(samples, trace=False, **stated, **keywords))
    print(f"identify, {name}: {took:.0f} ms")
for name, keywords in [("gauss-newton", {}), ("gradient", gradient)]:
    took = least(lambda: servo_id.Identifier(**stated, **keywords).learn(samples["position"], samples["command"]))
    print(f"Identifier, {name}: {took:.0f} ms")
