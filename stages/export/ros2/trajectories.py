"""Groups the joints that follow trajectories together: those of each arm, of each gripper, and the others."""

from collections.abc import Mapping, Sequence

from linkwright.stages.export.ros2.moveit import Semantics
from linkwright.stages.robot.text.names import free_name

TRAJECTORY = "joint_trajectory_controller"
"""Name of the controller of all joints that are in no gripper, and in no arm or in several arms."""

_RESERVED_NAMES = (TRAJECTORY, "velocity_controller", "effort_controller", "joint_state_broadcaster")
"""Names of controllers that no group gives its controller."""


def trajectories_of(joints: Sequence[str], semantics: Semantics) -> dict[str, tuple[str, ...]]:
    """Returns name of each controller that follows trajectories → its joints. `joints`: the joints that are
    commanded by position, in the order of the URDF.

    Each gripper has a controller, and so has each arm, unless a single arm has all other joints. The
    remaining joints, including those that several arms share, have one controller, `TRAJECTORY`.
    """
    used_names, remaining = {*_RESERVED_NAMES}, [*joints]
    controllers: dict[str, tuple[str, ...]] = {}
    for group in semantics.grippers:
        members = [joint for joint in remaining if joint in semantics.joints[group]]
        if members:
            controllers[_controller_name(group, used_names)] = tuple(members)
            remaining = [joint for joint in remaining if joint not in members]
    arms = _arms(remaining, semantics)
    arms_by_joint = {
        joint: [name for name, members in arms.items() if joint in members] for joint in remaining
    }
    joints_of_single_arm = {
        name: tuple(joint for joint in remaining if arms_by_joint[joint] == [name]) for name in arms
    }
    other_joints = tuple(joint for joint in remaining if len(arms_by_joint[joint]) != 1)
    arm_joints = {name: members for name, members in joints_of_single_arm.items() if members}
    if len(arm_joints) < 2 and not other_joints:
        other_joints, arm_joints = tuple(remaining), {}
    trajectories = {TRAJECTORY: other_joints} if other_joints else {}
    trajectories |= {_controller_name(name, used_names): members for name, members in arm_joints.items()}
    return trajectories | controllers


def _controller_name(group: str, used_names: set[str]) -> str:
    """Returns a free name for the controller of a group, and adds it to `used_names`."""
    name = free_name(f"{group}_controller", used_names)
    used_names.add(name)
    return name


def _arms(joints: Sequence[str], semantics: Semantics) -> dict[str, frozenset[str]]:
    """Returns the groups that are arms, legs and the like, with their joints among `joints`.

    A group that carries an end effector is an arm, and groups within it or around it are not. Of the other
    groups, those that consist of others, or are within another, are not arms either.
    """
    groups: dict[str, frozenset[str]] = {}
    names = sorted(semantics.joints, key=lambda name: name not in semantics.arms)
    for name in names:
        members = frozenset(joints).intersection(semantics.joints[name])
        if members and members not in groups.values():
            groups[name] = members
    arms = {name: members for name, members in groups.items() if name in semantics.arms}
    candidates = {
        name: members
        for name, members in groups.items()
        if name not in arms and not any(members < arm or members > arm for arm in arms.values())
    }
    undivided = {
        name: members
        for name, members in candidates.items()
        if members != _joints_of_inner_groups(members, candidates)
    }
    outermost = {
        name
        for name, members in undivided.items()
        if not any(members < other for other in undivided.values())
    }
    return {name: groups[name] for name in semantics.joints if name in arms or name in outermost}


def _joints_of_inner_groups(members: frozenset[str], groups: Mapping[str, frozenset[str]]) -> frozenset[str]:
    """Returns the joints of the groups within a group."""
    return frozenset(joint for inner in groups.values() if inner < members for joint in inner)
