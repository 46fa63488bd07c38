"""Scores of a method on a log: right, covered, held-out error, seconds. The limits are those of the project's own campaigns."""

import os
import signal

import numpy as np

from model import free_run_error, linear_error, physical

OF_B, OF_OTHERS, OF_AUTHORITY, WIDEST = 0.02, 0.05, 0.01, 4.0


def outside(value, truth):
    """Distance from the range of the truth."""
    return max(truth[0] - value, value - truth[1], 0.0)


def tolerance(name, log, std_error):
    """b to 2 %, others to 5 % or to an error that is negligible beside the largest command; three standard errors widen it, by 4."""
    largest = max(abs(x) for x in log.truth[name])
    if name == "b":
        least = OF_B * largest
    else:
        hardly = OF_AUTHORITY * log.truth["b"][1] * np.quantile(np.abs(log.command), 0.999)
        if name == "a":
            hardly /= np.sqrt(np.mean(np.gradient(log.position, log.step) ** 2))
        least = max(OF_OTHERS * largest, hardly)
    return float(np.clip(3 * (std_error or 0.0), least, WIDEST * least))


def against_truth(found, log):
    """Whether all values that a method gives are right, the error of b, and how many 95 % intervals hold the truth."""
    known = [name for name in log.truth if name in found.values]
    off = {name: outside(found.values[name], log.truth[name]) for name in known}
    wrongness = max(off[name] / tolerance(name, log, found.errors.get(name)) for name in known)
    # The truth of a range is no number to cover.
    errors = {name: found.errors.get(name, 0.0) for name in known if np.ptp(log.truth[name]) == 0.0}
    judged = [off[name] <= 1.96 * error for name, error in errors.items() if 0 < error < np.inf]
    return {
        "right": bool(wrongness <= 1.0),
        "error_of_b": float(off["b"] / log.truth["b"][1]),
        "covered": int(sum(judged)),
        "intervals": len(judged),
    }


def held_out(rival, log):
    """Fitted to the first half, the error of a free run over the second, as a share of its standard deviation."""
    middle = len(log.position) // 2
    first, second = log.part(slice(middle), "-first"), log.part(slice(middle, None), "-second")
    if hasattr(rival, "held_out"):
        return rival.held_out(first, second)
    found = rival.fit(first)
    if found.linear:
        return linear_error(found.linear, second)
    return free_run_error(lambda q, v: physical(found.values, second.command, second.step)(q, v), second)


class Late(Exception):
    """A method took longer than it may."""


def late(*_):
    raise Late("longer than it may take")


def processor():
    """Processor time so far of this process and of those that it waited for, s: other work on the machine is not in it."""
    return sum(os.times()[:4])


def scored(rival, log, longest):
    """All scores of a method on a log, or the reason why it has none. The longest time of a fit is processor time, s."""
    signal.signal(signal.SIGPROF, late)
    row = {"log": log.name, "group": log.group, "rows": len(log.position), "effects": log.effects}
    try:
        taken = []
        for _ in range(3 if log.group == "speed" else 1):
            signal.setitimer(signal.ITIMER_PROF, longest)
            begun = processor()
            found = rival.fit(log)
            taken.append(processor() - begun)
            if taken[0] > 5:
                break
        row["seconds"] = min(taken)
        row["values"] = {name: float(value) for name, value in found.values.items()}
        row["errors"] = {name: float(value) for name, value in found.errors.items()}
        row["converged"] = found.converged and bool(np.all(np.isfinite(list(row["values"].values()))))
        if log.truth:
            row.update(against_truth(found, log))
        if log.group != "speed":
            signal.setitimer(signal.ITIMER_PROF, 2 * longest)
            row["held_out"] = min(float(np.nan_to_num(held_out(rival, log), nan=1e6)), 1e6)
    except Exception as error:  # what a method raises is its score
        row["failed"] = f"{type(error).__name__}: {error}".splitlines()[0][:200]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return row
