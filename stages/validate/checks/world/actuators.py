"""Checks that each actuator drives its dof with its gains and ranges, and has a control in each keyframe."""

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import actuator_count, controls_of, index_of, joint_index
from linkwright.stages.mujoco.state import keyframe_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.dynamics.holding_control import holding_control, holding_state, torque_per_volt
from linkwright.stages.robot.model.actuation import Actuator
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, children_of
from linkwright.stages.robot.model.robot import Configuration, Value
from linkwright.stages.robot.motion.start_pose import HOME, keyframes
from linkwright.stages.validate.compiled import SCENE, CompiledModel
from linkwright.stages.validate.findings import differs, few, named, shown
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks MJCFs, and scenes that have the robot's keyframes. A URDF has no actuators."""
    scene = compiled.path.name == SCENE
    if compiled.urdf or (scene and not compiled.has_keyframes):
        return
    model, expected = compiled.model, compiled.written.actuation.actuators
    extras = compiled.robot.mjcf or NO_EXTRAS
    sections = (*extras.sections, *(extras.scene if scene else ()))
    source_names = [element.name for element in children_of(sections, "actuator")]
    number = len(expected) + len(source_names) + compiled.surplus.actuators
    total = actuator_count(model)
    if not expected and total == number:
        return
    poses = keyframes(compiled.robot) if compiled.has_keyframes else {}
    differences = {actuator.name: [*_differences(model, actuator, poses)] for actuator in expected}
    wrong = {name: findings for name, findings in differences.items() if findings}
    detail = f"{len(expected)} actuators with their dofs, gains and ranges"
    findings = [finding for findings in wrong.values() for finding in findings]
    if wrong:
        detail = f"differ: {', '.join(wrong)}"
    elif total != number:
        detail = f"expected {number} actuators, found {total}"
        own_names = {*source_names, *(actuator.name for actuator in expected)}
        names = [model.actuator(index).name for index in range(total)]
        message = "is not part of the robot"
        findings = [
            Finding(named("actuator", name), "name", message) for name in names if name not in own_names
        ]
    passed = not wrong and total == number
    yield compiled.result("actuators", passed, detail, float(len(wrong)), 0.0, few(findings))


def _differences(model: Any, actuator: Actuator, poses: Mapping[str, Configuration]) -> Iterator[Finding]:
    """Yields the differences of an actuator. `poses`: the poses of the file's keyframes, by name."""
    element = named(actuator.type, actuator.name)
    index = index_of(model, mujoco.mjtObj.mjOBJ_ACTUATOR, actuator.name)
    if index < 0:
        yield Finding(element, "name", "there is no actuator of this name")
        return
    driven = int(model.actuator_trnid[index][0])
    on_joint = int(model.actuator_trntype[index]) == mujoco.mjtTrn.mjTRN_JOINT
    if driven != joint_index(model, actuator.dof) or not on_joint:
        target = model.joint(driven).name if on_joint and driven >= 0 else "another thing"
        yield differs(element, "joint", target, actuator.dof)
    gear = float(model.actuator_gear[index][0])
    if not _is_same_number(gear, actuator.gear):
        yield differs(element, "gear", gear, actuator.gear)
    gains = [gain for gain in _gains(model, index, actuator) if not _is_same_number(*gain[1:])]
    # A gain is both in the force and in its bias: a single finding is enough.
    for attribute, number, goal in {gain[0]: gain for gain in reversed(gains)}.values():
        yield differs(element, attribute, number, goal)
    yield from _ranges(model, index, actuator, element)
    for name, pose in poses.items():
        yield from _keyframe_differences(model, index, actuator, name, pose[actuator.dof])


def _ranges(model: Any, index: int, actuator: Actuator, element: str) -> Iterator[Finding]:
    """Compares the ranges of control and force. Whether there is a range is not compared for an actuator with
    `saturation`."""
    control = controls_of(model, index).start
    saturated = any(name == "saturation" for name, _ in actuator.terms)
    for attribute, ends, limited, numbers in (
        (
            "ctrlrange",
            actuator.control,
            model.actuator_ctrllimited[control],
            model.actuator_ctrlrange[control],
        ),
        ("forcerange", actuator.force, model.actuator_forcelimited[index], model.actuator_forcerange[index]),
    ):
        if bool(limited) != (ends is not None) and not saturated:
            yield differs(element, attribute, numbers if limited else None, ends)
        elif ends is not None and not all(map(_is_same_number, numbers, ends)):
            yield differs(element, attribute, numbers, ends)


def _keyframe_differences(
    model: Any, index: int, actuator: Actuator, name: str, value: Value
) -> Iterator[Finding]:
    """Compares the control and the state at a keyframe, with the dof at `value`. Only `home` must exist here:
    another check looks for the other keyframes."""
    key = keyframe_index(model, name)
    assert not isinstance(value, tuple), "an actuator drives one turn or slide"
    force = actuator.force_at(name)
    state = holding_state(actuator, value, force)
    first, size = int(model.actuator_actadr[index]), int(model.actuator_actnum[index])
    if name == HOME and size != len(state):
        yield differs(named(actuator.type, actuator.name), "dyntype", f"of {size} states", str(len(state)))
    if key < 0 and name != HOME:
        return
    element = named("key", name)
    control = float(model.key_ctrl[key][controls_of(model, index).start]) if key >= 0 else np.nan
    expected = actuator.home if name == HOME else holding_control(actuator, value, force)
    if not _is_same_number(control, expected):
        yield Finding(element, "ctrl", f"of {actuator.name} is {shown(control)}, expected {shown(expected)}")
    if state and size == len(state) and key >= 0:
        activation = model.key_act[key][first : first + size]
        if not all(map(_is_same_number, activation, state)):
            yield Finding(
                element, "act", f"of {actuator.name} is {shown(activation)}, expected {shown(state)}"
            )


def _gains(model: Any, index: int, actuator: Actuator) -> list[tuple[str, float, float]]:
    """Returns (attribute, value, expected value) for each gain of an actuator, by its type, kp and kv."""
    gain, bias = model.actuator_gainprm[index], model.actuator_biasprm[index]
    kp, kv = actuator.kp or 0.0, actuator.kv or 0.0
    servo = (("kp", kp), ("biasprm", 0.0), ("kp", -kp), ("kv", -kv))
    by_type = {
        "position": servo,
        "intvelocity": servo,
        "velocity": (("kv", kv), ("biasprm", 0.0), ("biasprm", 0.0), ("kv", -kv)),
        "motor": (("gainprm", 1.0), *(("biasprm", 0.0),) * 3),
    }
    if actuator.type == "damper":
        return [("kv", gain[2], -kv)]
    if actuator.type == "pid":
        return [("kp", bias[1], -kp), ("kv", bias[2], -kv)]
    if actuator.type == "dcmotor":
        return [("motorconst", gain[1] / gain[0], torque_per_volt(actuator))]
    values = (gain[0], *bias[:3])
    return [
        (attribute, float(number), expected)
        for (attribute, expected), number in zip(by_type.get(actuator.type, ()), values, strict=False)
    ]


def _is_same_number(value: float, expected: float) -> bool:
    """Tells whether two numbers are equal within `ENGINE_TOLERANCE`, relative for numbers above 1."""
    return bool(abs(value - expected) <= ENGINE_TOLERANCE * max(1.0, abs(expected)))
