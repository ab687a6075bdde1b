"""Keeps the names of a robot's own file if the target formats allow them, and replaces the others."""

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.text.names import free_name

Key = TypeVar("Key", bound=Hashable)
FrameKey = TypeVar("FrameKey", bound=Hashable)

RESERVED = {"link": frozenset({WORLD_LINK}), "frame": frozenset({WORLD_LINK})}
"""Kind → names that have another meaning in a target format: MuJoCo's body `world` is the world itself, and a
frame of the robot is a link of a URDF."""


@dataclass(frozen=True, slots=True)
class FileNames(Generic[Key, FrameKey]):
    """The robot's names, by the identifier in the file: a name (URDF) or a number (MJCF)."""

    links: Mapping[Key, str]
    frames: Mapping[FrameKey, str]
    joints: Mapping[Key, str]
    """Names of joints, by the joint in the file (URDF), or by the body that it moves (MJCF)."""
    dofs: Mapping[Key, tuple[str, ...]]
    """Names of each joint's dofs in order, by the same keys as `joints`."""
    relations: Mapping[Key, str]
    """Names of relations, by the joint that follows (URDF), or by their number (MJCF)."""
    loops: Mapping[Key, tuple[str, str]]
    """Names of each equality that closes a loop, and of the dof that it may have."""


class Namer:
    """Gives out names, unique among things of a kind: "link", "joint" (dofs too), "frame" or "equality"
    (loops and relations). URDF and MJCF ask no more than that: things of two kinds may share a name.
    """

    def __init__(self) -> None:
        self._taken: dict[str, set[str]] = {}
        self._all_names = {WORLD_LINK}
        self._changed: list[tuple[str, str, str]] = []

    def reserve(self, names: Iterable[str]) -> None:
        """Excludes names, which other things have, from the names that `make` and `fill` give."""
        self._all_names.update(names)

    def keep(self, kind: str, source_names: Iterable[tuple[Key, str]]) -> dict[Key, str]:
        """Returns the names in the robot, by key, of things that have these names in the source, where each
        name is unique. Unnamed things ("") are left out.
        A name changes only if it is reserved, or has invisible characters (a line's end, a control
        character); names that stay have precedence.
        """
        taken_names = self._taken.setdefault(kind, set())
        names: dict[Key, str] = {}
        names_to_change = []
        for key, name in source_names:
            if not name:
                continue
            if name not in RESERVED.get(kind, ()) and name.isprintable():
                names[key] = name
                taken_names.add(name)
            else:
                names_to_change.append((key, name))
        for key, name in names_to_change:
            shown = "".join(letter if letter.isprintable() else "_" for letter in name)
            base_name = f"{shown}_{kind}" if shown in RESERVED.get(kind, ()) else shown
            names[key] = free_name(base_name, taken_names)
            taken_names.add(names[key])
            self._changed.append((kind, name, names[key]))
        self._all_names.update(names.values())
        return names

    def make(self, kind: str, proposal: str) -> str:
        """Returns a name for something unnamed in the source: `proposal`, with a number if another thing has
        it."""
        name = free_name(proposal, self._all_names)
        self._all_names.add(name)
        self._taken.setdefault(kind, set()).add(name)
        return name

    def fill(
        self, kind: str, names: Mapping[Key, str], proposals: Iterable[tuple[Key, str]]
    ) -> dict[Key, str]:
        """Returns the names of all keys in `proposals`: the name in `names`, else a new name from the
        proposal."""
        return {key: names.get(key) or self.make(kind, name) for key, name in proposals}

    def is_free(self, kind: str, name: str) -> bool:
        """Tells whether nothing of this kind has the name."""
        return name not in self._taken.get(kind, ())

    def report(self, log: Diagnostics) -> None:
        """Reports W-NAME for each name that changed."""
        for kind, old, new in self._changed:
            why = "it is reserved" if old in RESERVED.get(kind, ()) else "it holds invisible characters"
            text = f"the {kind} {old!r} was renamed to {new!r}: {why}"
            log.report("W-NAME", text, new, "give it another name in the file; robot.json has both")
