"""Measures how well the engine keeps the energy of a robot that only gravity moves."""

import math
from dataclasses import dataclass
from typing import Any

import mujoco

from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.validate.findings import largest_error
from linkwright.stages.validate.model.coordinates import DOFS_OF_TYPE, FREE, SLIDE
from linkwright.stages.validate.simulate.running import PASSIVE, flags, seeded_numbers, with_options

SECONDS = 0.5
"""Length of a run [s]."""

MAX_SPEED = 1.0
"""The largest speed [rad/s] of a turn at the start; for a slide it is multiplied by the size of the model."""

MAX_DRIFT = 1e-6
"""Drift of the energy per second, relative to the largest kinetic energy, below which it counts as zero."""

MIN_FALL = 8.0
"""Smallest factor by which a drift falls at half the step if it is the integrator's error. The integrator is
of fourth order, so that its error falls sixteenfold if the step is short enough."""

MAX_HALVINGS = 4
"""Largest number of halvings of the step: light links at the end of a chain whip around, and need short
steps."""

SAMPLES = 25
"""Number of times that the energy is computed in a run."""


@dataclass(frozen=True, slots=True)
class Drift:
    """The drift of energy [1/s] by time step [s]. The first step is the model's; each further step is half of
    the previous."""

    by_step: tuple[tuple[float, float], ...]

    @property
    def conserved(self) -> bool:
        (_, last), before = self.by_step[-1], self.by_step[-2:-1]
        return last < MAX_DRIFT or any(last * MIN_FALL <= drift for _, drift in before)


def drift_of_energy(model: Any) -> Drift:
    """Measures the drift of the passive model from seeded speeds at `home`, by the Runge-Kutta method.

    The model has no contacts, limits, friction, damping, springs, closed loops and actuators. The time step
    is halved until the energy is conserved, at most `MAX_HALVINGS` times.
    """
    drifts: list[tuple[float, float]] = []
    step = float(model.opt.timestep)
    for _ in range(MAX_HALVINGS + 1):
        drifts.append((step, _drift(model, step)))
        if Drift(tuple(drifts)).conserved:
            break
        step /= 2
    return Drift(tuple(drifts))


def _drift(model: Any, step: float) -> float:
    disabled_features = flags("CONSTRAINT", "ACTUATION", "SENSOR", *PASSIVE)
    changed = {
        "timestep": step,
        "integrator": mujoco.mjtIntegrator.mjINT_RK4,
        "disableflags": disabled_features | int(model.opt.disableflags) & flags("GRAVITY"),
        "enableflags": int(mujoco.mjtEnableBit.mjENBL_ENERGY),
    }
    with with_options(model, **changed):
        data = at_keyframe(model)
        data.qvel[:] = speeds(model)
        mujoco.mj_forward(model, data)
        start, largest, off_by = float(data.energy.sum()), float(data.energy[1]), 0.0
        steps = max(1, round(SECONDS / step / SAMPLES))
        for _ in range(SAMPLES):
            mujoco.mj_step(model, data, steps)
            mujoco.mj_forward(model, data)
            largest = max(largest, float(data.energy[1]))
            # Here NaN must count as infinite, since the largest value is kept.
            off_by = largest_error((off_by, abs(float(data.energy.sum()) - start)))
            if off_by == math.inf:
                return math.inf
    return off_by / largest / (SAMPLES * steps * step) if largest else 0.0


def speeds(model: Any) -> Any:
    """Returns speeds (nv,) of every degree of freedom, seeded by the names of the joints."""
    size = float(model.stat.extent)
    qvel = mujoco.MjData(model).qvel
    for joint in range(model.njnt):
        first = int(model.jnt_dofadr[joint])
        kind = mujoco.mjtJoint(model.jnt_type[joint])
        numbers = MAX_SPEED * seeded_numbers(model.joint(joint).name, DOFS_OF_TYPE[kind])
        if kind in (SLIDE, FREE):
            numbers[:3] *= size
        qvel[first : first + len(numbers)] = numbers
    return qvel
