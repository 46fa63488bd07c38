"""MuJoCo's own toolbox: a hinge with armature, damping, frictionloss and a constant load, by its recommended optimiser."""

import contextlib
import io

import mujoco
import numpy as np
from mujoco import sysid

from . import Found, filtered_derivatives

NAME = "mujoco.sysid"
LICENCE = "Apache-2.0"
NEEDS = ["mujoco", "colorama", "yaml", "plotly"]
XML = """<mujoco><option timestep="{step}" gravity="0 0 0" integrator="implicitfast"/><worldbody><body>
<joint name="j" armature="{armature}" damping="0.1" frictionloss="0.1"/><geom size="0.01" mass="1e-9"/></body></worldbody>
<actuator><motor name="u" joint="j"/><motor name="load" joint="j"/></actuator>
<sensor><jointpos name="q" joint="j"/></sensor></mujoco>"""


def fit(log):
    start = filtered_derivatives.fit(log).values
    drive = np.abs(log.command).max()
    speed = np.std(np.diff(log.position)) / log.step
    spec = mujoco.MjSpec.from_string(XML.format(step=log.step, armature=1 / abs(start["b"])))
    model = spec.compile()
    params = sysid.ParameterDict()

    def add(name, nominal, low, high, modifier):
        value = float(np.clip(nominal, low, high))
        params.add(sysid.Parameter(name, nominal=value, min_value=low, max_value=high, modifier=modifier))

    inertia = 1 / abs(start["b"])  # a start below zero is no start
    joint = lambda spec: spec.joint("j")
    add("armature", inertia, inertia / 4, 4 * inertia, lambda s, p: setattr(joint(s), "armature", p.value[0]))
    add("damping", start["a"] * inertia, 0.0, 10 * drive / speed, lambda s, p: joint(s).damping.__setitem__(0, p.value[0]))
    add("friction", start["c"] * inertia, 0.0, 2 * drive, lambda s, p: setattr(joint(s), "frictionloss", p.value[0]))
    add("load", start["d"] * inertia, -drive, drive, lambda s, p: s.actuator("load").gear.__setitem__(0, p.value[0]))
    times = np.arange(len(log.command)) * log.step
    control = sysid.TimeSeries(times, np.column_stack([log.command, np.ones(len(times))]))
    # MuJoCo's position sensor shows the beginning of a step at the time of its end.
    measured = sysid.TimeSeries.from_names(times[1:], log.position[:-1, None], model)
    begin = (log.position[5] - log.position[0]) / (5 * log.step)
    state = sysid.create_initial_state(model, np.array([log.position[0]]), np.array([begin]), np.zeros(0))
    sequences = sysid.ModelSequences("axis", spec, "log", state, control, measured)
    residual = sysid.build_residual_fn(models_sequences=[sequences])
    params.move_off_bounds()
    with contextlib.redirect_stdout(io.StringIO()):
        best, result = sysid.optimize(initial_params=params, residual_fn=residual, optimizer="mujoco", verbose=False)
    J, damping, friction, load = (float(best[name].value[0]) for name in ("armature", "damping", "friction", "load"))
    values = {"a": damping / J, "b": 1 / J, "c": friction / J, "d": load / J}
    covariance, _ = sysid.calculate_intervals(residual(result.x, best)[0], result.jac)
    to = np.array([[-damping / J**2, 1 / J, 0, 0], [-1 / J**2, 0, 0, 0], [-friction / J**2, 0, 1 / J, 0], [-load / J**2, 0, 0, 1 / J]])
    errors = np.sqrt(np.diag(to @ covariance @ to.T))
    return Found(values, dict(zip("abcd", errors)))
