"""The assembly as drawn: every occurrence at any depth, and every feature in each place it acts.

Reads Onshape's assembly definition. One sub-assembly's features act once for every occurrence of
that sub-assembly, so what identifies a feature is its owner's occurrence path and its id.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import orjson

from stages.robot.bundle import StudioKey
from stages.robot.errors import AssemblyError, Diagnostic, ProtocolError
from stages.robot.model import Array, MateRef, frozen

Path = tuple[str, ...]
Record = Mapping[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Occurrence:
    """One instance in one place: `path` of instance ids, `names` the same in words."""

    path: Path
    names: tuple[str, ...]
    record: Record
    world_from_occurrence: Array
    fixed: bool

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
    """`limits` are Onshape's own names and values [rad or m], None where the server did not send any."""

    ref: MateRef
    title: str
    entities: tuple[Entity, ...]
    limits: Mapping[str, float] | None


@dataclass(frozen=True, slots=True)
class MateRelation:
    """Joins two mates, each named by (owner path, feature id); `mates[1]` follows."""

    owner: Path
    feature: str
    title: str
    type: str
    mates: tuple[tuple[Path, str], ...]
    ratio: float
    reverse: bool


@dataclass(frozen=True, slots=True)
class MateGroup:
    owner: Path
    title: str
    members: tuple[Path, ...]


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


@dataclass(slots=True)
class Assembly:
    """Everything that is not suppressed. `occurrences` has the root's absent: its path is ()."""

    root: Record
    occurrences: dict[Path, Occurrence] = field(default_factory=dict)
    mates: list[Mate] = field(default_factory=list)
    relations: list[MateRelation] = field(default_factory=list)
    groups: list[MateGroup] = field(default_factory=list)
    connectors: list[Connector] = field(default_factory=list)
    body_types: dict[tuple[StudioKey, str], str] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)

    @property
    def parts(self) -> list[Occurrence]:
        """Part occurrences, sorted by path."""
        return [o for path, o in sorted(self.occurrences.items()) if o.is_part]

    def world_from(self, entity: Entity) -> Array:
        """The entity's frame in the root assembly's frame, at the saved pose: (4, 4)."""
        if not entity.path:
            return entity.occurrence_from_frame
        return self.occurrences[entity.path].world_from_occurrence @ entity.occurrence_from_frame


def read_assembly(body: bytes) -> Assembly:
    """The assembly in an assembly-definition reply; ProtocolError where it is not one."""
    with _shape_of("assembly definition", ""):
        definition = orjson.loads(body)
        root = definition["rootAssembly"]
        subs = {StudioKey.of(sub): sub for sub in definition.get("subAssemblies") or ()}
        assembly = Assembly(root)
        for part in definition.get("parts") or ():
            assembly.body_types[StudioKey.of(part), part.get("partId", "")] = part.get("bodyType", "solid")
        placed = {tuple(o["path"]): o for o in root.get("occurrences") or ()}
        owners: list[tuple[Path, tuple[str, ...], Record]] = [((), (), root)]
        for path, names, record in owners:
            owners.extend(_expand(assembly, path, names, record, placed, subs))
    _leave_out_empty(assembly)
    # Features need every occurrence to be known: a mate of one assembly may reach into another.
    for path, names, record in owners:
        for feature in record.get("features") or ():
            if not feature.get("suppressed"):
                with _shape_of("feature", "/".join((*names, str(feature.get("id"))))):
                    _read_feature(assembly, path, names, feature)
    if not assembly.parts:
        msg = "the assembly has no parts"
        hint = "insert at least one part, or unsuppress what is there"
        raise AssemblyError(msg, where=root.get("elementId", ""), hint=hint)
    return assembly


@contextmanager
def _shape_of(what: str, where: str) -> Iterator[None]:
    """Turns what Python says of an unexpected shape into a ProtocolError that says where."""
    try:
        yield
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        msg = f"the {what} is not in the shape of the API ({type(error).__name__}: {error})"
        hint = "fetch it again, or make the bundle again; if it stays so, the API has changed"
        raise ProtocolError(msg, where, hint) from error


def _leave_out_empty(assembly: Assembly) -> None:
    """Forgets sub-assemblies without any part: they are as absent as what is suppressed."""
    used = {part.path[:depth] for part in assembly.parts for depth in range(1, len(part.path) + 1)}
    for path in set(assembly.occurrences) - used:
        del assembly.occurrences[path]


def _expand(
    assembly: Assembly,
    path: Path,
    names: tuple[str, ...],
    record: Record,
    placed: Mapping[Path, Record],
    subs: Mapping[StudioKey, Record],
) -> Iterator[tuple[Path, tuple[str, ...], Record]]:
    """Files the instances of one assembly; yields the sub-assemblies among them."""
    for instance in record.get("instances") or ():
        if instance.get("suppressed"):
            continue
        child, child_names = (*path, instance["id"]), (*names, instance.get("name") or "unnamed")
        title = "/".join(child_names)
        if instance.get("type") not in ("Part", "Assembly"):
            kind = instance.get("type") or "without a type"
            assembly.diagnostics.append(
                Diagnostic("W-INSTANCE", f"instance is {kind}: neither part nor assembly, left out", title)
            )
            continue
        place = placed.get(child)
        if place is None:
            msg = "the definition gives no transform for this instance"
            raise ProtocolError(msg, where=title)
        assembly.occurrences[child] = Occurrence(
            child, child_names, instance, _rigid(place["transform"], title), bool(place.get("fixed"))
        )
        if instance["type"] == "Assembly":
            sub = subs.get(StudioKey.of(instance))
            if sub is None:
                msg = "the definition lacks this sub-assembly"
                raise ProtocolError(msg, where=title)
            yield child, child_names, sub


def _rigid(values: list[float], title: str) -> Array:
    """A row-major 4x4 as an array; ProtocolError unless it keeps lengths."""
    transform = np.array(values, dtype=float).reshape(4, 4)
    rotation = transform[:3, :3]
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6):
        msg = "the transform of this instance is not rigid"
        raise ProtocolError(msg, where=title)
    return frozen(transform)


def _read_feature(assembly: Assembly, owner: Path, names: tuple[str, ...], feature: Record) -> None:
    data, kind = feature.get("featureData") or {}, feature.get("featureType")
    name = data.get("name") or feature.get("id", "")
    title = "/".join((*names, name))
    if kind == "mate":
        _read_mate(assembly, owner, title, name, feature, data)
    elif kind == "mateRelation":
        assembly.relations.append(
            MateRelation(
                owner,
                feature["id"],
                title,
                data.get("relationType", "UNKNOWN"),
                tuple((owner + tuple(m.get("occurrence") or ()), m["featureId"]) for m in data["mates"]),
                float(data.get("relationRatio") or 0.0),
                bool(data.get("reverseDirection")),
            )
        )
    elif kind == "mateGroup":
        members = tuple(owner + tuple(o.get("occurrence") or ()) for o in data.get("occurrences") or ())
        assembly.groups.append(
            MateGroup(owner, title, tuple(m for m in members if m in assembly.occurrences))
        )
    elif kind == "mateConnector":
        path = owner + tuple(data.get("occurrence") or ())
        if path and path not in assembly.occurrences:
            return  # on a suppressed instance: as absent as the instance itself
        frame = _frame(data["mateConnectorCS"])
        assembly.connectors.append(Connector(owner, feature["id"], name, names, Entity(path, frame)))
    else:
        assembly.diagnostics.append(
            Diagnostic(
                "W-FEATURE",
                f"a feature of type {kind} is not modelled: the robot moves as if it were not there",
                title,
                "replace it by a mate, or suppress it",
            )
        )


def _read_mate(assembly: Assembly, owner: Path, title: str, name: str, feature: Record, data: Record) -> None:
    entities = tuple(
        Entity(owner + tuple(e.get("matedOccurrence") or ()), _frame(e["matedCS"]))
        for e in data["matedEntities"]
    )
    alive = len(entities) == 2 and all(not e.path or e.path in assembly.occurrences for e in entities)
    if not alive:
        assembly.diagnostics.append(
            Diagnostic(
                "W-MATE-BROKEN",
                "the mate lacks one of its two sides (deleted or suppressed) and is left out",
                title,
                "repair or delete the mate in Onshape",
            )
        )
        return
    ref = MateRef(owner, feature["id"], name, data.get("mateType", "UNKNOWN"))
    limits = data.get("mateLimits")
    if limits is not None:
        limits = {key: float(value) for key, value in limits.items() if value is not None}
    assembly.mates.append(Mate(ref, title, entities, limits))


def _frame(cs: Record) -> Array:
    """A mate coordinate system {origin, xAxis, yAxis, zAxis} as occurrence_from_frame (4, 4)."""
    frame = np.eye(4)
    for column, key in enumerate(("xAxis", "yAxis", "zAxis", "origin")):
        frame[:3, column] = cs[key]
    return frozen(frame)
