"""How well the engine keeps the energy of a robot that nothing but gravity moves."""

from dataclasses import dataclass
from typing import Any

import mujoco

from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.validate.model.coordinates import FREE, SLIDE, WIDTH
from linkwright.stages.validate.simulate.running import PASSIVE, drawn, flags, with_options

SECONDS = 0.5
"""The length of a run."""

SPEED = 1.0
"""The largest speed of a turn at the start [rad/s]; of a slide it is that times the size of the model."""

DRIFT = 1e-6
"""Of the energy, per second, relative to the largest kinetic energy: less than this is none."""

FALL = 8.0
"""A drift that falls at least so much when the step is halved is the integrator's own: it is of fourth order,
and falls sixteenfold where the step is short enough."""

HALVINGS = 4
"""So often the step is halved: light links far out whip around, and need short steps."""

SAMPLES = 25
"""So often the energy is looked at in a run."""


@dataclass(frozen=True, slots=True)
class Drift:
    """The drift of energy [1/s] by time step [s], each half of the one before; the first is the model's."""

    by_step: tuple[tuple[float, float], ...]

    @property
    def conserved(self) -> bool:
        (_, last), before = self.by_step[-1], self.by_step[-2:-1]
        return last < DRIFT or any(last * FALL <= drift for _, drift in before)


def drift_of_energy(model: Any) -> Drift:
    """Runs the passive model, without contacts, limits, friction, damping, springs, closed loops and
    actuators, from seeded speeds at `home`, by Runge and Kutta's method at its own time step; then at half of
    that, and so on, until the energy is conserved or the step has been halved `HALVINGS` times."""
    found: list[tuple[float, float]] = []
    step = float(model.opt.timestep)
    for _ in range(HALVINGS + 1):
        found.append((step, _drift(model, step)))
        if Drift(tuple(found)).conserved:
            break
        step /= 2
    return Drift(tuple(found))


def _drift(model: Any, step: float) -> float:
    off = flags("CONSTRAINT", "ACTUATION", "SENSOR", *PASSIVE)
    changed = {
        "timestep": step,
        "integrator": mujoco.mjtIntegrator.mjINT_RK4,
        "disableflags": off | int(model.opt.disableflags) & flags("GRAVITY"),
        "enableflags": int(mujoco.mjtEnableBit.mjENBL_ENERGY),
    }
    with with_options(model, **changed):
        data = at_keyframe(model)
        data.qvel[:] = speeds(model)
        mujoco.mj_forward(model, data)
        start, largest, off_by = float(data.energy.sum()), float(data.energy[1]), 0.0
        each = max(1, round(SECONDS / step / SAMPLES))
        for _ in range(SAMPLES):
            mujoco.mj_step(model, data, each)
            mujoco.mj_forward(model, data)
            largest = max(largest, float(data.energy[1]))
            off_by = max(off_by, abs(float(data.energy.sum()) - start))
            if not off_by < float("inf"):
                return float("inf")
    return off_by / largest / (SAMPLES * each * step) if largest else 0.0


def speeds(model: Any) -> Any:
    """Speeds (nv,) of every degree of freedom, seeded by the names of the joints."""
    size = float(model.stat.extent)
    found = mujoco.MjData(model).qvel
    for joint in range(model.njnt):
        first = int(model.jnt_dofadr[joint])
        kind = mujoco.mjtJoint(model.jnt_type[joint])
        own = SPEED * drawn(model.joint(joint).name, WIDTH[kind])
        if kind in (SLIDE, FREE):
            own[:3] *= size
        found[first : first + len(own)] = own
    return found
