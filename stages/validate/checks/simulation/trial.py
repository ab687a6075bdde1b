"""The model stays whole and finite in a trial run from `home`, with the controls there, at its time step.

Where it does not, the run is repeated with one thing changed, to say what would mend it.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import mujoco

from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.trial import OPEN, Trial, trial_run
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.simulate.running import flags, touching, with_options

DAMPING = 0.1
"""Of a joint, as a share of its inertia in a time step, that is tried."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of MJCF files: a URDF has neither a time step nor a home."""
    model = compiled.model
    if compiled.urdf or not model.nv:
        return
    trial = trial_run(model)
    detail = f"simulated for {trial.time:.3g} s from home without a warning; loops opened by at most [m, rad]"
    if trial.failed:
        where = f" at {', '.join(trial.joints[:3])}" if trial.joints else ""
        detail = f"after {trial.time:.3g} s {trial.failed}{where}; {_remedy(model, trial)}"
    yield compiled.result("trial run", not trial.failed, detail, trial.opening, OPEN)


def _remedy(model: Any, trial: Trial) -> str:
    """The first change with which the run passes, in the words of the configuration."""
    step = model.opt.timestep
    joint = trial.joint or "*"
    for change, words in (
        (_without_contacts, f"without contacts it does not: {_deepest(model)}"),
        (_half_step, f"scene.option.timestep={step / 2:g} would mend it"),
        (_armature(trial), f"armature would mend it: joints: {{{joint}: {{armature: ...}}}}"),
        (_damping(trial), f"damping would mend it: joints: {{{joint}: {{damping: ...}}}}"),
    ):
        with change(model):
            if not trial_run(model).failed:
                return words
    return f"look at joints: {{{joint}: {{damping: ..., armature: ...}}}} and the masses beyond it"


def _without_contacts(model: Any) -> Any:
    return with_options(model, disableflags=model.opt.disableflags | flags("CONTACT"))


def _half_step(model: Any) -> Any:
    return with_options(model, timestep=model.opt.timestep / 2)


def _armature(trial: Trial) -> Callable[[Any], Any]:
    return _more("dof_armature", trial, 1.0)


def _damping(trial: Trial) -> Callable[[Any], Any]:
    return _more("dof_damping", trial, DAMPING)


def _more(field: str, trial: Trial, share: float) -> Callable[[Any], Any]:
    """More of a property of the joints of the failure, all joints where there are none: as a share of their
    inertias, of damping per time step."""

    @contextmanager
    def change(model: Any) -> Iterator[None]:
        values = getattr(model, field)
        before = values.copy()
        for dof in range(model.nv):
            joint = model.joint(int(model.dof_jntid[dof]))
            if joint.type[0] != mujoco.mjtJoint.mjJNT_FREE and (
                not trial.joints or joint.name in trial.joints
            ):
                inertia = model.dof_M0[dof]
                values[dof] += share * inertia / (model.opt.timestep if field == "dof_damping" else 1.0)
        # What MuJoCo derives from these when it compiles.
        mujoco.mj_setConst(model, mujoco.MjData(model))
        try:
            yield
        finally:
            values[:] = before
            mujoco.mj_setConst(model, mujoco.MjData(model))

    return change


def _deepest(model: Any) -> str:
    """The two bodies whose contact at home is the deepest, and what to do about it."""
    data = at_keyframe(model)
    mujoco.mj_forward(model, data)
    if not data.ncon:
        return "see contact.exclude and mesh.colliders"
    deepest = touching(model, data)[0]
    see = "contact.exclude and mesh.colliders" if deepest.other else "scene.pose"
    names = " and ".join(model.body(body).name for body in (deepest.other, deepest.body))
    return f"{names} overlap by {1000 * deepest.depth:.2g} mm at home, see {see}"
