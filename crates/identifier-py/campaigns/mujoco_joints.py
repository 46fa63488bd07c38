"""Twelve joints of MuJoCo under its own position actuators: identified from position and goal, exported as MJCF, simulated
again. Needs `pip install mujoco` beside this package; docs/measurements.md has the results.

    python mujoco_joints.py [--seed N] [--sharp]

MuJoCo is a simulator that nobody here wrote. Each joint has an armature, a damping and a frictionloss; physics run at 1 kHz,
positions are those of an encoder of 4096 counts, and logs of 20 s have every row or every fifth. `--sharp` simulates
frictionloss nearly without MuJoCo's regularisation (solreffriction, solimpfriction), which is not part of the model.
"""

import argparse
import time

import mujoco
import numpy as np

import servo_id

JOINTS = 12
STEP = 1e-3  # s, of the physics
DURATION = 20.0  # s
COUNTS = 4096  # of the encoder's revolution
# Natural frequency, rad/s, and damping ratio by the actuator, of the joint with its position actuator.
GAIN_SETS = {"soft": (10.0, 0.3), "damped": (18.0, 0.7), "stiff, kv = 0": (30.0, 0.0)}
ALLOWED = {"armature": 0.03, "damping": 0.03, "frictionloss": 0.05}
REPEATABLE = {"armature": 0.02, "damping": 0.05, "frictionloss": 0.03}


class Joints:
    """The joints with their gains, and what they are driven by."""

    def __init__(self, seed: int, gains: str, integrator: str, friction: str):
        random = np.random.default_rng(seed)
        armature = np.exp(random.uniform(np.log(0.005), np.log(0.2), JOINTS))
        self.truth = {
            "armature": armature,
            "damping": armature * random.uniform(1.0, 8.0, JOINTS),
            "frictionloss": armature * random.uniform(2.0, 15.0, JOINTS),
        }
        frequency, ratio = GAIN_SETS[gains]
        self.kp = armature * frequency**2
        self.kv = armature * 2.0 * ratio * frequency
        self.limit = armature * 400.0
        self.integrator = integrator
        self.friction = friction

    def model(self, defaults: str = "") -> mujoco.MjModel:
        """The true joints, or those of an exported model's default classes."""

        def joint(number: int) -> str:
            if defaults:
                return f'class="joint_{number}"'
            return " ".join(f'{name}="{values[number]}"' for name, values in self.truth.items())

        bodies = "".join(
            f'<body><joint name="joint_{number}" axis="0 0 1" {self.friction} {joint(number)}/>'
            '<geom size="0.01" mass="1e-6"/></body>'
            for number in range(JOINTS)
        )
        actuators = "".join(
            f'<position joint="joint_{number}" kp="{self.kp[number]}" kv="{self.kv[number]}" '
            f'forcerange="-{self.limit[number]} {self.limit[number]}"/>'
            for number in range(JOINTS)
        )
        return mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{STEP}" integrator="{self.integrator}" gravity="0 0 0">'
            f'<flag contact="disable"/></option>{defaults}<worldbody>{bodies}</worldbody>'
            f"<actuator>{actuators}</actuator></mujoco>"
        )


def goals(seed: int, sample_time: float) -> np.ndarray:
    """Steps every half second with two sines, rad, as a policy or an operator may give them."""
    random = np.random.default_rng(1000 + seed)
    time_ = np.arange(round(DURATION / sample_time))[:, None] * sample_time
    steps = random.uniform(-0.5, 0.5, (round(DURATION / 0.5), JOINTS))
    phases = random.uniform(0.0, 2.0 * np.pi, (2, JOINTS))
    held = np.repeat(steps, round(0.5 / sample_time), axis=0)
    tones = 0.3 * np.sin(4.4 * time_ + phases[0]) + 0.2 * np.sin(11.9 * time_ + phases[1])
    return held + tones


def motion(model: mujoco.MjModel, goal: np.ndarray, sample_time: float) -> np.ndarray:
    """The positions of the joints at the rows of their goals, rad."""
    data = mujoco.MjData(model)
    positions = np.empty_like(goal)
    for row, controls in enumerate(goal):
        positions[row] = data.qpos
        data.ctrl[:] = controls
        mujoco.mj_step(model, data, round(sample_time / STEP))
    return positions


def defaults_of(exported: str) -> str:
    """The default classes of an exported model, to stand in another one."""
    return exported.split("<mujoco>")[1].split("</mujoco>")[0]


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--seed", type=int, default=7)
    options.add_argument("--sharp", action="store_true")
    stated = options.parse_args()
    friction = 'solreffriction="0.004 1" solimpfriction="0.99 0.99 0.001"' if stated.sharp else ""
    print(f"MuJoCo {mujoco.__version__}, servo-id {servo_id.__version__}, seed {stated.seed}")
    errors = {name: [] for name in ALLOWED}
    spreads = {name: [] for name in ALLOWED}
    for integrator in ("implicitfast", "Euler"):
        for sample_time in (0.005, 0.001):
            found = {name: [] for name in ALLOWED}
            for number, gains in enumerate(GAIN_SETS):
                joints = Joints(stated.seed, gains, integrator, friction)
                goal = goals(stated.seed + number, sample_time)
                exact = motion(joints.model(), goal, sample_time)
                count = 2.0 * np.pi / COUNTS
                began, spent = time.perf_counter(), time.process_time()
                results = servo_id.identify_joints(
                    {"position": np.round(exact / count) * count, "goal": goal},
                    sample_time=sample_time,
                    counts_per_rev=COUNTS,
                    kp=joints.kp,
                    kd=joints.kv,
                    limit=joints.limit,
                    loop_time=STEP,
                    integrator="euler" if integrator == "Euler" else "implicit",
                    command_unit="Nm",
                )
                seconds = time.perf_counter() - began, time.process_time() - spent
                converged = sum(result.converged for result in results.values())
                again = joints.model(defaults_of(servo_id.export(results, "mjcf", accept_unconverged=True)))
                difference = motion(again, goal, sample_time) - exact
                relative = np.sqrt((difference**2).mean(0)) / exact.std(0)
                for name in ALLOWED:
                    own = getattr(again, f"dof_{name}")
                    found[name].append(own)
                    errors[name].append(own / joints.truth[name] - 1.0)
                largest = ", ".join(f"{name} {100 * np.abs(errors[name][-1]).max():.1f}" for name in ALLOWED)
                print(
                    f"{integrator}, {1 / sample_time:.0f} Hz, {gains}: {converged} of {JOINTS} converged in "
                    f"{seconds[0]:.1f} s ({seconds[1]:.1f} s of processor); largest error, %: {largest}; motion simulated "
                    f"again off by {100 * np.median(relative):.1f} % (largest {100 * relative.max():.1f})",
                    flush=True,
                )
            for name, own in found.items():
                spreads[name].append(np.std(own, axis=0, ddof=1) / np.mean(own, axis=0))
    for name, allowed in ALLOWED.items():
        off, spread = np.abs(np.concatenate(errors[name])), np.concatenate(spreads[name])
        print(
            f"{name}: {100 * (off <= allowed).mean():.1f} % of {off.size} within {100 * allowed:.0f} %, median error "
            f"{100 * np.median(off):.2f} %, largest {100 * off.max():.2f} %; standard deviation over the gain sets: median "
            f"{100 * np.median(spread):.2f} %, largest {100 * spread.max():.2f} % (asked: {100 * REPEATABLE[name]:.0f} %)"
        )


if __name__ == "__main__":
    main()
