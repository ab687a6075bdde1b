"""Chooses the names of a robot's links, joints and frames in an SDF, where they share a namespace."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.robot.model.robot import Joint, Loop, Robot
from linkwright.stages.robot.text.names import free

WORLD = "world"
"""The name of a link at the origin of the assembly. An SDF reserves it for the world outside the model."""


@dataclass(frozen=True, slots=True)
class SdfNames:
    """Names in the robot → names in the SDF."""

    links: Mapping[str, str]
    joints: Mapping[str, str]
    """Dof → its joint in the SDF. A joint or loop without dofs is listed by its own name."""

    frames: Mapping[str, str]
    between: Mapping[str, tuple[str, ...]]
    """Joint or loop → the links between its dofs."""

    base: str
    """The joint that holds the root link of a fixed robot."""

    @property
    def changed(self) -> Iterator[tuple[str, str, str]]:
        """Yields (kind, name, name in the SDF) for each link, joint or frame that has another name in the
        SDF."""
        for kind, names in (("link", self.links), ("joint", self.joints), ("frame", self.frames)):
            yield from ((kind, name, sdf_name) for name, sdf_name in names.items() if name != sdf_name)


def sdf_names(robot: Robot) -> SdfNames:
    """Chooses the names in the SDF.

    Links keep their names. Joints keep their names unless a link has the same name, and frames unless a link
    or a joint has it. Generated names differ from all other names.
    """
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    links = [link.name for link in robot.links]
    joints = [name for chain in chains for name in _joints_of(chain)]
    frames = [frame.name for frame in robot.frames]
    all_names = {*map(_allowed_name, (*links, *joints, *frames)), WORLD}
    used_names = {WORLD}

    def assign_names(names: list[str], kind: str) -> dict[str, str]:
        sdf_names = {}
        for name in names:
            sdf_name = _allowed_name(name)
            if sdf_name in used_names:
                sdf_name = free(f"{sdf_name}_{kind}", all_names)
                all_names.add(sdf_name)
            used_names.add(sdf_name)
            sdf_names[name] = sdf_name
        return sdf_names

    # The order decides which names stay.
    link_names = assign_names(links, "link")
    joint_names = assign_names(joints, "joint")
    frame_names = assign_names(frames, "frame")
    all_names |= used_names
    between = {}
    for chain in chains:
        links_between = []
        for number in range(1, len(chain.dofs)):
            links_between.append(free(f"{_allowed_name(chain.name)}_{number}", all_names))
            all_names.add(links_between[-1])
        between[chain.name] = tuple(links_between)
    base = free(f"{link_names[robot.root.name]}_fixed", all_names)
    return SdfNames(link_names, joint_names, frame_names, between, base)


def _joints_of(chain: Joint | Loop) -> list[str]:
    """Returns the names of the SDF joints of a joint or loop: the names of its dofs, or its own name if it
    has no dofs."""
    return [dof.name for dof in chain.dofs] or [chain.name]


def _allowed_name(name: str) -> str:
    """Returns the name without what SDF does not allow: `::`, which separates the names of scopes, and the
    underscores around `__name__`, which is reserved."""
    name = name.replace("::", "_")
    if re.fullmatch("__.*__", name, re.DOTALL):
        name = name.strip("_") or "unnamed"
    return name
