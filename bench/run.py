"""The benchmark: the same logs through servo-id and through what people use. `python bench/run.py --help`; see README.md."""

import argparse
import datetime
import importlib.util
import json
import os
import pickle
import platform
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # processor time counts each
    os.environ.setdefault(threads, "1")

import logs as sources  # noqa: E402
import page  # noqa: E402
import rivals  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="of the drawn logs")
    parser.add_argument("--count", type=int, default=20, help="number of drawn logs")
    parser.add_argument("--logs", type=Path, help="a folder with CSV files of yours: time, position and command in SI")
    parser.add_argument("--go2", type=Path, help="the file of the Go2's log, where it is at hand")
    parser.add_argument("--only", nargs="*", default=rivals.NAMES, choices=rivals.NAMES, help="methods")
    parser.add_argument("--longest", type=int, default=20, help="longest processor time of a fit, s")
    parser.add_argument("--budget", type=int, default=60, help="processor time of a method, s: then it takes no further log")
    parser.add_argument("--jobs", type=int, default=1, help="methods at the same time; times are exact with one")
    parser.add_argument("--program", default=str(HERE.parent / "target/release/servo-id"), help="servo-id")
    parser.add_argument("--out", type=Path, default=HERE.parent / "results", help="folder of results.json")
    parser.add_argument("--page", type=Path, help="folder of RESULTS.md and its pictures; by default that of --out")
    parser.add_argument("--quick", action="store_true", help="two logs and two methods, as a test")
    return parser.parse_args()


def collected(options, folder):
    """All logs, and what is missing with the reason."""
    number = 1 if options.quick else options.count
    with ThreadPoolExecutor(options.jobs) as pool:
        drawn = list(pool.map(lambda k: sources.drawn(options.program, folder, options.seed, k), range(number)))
    found, missing = [], {}

    def take(name, make):
        try:
            found.extend(make())
        except Exception as error:
            missing[name] = f"{type(error).__name__}: {error}".splitlines()[0]

    take("MuJoCo", lambda: [sources.mujoco_joint(folder, options.seed, k) for k in range(1 if options.quick else 4)])
    if options.logs:
        take("yours", lambda: sources.of_folder(folder, options.logs))
    if not options.quick:
        take("Go2", lambda: sources.go2(folder, options.go2))
        take("EMPS", lambda: sources.emps(folder))
        for rows in (10_000, 100_000):
            take("speed", lambda rows=rows: [speed(options, folder, rows, k) for k in range(2)])
    # In turn one of each kind: a slow method then meets every kind before its time is over.
    kinds = {}
    for log in found + drawn:
        kinds.setdefault(log.group, []).append(log)
    in_turn = sorted((place, kind) for kind, of_kind in kinds.items() for place in range(len(of_kind)))
    return [kinds[kind][place] for place, kind in in_turn], missing


def speed(options, folder, rows, number):
    log = sources.drawn(options.program, folder, options.seed, 10_000 + rows + number, 0, rows)
    log.group = "speed"
    return log


def of_method(name, logs, options):
    """The rows of a method and what it takes, in a process of its own."""
    method = ran(name, logs, options)
    print(method["name"], method.get("not_run", f"{len(method['rows'])} logs"), flush=True)
    return method


def ran(name, logs, options):
    spec = importlib.util.find_spec(f"rivals.{name}")
    text = Path(spec.origin).read_text()
    constants = {}
    for line in text.splitlines():  # without importing what may be missing
        key, _, value = line.partition(" = ")
        if key in ("NAME", "LICENCE", "NEEDS", "NOT_RUN"):
            constants[key.lower()] = eval(value)
    lacking = [package for package in constants["needs"] if importlib.util.find_spec(package) is None]
    if lacking:
        constants["not_run"] = f"not installed: {', '.join(lacking)}"
    if "not_run" in constants:
        return {**constants, "rows": []}
    command = [sys.executable, str(HERE / "worker.py"), name, str(logs), str(options.longest), str(options.budget)]
    environment = {**os.environ, "SERVO_ID": str(Path(options.program).resolve())}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    rows = []
    for line in done.stdout.splitlines():
        read = json.loads(line) if line.startswith("{") else {}
        if "log" in read:
            rows.append(read)
        else:
            constants.update(read)
    if done.returncode:
        constants["not_run"] = "ended early: " + (done.stderr.strip().splitlines() or ["no message"])[-1][:200]
    return {**constants, "rows": rows}


def processor_name():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def main():
    options = arguments()
    if options.quick:
        options.only = ["servo_id", "filtered_derivatives"]
    options.page = options.page or options.out
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        all_logs, missing = collected(options, folder)
        pickled = Path(folder) / "logs.pickle"
        pickled.write_bytes(pickle.dumps(all_logs))
        with ThreadPoolExecutor(options.jobs) as pool:
            found = pool.map(lambda name: of_method(name, pickled, options), options.only)
            methods = dict(zip(options.only, found))
    results = {
        "date": datetime.date.today().isoformat(),
        "machine": f"{os.cpu_count()} cores, {processor_name()}",
        "seed": options.seed,
        "command": f"python bench/run.py --seed {options.seed} --count {options.count} --jobs {options.jobs}",
        "longest": options.longest,
        "budget": options.budget,
        "logs": [{"log": x.name, "group": x.group, "rows": len(x.position), "effects": x.effects} for x in all_logs],
        "missing": missing,
        "methods": methods,
    }
    (options.out / "results.json").write_text(json.dumps(results, indent=1))
    page.write(results, options.page)
    print(f"{options.page / 'RESULTS.md'}")
    if options.quick and not all(row.get("right") for row in methods["servo_id"]["rows"]):
        sys.exit("servo-id is wrong on a log of the quick run")


if __name__ == "__main__":
    main()
