"""The names of a robot's things in an SDF, where links, joints and frames share one space of names."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.robot.model.robot import Joint, Loop, Robot
from linkwright.stages.robot.text.names import free

ROOT_OF_ALL = "world"
"""A link of this name is the origin of the assembly; to an SDF it is what is outside of the model."""


@dataclass(frozen=True, slots=True)
class SdfNames:
    """Names in the SDF by those in the robot.

    `joints`: of dofs, and of joints and loops without any; of those of loops too. `between`: the links
    between the dofs of a joint or loop. `base`: the joint that holds the root link of a fixed robot.
    """

    links: Mapping[str, str]
    joints: Mapping[str, str]
    frames: Mapping[str, str]
    between: Mapping[str, tuple[str, ...]]
    base: str

    @property
    def changed(self) -> Iterator[tuple[str, str, str]]:
        """What has another name in the SDF: its kind, its name, and that in the SDF."""
        for kind, names in (("link", self.links), ("joint", self.joints), ("frame", self.frames)):
            yield from ((kind, name, own) for name, own in names.items() if name != own)


def sdf_names(robot: Robot) -> SdfNames:
    """A link keeps its name, a joint does unless a link has it, a frame unless a link or joint has it; names
    that are made up give way to all that are not."""
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    links = [link.name for link in robot.links]
    joints = [name for one in chains for name in _joints_of(one)]
    frames = [frame.name for frame in robot.frames]
    every = {*map(_allowed, (*links, *joints, *frames)), ROOT_OF_ALL}
    taken = {ROOT_OF_ALL}

    def named(names: list[str], kind: str) -> dict[str, str]:
        found = {}
        for name in names:
            own = _allowed(name)
            if own in taken:
                own = free(f"{own}_{kind}", every)
                every.add(own)
            taken.add(own)
            found[name] = own
        return found

    own_links, own_joints, own_frames = named(links, "link"), named(joints, "joint"), named(frames, "frame")
    every |= taken
    between = {}
    for one in chains:
        made = []
        for count in range(1, len(one.dofs)):
            made.append(free(f"{_allowed(one.name)}_{count}", every))
            every.add(made[-1])
        between[one.name] = tuple(made)
    base = free(f"{own_links[robot.root.name]}_fixed", every)
    return SdfNames(own_links, own_joints, own_frames, between, base)


def _joints_of(one: Joint | Loop) -> list[str]:
    """What becomes a joint of the SDF: each dof, or the joint itself where it has none."""
    return [dof.name for dof in one.dofs] or [one.name]


def _allowed(name: str) -> str:
    """The name as SDF allows it: `::` stands between names of scopes, and `__name__` is reserved."""
    name = name.replace("::", "_")
    if re.fullmatch("__.*__", name, re.DOTALL):
        name = name.strip("_") or "unnamed"
    return name
