"""The assembly as drawn: every occurrence at any depth, and every feature once for each place where it acts.

The features of a sub-assembly act once for each of its occurrences, so a feature is identified by the
occurrence path of its owner and its id.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from linkwright.stages.robot.bundle import StudioKey
from linkwright.stages.robot.errors import AssemblyError, Diagnostic
from linkwright.stages.robot.model.dofs import AS_TYPED, LimitOrigin
from linkwright.stages.robot.model.robot import Array, MateRef, frozen

Path = tuple[str, ...]
Record = Mapping[str, Any]

ORIGIN = frozen(np.eye(4))
"""The root assembly's own frame, in which all poses are given."""


@dataclass(frozen=True, slots=True, eq=False)
class Occurrence:
    """One instance in one place: `path` of instance ids, `names` the same in words."""

    path: Path
    names: tuple[str, ...]
    record: Record
    world_from_occurrence: Array
    fixed: bool
    hidden: bool = False

    @property
    def is_part(self) -> bool:
        return bool(self.record.get("type") == "Part")

    @property
    def title(self) -> str:
        return "/".join(self.names)


@dataclass(frozen=True, slots=True, eq=False)
class Entity:
    """One side of a mate: an occurrence (the empty path is the assembly origin) and a frame on it."""

    path: Path
    occurrence_from_frame: Array


@dataclass(frozen=True, slots=True, eq=False)
class Mate:
    """`limits` are Onshape's own names and values [rad or m], None where the server did not send any;
    `limit_origin`: how they were read."""

    ref: MateRef
    title: str
    entities: tuple[Entity, ...]
    limits: Mapping[str, float] | None
    limit_origin: LimitOrigin = AS_TYPED

    @property
    def key(self) -> tuple[Path, str, str]:
        """Its identifier: (owner path, feature id, copied instance)."""
        return self.ref.key


@dataclass(frozen=True, slots=True)
class MateRelation:
    """Joins two mates, each named by (owner path, feature id); `mates[1]` follows. A SCREW names one.

    `ratio` counts for GEAR and LINEAR, `length` [m a turn] for RACK_AND_PINION and SCREW.
    """

    owner: Path
    feature: str
    title: str
    type: str
    mates: tuple[tuple[Path, str], ...]
    ratio: float
    length: float
    reverse: bool


@dataclass(frozen=True, slots=True)
class MateGroup:
    owner: Path
    title: str
    members: tuple[Path, ...]


@dataclass(frozen=True, slots=True)
class Pattern:
    """A pattern or a mirror: the path of each seed → those of its copies, in order.

    `mirrors`: whether copies may be mirror images.
    """

    owner: Path
    title: str
    copies: Mapping[Path, tuple[Path, ...]]
    mirrors: bool = False


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
        return "/".join((*self.names, self.name))


@dataclass(frozen=True, slots=True, eq=False)
class Assembly:
    """Everything that is not suppressed. `occurrences` has the root's absent: its path is ().

    `stiff`: sub-assemblies that are rigid in any case. `standard`: the parts that are standard content.
    """

    root: Record
    occurrences: Mapping[Path, Occurrence] = field(default_factory=dict)
    mates: Sequence[Mate] = ()
    relations: Sequence[MateRelation] = ()
    groups: Sequence[MateGroup] = ()
    connectors: Sequence[Connector] = ()
    patterns: Sequence[Pattern] = ()
    stiff: frozenset[Path] = frozenset()
    body_types: Mapping[tuple[StudioKey, str], str] = field(default_factory=dict)
    standard: frozenset[tuple[StudioKey, str]] = frozenset()
    diagnostics: Sequence[Diagnostic] = ()

    @property
    def parts(self) -> list[Occurrence]:
        """Part occurrences, sorted by path."""
        return [o for path, o in sorted(self.occurrences.items()) if o.is_part]

    def world_from(self, entity: Entity) -> Array:
        """The entity's frame in the root assembly's frame, at the saved pose: (4, 4)."""
        return self.world_from_path(entity.path) @ entity.occurrence_from_frame

    def world_from_path(self, path: Path) -> Array:
        """The pose (4, 4) of an occurrence, or of the assembly itself, at the saved pose."""
        return self.occurrences[path].world_from_occurrence if path else ORIGIN


def check_parts(assembly: Assembly, hint: str) -> None:
    """AssemblyError where there is no part at all."""
    if not assembly.parts:
        msg = "the assembly has no parts"
        raise AssemblyError(msg, where=assembly.root.get("elementId", ""), hint=hint)


def without_empty(occurrences: Mapping[Path, Occurrence]) -> dict[Path, Occurrence]:
    """Occurrences without the sub-assemblies that have no part: these are treated as suppressed."""
    parts = [path for path, one in occurrences.items() if one.is_part]
    used = {path[:depth] for path in parts for depth in range(1, len(path) + 1)}
    return {path: one for path, one in occurrences.items() if path in used}
