"""An unscented Kalman filter of position, velocity and the logarithms of a, b and c beside d, in two passes."""

import numpy as np
from numba import njit

from model import advance

from . import Found, filtered_derivatives

NAME = "unscented Kalman filter"
LICENCE = "BSD-3 (numba)"
NEEDS = ["numba"]
USES = [advance]


@njit(cache=True)
def filtered(x, P, Q, noise, position, command, step):
    """The state at the end with its covariance, and the negative logarithm of the likelihood."""
    n = len(x)
    cost = 0.0
    points = np.empty((2 * n, n))
    for k in range(len(position)):
        error = position[k] - x[0]
        variance = P[0, 0] + noise
        cost += 0.5 * (np.log(variance) + error * error / variance)
        gain = P[:, 0] / variance
        x = x + gain * error
        P = P - np.outer(gain, gain) * variance
        P = 0.5 * (P + P.T) + 1e-12 * np.diag(np.diag(P))
        root = np.linalg.cholesky(P * n)
        for i in range(n):
            points[i] = x + root[:, i]
            points[n + i] = x - root[:, i]
        for point in points:
            a, b, c = np.exp(point[2]), np.exp(point[3]), np.exp(point[4])
            point[0], point[1] = advance(point[0], point[1], b * command[k] + point[5], a, c, step)
        x = points.sum(axis=0) / (2 * n)
        away = points - x
        P = away.T @ away / (2 * n) + Q
    return x, P, cost


def fit(log):
    start = filtered_derivatives.fit(log).values
    drive = abs(start["b"]) * np.std(log.command)
    speed = np.std(np.diff(log.position)) / log.step
    least = {"a": 0.01 * drive / speed, "b": 1e-9, "c": 0.001 * drive}
    begin = [log.position[0], 0.0, *(np.log(max(start[name], least[name])) for name in "abc"), start["d"]]
    steps = np.diff(np.unique(log.position))
    noise = max(np.min(steps[steps > 1e-9 * np.ptp(log.position)]) ** 2 / 12, (1e-6 * np.ptp(log.position)) ** 2)
    best = None
    # Process noise of the velocity by the likelihood: 0.01 % to 1 % of the usual acceleration over a sample.
    for share in (1e-4, 1e-3, 1e-2):
        Q = np.diag([0.0, (share * drive * log.step) ** 2, 0.0, 0.0, 0.0, 0.0])
        x, spread = np.array(begin), np.diag([noise, speed**2, 1.0, 0.1, 1.0, (0.2 * drive) ** 2])
        try:
            for _ in range(2):
                x[:2] = log.position[0], 0.0
                x, P, cost = filtered(x, spread, Q, noise, log.position, log.command, log.step)
        except np.linalg.LinAlgError:
            continue
        if np.isfinite(cost) and (best is None or cost < best[2]):
            best = x, P, cost
    if best is None:
        raise ArithmeticError("the covariance lost its sign under every noise")
    x, P, _ = best
    deviations = np.sqrt(np.diag(P))
    values = dict(zip("abcd", [*np.exp(x[2:5]), x[5]]))
    errors = {name: deviations[2 + i] * (values[name] if name != "d" else 1.0) for i, name in enumerate("abcd")}
    return Found(values, errors)
