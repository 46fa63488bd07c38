"""sysidentpy's FROLS with unbiased least squares and terms by an information criterion; linear, as a servo nearly is."""

import numpy as np
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares

from model import servo_of, state_space

from . import Found

NAME = "sysidentpy, FROLS"
LICENCE = "BSD-3"
NEEDS = ["sysidentpy"]
LAGS = 3


def fit(log):
    # A loop in balance: the mean of the command is what the load takes.
    start, scale = np.mean(log.position), np.std(log.position)
    balance, size = np.mean(log.command), np.std(log.command)
    model = FROLS(
        ylag=LAGS,
        xlag=LAGS,
        order_selection=True,
        n_info_values=2 * LAGS + 1,
        info_criteria="bic",
        estimator=LeastSquares(unbiased=True),
        basis_function=Polynomial(degree=1),
    )
    model.fit(X=((log.command - balance) / size)[:, None], y=((log.position - start) / scale)[:, None])
    numerator, denominator = np.zeros(LAGS + 1), np.eye(LAGS + 1)[0]
    # Codes of regressors: 1000 + lag of the output, 2000 + lag of the input, 0 of the constant.
    for (code,), theta in zip(model.final_model, np.ravel(model.theta)):
        if code >= 2000:
            numerator[code - 2000] = theta * scale / size
        elif code:
            denominator[code - 1000] = -theta
    linear = (*state_space(numerator, denominator), start, balance)
    return Found(servo_of(linear, log), linear=linear)
