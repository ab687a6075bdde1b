"""What stands in a URDF for what a robot has and URDF has no word for: its names, for who writes and who
checks one.

To a URDF a frame is a link, and so are the two frames of a loop and what stands between the dofs of one
joint; a ball is three joints. Links share one space of names there, joints another.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.robot.model.robot import Joint, Robot
from linkwright.stages.robot.text.names import free


@dataclass(frozen=True, slots=True)
class UrdfNames:
    """Names in the URDF by those in the robot.

    `frames`: the link that a frame is; `ends`: the links that a loop's two frames are; `between`: the links
    between the dofs of a joint; `turns`: a ball's joints about x, y and z; `holders`: the joint by which
    each link of `frames` and `ends` is fixed.
    """

    frames: Mapping[str, str]
    ends: Mapping[str, tuple[str, str]]
    between: Mapping[str, tuple[str, ...]]
    turns: Mapping[str, tuple[str, str, str]]
    holders: Mapping[str, str]


def urdf_names(robot: Robot) -> UrdfNames:
    """A frame keeps its name unless a link has it, and so does the joint that holds it unless another joint
    has that; names that are made up give way to all that are not."""
    links = {link.name for link in robot.links}
    every = links | {frame.name for frame in robot.frames}
    frames = {
        frame.name: _taken(f"{frame.name}_frame", every) if frame.name in links else frame.name
        for frame in robot.frames
    }
    between = {
        joint.name: tuple(_taken(f"{joint.name}_{count}", every) for count in range(1, urdf_steps(joint)))
        for joint in robot.joints
    }
    ends = {
        loop.name: (_taken(f"{loop.name}_a", every), _taken(f"{loop.name}_b", every)) for loop in robot.loops
    }
    joints = {joint.name for joint in robot.joints} | {dof.name for dof in robot.dofs}
    holders = {frames[frame.name]: _taken(frame.joint, joints) for frame in robot.frames if frame.joint}
    turns = {}
    for dof in robot.dofs:
        if dof.kind == "ball":
            x, y, z = (_taken(f"{dof.name}_{letter}", joints) for letter in "xyz")
            turns[dof.name] = (x, y, z)
    fixed = [*frames.values(), *(end for pair in ends.values() for end in pair)]
    holders |= {link: _taken(f"{link}_fixed", joints) for link in fixed if link not in holders}
    return UrdfNames(frames, ends, between, turns, holders)


def urdf_steps(joint: Joint) -> int:
    """How many joints of a URDF stand for one."""
    return sum(3 if dof.kind == "ball" else 1 for dof in joint.dofs)


def _taken(name: str, taken: set[str]) -> str:
    """A free name, which is taken from then on."""
    found = free(name, taken)
    taken.add(found)
    return found
