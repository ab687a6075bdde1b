"""Writes keyframes: the named poses of the robot, placed in the scene, and the poses of its other objects."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from linkwright.stages.export.mjcf.actuators import KeyedActuator, key_attributes, keyed_actuators
from linkwright.stages.export.mjcf.joints import free_joint_name, free_qpos, qpos
from linkwright.stages.export.mjcf.sections import keyed_actuators_of
from linkwright.stages.formats.mjcf.joints import joints_in_order
from linkwright.stages.formats.numbers import TURN, number
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.poses import UNMOVED
from linkwright.stages.robot.model.robot import Array, Configuration, Robot
from linkwright.stages.robot.motion.start_pose import keyframes

if TYPE_CHECKING:
    from linkwright.stages.export.writer import WriterInput
    from linkwright.stages.formats.written import Written


def write_keyframes(root: Element, inputs: "WriterInput", model: Element | None = None) -> None:
    """Writes the keyframes, with the controls at which the actuators rest. `root`: the root of the robot's
    file, or of the scene; in the latter case `model` is the root of the robot's file."""
    written = inputs.written
    robot, extras = written.as_mjcf.robot, written.extras
    # The order of `qpos` is that of the joints in the compiled file.
    joints = [node.get("name") for node, _ in joints_in_order(root if model is None else model)]
    scene_qpos_by_name = {keyed.name: keyed.scene or extras.scene_qpos for keyed in extras.keyframes}
    if not joints and not extras.scene_qpos:
        return
    keyframe = element(root, "keyframe")
    for name, q in keyframes(robot).items():
        qpos_by_joint = dict(_qpos_by_joint(robot, q, written.start, inputs.standing.placed(q, name)))
        qpos_texts = [qpos_by_joint[joint] for joint in joints]
        if model is not None:
            # Whether a value is an angle or a length is unknown here; both are written as angles are.
            qpos_texts += [
                number(value, least=TURN) for value in scene_qpos_by_name.get(name, extras.scene_qpos)
            ]
        actuators = [
            *_keyed_robot_actuators(written, name, q),
            *(keyed_actuators_of(extras.scene) if model is not None else ()),
        ]
        element(keyframe, "key", name=name, qpos=" ".join(qpos_texts), **key_attributes(actuators))


def _keyed_robot_actuators(written: "Written", keyframe: str, q: Configuration) -> list[KeyedActuator]:
    """Returns the robot's actuators in the order of the file."""
    extras = written.extras
    actuators = {actuator.name: actuator for actuator in keyed_actuators(written.actuation, keyframe, q)}
    actuators |= {actuator.name: actuator for actuator in keyed_actuators_of(extras.sections)}
    return [actuators[name] for name in extras.in_order("actuator", actuators)]


def _qpos_by_joint(
    robot: Robot, q: Configuration, start: Configuration, world_from_root: Array
) -> Iterator[tuple[str, str]]:
    """Yields (name, numbers in `qpos`) of each joint of the robot and its loops at `q`."""
    if not robot.base.fixed:
        yield free_joint_name(robot), free_qpos(world_from_root)
    chains = [(joint.parent_from_joint, joint.dofs) for joint in robot.joints]
    chains += [(loop.b_from_frame, loop.dofs) for loop in robot.loops]
    for parent_from_joint, dofs in chains:
        for dof in dofs:
            # A free joint is below the world, placed as if its parent were at the root: see `bodies`.
            world_from_joint = world_from_root @ parent_from_joint if dof.kind == "free" else UNMOVED
            yield dof.name, qpos(dof, q[dof.name], start[dof.name], world_from_joint)
