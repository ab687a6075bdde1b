"""The names of a robot's things as prims of a USD: identifiers, which every version of USD reads."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.robot.model.robot import Joint, Loop, Robot
from linkwright.stages.robot.text.names import free, plain


@dataclass(frozen=True, slots=True)
class UsdNames:
    """Names of prims by those in the robot.

    `joints`: of dofs, and of joints and loops without any; those of loops too. `between`: the links between
    the dofs of a joint or loop. `base`: the joint that holds the root link of a fixed robot. `scopes`: the
    prims beside the links, by what they hold.
    """

    robot: str
    links: Mapping[str, str]
    joints: Mapping[str, str]
    between: Mapping[str, tuple[str, ...]]
    base: str
    scopes: Mapping[str, str]

    @property
    def changed(self) -> Iterator[tuple[str, str, str]]:
        """What has another name in the USD: its kind, its name, and that in the USD."""
        for kind, names in (("link", self.links), ("joint", self.joints)):
            yield from ((kind, name, own) for name, own in names.items() if name != own)


def usd_names(robot: Robot) -> UsdNames:
    """Links and joints keep their names where these are identifiers; what is made up gives way."""
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    links = identifiers(link.name for link in robot.links)
    joints = identifiers(name for one in chains for name in joints_of(one))
    siblings = set(links.values())
    between = {one.name: tuple(_added(one, siblings)) for one in chains}
    scopes = {}
    for name in ("joints", "materials"):
        scopes[name] = free(name, siblings)
        siblings.add(scopes[name])
    base = free("root_joint", set(joints.values()))
    return UsdNames(identifier(robot.name), links, joints, between, base, scopes)


def identifiers(names: Iterable[str], taken: Iterable[str] = ()) -> dict[str, str]:
    """An identifier for each name, none of them twice or among `taken`: names that are identifiers keep
    theirs."""
    names = list(dict.fromkeys(names))
    used = set(taken)
    found = {name: name for name in names if identifier(name) == name and name not in used}
    used |= found.keys()
    for name in names:
        if name not in found:
            found[name] = free(identifier(name), used)
            used.add(found[name])
    return {name: found[name] for name in names}


def identifier(name: str) -> str:
    """The name in [A-Za-z0-9_], and with no digit first."""
    own = plain(name)
    return f"_{own}" if own[0].isdigit() else own


def joints_of(one: Joint | Loop) -> list[str]:
    """What may become a joint of the USD: each dof, or the joint itself where it has none; also a loop of
    several dofs."""
    names = [dof.name for dof in one.dofs]
    return [*names, one.name] if not names or (isinstance(one, Loop) and len(names) > 1) else names


def _added(one: Joint | Loop, siblings: set[str]) -> Iterator[str]:
    for count in range(1, len(one.dofs)):
        name = free(f"{identifier(one.name)}_{count}", siblings)
        siblings.add(name)
        yield name
