"""Each actuator drives its dof with its gains and ranges, and each keyframe has its control and its state."""

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import index_of, joint_index
from linkwright.stages.mujoco.state import keyframe_of
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.dynamics.holding_control import control_at, state_at, torque_per_volt
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, children_of
from linkwright.stages.robot.model.robot import Configuration, Value
from linkwright.stages.robot.motion.start_pose import HOME, keyframes
from linkwright.stages.validate.compiled import SCENE, CompiledModel
from linkwright.stages.validate.findings import differs, few, named, shown
from linkwright.stages.validate.model.coordinates import SAME


def check(compiled: CompiledModel) -> Iterator[Check]:
    """A URDF has no actuators. Of a scene only where the robot's keyframes are in it."""
    scene = compiled.path.name == SCENE
    if compiled.urdf or (scene and not compiled.has_keyframes):
        return
    model, expected = compiled.model, compiled.written.actuation.actuators
    extras = compiled.robot.mjcf or NO_EXTRAS
    sections = (*extras.sections, *(extras.scene if scene else ()))
    more = [element.name for element in children_of(sections, "actuator")]
    number = len(expected) + len(more) + compiled.surplus.actuators
    if not expected and model.nu == number:
        return
    poses = keyframes(compiled.robot) if compiled.has_keyframes else {}
    wrong = {one.name: found for one in expected if (found := [*_differences(model, one, poses)])}
    detail = f"{len(expected)} actuators with their dofs, gains and ranges"
    findings = [found for every in wrong.values() for found in every]
    if wrong:
        detail = f"differ: {', '.join(wrong)}"
    elif model.nu != number:
        detail = f"expected {number} actuators, found {model.nu}"
        known = {*more, *(one.name for one in expected)}
        names = [model.actuator(index).name for index in range(model.nu)]
        message = "is not one of the robot's"
        findings = [Finding(named("actuator", name), "name", message) for name in names if name not in known]
    passed = not wrong and model.nu == number
    yield compiled.result("actuators", passed, detail, float(len(wrong)), 0.0, few(findings))


def _differences(model: Any, one: Actuator, poses: Mapping[str, Configuration]) -> Iterator[Finding]:
    """`poses`: of the keyframes that the file has, by name."""
    element = named(one.type, one.name)
    index = index_of(model, mujoco.mjtObj.mjOBJ_ACTUATOR, one.name)
    if index < 0:
        yield Finding(element, "name", "there is no actuator of this name")
        return
    driven = int(model.actuator_trnid[index][0])
    on_joint = int(model.actuator_trntype[index]) == mujoco.mjtTrn.mjTRN_JOINT
    if driven != joint_index(model, one.dof) or not on_joint:
        found = model.joint(driven).name if on_joint and driven >= 0 else "another thing"
        yield differs(element, "joint", found, one.dof)
    gear = float(model.actuator_gear[index][0])
    if not _same(gear, one.gear):
        yield differs(element, "gear", gear, one.gear)
    gains = [found for found in _gains(model, index, one) if not _same(*found[1:])]
    # A gain counts in the force and in its bias: the first says it all.
    for attribute, number, wanted in {found[0]: found for found in reversed(gains)}.values():
        yield differs(element, attribute, number, wanted)
    yield from _ranges(model, index, one, element)
    for name, pose in poses.items():
        yield from _at_rest(model, index, one, name, pose[one.dof])


def _ranges(model: Any, index: int, one: Actuator, element: str) -> Iterator[Finding]:
    saturated = any(name == "saturation" for name, _ in one.terms)
    for attribute, ends, limited, numbers in (
        ("ctrlrange", one.control, model.actuator_ctrllimited[index], model.actuator_ctrlrange[index]),
        ("forcerange", one.force, model.actuator_forcelimited[index], model.actuator_forcerange[index]),
    ):
        if bool(limited) != (ends is not None) and not saturated:
            yield differs(element, attribute, numbers if limited else None, ends)
        elif ends is not None and not all(map(_same, numbers, ends)):
            yield differs(element, attribute, numbers, ends)


def _at_rest(model: Any, index: int, one: Actuator, name: str, value: Value) -> Iterator[Finding]:
    """The control and the state at a keyframe, with the dof at `value`. Only `home` must be there: that
    others are is another check's."""
    key = keyframe_of(model, name)
    assert not isinstance(value, tuple), "an actuator drives one turn or slide"
    force = one.force_at(name)
    state = state_at(one, value, force)
    first, size = int(model.actuator_actadr[index]), int(model.actuator_actnum[index])
    if name == HOME and size != len(state):
        yield differs(named(one.type, one.name), "dyntype", f"of {size} states", str(len(state)))
    if key < 0 and name != HOME:
        return
    element = named("key", name)
    control = float(model.key_ctrl[key][index]) if key >= 0 else np.nan
    wanted = one.home if name == HOME else control_at(one, value, force)
    if not _same(control, wanted):
        yield Finding(element, "ctrl", f"of {one.name} is {shown(control)}, expected {shown(wanted)}")
    if state and size == len(state) and key >= 0:
        found = model.key_act[key][first : first + size]
        if not all(map(_same, found, state)):
            yield Finding(element, "act", f"of {one.name} is {shown(found)}, expected {shown(state)}")


def _gains(model: Any, index: int, one: Actuator) -> list[tuple[str, float, float]]:
    """(attribute, in the model, expected) of what the type of an actuator, with its kp and kv, makes of the
    force."""
    gain, bias = model.actuator_gainprm[index], model.actuator_biasprm[index]
    kp, kv = one.kp or 0.0, one.kv or 0.0
    servo = (("kp", kp), ("biasprm", 0.0), ("kp", -kp), ("kv", -kv))
    known = {
        "position": servo,
        "intvelocity": servo,
        "velocity": (("kv", kv), ("biasprm", 0.0), ("biasprm", 0.0), ("kv", -kv)),
        "motor": (("gainprm", 1.0), *(("biasprm", 0.0),) * 3),
    }
    if one.type == "damper":
        return [("kv", gain[2], -kv)]
    if one.type == "pid":
        return [("kp", bias[1], -kp), ("kv", bias[2], -kv)]
    if one.type == "dcmotor":
        return [("motorconst", gain[1] / gain[0], torque_per_volt(one))]
    found = (gain[0], *bias[:3])
    return [
        (attribute, float(number), wanted)
        for (attribute, wanted), number in zip(known.get(one.type, ()), found, strict=False)
    ]


def _same(found: float, expected: float) -> bool:
    return bool(abs(found - expected) <= SAME * max(1.0, abs(expected)))
