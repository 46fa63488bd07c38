"""Twelve joints of a measured robot, from positions and goals: do the halves of its log agree? `python bench/go2.py --help`.

Gravity and the coupling of the joints come from the robot's model by MuJoCo's inverse dynamics, as a known torque. Both files are
fetched from the repository of the log (BSD-3), where they are not at hand."""

import argparse
import json
import os
import re
import subprocess
import tempfile
import urllib.request
from pathlib import Path

import mujoco
import numpy as np
from scipy.signal import butter, sosfiltfilt

import logs

MODEL = logs.GO2.rsplit("/datasets", 1)[0] + "/robot_model/go2/go2.xml"
KP, KD = logs.GO2_GAINS


def known_torques(text, positions, step):
    """Torque on each joint beside that of its motor and its own inertia, N·m, with the body held."""
    # The looks are in other files, and are no matter.
    text = re.sub(r"<mesh [^>]*/>|<geom [^>]*mesh=[^>]*/>|<freejoint/>|<keyframe>.*?</keyframe>", "", text, flags=re.DOTALL)
    model = mujoco.MjModel.from_xml_string(text)
    model.dof_armature[:], model.dof_damping[:], model.dof_frictionloss[:] = 0.0, 0.0, 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    data, full = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    smooth = sosfiltfilt(butter(4, 30.0 * 2 * step, output="sos"), positions, axis=0)
    velocities = np.gradient(smooth, step, axis=0)
    accelerations = np.gradient(velocities, step, axis=0)
    torques = np.empty_like(positions)
    for k in range(len(positions)):
        data.qpos, data.qvel, data.qacc = smooth[k], velocities[k], accelerations[k]
        mujoco.mj_inverse(model, data)
        mujoco.mj_fullM(model, data, full)
        torques[k] = np.diag(full) * accelerations[k] - data.qfrc_inverse
    return torques


def identified(program, folder, columns, options):
    path = Path(folder) / "joint.csv"
    np.savetxt(path, np.column_stack(columns), "%.9g", ",", header="t_s,q_rad,goal_rad,model_Nm", comments="")
    call = [program, "identify", str(path), "--position", "q_rad", "--goal", "goal_rad", "--kp", str(KP), "--kd", str(KD)]
    done = subprocess.run([*call, "--command-unit", "Nm", *options, "--json", "-"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--log", type=Path, help="the log, where it is at hand")
    parser.add_argument("--model", type=Path, help="the robot's model, where it is at hand")
    parser.add_argument("--program", default=str(Path(__file__).parent.parent / "target/release/servo-id"), help="servo-id")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        time, positions, goals = logs.go2_columns(folder, options.log)
        text = options.model.read_text() if options.model else urllib.request.urlopen(MODEL, timeout=20).read().decode()
        step, middle = float(np.mean(np.diff(time))), len(time) // 2
        torques = known_torques(text, positions, step)
        for title, more in (("position and goal", []), ("with the known torque", ["--known-torque", "model_Nm"])):
            table(title, options.program, folder, (time, positions, goals, torques), middle, more)


def table(title, program, folder, columns, middle, more):
    time, positions, goals, torques = columns
    agreed, begun, taken = {"inertia": [], "coulomb": []}, 0.0, 0.0
    print(f"{title}\njoint  whole log: armature, friction, verdict | first half | second half | apart, errors")
    for joint in range(positions.shape[1]):
        cells, found = [], []
        for rows in (slice(None), slice(middle), slice(middle, None)):
            of_joint = (time[rows] - time[rows][0], positions[rows, joint], goals[rows, joint], torques[rows, joint])
            begun = sum(os.times()[2:4])
            result = identified(program, folder, of_joint, more)
            taken += sum(os.times()[2:4]) - begun if rows == slice(None) else 0.0
            physical = result["physical"]
            found.append({name: (physical[name]["value"], physical[name]["std_error"] or np.inf) for name in agreed})
            known = ", ".join(f"{value:.4f} ± {1.96 * error:.2g}" for value, error in found[-1].values())
            cells.append(f"{known}, {result['status']} {result['code']}")
        apart = []
        for name, all_ in agreed.items():
            (one, first), (other, second) = found[1][name], found[2][name]
            apart.append(abs(one - other) / np.hypot(first, second))
            all_.append(apart[-1] <= 1.96)
        print(f"{joint:5}  " + " | ".join(cells) + " | " + ", ".join(f"{x:.1f}" for x in apart), flush=True)
    counts = ", ".join(f"{name} {sum(all_)} of {len(all_)}" for name, all_ in agreed.items())
    print(f"halves agree within their 95 % errors: {counts}; whole logs take {taken:.1f} s of processor time\n")


if __name__ == "__main__":
    main()
