"""SIPPY's ARMAX with two poles: white noise of the position is then part of its model."""

import contextlib
import io

import numpy as np
from sippy_unipi import system_identification

from model import servo_of, state_space

from . import Found

NAME = "sippy-unipi, ARMAX"
LICENCE = "LGPL-3.0"
NEEDS = ["sippy_unipi"]


def fit(log):
    # A loop in balance: the mean of the command is what the load takes.
    start, balance = np.mean(log.position), np.mean(log.command)
    with contextlib.redirect_stdout(io.StringIO()):
        model = system_identification(
            log.position - start, log.command - balance, "ARMAX", tsample=log.step, ARMAX_orders=[2, 2, 2, 1], max_iterations=100
        )
    numerator, denominator = (np.ravel(getattr(model.G, part)[0][0]) for part in ("num", "den"))
    length = max(len(numerator), len(denominator))
    denominator = np.pad(denominator, (0, length - len(denominator)))
    numerator = np.pad(numerator, (length - len(numerator), 0))
    linear = (*state_space(numerator / denominator[0], denominator / denominator[0]), start, balance)
    return Found(servo_of(linear, log), linear=linear)
