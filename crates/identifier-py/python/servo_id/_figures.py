"""Pictures of results, with matplotlib."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ._results import Result


def of_result(result: "Result") -> "Figure":
    """Position, command and output error, and the estimates with their bands."""
    if not result.trace:
        raise ValueError("there is no trace to draw: identify or simulate with trace=True")
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("pictures need matplotlib: pip install servo-id[plot]") from error
    trace = result.trace
    time = trace["time"]
    # A fit of a whole log has no course of its estimates.
    estimated = [
        name
        for name in ("a", "b", "coulomb", "load")
        if name in result.estimates and np.isfinite(trace[name]).any()
    ]
    figure, axes = pyplot.subplots(
        3 + len(estimated), sharex=True, layout="constrained", figsize=(8.0, 1.5 * (3 + len(estimated)))
    )
    for axis, (name, unit) in zip(
        axes, [("position", "rad"), ("command", ""), ("output_error", "rad")]
    ):
        axis.plot(time, trace[name], linewidth=0.8)
        axis.set_ylabel(f"{name.replace('_', ' ')}\n{unit}")
    axes[0].plot(time, trace["position"] - trace["output_error"], linewidth=0.8, linestyle="--")
    axes[0].legend(["measured", "model"])
    for axis, name in zip(axes[3:], estimated):
        _estimate(axis, result, name)
    axes[0].set_title(result.verdict)
    axes[-1].set_xlabel("time, s")
    return figure


def _estimate(axis: "Axes", result: "Result", name: str) -> None:
    """An estimate over time with its band, scaled to its second half."""
    time, value = result.trace["time"], result.trace[name]
    error = result.trace[f"std_error_{name}"]
    axis.plot(time, value, linewidth=1.0)
    axis.fill_between(time, value - 2 * error, value + 2 * error, alpha=0.25, linewidth=0)
    if result.truth is not None:
        axis.axhline(result.truth[name], color="black", linestyle="--", linewidth=0.8)
    late = slice(len(time) // 2, None)
    low, high = (value - 2 * np.nan_to_num(error))[late], (value + 2 * np.nan_to_num(error))[late]
    low, high = np.nanmin(low), np.nanmax(high)
    if np.isfinite([low, high]).all() and high > low:
        room = 0.5 * (high - low)
        axis.set_ylim(low - room, high + room)
    axis.set_ylabel(f"{name}\n{result.units[name]}")
