"""Least squares on filtered derivatives, as SysId does it: acceleration on velocity, command, sign of velocity and one."""

import numpy as np
from scipy.signal import butter, sosfiltfilt

from . import Found

NAME = "least squares on filtered derivatives"
LICENCE = "BSD-3 (scipy)"
NEEDS = ["scipy"]


def fit(log):
    position = log.position - log.position[0]
    # The usual rule: a low-pass without phase at ten times the frequency of the motion, and the same for all columns.
    speed = np.sqrt(np.mean(np.gradient(position, log.step) ** 2))
    cutoff = min(10 * speed / np.std(position), 0.8 * np.pi / log.step)
    filtered = lambda x: sosfiltfilt(butter(4, cutoff * log.step / np.pi, output="sos"), x)
    smooth = filtered(position)
    velocity = np.gradient(smooth, log.step)
    acceleration = np.diff(smooth, 2) / log.step**2
    # The command of the row before acts with that of the row: the second difference is centred on the row.
    command = filtered(0.5 * (log.command[1:-1] + log.command[:-2]))
    friction = filtered(np.sign(velocity))[1:-1]
    columns = np.column_stack([-velocity[1:-1], command, -friction, np.ones(len(command))])
    inside = slice(len(command) // 50, -(len(command) // 50) or None)
    columns, acceleration = columns[inside], acceleration[inside]
    found, *_ = np.linalg.lstsq(columns, acceleration, rcond=None)
    rest = acceleration - columns @ found
    covariance = np.linalg.inv(columns.T @ columns) * (rest @ rest) / (len(rest) - 4)
    return Found(dict(zip("abcd", found)), dict(zip("abcd", np.sqrt(np.diag(covariance)))))
