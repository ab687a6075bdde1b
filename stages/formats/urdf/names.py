"""Chooses names in a URDF for the things of a robot that are extra links and joints there.

In a URDF a frame is a link, and so are the two frames of a loop and the bodies between the dofs of a joint; a
ball is three joints. Links and joints have separate namespaces there.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.robot.model.robot import Joint, Robot
from linkwright.stages.robot.text.names import free_name


@dataclass(frozen=True, slots=True)
class UrdfNames:
    """Names in the robot → names in the URDF."""

    frames: Mapping[str, str]
    """Frame → the link that represents it."""

    ends: Mapping[str, tuple[str, str]]
    """Loop → the links that represent its two frames."""

    links_between: Mapping[str, tuple[str, ...]]
    """Joint → the links between its dofs."""

    turns: Mapping[str, tuple[str, str, str]]
    """Ball → its joints about x, y and z."""

    holders: Mapping[str, str]
    """Link of `frames` or `ends` → the joint that fixes it."""


def urdf_names(robot: Robot) -> UrdfNames:
    """Chooses the names in the URDF.

    A frame keeps its name unless a link has it, and so does the joint that holds it unless another joint has
    that name; generated names give way to all others.
    """
    links = {link.name for link in robot.links}
    link_names = links | {frame.name for frame in robot.frames}
    frames = {
        frame.name: _take(f"{frame.name}_frame", link_names) if frame.name in links else frame.name
        for frame in robot.frames
    }
    between = {
        joint.name: tuple(_take(f"{joint.name}_{count}", link_names) for count in range(1, urdf_steps(joint)))
        for joint in robot.joints
    }
    ends = {
        loop.name: (_take(f"{loop.name}_a", link_names), _take(f"{loop.name}_b", link_names))
        for loop in robot.loops
    }
    joints = {joint.name for joint in robot.joints} | {dof.name for dof in robot.dofs}
    holders = {frames[frame.name]: _take(frame.joint, joints) for frame in robot.frames if frame.joint}
    turns = {}
    for dof in robot.dofs:
        if dof.kind == "ball":
            x, y, z = (_take(f"{dof.name}_{letter}", joints) for letter in "xyz")
            turns[dof.name] = (x, y, z)
    fixed = [*frames.values(), *(end for pair in ends.values() for end in pair)]
    holders |= {link: _take(f"{link}_fixed", joints) for link in fixed if link not in holders}
    return UrdfNames(frames, ends, between, turns, holders)


def urdf_steps(joint: Joint) -> int:
    """Returns the number of joints of a URDF for a joint of the robot."""
    return sum(3 if dof.kind == "ball" else 1 for dof in joint.dofs)


def _take(name: str, taken: set[str]) -> str:
    """Returns a free name, by adding a number to `name` if necessary, and adds it to `taken`."""
    chosen = free_name(name, taken)
    taken.add(chosen)
    return chosen
