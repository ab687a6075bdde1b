"""Keeps the names of a robot's own file where the target formats allow them, and maps the others."""

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.text.names import free

Key = TypeVar("Key", bound=Hashable)
FrameKey = TypeVar("FrameKey", bound=Hashable)

RESERVED = {"link": frozenset({WORLD_LINK}), "frame": frozenset({WORLD_LINK})}
"""Names that mean something else in a target format, by kind of thing. To MuJoCo the body `world` is the
world itself, and a frame is a link of a URDF."""


@dataclass(frozen=True, slots=True)
class FileNames(Generic[Key, FrameKey]):
    """The robot's names, by the identifier in the file: a name (URDF) or a number (MJCF)."""

    links: Mapping[Key, str]
    frames: Mapping[FrameKey, str]
    joints: Mapping[Key, str]
    """By joint (URDF), or by the body that moves (MJCF)."""
    dofs: Mapping[Key, tuple[str, ...]]
    """In order, by the same keys as `joints`."""
    relations: Mapping[Key, str]
    """By the joint that follows, or by number."""
    loops: Mapping[Key, tuple[str, str]]
    """Names of each equality that closes a loop, and of the dof that it may have."""


class Namer:
    """Gives out names, unique among things of a kind: "link", "joint" (dofs too), "frame" or "equality"
    (loops and relations). URDF and MJCF ask no more than that: things of two kinds may share a name.
    """

    def __init__(self) -> None:
        self._taken: dict[str, set[str]] = {}
        self._every = {WORLD_LINK}
        self._changed: list[tuple[str, str, str]] = []

    def reserve(self, names: Iterable[str]) -> None:
        """Keeps names that other things have from being made."""
        self._every.update(names)

    def keep(self, kind: str, source_names: Iterable[tuple[Key, str]]) -> dict[Key, str]:
        """Returns the robot's names by key, of things with these names in the source, each unique there.
        Unnamed things ("") are left out.

        A name changes only where it is reserved or holds invisible characters (a line's end, a control
        character); names that stay have precedence.
        """
        taken_names = self._taken.setdefault(kind, set())
        names: dict[Key, str] = {}
        changing = []
        for key, name in source_names:
            if not name:
                continue
            if name not in RESERVED.get(kind, ()) and name.isprintable():
                names[key] = name
                taken_names.add(name)
            else:
                changing.append((key, name))
        for key, name in changing:
            shown = "".join(letter if letter.isprintable() else "_" for letter in name)
            base_name = f"{shown}_{kind}" if shown in RESERVED.get(kind, ()) else shown
            names[key] = free(base_name, taken_names)
            taken_names.add(names[key])
            self._changed.append((kind, name, names[key]))
        self._every.update(names.values())
        return names

    def make(self, kind: str, proposal: str) -> str:
        """Returns a name for something unnamed in the source: `proposal`, with a number where it is taken."""
        name = free(proposal, self._every)
        self._every.add(name)
        self._taken.setdefault(kind, set()).add(name)
        return name

    def fill(
        self, kind: str, names: Mapping[Key, str], proposals: Iterable[tuple[Key, str]]
    ) -> dict[Key, str]:
        """Returns the names of all keys in `proposals`: the name in `names`, else a new name from the
        proposal."""
        return {key: names.get(key) or self.make(kind, name) for key, name in proposals}

    def is_free(self, kind: str, name: str) -> bool:
        """Returns whether nothing of this kind has the name."""
        return name not in self._taken.get(kind, ())

    def report(self, log: Diagnostics) -> None:
        """Reports W-NAME for each name that changed."""
        for kind, old, new in self._changed:
            why = "it is reserved" if old in RESERVED.get(kind, ()) else "it holds invisible characters"
            text = f"the {kind} {old!r} was renamed to {new!r}: {why}"
            log.report("W-NAME", text, new, "give it another name in the file; robot.json has both")
