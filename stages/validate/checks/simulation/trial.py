"""Checks that the model stays finite and stable in a trial run from `home`, with the controls of `home`.

If it fails, the run is repeated with a single change, to tell the user a remedy.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import mujoco

from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.trial import MAX_OPENING, Trial, trial_run
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.simulate.running import flags, touching, with_options

TRIED_DAMPING = 0.1
"""Damping that is tried, as a share of the joint's inertia per time step."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Runs MJCF files, since a URDF has neither a time step nor a home."""
    model = compiled.model
    if compiled.urdf or not model.nv:
        return
    trial = trial_run(model)
    detail = f"simulated for {trial.time:.3g} s from home without a warning; loops opened by at most [m, rad]"
    if trial.failed:
        where = f" at {', '.join(trial.joints[:3])}" if trial.joints else ""
        detail = f"after {trial.time:.3g} s {trial.failed}{where}; {_remedy(model, trial)}"
    yield compiled.result("trial run", not trial.failed, detail, trial.opening, MAX_OPENING)


def _remedy(model: Any, trial: Trial) -> str:
    """Returns the first change with which the run passes, as a text with keys of the configuration."""
    step = model.opt.timestep
    joint = trial.joint or "*"
    for change, words in (
        (_without_contacts, f"without contacts it does not: {_deepest_contact_text(model)}"),
        (_half_step, f"scene.option.timestep={step / 2:g} would fix it"),
        (_armature(trial), f"armature would fix it: joints: {{{joint}: {{armature: ...}}}}"),
        (_damping(trial), f"damping would fix it: joints: {{{joint}: {{damping: ...}}}}"),
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
    return _increase("dof_armature", trial, 1.0)


def _damping(trial: Trial) -> Callable[[Any], Any]:
    return _increase("dof_damping", trial, TRIED_DAMPING)


def _increase(field: str, trial: Trial, share: float) -> Callable[[Any], Any]:
    """Returns a change that increases a property of the failed joints, or of all joints, by a share of their
    inertias, for damping per time step."""

    @contextmanager
    def change(model: Any) -> Iterator[None]:
        values = getattr(model, field)
        saved_values = values.copy()
        for dof in range(model.nv):
            joint = model.joint(int(model.dof_jntid[dof]))
            if joint.type[0] != mujoco.mjtJoint.mjJNT_FREE and (
                not trial.joints or joint.name in trial.joints
            ):
                inertia = model.dof_M0[dof]
                values[dof] += share * inertia / (model.opt.timestep if field == "dof_damping" else 1.0)
        # MuJoCo derives these values when it compiles.
        mujoco.mj_setConst(model, mujoco.MjData(model))
        try:
            yield
        finally:
            values[:] = saved_values
            mujoco.mj_setConst(model, mujoco.MjData(model))

    return change


def _deepest_contact_text(model: Any) -> str:
    """Returns a text with the two bodies whose contact at `home` is the deepest, and the remedy."""
    data = at_keyframe(model)
    mujoco.mj_forward(model, data)
    contacts = touching(model, data)
    if not contacts:
        return "see contact.exclude and mesh.colliders"
    deepest = contacts[0]
    see = "contact.exclude and mesh.colliders" if deepest.other else "scene.pose"
    names = " and ".join(model.body(body).name for body in (deepest.other, deepest.body))
    return f"{names} overlap by {1000 * deepest.depth:.2g} mm at home, see {see}"
