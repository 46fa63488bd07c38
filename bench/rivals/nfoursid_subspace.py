"""N4SID of nfoursid with two states, as its documentation shows it."""

import numpy as np
import pandas
from nfoursid.nfoursid import NFourSID

from model import servo_of

from . import Found

NAME = "nfoursid, N4SID"
LICENCE = "MIT"
NEEDS = ["nfoursid", "pandas"]


def fit(log):
    # A loop in balance: the mean of the command is what the load takes.
    start, scale = np.mean(log.position), np.std(log.position)
    balance, size = np.mean(log.command), np.std(log.command)
    frame = pandas.DataFrame({"u": (log.command - balance) / size, "y": (log.position - start) / scale})
    subspace = NFourSID(frame, output_columns=["y"], input_columns=["u"], num_block_rows=10)
    subspace.subspace_identification()
    model, _ = subspace.system_identification(rank=2)
    A, B, C, D = (np.asarray(matrix, dtype=float) for matrix in (model.a, model.b, model.c, model.d))
    linear = (A, B[:, 0] / size, C[0] * scale, float(D[0, 0]) * scale / size, start, balance)
    return Found(servo_of(linear, log), linear=linear)
