"""Measures how well the engine keeps the energy of a robot that only gravity moves."""

import math
from dataclasses import dataclass
from typing import Any

import mujoco

from linkwright.stages.mujoco.state import at_keyframe
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
    """Pairs of a step [s] and its drift, which is infinite if the energy is not finite."""

    @property
    def is_conserved(self) -> bool:
        """Tells whether the last drift counts as zero, or is the integrator's error."""
        (_, last), previous = self.by_step[-1], self.by_step[-2:-1]
        falls = math.isfinite(last) and any(last * MIN_FALL <= drift for _, drift in previous)
        return last < MAX_DRIFT or falls


def drift_of_energy(model: Any) -> Drift:
    """Measures the drift of the passive model from seeded speeds at `home`, by the Runge-Kutta method.

    Contacts, limits, friction, damping, springs, closed loops and actuators are off. The time step is halved
    until the energy is conserved, at most `MAX_HALVINGS` times.
    """
    drifts: list[tuple[float, float]] = []
    step = float(model.opt.timestep)
    for _ in range(MAX_HALVINGS + 1):
        drifts.append((step, _drift(model, step)))
        if Drift(tuple(drifts)).is_conserved:
            break
        step /= 2
    return Drift(tuple(drifts))


def _drift(model: Any, step: float) -> float:
    """Returns the drift [1/s] of a run of `SECONDS` with a time step [s]; infinite if the energy is not
    finite, 0 if nothing moves."""
    disabled_features = flags("CONSTRAINT", "ACTUATION", "SENSOR", *PASSIVE)
    options = {
        "timestep": step,
        "integrator": mujoco.mjtIntegrator.mjINT_RK4,
        "disableflags": disabled_features | int(model.opt.disableflags) & flags("GRAVITY"),
        "enableflags": int(mujoco.mjtEnableBit.mjENBL_ENERGY),
    }
    with with_options(model, **options):
        data = at_keyframe(model)
        data.qvel[:] = speeds(model)
        mujoco.mj_forward(model, data)
        start_energy, max_kinetic_energy = float(data.energy.sum()), float(data.energy[1])
        max_error = 0.0
        steps = max(1, round(SECONDS / step / SAMPLES))
        for _ in range(SAMPLES):
            mujoco.mj_step(model, data, steps)
            mujoco.mj_forward(model, data)
            error = abs(float(data.energy.sum()) - start_energy)
            if not math.isfinite(error):
                return math.inf
            max_error = max(max_error, error)
            max_kinetic_energy = max(max_kinetic_energy, float(data.energy[1]))
    return max_error / max_kinetic_energy / (SAMPLES * steps * step) if max_kinetic_energy else 0.0


def speeds(model: Any) -> Any:
    """Returns the speed (nv,) of every degree of freedom [rad/s or m/s], seeded by the joints' names."""
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
