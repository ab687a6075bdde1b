"""Describes an assembly as drawn: every occurrence at any depth, and every feature once for each occurrence
of its owner.

The features of a sub-assembly act once for each of its occurrences, so a feature is identified by the
occurrence path of its owner and its id.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from linkwright.stages.robot.bundle import ElementKey
from linkwright.stages.robot.errors import AssemblyError, Diagnostic
from linkwright.stages.robot.model.dofs import AS_TYPED, LimitOrigin
from linkwright.stages.robot.model.robot import Array, MateRef, frozen

Path = tuple[str, ...]
Record = Mapping[str, Any]

ORIGIN = frozen(np.eye(4))
"""The root assembly's own frame, in which all poses are given."""


@dataclass(frozen=True, slots=True, eq=False)
class Occurrence:
    """An instance of a part or sub-assembly, at its place in the root assembly."""

    path: Path
    """Ids of the instances from the root assembly down to this one."""
    names: tuple[str, ...]
    """Names of the instances from the root assembly down to this one."""
    record: Record
    world_from_occurrence: Array
    fixed: bool
    hidden: bool = False

    @property
    def is_part(self) -> bool:
        """Whether the occurrence is a part, not a sub-assembly."""
        return bool(self.record.get("type") == "Part")

    @property
    def title(self) -> str:
        """The names down to the occurrence, joined by "/"."""
        return "/".join(self.names)


@dataclass(frozen=True, slots=True, eq=False)
class Entity:
    """A side of a mate: an occurrence and a frame on it."""

    path: Path
    """Path of the occurrence; () for the assembly's origin."""
    occurrence_from_frame: Array


@dataclass(frozen=True, slots=True, eq=False)
class Mate:
    """A mate between two occurrences."""

    ref: MateRef
    title: str
    entities: tuple[Entity, ...]
    limits: Mapping[str, float] | None
    """Limits by Onshape's names for them [rad or m]; None if the server did not send any."""
    limit_origin: LimitOrigin = AS_TYPED
    """How the limits were read."""

    @property
    def key(self) -> tuple[Path, str, str]:
        """The identifier of the mate: (owner path, feature id, copied instance)."""
        return self.ref.key


@dataclass(frozen=True, slots=True)
class MateRelation:
    """A relation between two mates."""

    owner: Path
    feature: str
    title: str
    type: str
    mates: tuple[tuple[Path, str], ...]
    """Each mate's (owner path, feature id); the second mate follows the first. A SCREW has a single mate."""
    ratio: float
    """Ratio of a GEAR or LINEAR."""
    length: float
    """Length for each turn [m] of a RACK_AND_PINION or SCREW."""
    reverse: bool


@dataclass(frozen=True, slots=True)
class MateGroup:
    """A mate group: its members do not move relative to each other."""

    owner: Path
    title: str
    members: tuple[Path, ...]


@dataclass(frozen=True, slots=True)
class Pattern:
    """A pattern or a mirror."""

    owner: Path
    title: str
    copies: Mapping[Path, tuple[Path, ...]]
    """Path of each seed → paths of its copies, in order."""
    mirrors: bool = False
    """Whether copies may be mirror images."""


@dataclass(frozen=True, slots=True, eq=False)
class Connector:
    """A mate connector that the designer placed and named."""

    owner: Path
    feature: str
    name: str
    names: tuple[str, ...]
    entity: Entity

    @property
    def title(self) -> str:
        """The names down to the connector, joined by "/"."""
        return "/".join((*self.names, self.name))


@dataclass(frozen=True, slots=True, eq=False)
class Assembly:
    """Everything in an assembly that is not suppressed."""

    root: Record
    occurrences: Mapping[Path, Occurrence] = field(default_factory=dict)
    """All occurrences except the root assembly, whose path is ()."""
    mates: Sequence[Mate] = ()
    relations: Sequence[MateRelation] = ()
    groups: Sequence[MateGroup] = ()
    connectors: Sequence[Connector] = ()
    patterns: Sequence[Pattern] = ()
    stiff: frozenset[Path] = frozenset()
    """Sub-assemblies that are rigid in any case."""
    body_types: Mapping[tuple[ElementKey, str], str] = field(default_factory=dict)
    standard: frozenset[tuple[ElementKey, str]] = frozenset()
    """Parts that are standard content."""
    diagnostics: Sequence[Diagnostic] = ()

    @property
    def parts(self) -> list[Occurrence]:
        """Part occurrences, sorted by path."""
        return [o for path, o in sorted(self.occurrences.items()) if o.is_part]

    def world_from(self, entity: Entity) -> Array:
        """Returns the entity's frame in the root assembly's frame, at the saved pose: (4, 4)."""
        return self.world_from_path(entity.path) @ entity.occurrence_from_frame

    def world_from_path(self, path: Path) -> Array:
        """Returns the pose (4, 4) of an occurrence, or of the assembly itself, at the saved pose."""
        return self.occurrences[path].world_from_occurrence if path else ORIGIN


def check_parts(assembly: Assembly, hint: str) -> None:
    """Raises AssemblyError, with the hint, if the assembly has no part."""
    if not assembly.parts:
        msg = "the assembly has no parts"
        raise AssemblyError(msg, where=assembly.root.get("elementId", ""), hint=hint)


def without_empty(occurrences: Mapping[Path, Occurrence]) -> dict[Path, Occurrence]:
    """Returns the occurrences without the sub-assemblies that have no part, which count as suppressed."""
    parts = [path for path, occurrence in occurrences.items() if occurrence.is_part]
    used_paths = {path[:depth] for path in parts for depth in range(1, len(path) + 1)}
    return {path: occurrence for path, occurrence in occurrences.items() if path in used_paths}
