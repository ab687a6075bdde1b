"""Chooses the names of a robot's links, joints and frames in an SDF, where all of them share a namespace."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.robot.model.robot import Joint, Loop, Robot
from linkwright.stages.robot.text.names import free_name

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

    def changed_names(self) -> Iterator[tuple[str, str, str]]:
        """Yields (kind, name, name in the SDF) for each link, joint or frame that has another name in the
        SDF."""
        for kind, names in (("link", self.links), ("joint", self.joints), ("frame", self.frames)):
            yield from ((kind, name, sdf_name) for name, sdf_name in names.items() if name != sdf_name)


def sdf_names(robot: Robot) -> SdfNames:
    """Chooses the names in the SDF.

    A name that an SDF does not allow is first replaced by an allowed name. Links keep these names; joints
    keep them unless a link has the same name, and frames unless a link or a joint has it. Generated names
    differ from all others.
    """
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    links = [link.name for link in robot.links]
    joints = [name for chain in chains for name in _joint_names(chain)]
    frames = [frame.name for frame in robot.frames]
    namespace = _Namespace((*links, *joints, *frames))
    # The order decides which names stay.
    link_names = namespace.assign(links, "link")
    joint_names = namespace.assign(joints, "joint")
    frame_names = namespace.assign(frames, "frame")
    links_between = {
        chain.name: tuple(
            namespace.generate(f"{_allowed_name(chain.name)}_{number}")
            for number in range(1, len(chain.dofs))
        )
        for chain in chains
    }
    base_joint = namespace.generate(f"{link_names[robot.root.name]}_fixed")
    return SdfNames(link_names, joint_names, frame_names, links_between, base_joint)


class _Namespace:
    """The names of an SDF while they are chosen."""

    def __init__(self, names: Iterable[str]) -> None:
        """`names`: all names in the robot that will be assigned, which generated names avoid."""
        self._all_names = {*map(_allowed_name, names), WORLD}
        self._used_names = {WORLD}
        """The names in the SDF that are assigned already."""

    def assign(self, names: Iterable[str], kind: str) -> dict[str, str]:
        """Returns name → name in the SDF, with the suffix `kind` if another element has the name."""
        sdf_name_by_name = {}
        for name in names:
            sdf_name = _allowed_name(name)
            if sdf_name in self._used_names:
                sdf_name = self.generate(f"{sdf_name}_{kind}")
            self._used_names.add(sdf_name)
            sdf_name_by_name[name] = sdf_name
        return sdf_name_by_name

    def generate(self, base_name: str) -> str:
        """Returns a name that no other element has: `base_name`, with a number if necessary."""
        name = free_name(base_name, self._all_names)
        self._all_names.add(name)
        return name


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
