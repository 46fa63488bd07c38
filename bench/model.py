"""The servo that physical methods fit, q'' = -a q' + b u(t - delay) - c sign q' + d, and free runs of it and of linear models."""

import numpy as np
from numba import njit
from scipy.optimize import least_squares


@njit(cache=True)
def advance(q, v, drive, a, c, duration):
    """Position and velocity after a time under a constant drive (rad/s²), with stops, sticking and reversals."""
    for _ in range(3):
        if v == 0.0:
            if abs(drive) <= c:
                return q, 0.0
            side = np.sign(drive)
        else:
            side = np.sign(v)
        push = drive - c * side
        decay = np.exp(-a * duration)
        spread = (1.0 - decay) / a if a * duration > 1e-9 else duration
        end = v * decay + push * spread
        if end * side >= 0.0:
            slow = (duration - spread) / a if a * duration > 1e-4 else 0.5 * duration * duration
            return q + v * spread + push * slow, end
        # The velocity reaches zero within this time.
        stop = v / (v - end) * duration if a * abs(v) < 1e-6 * abs(push) else np.log(1.0 - a * v / push) / a
        stop = min(max(stop, 0.0), duration)
        q += 0.5 * v * stop
        v = 0.0
        duration -= stop
    return q, v


@njit(cache=True)
def simulate(a, b, c, d, delay, q, v, command, step):
    """Positions at the samples, rad. The delay is in samples, at least zero."""
    whole = int(np.floor(delay))
    part = delay - whole
    positions = np.empty(len(command))
    for k in range(len(command)):
        positions[k] = q
        before, after = command[max(k - whole - 1, 0)], command[max(k - whole, 0)]
        if part > 0.0:
            q, v = advance(q, v, b * before + d, a, c, part * step)
        q, v = advance(q, v, b * after + d, a, c, (1.0 - part) * step)
    return positions


def physical(values, command, step):
    """A free run by q and v at the start, of values a, b, and where they are given c, d and the delay (s)."""
    a, b, c, d, delay = (values.get(name, 0.0) for name in ("a", "b", "c", "d", "delay"))
    return lambda q, v: simulate(max(a, 0.0), b, max(c, 0.0), d, max(delay, 0.0) / step, q, v, command, step)


def free_run_error(run, log):
    """Error (rms, of the motion's standard deviation) of a free run whose start is fitted to the whole log."""
    speed = np.sqrt(np.mean(np.gradient(log.position, log.step) ** 2))
    scale = np.array([np.std(log.position), speed])
    guess = np.array([log.position[0], (log.position[5] - log.position[0]) / (5 * log.step)]) / scale

    def residual(start):
        error = (run(*(start * scale)) - log.position) / scale[0]
        return np.clip(np.nan_to_num(error, nan=1e6), -1e6, 1e6)

    found = least_squares(residual, guess, diff_step=1e-4, max_nfev=30)
    return float(np.sqrt(np.mean(found.fun**2)))


@njit(cache=True)
def linear(A, B, C, D, state, command):
    """Outputs of a linear discrete model."""
    outputs = np.empty(len(command))
    for k in range(len(command)):
        outputs[k] = np.dot(C, state) + D * command[k]
        state = A @ state + B * command[k]
    return outputs


def linear_error(model, log):
    """As `free_run_error`, of a model (A, B, C, D, means of position and command): its initial state is fitted."""
    A, B, C, D, offset, balance = model
    forced = linear(A, B, C, D, np.zeros(len(A)), log.command - balance)
    free = np.column_stack([linear(A, B * 0, C, 0.0, unit, log.command) for unit in np.eye(len(A))])
    if not (np.all(np.isfinite(forced)) and np.all(np.isfinite(free))):
        return float("inf")
    wanted = log.position - offset - forced
    start, *_ = np.linalg.lstsq(free, wanted, rcond=None)
    return float(np.sqrt(np.mean((wanted - free @ start) ** 2)) / np.std(log.position))


def servo_of(model, log):
    """a and b of a linear model: 1/G(jω) = (-ω² + aω j)/b where the command moves the servo most."""
    A, B, C, D, *_ = model
    power = np.abs(np.fft.rfft(log.command - np.mean(log.command))) ** 2
    omega = 2 * np.pi * np.fft.rfftfreq(len(log.command), log.step)
    usable = (omega > 0) & (omega * log.step < 0.5)
    omega, power = omega[usable], power[usable]
    best = np.argsort(power / omega**2)[-20:]
    omega, weight = omega[best], np.sqrt(power[best]) / omega[best]
    z = np.exp(1j * omega * log.step)
    hold = (1 - 1 / z) / (1j * omega * log.step)
    gain = np.array([C @ np.linalg.solve(x * np.eye(len(A)) - A, B) + D for x in z]) / hold
    # g (-ω² + aω j) = b, and so for the unknowns a and b: a (jω g) - b = ω² g.
    left = np.column_stack([1j * omega * gain, -np.ones(len(omega))]) * weight[:, None]
    right = omega**2 * gain * weight
    (a, b), *_ = np.linalg.lstsq(np.vstack([left.real, left.imag]), np.concatenate([right.real, right.imag]), rcond=None)
    return {"a": float(a), "b": float(b)}


def state_space(numerator, denominator):
    """(A, B, C, D) in controllable form of a transfer function in z, both lists of one length, denominator[0] = 1."""
    n = len(denominator) - 1
    A = np.eye(n, k=-1)
    A[0] = -np.asarray(denominator[1:])
    C = np.asarray(numerator[1:]) - numerator[0] * np.asarray(denominator[1:])
    return A, np.eye(n)[0], C, float(numerator[0])
