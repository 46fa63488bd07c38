"""Mechanisms of robots in competitions, logged at 50 Hz with a voltage that sags: kS, kV and kA after 5 s, of the tests of
WPILib's SysId and of driving.
docs/measurements.md has the results.

    python feed_forward.py [--seed N]

The simulation is this file's own, at 1 kHz: a motor with a winding resistance at a battery of 12.6 V and 20 mΩ behind a bridge
whose duty changes every 20 ms, and a rotation by an encoder of 2048 counts. Each row has the position and the voltage at
the motor as a robot program reads them at its beginning: duty times the battery's voltage just then.
"""

import argparse
from collections.abc import Callable

import numpy as np

import servo_id

MECHANISMS = 40
PERIOD, STEP, DURATION = 0.02, 1e-3, 5.0  # s
COUNTS = 2048


def drawn(random: np.random.Generator) -> dict[str, float]:
    """kS in V, kV in V·s/rad and kA in V·s²/rad, with the current of a volt, A."""
    kv = random.uniform(0.1, 0.4)
    return {
        "kS": random.uniform(0.1, 0.4),
        "kV": kv,
        "kA": kv * random.uniform(0.08, 0.5),
        "resistance": random.uniform(0.03, 0.1),
    }


def sysid(random: np.random.Generator) -> np.ndarray:
    """The duty of each row in SysId's four tests: slow ramps forwards and backwards, and a step each way."""
    ramp = np.linspace(0.0, 0.4, round(1.5 / PERIOD))
    step = np.full(round(1.0 / PERIOD), 0.6)
    return np.concatenate([ramp, -ramp, step, -step])


def driving(random: np.random.Generator) -> np.ndarray:
    """The duty of a driver who changes it every quarter of a second."""
    levels = random.uniform(-0.8, 0.8, round(DURATION / 0.25))
    return levels[np.arange(round(DURATION / PERIOD)) * len(levels) // round(DURATION / PERIOD)]


def moved(own: dict[str, float], duties: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position, rad, and voltage of each row under duties, which change by 0.2 in a row at most."""
    rows, steps = len(duties), round(PERIOD / STEP)
    position = velocity = 0.0
    positions, voltages = np.empty(rows), np.empty(rows)
    for row, wanted in enumerate(duties):
        duty = wanted if row == 0 else duty + np.clip(wanted - duty, -0.2, 0.2)
        for step in range(steps):
            # U = 12.6 − 0.02 duty i and i = (duty U − kV v)/R.
            r = own["resistance"]
            battery = (12.6 + 0.02 * duty * own["kV"] * velocity / r) / (1.0 + 0.02 * duty**2 / r)
            voltage = duty * battery
            if step == 0:
                count = 2.0 * np.pi / COUNTS
                positions[row], voltages[row] = np.round(position / count) * count, voltage
            rest = voltage - own["kV"] * velocity
            if velocity == 0.0 and abs(rest) <= own["kS"]:
                continue
            sign = np.sign(velocity) or np.sign(rest)
            after = velocity + STEP * (rest - own["kS"] * sign) / own["kA"]
            after = 0.0 if after * sign < 0.0 else after
            position += 0.5 * STEP * (velocity + after)
            velocity = after
    return positions, voltages


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--seed", type=int, default=1)
    seed = options.parse_args().seed
    print(f"servo-id {servo_id.__version__}")
    for course in (sysid, driving):
        report(course, np.random.default_rng(seed))


def report(course: Callable[[np.random.Generator], np.ndarray], random: np.random.Generator) -> None:
    """Identifies the mechanisms under a course of duties and prints the errors."""
    names = ("kS", "kV", "kA")
    errors, converged = [], 0
    for _ in range(MECHANISMS):
        own = drawn(random)
        position, voltage = moved(own, course(random))
        found = servo_id.identify(
            {"position": position, "command": voltage},
            sample_time=PERIOD, counts_per_rev=COUNTS, command_unit="V", trace=False,
        )
        converged += found.converged
        errors.append([found.voltage_gains[name].value / own[name] - 1.0 for name in names])
    print(f"{course.__name__}: {converged} of {MECHANISMS} converged")
    for name, off in zip(names, 100.0 * np.abs(np.array(errors)).T):
        print(
            f"  {name}: {100 * (off <= 2.0).mean():.0f} % within 2 %; median {np.median(off):.2f} %, 90th percentile "
            f"{np.quantile(off, 0.9):.2f} %, largest {off.max():.2f} %"
        )


if __name__ == "__main__":
    main()
