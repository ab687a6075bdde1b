"""Writes the joints of an MJCF: the dofs between a body and its parent.

A body's pose in the file is the one at qpos0. Its joints act one after the other, from parent to child,
each given in the body's own frame at qpos0; `ref` makes a joint's value in `qpos` equal the dof's. A
ball's value is relative to the pose at qpos0; a free joint's value is the pose in the world.
"""

from collections.abc import Collection, Mapping, Sequence

from linkwright.stages.formats.numbers import LENGTH, least_of, number, spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.poses import UNMOVED, inverse, motion, quat_from_rotation
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Robot, Value
from linkwright.stages.robot.motion.kinematics import chain
from linkwright.stages.robot.text.names import free_name

UNBOUNDED_END = "1e6"
"""Substitute [rad or m] for the missing end of a one-sided limit: MuJoCo has no one-sided range."""

JOINT_TYPES = {"turn": "hinge", "slide": "slide", "ball": "ball"}
"""Kind of a dof → MuJoCo's type of its joint."""

NO_ATTRIBUTES: Mapping[str, Mapping[str, str]] = {}


def write_joints(
    body: Element,
    dofs: Sequence[Dof],
    start: Configuration,
    compensating: Collection[str] = (),
    body_from_link: Array = UNMOVED,
    source_attributes: Mapping[str, Mapping[str, str]] = NO_ATTRIBUTES,
) -> None:
    """Writes the `<joint>`s of a body. The pose of its link in the parent is the chain of `dofs` at `start`.

    `compensating`: the dofs whose actuators hold the weight that bodies compensate; `body_from_link` (4, 4);
    `source_attributes`: dof → its attributes in an MJCF source, which override those of the robot.
    """
    for index, dof in enumerate(dofs):
        later_dofs = dofs[index + 1 :]
        body_from_dof = body_from_link @ inverse(chain(later_dofs, start)) if later_dofs else body_from_link
        if dof.kind == "free":
            element(body, "freejoint", name=dof.name)
        else:
            attributes = _joint_attributes(dof, body_from_dof, start[dof.name], dof.name in compensating)
            element(body, "joint", **{**attributes, **source_attributes.get(dof.name, {})})


def _joint_attributes(
    dof: Dof, body_from_dof: Array, start: Value, is_compensating: bool
) -> dict[str, str | None]:
    """Returns the attributes of a joint. `start`: its value at qpos0; `is_compensating`: whether its
    actuators hold the weight that bodies compensate."""
    dynamics, spring = dof.dynamics, dof.spring
    position = spaced(body_from_dof[:3, 3], least=LENGTH)
    # A ball has no axis. Its limit is a cone, which MuJoCo does not have.
    scalar_attributes: dict[str, str | None] = {}
    if not isinstance(start, tuple):
        effort, ref = dynamics.effort, number(start, least=least_of(dof.kind))
        scalar_attributes = {
            "axis": spaced(body_from_dof[:3, :3] @ dof.axis),
            "range": _range(dof),
            "ref": None if ref == "0" else ref,
            "actuatorfrcrange": None if effort is None else f"{number(-effort)} {number(effort)}",
        }
    return {
        "name": dof.name,
        "type": JOINT_TYPES[dof.kind],
        "pos": None if position == "0 0 0" else position,
        "axis": scalar_attributes.get("axis"),
        "range": scalar_attributes.get("range"),
        "ref": scalar_attributes.get("ref"),
        "stiffness": None if spring is None else number(spring.stiffness),
        "springref": number(spring.reference) if spring is not None and spring.reference else None,
        "damping": _number(dynamics.damping),
        "frictionloss": _number(dynamics.friction),
        "armature": _number(dynamics.armature),
        "actuatorfrcrange": scalar_attributes.get("actuatorfrcrange"),
        "actuatorgravcomp": "true" if is_compensating else None,
    }


def _number(value: float | None) -> str | None:
    """Returns the text of a number that may be unset."""
    return None if value is None else number(value)


def _range(dof: Dof) -> str | None:
    """Returns the range of a turn or slide; None without limits."""
    lower, upper = dof.limits.lower, dof.limits.upper
    if lower is None and upper is None:
        return None
    least = least_of(dof.kind)
    texts = spaced([end for end in (lower, upper) if end is not None], least=least).split()
    return " ".join(["-" + UNBOUNDED_END] * (lower is None) + texts + [UNBOUNDED_END] * (upper is None))


def qpos(dof: Dof, value: Value, start: Value, world_from_joint: Array) -> str:
    """Returns a dof's numbers in `qpos` at `value`. `start`: its value at qpos0; `world_from_joint` (4, 4):
    for a free joint, the frame to which its value is relative."""
    if not isinstance(value, tuple):
        return number(value, least=least_of(dof.kind))
    pose = motion(dof.kind, dof.axis, value)
    if dof.kind == "free":
        return free_qpos(world_from_joint @ pose)
    rotation = motion(dof.kind, dof.axis, start)[:3, :3].T @ pose[:3, :3]
    return spaced(quat_from_rotation(rotation))


def free_qpos(pose: Array) -> str:
    """Returns the seven numbers of a free joint at a pose (4, 4) in the world: position [m] and
    quaternion."""
    return f"{spaced(pose[:3, 3], least=LENGTH)} {spaced(quat_from_rotation(pose[:3, :3]))}"


def free_joint_name(robot: Robot) -> str:
    """Returns the name of the free joint of a floating base."""
    used_names = {dof.name for dof in robot.dofs} | {dof.name for loop in robot.loops for dof in loop.dofs}
    return free_name(robot.base.joint or f"{robot.root.name}_free", used_names)
