"""Chooses the names of a robot's things in an SDF, where links, joints and frames share a namespace."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.robot.model.robot import Joint, Loop, Robot
from linkwright.stages.robot.text.names import free

ROOT_OF_ALL = "world"
"""The name of a link that is the origin of the assembly; in an SDF it is the world outside of the model."""


@dataclass(frozen=True, slots=True)
class SdfNames:
    """Names in the robot → names in the SDF."""

    links: Mapping[str, str]
    joints: Mapping[str, str]
    """Names of the dofs of joints and loops; of joints and loops without dofs, their own names."""

    frames: Mapping[str, str]
    between: Mapping[str, tuple[str, ...]]
    """Joint or loop → the links between its dofs."""

    base: str
    """The joint that holds the root link of a fixed robot."""

    @property
    def changed(self) -> Iterator[tuple[str, str, str]]:
        """Yields the things with another name in the SDF: kind, name, and name in the SDF."""
        for kind, names in (("link", self.links), ("joint", self.joints), ("frame", self.frames)):
            yield from ((kind, name, sdf_name) for name, sdf_name in names.items() if name != sdf_name)


def sdf_names(robot: Robot) -> SdfNames:
    """Chooses the names in the SDF.

    A link keeps its name, a joint does unless a link has it, a frame does unless a link or joint has it;
    generated names give way to all others.
    """
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    links = [link.name for link in robot.links]
    joints = [name for chain in chains for name in _joints_of(chain)]
    frames = [frame.name for frame in robot.frames]
    all_names = {*map(_allowed, (*links, *joints, *frames)), ROOT_OF_ALL}
    used_names = {ROOT_OF_ALL}

    def named(names: list[str], kind: str) -> dict[str, str]:
        names_by_robot = {}
        for name in names:
            sdf_name = _allowed(name)
            if sdf_name in used_names:
                sdf_name = free(f"{sdf_name}_{kind}", all_names)
                all_names.add(sdf_name)
            used_names.add(sdf_name)
            names_by_robot[name] = sdf_name
        return names_by_robot

    link_names, joint_names, frame_names = (
        named(links, "link"),
        named(joints, "joint"),
        named(frames, "frame"),
    )
    all_names |= used_names
    between = {}
    for chain in chains:
        links_between = []
        for count in range(1, len(chain.dofs)):
            links_between.append(free(f"{_allowed(chain.name)}_{count}", all_names))
            all_names.add(links_between[-1])
        between[chain.name] = tuple(links_between)
    base = free(f"{link_names[robot.root.name]}_fixed", all_names)
    return SdfNames(link_names, joint_names, frame_names, between, base)


def _joints_of(chain: Joint | Loop) -> list[str]:
    """Returns the names of the SDF's joints for a joint or loop: those of its dofs, or its own without
    dofs."""
    return [dof.name for dof in chain.dofs] or [chain.name]


def _allowed(name: str) -> str:
    """Returns the name as SDF allows it: `::` separates the names of scopes, and `__name__` is reserved."""
    name = name.replace("::", "_")
    if re.fullmatch("__.*__", name, re.DOTALL):
        name = name.strip("_") or "unnamed"
    return name
