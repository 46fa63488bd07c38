"""An output-error fit: simulate a, b, c, d, the delay and the start, least squares of the position with scipy."""

import numpy as np
from scipy.optimize import least_squares

from model import advance, simulate

from . import Found, filtered_derivatives

NAME = "output-error fit, numba and scipy"
LICENCE = "BSD-3 (numba, scipy)"
NEEDS = ["numba", "scipy"]
USES = [advance, simulate]  # part of what a user writes


def fit(log):
    start = filtered_derivatives.fit(log).values
    authority = abs(start["b"]) * np.std(log.command)
    speed = np.sqrt(np.mean(np.gradient(log.position, log.step) ** 2))
    scale = np.array([authority / speed, abs(start["b"]), authority, authority, 1.0, np.ptp(log.position), speed])
    deviation = np.std(log.position)

    begin = (log.position[5] - log.position[0]) / (5 * log.step)
    x = np.array([start["a"], start["b"], start["c"], start["d"], 0.5, log.position[0], begin]) / scale
    low = np.array([0, -np.inf, 0, -np.inf, 0, -np.inf, -np.inf])
    high = np.array([np.inf, np.inf, np.inf, np.inf, 20, np.inf, np.inf])
    # From a short horizon to the whole log: a free run over all of it has more minima.
    for share in (0.03, 0.1, 0.3, 1.0):
        rows = int(share * len(log.position))
        command, position = log.command[:rows], log.position[:rows]

        def residual(x):
            simulated = simulate(*(x * scale), command, log.step)
            return np.clip((simulated - position) / deviation, -1e6, 1e6)

        x = np.clip(x, low + 1e-9, high - 1e-9)
        found = least_squares(residual, x, bounds=(low, high), x_scale="jac", diff_step=1e-4, max_nfev=100)
        x = found.x
    values = dict(zip(["a", "b", "c", "d", "delay"], x * scale))
    values["delay"] *= log.step
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * (found.fun @ found.fun) / (rows - len(x))
    errors = dict(zip("abcd", np.sqrt(np.diag(covariance)) * scale))
    return Found(values, errors, bool(found.success))
