"""Keyframes: the named poses of the robot, each where the scene puts it, and of what lies beside it there."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from linkwright.stages.export.mjcf.actuators import KeyedActuator, drives, key_attributes
from linkwright.stages.export.mjcf.joints import free_joint_name, free_qpos, qpos
from linkwright.stages.export.mjcf.sections import drives_of
from linkwright.stages.formats.mjcf.joints import joints_in_order
from linkwright.stages.formats.numbers import TURN, number
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.poses import UNMOVED
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.start_pose import keyframes

if TYPE_CHECKING:
    from linkwright.stages.export.writer import WriterInput
    from linkwright.stages.formats.written import Written


def write_keyframes(root: Element, given: "WriterInput", model: Element | None = None) -> None:
    """The keyframes, with the controls for which the actuators rest there. `model`: the robot's own, where
    `root` is that of the scene."""
    written = given.written
    robot, extras = written.as_mjcf.robot, written.extras
    joints = [node.get("name") for node, _ in joints_in_order(root if model is None else model)]
    beside = {one.name: one.scene or extras.scene_qpos for one in extras.keyframes}
    if not joints and not extras.scene_qpos:
        return
    keyframe = element(root, "keyframe")
    for name, q in keyframes(robot).items():
        texts = dict(_qpos(robot, q, written.start, given.standing.placed(q, name)))
        numbers = [texts[joint] for joint in joints]
        if model is not None:
            numbers += [number(one, least=TURN) for one in beside.get(name, extras.scene_qpos)]
        every = [*_driven(written, name, q), *(drives_of(extras.scene) if model is not None else ())]
        element(keyframe, "key", name=name, qpos=" ".join(numbers), **key_attributes(every))


def _driven(written: "Written", keyframe: str, q: Configuration) -> list[KeyedActuator]:
    """The robot's actuators in the order of the file."""
    extras = written.extras
    every = {one.name: one for one in drives(written.actuation, keyframe, q)}
    every |= {one.name: one for one in drives_of(extras.sections)}
    return [every[name] for name in extras.in_order("actuator", every)]


def _qpos(
    robot: Robot, q: Configuration, start: Configuration, world_from_root: Array
) -> Iterator[tuple[str, str]]:
    """(name, numbers) of every joint of the model at `q`."""
    if not robot.base.fixed:
        yield free_joint_name(robot), free_qpos(world_from_root)
    chains = [(joint.parent_from_joint, joint.dofs) for joint in robot.joints]
    chains += [(loop.b_from_frame, loop.dofs) for loop in robot.loops]
    for parent_from_joint, dofs in chains:
        for dof in dofs:
            world_from_joint = world_from_root @ parent_from_joint if dof.kind == "free" else UNMOVED
            yield dof.name, qpos(dof, q[dof.name], start[dof.name], world_from_joint)
