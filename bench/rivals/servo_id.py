"""This project's program, as a user calls it: one command, which reads the file and finds all else."""

import json
import os
import subprocess
from pathlib import Path

from . import Found

NAME = "servo-id identify"
LICENCE = "MIT or Apache-2.0"
NEEDS = []
USER_LINES = 1  # servo-id identify log.csv
COLUMNS = {"a": "a", "b": "b", "c": "coulomb", "d": "load"}


def identify(log, *options):
    # Beside the log, which has a folder of its own.
    result = str(Path(log.file).with_suffix(".result"))
    command = [os.environ["SERVO_ID"], "identify", log.file, *options, "--json", result, "--force", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    with open(result) as text:
        return json.load(text)


def fit(log):
    result = identify(log)
    estimates = result["estimates"]
    known = {short: estimates[name] for short, name in COLUMNS.items() if estimates.get(name)}
    return Found(
        {name: known[name]["value"] for name in known},
        {name: known[name]["std_error"] for name in known if known[name].get("std_error") is not None},
        result["status"] == "converged",
    )


def held_out(first, second):
    """The free run of what it found, effects included, over the second half with a fitted start."""
    found = identify(first, "--predict", second.file)["predictions"][0]["open_loop"]
    return found["rms"] / float(second.position.std())
