"""Which joints follow trajectories together: those of an arm, of a gripper, and the others."""

from collections.abc import Mapping, Sequence

from linkwright.stages.export.ros2.moveit import Semantics
from linkwright.stages.robot.text.names import free

TRAJECTORY = "joint_trajectory_controller"
"""The name of the controller of the joints that are in no arm of several, and in no gripper."""

_TAKEN = (TRAJECTORY, "velocity_controller", "effort_controller", "joint_state_broadcaster")


def trajectories_of(joints: Sequence[str], semantics: Semantics) -> dict[str, tuple[str, ...]]:
    """The joints of each controller that follows trajectories, by its name. `joints`: those that are
    commanded by position, in the order of the URDF.

    Each gripper has a controller, and so has each arm where there are several. A joint that several arms
    share is with those of no arm.
    """
    taken, rest = {*_TAKEN}, [*joints]
    controllers: dict[str, tuple[str, ...]] = {}
    for group in semantics.grippers:
        held = [joint for joint in rest if joint in semantics.joints[group]]
        if held:
            controllers[_name(group, taken)] = tuple(held)
            rest = [joint for joint in rest if joint not in held]
    arms = _arms(rest, semantics)
    holders = {joint: [name for name, held in arms.items() if joint in held] for joint in rest}
    own = {name: tuple(joint for joint in rest if holders[joint] == [name]) for name in arms}
    shared = tuple(joint for joint in rest if len(holders[joint]) != 1)
    whole = {name: held for name, held in own.items() if held}
    if len(whole) < 2 and not shared:
        shared, whole = tuple(rest), {}
    trajectories = {TRAJECTORY: shared} if shared else {}
    trajectories |= {_name(name, taken): held for name, held in whole.items()}
    return trajectories | controllers


def _name(group: str, taken: set[str]) -> str:
    name = free(f"{group}_controller", taken)
    taken.add(name)
    return name


def _arms(joints: Sequence[str], semantics: Semantics) -> dict[str, frozenset[str]]:
    """The groups that are arms, legs and the like, with those of these joints that they have.

    What carries an end effector is an arm, and groups within it or around it are none. Of the others, a group
    that others make up is none, and neither is a group within another.
    """
    groups: dict[str, frozenset[str]] = {}
    order = sorted(semantics.joints, key=lambda name: name not in semantics.arms)
    for name in order:
        held = frozenset(joints).intersection(semantics.joints[name])
        if held and held not in groups.values():
            groups[name] = held
    arms = {name: held for name, held in groups.items() if name in semantics.arms}
    others = {
        name: held
        for name, held in groups.items()
        if name not in arms and not any(held < arm or held > arm for arm in arms.values())
    }
    simple = {name: held for name, held in others.items() if held != _made_up(held, others)}
    outer = {name for name, held in simple.items() if not any(held < other for other in simple.values())}
    return {name: groups[name] for name in semantics.joints if name in arms or name in outer}


def _made_up(held: frozenset[str], groups: Mapping[str, frozenset[str]]) -> frozenset[str]:
    """The joints of the groups within one."""
    return frozenset(joint for other in groups.values() if other < held for joint in other)
