"""Chooses the names of a robot's things as prims of a USD: identifiers, which every version of USD reads."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from linkwright.stages.robot.model.robot import Joint, Loop, Robot
from linkwright.stages.robot.text.names import free_name, plain


@dataclass(frozen=True, slots=True)
class UsdNames:
    """Names in the robot → names of prims."""

    robot: str
    """The name of the root prim."""

    links: Mapping[str, str]
    joints: Mapping[str, str]
    """Names of the dofs of joints and loops; of joints and loops without dofs, their own names."""

    links_between: Mapping[str, tuple[str, ...]]
    """Joint or loop → the links between its dofs."""

    base_joint: str
    """The joint that holds the root link of a fixed robot."""

    scopes: Mapping[str, str]
    """Content → the prim next to the links that holds it."""

    def changed_names(self) -> Iterator[tuple[str, str, str]]:
        """Yields (kind, name, name in the USD) for each link or joint that has another name in the USD."""
        for kind, names in (("link", self.links), ("joint", self.joints)):
            yield from ((kind, name, prim) for name, prim in names.items() if name != prim)


def usd_names(robot: Robot) -> UsdNames:
    """Chooses the names in the USD. Links and joints keep names that are identifiers; generated names give
    way."""
    chains: list[Joint | Loop] = [*robot.joints, *robot.loops]
    links = identifiers(link.name for link in robot.links)
    joints = identifiers(name for chain in chains for name in joints_of(chain))
    siblings = set(links.values())
    between = {chain.name: tuple(_names_between(chain, siblings)) for chain in chains}
    scopes = {}
    for name in ("joints", "materials", "actuators"):
        scopes[name] = free_name(name, siblings)
        siblings.add(scopes[name])
    base = free_name("root_joint", set(joints.values()))
    return UsdNames(identifier(robot.name), links, joints, between, base, scopes)


def identifiers(names: Iterable[str], taken: Iterable[str] = ()) -> dict[str, str]:
    """Returns an identifier for each name, unique and not among `taken`; names that are identifiers stay."""
    names = list(dict.fromkeys(names))
    used_names = set(taken)
    prims = {name: name for name in names if identifier(name) == name and name not in used_names}
    used_names |= prims.keys()
    for name in names:
        if name not in prims:
            prims[name] = free_name(identifier(name), used_names)
            used_names.add(prims[name])
    return {name: prims[name] for name in names}


def identifier(name: str) -> str:
    """Returns a name in [A-Za-z0-9_] that does not begin with a digit: `name` itself if it is such a name."""
    legal = plain(name)
    return f"_{legal}" if legal[0].isdigit() else legal


def joints_of(chain: Joint | Loop) -> list[str]:
    """Returns the names of the USD's possible joints for a joint or loop: those of its dofs, or its own
    without dofs; for a loop of several dofs also its own."""
    names = [dof.name for dof in chain.dofs]
    return [*names, chain.name] if not names or (isinstance(chain, Loop) and len(names) > 1) else names


def _names_between(chain: Joint | Loop, siblings: set[str]) -> Iterator[str]:
    """Yields free names of the links between the dofs of a chain, and adds them to `siblings`."""
    for count in range(1, len(chain.dofs)):
        name = free_name(f"{identifier(chain.name)}_{count}", siblings)
        siblings.add(name)
        yield name
