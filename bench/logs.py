"""The logs: drawn servos, joints of MuJoCo, measured logs, and those of a folder. Each is a CSV file and what is known of it."""

import csv
import json
import os
import pickle
import subprocess
import urllib.request
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

HEADING = ["time_s", "position_rad", "command"]
GO2 = "https://raw.githubusercontent.com/iit-DLSLab/sim2real-robot-identification/main/datasets/go2/traj_0.pt"
GO2_GAINS = (20.0, 1.5)  # N·m/rad and N·m s/rad of the robot's own position loop


@dataclass
class Log:
    """Samples in SI and even time. `truth` has a range of a, b, c and d each, where it is known."""

    name: str
    group: str
    step: float
    position: np.ndarray
    command: np.ndarray
    truth: dict = field(default_factory=dict)
    effects: list = field(default_factory=list)
    file: str = ""

    def part(self, rows, name):
        """Some of its rows as a log of its own, beside its file."""
        return Log(self.name + name, self.group, self.step, self.position[rows], self.command[rows], file=self.file).kept(
            Path(self.file).parent
        )

    def kept(self, folder):
        """Writes the CSV file that programs read."""
        self.file = str(Path(folder) / f"{self.name}.csv")
        times = np.arange(len(self.position)) * self.step
        rows = np.column_stack([times, self.position, self.command])
        np.savetxt(self.file, rows, "%.9g", ",", header=",".join(HEADING), comments="")
        return self


def drawn(program, folder, seed, number, effects=None, rows=None):
    """A servo with drawn values under a drawn controller, by `servo-id run`; one that moves too little is drawn again."""
    random = np.random.default_rng([seed, number])
    folder = Path(folder) / f"{seed}-{number}"
    folder.mkdir()
    for _ in range(100):
        setup = Setup(random, rows)
        count = random.integers(0, 6) if effects is None else effects
        alone = setup.log(program, folder)
        if alone is None:
            continue
        names = list(random.choice(list(EFFECTS), count, replace=False))
        if "resonance" in names and "backlash" in names:
            names.remove("backlash")
        for name in names:
            table, lines = EFFECTS[name](random, setup, alone)
            setup.lines[table] += lines
        log = setup.log(program, folder) if names else alone
        if log is not None:
            log.name, log.group, log.effects = f"drawn-{seed}-{number}", "drawn", names
            log.truth["d"] = sorted([setup.d, setup.d + setup.mean_gravity(log)])
            return log.kept(folder)
    raise RuntimeError(f"no loop of log {number} of seed {seed} works")


class Setup:
    """A scenario of `servo-id run`: servo, encoder, controller and reference."""

    def __init__(self, random, rows):
        between = lambda low, high: float(np.exp(random.uniform(np.log(low), np.log(high))))
        self.step = round(1.0 / between(250.0, 5000.0), 7)
        self.rows = rows or int(min(between(3.0, 20.0) / self.step, 10_000))
        self.counts = round(between(500, 65_536))
        authority, self.limit = between(50.0, min(0.02 / self.step**2, 5e4)), between(0.5, 50.0)
        self.a, self.b, self.c = between(0.05, 30.0), authority / self.limit, authority * between(0.002, 0.2)
        self.d = authority * between(0.003, 0.15) * random.choice([-1, 1]) if random.random() < 0.6 else 0.0
        demand = between(0.05, 1.5)
        stiffest = np.sqrt(demand * authority * self.counts / (100 * 2 * np.pi))
        width = max(between(4.4, max(min(0.12 / self.step, 250.0, stiffest), 6.6)) for _ in range(2))
        size = min(demand * authority / width**2, 100.0)
        believed = self.b * between(0.6, 1.6)
        hold = max(round(2 * np.pi / width * random.uniform(0.3, 2.0) / self.step), 2) * self.step
        reference = random.choice(["binary", "steps", "sweep", "multisine"])
        self.gravity = (0.0, 0.0)
        self.width = width
        self.lines = {
            "plant": f"a = {self.a}\nb = {self.b}\ncoulomb = {self.c}\nload = {self.d}\n",
            "encoder": f"counts_per_rev = {self.counts}\n",
            "amplifier": f"limit = {self.limit}\n",
            "controller": f"sample_time = {self.step}\nkp = {width**2 / believed}\n"
            f"kd = {2 * random.uniform(0.5, 1.0) * width / believed}\nki = {width**3 * between(0.02, 0.3) / believed}\n"
            f'velocity_filter = {{ kind = "low-pass", cutoff = {min(width * between(4, 20), 0.9 / self.step)} }}\n',
            "excitation": {
                "binary": f'kind = "prbs"\namplitude = {0.5 * size}\nhold = {hold}\n',
                "steps": f'kind = "steps"\nlevels = {[float(x) for x in size * random.uniform(-1, 1, 15)]}\nhold = {hold}\n',
                "sweep": f'kind = "chirp"\namplitude = {size}\nfrom = {width / 20}\nto = {width * random.uniform(0.5, 1.5)}\n'
                f"duration = {round(self.rows / random.integers(1, 4)) * self.step}\n",
                "multisine": f'kind = "multisine"\namplitudes = {[0.6 * size, 0.3 * size, 0.1 * size]}\n'
                f"frequencies = {[float(x) for x in width * random.uniform(0.05, 1.0, 3)]}\n",
            }[reference],
            "identifier": 'law = "gauss-newton"\n',
            "run": f"duration = {self.rows * self.step}\nseed = {random.integers(1, 2**31)}\n",
        }

    def log(self, program, folder):
        """Runs it; none if the loop does not work."""
        scenario, table = folder / "drawn.toml", folder / "drawn.csv"
        scenario.write_text("".join(f"[{name}]\n{lines}" for name, lines in self.lines.items()))
        run = [program, "run", str(scenario), "--csv", str(table), "--force", "--quiet"]
        done = subprocess.run(run, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(done.stderr)
        position, command = columns(table, ["position_rad", "command"])
        low, high = position.min(), position.max()
        middle = position[(position < low + 0.3 * (high - low)) | (position > low + 0.7 * (high - low))]
        crossings = np.count_nonzero(np.diff(middle > 0.5 * (low + high)))
        limited = np.mean(np.abs(command) > 0.999999 * self.limit)
        if limited > 0.4 or high - low < 12 * 2 * np.pi / self.counts or high - low > 1e4 or crossings < 4:
            return None
        truth = {"a": [self.a] * 2, "b": [self.b] * 2, "c": [self.c] * 2, "d": [self.d] * 2}
        return Log("", "", self.step, position, command, truth)

    def mean_gravity(self, log):
        """On small travel gravity's mean is part of the load, rad/s²."""
        start = log.position[0]
        sine, cosine = np.sin(log.position - start), np.cos(log.position - start)
        return float(np.mean(self.gravity[0] * sine + self.gravity[1] * cosine))


def wave(random, size):
    angle = random.uniform(0, 2 * np.pi)
    return [float(size * np.sin(angle)), float(size * np.cos(angle))]


def gravity(random, setup, log):
    setup.gravity = wave(random, push(setup, log) * random.uniform(0.02, 0.2))
    return "plant", f"gravity = {setup.gravity}\n"


def push(setup, log):
    return setup.b * np.sqrt(np.mean(log.command**2))


def speed(log):
    return float(np.sqrt(np.mean(np.gradient(log.position, log.step) ** 2)))


def count(setup):
    return 2 * np.pi / setup.counts


# Effects that leave b one number, each of a usual size for the motion: the table of the scenario and its lines.
EFFECTS = {
    "delay": lambda r, s, log: (
        "plant",
        f"delay = {r.uniform(0.2, np.clip(0.25 / (s.width * s.step), 0.4, 4.0)) * s.step}\n",
    ),
    "current loop": lambda r, s, log: ("plant", f"current_loop = {1 / (2 * np.pi * r.uniform(150, 2000))}\n"),
    "asymmetry": lambda r, s, log: ("plant", f"asymmetry = {s.a * r.uniform(0.2, 0.7) * r.choice([-1, 1])}\n"),
    "quadratic friction": lambda r, s, log: (
        "plant",
        f"quadratic_friction = {push(s, log) * r.uniform(0.01, 0.15) / speed(log) ** 2}\n",
    ),
    "low-speed friction": lambda r, s, log: (
        "plant",
        f"low_speed_friction = {s.c * r.uniform(0.2, 0.8)}\nlow_speed_velocity = {speed(log) * r.uniform(0.03, 0.3)}\n",
    ),
    "gravity": gravity,
    "cogging": lambda r, s, log: (
        "plant",
        f"ripple = {wave(r, push(s, log) * r.uniform(0.005, 0.05))}\nripple_order = {r.integers(2, 37)}\n",
    ),
    "dead band": lambda r, s, log: ("plant", f"dead_band = {np.std(log.command) * r.uniform(0.005, 0.05)}\n"),
    "load-dependent friction": lambda r, s, log: ("plant", f"load_dependent_friction = {r.uniform(0.02, 0.15)}\n"),
    "hidden limit": lambda r, s, log: (
        "plant",
        f"hidden_limit = {np.quantile(np.abs(log.command), 0.99) * r.uniform(0.6, 0.95)}\n",
    ),
    "resonance": lambda r, s, log: (
        "plant",
        f"resonance = {2 * np.pi * r.uniform(20, 400)}\nresonance_damping = {r.uniform(0.01, 0.1)}\n"
        f"inertia_ratio = {r.uniform(0.1, 0.7)}\n",
    ),
    "backlash": lambda r, s, log: (
        "plant",
        f"backlash = {count(s) * r.uniform(1, np.clip(0.2 * np.ptp(log.position) / count(s), 2, 20))}\n",
    ),
    "noise": lambda r, s, log: (
        "encoder",
        f"noise = {count(s) * r.uniform(0.1, np.clip(0.05 * np.ptp(log.position) / count(s), 0.2, 10))}\n",
    ),
    "eccentricity": lambda r, s, log: ("encoder", f"eccentricity = {r.uniform(1e-4, 3e-3)}\n"),
    "jitter": lambda r, s, log: ("encoder", f"jitter = {r.uniform(0.01, 0.1)}\n"),
}


def columns(table, names):
    """Columns of a CSV file by their names; a plain or gzipped file."""
    found = np.genfromtxt(table, delimiter=",", names=True, usecols=names, deletechars="")
    return [np.ascontiguousarray(found[name], dtype=float) for name in names]


def mujoco_joint(folder, seed, number):
    """A hinge of MuJoCo with armature, damping and frictionloss, driven by a torque; its own physics at 1 kHz."""
    import mujoco

    random = np.random.default_rng([seed, number, 1])
    armature = float(np.exp(random.uniform(np.log(0.005), np.log(0.2))))
    damping, friction = armature * random.uniform(1, 8), armature * random.uniform(2, 15)
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><option timestep="0.001" gravity="0 0 0" integrator="implicitfast"/><worldbody><body>'
        f'<joint name="j" armature="{armature}" damping="{damping}" frictionloss="{friction}"/>'
        '<geom size="0.01" mass="1e-6"/></body></worldbody><actuator><motor joint="j"/></actuator></mujoco>'
    )
    data = mujoco.MjData(model)
    step, resolution = 0.001, 2 * np.pi / 4096
    rows, position, command, last = 10_000, [], [], 0.0
    tones = random.uniform(2.0, 25.0, 3)
    for k in range(rows):
        seen = np.floor(data.qpos[0] / resolution) * resolution
        goal = 0.3 * np.sum(np.sin(tones * k * step))
        data.ctrl[0] = armature * (300.0 * (goal - seen) - 12.0 * (seen - last) / step)
        last = seen
        position.append(seen)
        command.append(data.ctrl[0])
        mujoco.mj_step(model, data)
    inertia = armature + 1e-6 * 0.4 * 0.01**2
    truth = {"a": damping / inertia, "b": 1 / inertia, "c": friction / inertia, "d": 0.0}
    truth = {name: [float(value)] * 2 for name, value in truth.items()}
    return Log(f"mujoco-{seed}-{number}", "MuJoCo", step, np.array(position), np.array(command), truth).kept(folder)


class Tensors(pickle.Unpickler):
    """Reads the arrays of a PyTorch file and nothing else of it."""

    def __init__(self, archive, root):
        super().__init__(archive.open(f"{root}/data.pkl"))
        self.archive, self.root = archive, root

    def find_class(self, module, name):
        allowed = {
            "_rebuild_tensor_v2": lambda data, offset, shape, *_: data[offset : offset + int(np.prod(shape))].reshape(shape),
            "FloatStorage": np.float32,
            "OrderedDict": dict,
        }
        return allowed[name]

    def persistent_load(self, saved):
        return np.frombuffer(self.archive.read(f"{self.root}/data/{saved[2]}"), saved[1])


def go2_columns(folder, file=None):
    """Times, positions and goals of the twelve joints, fetched unless the file is at hand."""
    path = Path(file or Path(folder) / "go2.pt")
    if not path.exists():
        with urllib.request.urlopen(GO2, timeout=20) as answer:
            path.write_bytes(answer.read())
    archive = zipfile.ZipFile(path)
    found = Tensors(archive, archive.namelist()[0].split("/")[0]).load()
    return [np.asarray(found[name], dtype=float) for name in ("time", "dof_pos", "des_dof_pos")]


def go2(folder, file=None):
    """Twelve joints of a measured robot: the command is that of its own loop."""
    time, positions, goals = go2_columns(folder, file)
    step, (kp, kd) = float(np.mean(np.diff(time))), GO2_GAINS
    logs = []
    for joint in range(positions.shape[1]):
        q, goal = positions[:, joint], goals[:, joint]
        command = kp * (goal - q) - kd * np.gradient(q, step)
        logs.append(Log(f"go2-{joint}", "Go2", step, q, command).kept(folder))
    return logs


def emps(folder):
    """The log of EMPS, which EMPS_LOG names."""
    time, position, command = columns(os.environ["EMPS_LOG"], ["t_s", "q_m", "vir_V"])
    return [Log("emps", "EMPS", float(np.mean(np.diff(time))), position, command).kept(folder)]


def of_folder(folder, source):
    """Logs that a user adds: CSV files with time, position and command as their first three columns, in SI."""
    logs = []
    for path in sorted(Path(source).glob("*.csv")):
        with open(path) as text:
            names = next(csv.reader(text))[:3]
        time, position, command = columns(path, names)
        truth = path.with_suffix(".json")
        known = json.loads(truth.read_text()) if truth.exists() else {}
        known = {name: [value, value] for name, value in known.items()}
        logs.append(Log(path.stem, "yours", float(np.mean(np.diff(time))), position, command, known).kept(folder))
    return logs
