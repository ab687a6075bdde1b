"""Reads Onshape's assembly definition into an `Assembly`, tolerant of keys that it does not know."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np
import orjson

from stages.graph.couplings import TYPES
from stages.graph.onshape.assembly import (
    Assembly,
    Connector,
    Entity,
    Mate,
    MateGroup,
    MateRelation,
    Occurrence,
    Path,
    Pattern,
    Record,
    check_parts,
    leave_out_empty,
)
from stages.robot.bundle import StudioKey
from stages.robot.errors import Diagnostic, ProtocolError
from stages.robot.model import Array, MateRef, frozen


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
    leave_out_empty(assembly)
    # Features need every occurrence to be known: a mate of one assembly may reach into another.
    for path, names, record in owners:
        for feature in record.get("features") or ():
            if not feature.get("suppressed"):
                with _shape_of("feature", "/".join((*names, str(feature.get("id"))))):
                    _read_feature(assembly, path, names, feature)
        with _shape_of("pattern", "/".join(names)):
            assembly.patterns.extend(_read_patterns(path, names, record))
    check_parts(assembly, "insert at least one part, or unsuppress what is there")
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
            child,
            child_names,
            instance,
            _rigid(place["transform"], title),
            bool(place.get("fixed")),
            bool(place.get("hidden")),
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
    if not abs(rotation @ rotation.T - np.eye(3)).max() < 1e-6:  # nor where one is not a number
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
                tuple(
                    (owner + tuple(m.get("occurrence") or ()), m["featureId"])
                    for m in data.get("mates") or ()
                ),
                float(data.get("relationRatio") or 0.0),
                float(data.get("relationLength") or 0.0),
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
    if ref.type not in TYPES:
        assembly.diagnostics.append(
            Diagnostic(
                "E-MATE-TYPE",
                f"a mate of the type {ref.type} is not known: whether it holds anything neither",
                title,
                f"suppress it, or use one of {', '.join(TYPES)}",
            )
        )
        return
    limits = data.get("mateLimits")
    if limits is not None:
        limits = {key: float(value) for key, value in limits.items() if value is not None}
    assembly.mates.append(Mate(ref, title, entities, limits))


def _read_patterns(owner: Path, names: tuple[str, ...], record: Record) -> Iterator[Pattern]:
    """The patterns and mirrors of one assembly, by id: what each is a copy of."""
    drawn = [
        (pattern, list((pattern.get("seedToPatternInstances") or {}).items()))
        for pattern in record.get("patterns") or ()
    ] + [
        (
            mirror,
            [
                (child["seedOccurrence"], child.get("instanceIds"))
                for child in mirror.get("children") or ()
                if child.get("seedOccurrence")
            ],
        )
        for mirror in record.get("parametricInstances") or ()
    ]
    for pattern, pairs in sorted(drawn, key=lambda one: str(one[0].get("id"))):
        if pattern.get("suppressed"):
            continue
        copies: dict[Path, tuple[Path, ...]] = {}
        for seed, ids in pairs:
            path = owner + ((seed,) if isinstance(seed, str) else tuple(seed))
            copies[path] = copies.get(path, ()) + tuple((*owner, ident) for ident in ids or ())
        name = pattern.get("name") or pattern.get("type") or "pattern"
        yield Pattern(owner, "/".join((*names, name)), copies)


def _frame(cs: Record) -> Array:
    """A mate coordinate system {origin, xAxis, yAxis, zAxis} as occurrence_from_frame (4, 4)."""
    frame = np.eye(4)
    for column, key in enumerate(("xAxis", "yAxis", "zAxis", "origin")):
        frame[:3, column] = cs[key]
    return frozen(frame)
