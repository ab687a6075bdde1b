"""Names from a robot's own file: kept where the target formats allow them, else mapped."""

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.text.names import free

Key = TypeVar("Key", bound=Hashable)
FrameKey = TypeVar("FrameKey", bound=Hashable)

RESERVED = {"link": frozenset({WORLD_LINK}), "frame": frozenset({WORLD_LINK})}
"""By kind: names that mean something else in a target. To MuJoCo the body `world` is the world itself, and a
frame is a link of a URDF."""


@dataclass(frozen=True, slots=True)
class FileNames(Generic[Key, FrameKey]):
    """The robot's names, by the identifier in the file: a name (URDF) or a number (MJCF).

    `joints`: of what lets a link move, by joint (URDF) or by the body that moves (MJCF); `dofs`: of its
    coordinates in order, by the same. `relations`: by the joint that follows, or by number. `loops`: of
    equalities that close loops and of the one dof that each may have.
    """

    links: Mapping[Key, str]
    frames: Mapping[FrameKey, str]
    joints: Mapping[Key, str]
    dofs: Mapping[Key, tuple[str, ...]]
    relations: Mapping[Key, str]
    loops: Mapping[Key, tuple[str, str]]


class Namer:
    """Gives out names, unique among things of one kind: "link", "joint" (dofs too), "frame" or "equality"
    (loops and relations). That is all that URDF and MJCF ask: things of two kinds may share a name.
    """

    def __init__(self) -> None:
        self._taken: dict[str, set[str]] = {}
        self._every = {WORLD_LINK}
        self._changed: list[tuple[str, str, str]] = []

    def reserve(self, names: Iterable[str]) -> None:
        """Keeps names that other things have from being made."""
        self._every.update(names)

    def keep(self, kind: str, given: Iterable[tuple[Key, str]]) -> dict[Key, str]:
        """The robot's names by key, of things with these names in the source, each unique there. What has
        no name ("") gets none.

        A name changes only where it is reserved or holds invisible characters (a line's end, a control
        character); names that stay have precedence.
        """
        taken = self._taken.setdefault(kind, set())
        names: dict[Key, str] = {}
        changing = []
        for key, name in given:
            if not name:
                continue
            if name not in RESERVED.get(kind, ()) and name.isprintable():
                names[key] = name
                taken.add(name)
            else:
                changing.append((key, name))
        for key, name in changing:
            shown = "".join(letter if letter.isprintable() else "_" for letter in name)
            wanted = f"{shown}_{kind}" if shown in RESERVED.get(kind, ()) else shown
            names[key] = free(wanted, taken)
            taken.add(names[key])
            self._changed.append((kind, name, names[key]))
        self._every.update(names.values())
        return names

    def make(self, kind: str, wanted: str) -> str:
        """A name for something unnamed in the source: `wanted`, with a number where it is taken."""
        name = free(wanted, self._every)
        self._every.add(name)
        self._taken.setdefault(kind, set()).add(name)
        return name

    def fill(self, kind: str, names: Mapping[Key, str], wanted: Iterable[tuple[Key, str]]) -> dict[Key, str]:
        """The names of all that is `wanted`: the one in `names`, else one made from the wanted one."""
        return {key: names.get(key) or self.make(kind, name) for key, name in wanted}

    def is_free(self, kind: str, name: str) -> bool:
        """Whether nothing of this kind has the name."""
        return name not in self._taken.get(kind, ())

    def report(self, log: Diagnostics) -> None:
        """W-NAME for each name that changed."""
        for kind, old, new in self._changed:
            why = "it is reserved" if old in RESERVED.get(kind, ()) else "it holds invisible characters"
            text = f"the {kind} {old!r} was renamed to {new!r}: {why}"
            log.report("W-NAME", text, new, "give it another name in the file; robot.json has both")
