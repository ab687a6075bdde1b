"""Chooses the names of a robot's links, joints and frames in an SDF, where all of them share a namespace."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.robot.model.robot import Joint, Loop, Robot
from linkwright.stages.robot.text.names import free

WORLD = "world"
"""The name that an SDF reserves for the world outside the model. A robot may have a link of this name, at the
origin of its assembly."""


@dataclass(frozen=True, slots=True)
class SdfNames:
    """The names of a robot's elements in an SDF; the keys are the names in the robot."""

    links: Mapping[str, str]
    joints: Mapping[str, str]
    """Dof → its joint in the SDF. A joint or loop without dofs has an entry under its own name."""

    frames: Mapping[str, str]
    links_between: Mapping[str, tuple[str, ...]]
    """Joint or loop → the names of the generated links between its dofs."""

    base_joint: str
    """The name of the generated joint that holds the root link of a fixed robot."""

    @property
    def changes(self) -> Iterator[tuple[str, str, str]]:
        """Yields (kind, name, name in the SDF) for each link, joint or frame that has another name in the
        SDF."""
        for kind, names in (("link", self.links), ("joint", self.joints), ("frame", self.frames)):
            yield from ((kind, name, sdf_name) for name, sdf_name in names.items() if name != sdf_name)


def sdf_names(robot: Robot) -> SdfNames:
    """Chooses the names in the SDF.

    Links keep their names. Joints keep their names unless a link has the same name, and frames unless a link
    or a joint has it. Names that an SDF does not allow are changed. Generated names differ from all others.
    """
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    links = [link.name for link in robot.links]
    joints = [name for chain in chains for name in _joint_names(chain)]
    frames = [frame.name for frame in robot.frames]
    # `used_names` have been assigned; a generated name also avoids names that will be assigned later.
    all_names = {*map(_allowed_name, (*links, *joints, *frames)), WORLD}
    used_names = {WORLD}

    def assign_names(names: list[str], kind: str) -> dict[str, str]:
        """Returns name → name in the SDF, with the suffix `kind` if another element has the name."""
        name_in_sdf = {}
        for name in names:
            sdf_name = _allowed_name(name)
            if sdf_name in used_names:
                sdf_name = free(f"{sdf_name}_{kind}", all_names)
                all_names.add(sdf_name)
            used_names.add(sdf_name)
            name_in_sdf[name] = sdf_name
        return name_in_sdf

    # The order decides which names stay.
    link_names = assign_names(links, "link")
    joint_names = assign_names(joints, "joint")
    frame_names = assign_names(frames, "frame")
    all_names |= used_names
    links_between = {}
    for chain in chains:
        chain_links = []
        for number in range(1, len(chain.dofs)):
            chain_links.append(free(f"{_allowed_name(chain.name)}_{number}", all_names))
            all_names.add(chain_links[-1])
        links_between[chain.name] = tuple(chain_links)
    base_joint = free(f"{link_names[robot.root.name]}_fixed", all_names)
    return SdfNames(link_names, joint_names, frame_names, links_between, base_joint)


def _joint_names(chain: Joint | Loop) -> list[str]:
    """Returns the names for which a joint or loop needs SDF joints: those of its dofs, or its own name if it
    has no dofs."""
    return [dof.name for dof in chain.dofs] or [chain.name]


def _allowed_name(name: str) -> str:
    """Returns a name that an SDF allows: without `::`, which separates scopes, and without the underscores of
    names such as `__name__`, which are reserved."""
    name = name.replace("::", "_")
    if re.fullmatch("__.*__", name, re.DOTALL):
        name = name.strip("_") or "unnamed"
    return name
