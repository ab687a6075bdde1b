"""Reads Onshape's assembly definition into an `Assembly`, tolerant of keys that it does not know."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple

import numpy as np
import orjson

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
from stages.graph.onshape.mates import JOINT_TYPES
from stages.graph.onshape.reply_fields import check_rigid, number, numbers, path_of, shape_of, text
from stages.robot.bundle import StudioKey
from stages.robot.errors import Diagnostic, ProtocolError
from stages.robot.model import Array, MateRef, frozen


def read_assembly(body: bytes) -> Assembly:
    """The assembly in an assembly-definition reply; ProtocolError where it is not one."""
    with shape_of("assembly definition", ""):
        definition = orjson.loads(body)
        root = definition["rootAssembly"]
        subs = {StudioKey.of(sub): sub for sub in definition.get("subAssemblies") or ()}
        assembly = Assembly(root)
        for part in definition.get("parts") or ():
            assembly.body_types[StudioKey.of(part), part.get("partId", "")] = part.get("bodyType", "solid")
        placed = {path_of(o["path"]): o for o in root.get("occurrences") or ()}
        owners: list[tuple[Path, tuple[str, ...], Record]] = [((), (), root)]
        for path, names, record in owners:
            owners.extend(_expand(assembly, path, names, record, placed, subs))
    leave_out_empty(assembly)
    # Features need every occurrence to be known: a mate of one assembly may reach into another.
    for path, names, record in owners:
        with shape_of("list of features", "/".join(names)):
            features = [one for one in record.get("features") or () if not one.get("suppressed")]
            _check_ids(features)
        for feature in features:
            with shape_of("feature", "/".join((*names, feature["id"]))):
                _read_feature(assembly, path, names, feature)
        with shape_of("pattern", "/".join(names)):
            assembly.patterns.extend(_read_patterns(path, names, record))
    check_parts(assembly, "insert at least one part, or unsuppress what is there")
    return assembly


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
        child, child_names = (*path, text(instance["id"])), (*names, text(instance.get("name") or "unnamed"))
        title = "/".join(child_names)
        if instance.get("type") not in ("Part", "Assembly"):
            kind = instance.get("type") or "without a type"
            what = f"instance is {kind}: neither part nor assembly, left out"
            hint = "suppress it, or put a part or an assembly in its place"
            assembly.diagnostics.append(Diagnostic("W-INSTANCE", what, title, hint))
            continue
        with shape_of("instance", title):
            occurrence = _occurrence(child, child_names, instance, placed)
            if child in assembly.occurrences:
                msg = f"another instance has its id, {child[-1]!r}, too"
                raise ValueError(msg)
            assembly.occurrences[child] = occurrence
        if instance["type"] == "Assembly":
            sub = subs.get(StudioKey.of(instance))
            if sub is None:
                msg = "the definition lacks this sub-assembly"
                raise ProtocolError(msg, where=title)
            yield child, child_names, sub


def _occurrence(
    path: Path, names: tuple[str, ...], instance: Record, placed: Mapping[Path, Record]
) -> Occurrence:
    for ident in astuple(StudioKey.of(instance)):
        text(ident)
    if instance["type"] == "Part":
        text(instance["partId"])
    if path not in placed:
        msg = "the definition gives no transform for this instance"
        raise ProtocolError(msg, where="/".join(names))
    place = placed[path]
    transform = numbers(place["transform"], 16).reshape(4, 4)
    check_rigid(transform)
    return Occurrence(
        path, names, instance, frozen(transform), bool(place.get("fixed")), bool(place.get("hidden"))
    )


def _check_ids(features: Sequence[Record]) -> None:
    """ValueError or TypeError unless each feature has an id of its own: by it they are told apart."""
    seen: set[str] = set()
    for ident in (text(feature["id"]) for feature in features):
        if ident in seen:
            msg = f"two features have the id {ident!r}"
            raise ValueError(msg)
        seen.add(ident)


def _read_feature(assembly: Assembly, owner: Path, names: tuple[str, ...], feature: Record) -> None:
    data, kind = feature.get("featureData") or {}, feature.get("featureType")
    name = text(data.get("name") or feature["id"])
    title = "/".join((*names, name))
    if kind == "mate":
        _read_mate(assembly, owner, title, name, feature, data)
    elif kind == "mateRelation":
        assembly.relations.append(
            MateRelation(
                owner,
                feature["id"],
                title,
                text(data.get("relationType", "UNKNOWN")),
                tuple(
                    (owner + path_of(m.get("occurrence")), text(m["featureId"]))
                    for m in data.get("mates") or ()
                ),
                number(data.get("relationRatio") or 0.0),
                number(data.get("relationLength") or 0.0),
                bool(data.get("reverseDirection")),
            )
        )
    elif kind == "mateGroup":
        members = tuple(owner + path_of(o.get("occurrence")) for o in data.get("occurrences") or ())
        assembly.groups.append(
            MateGroup(owner, title, tuple(m for m in members if m in assembly.occurrences))
        )
    elif kind == "mateConnector":
        path = owner + path_of(data.get("occurrence"))
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
        Entity(owner + path_of(e.get("matedOccurrence")), _frame(e["matedCS"]))
        for e in data["matedEntities"] or ()
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
    ref = MateRef(owner, feature["id"], name, text(data.get("mateType", "UNKNOWN")))
    if ref.type not in JOINT_TYPES:
        assembly.diagnostics.append(
            Diagnostic(
                "E-MATE-TYPE",
                f"a mate of the type {ref.type} is not known: whether it holds anything neither",
                title,
                f"suppress it, or use one of {', '.join(JOINT_TYPES)}",
            )
        )
        return
    limits = data.get("mateLimits")
    if limits is not None:
        limits = {key: number(value) for key, value in limits.items() if value is not None}
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
            path = owner + path_of([seed] if isinstance(seed, str) else seed)
            copies[path] = copies.get(path, ()) + tuple((*owner, ident) for ident in path_of(ids))
        name = pattern.get("name") or pattern.get("type") or "pattern"
        yield Pattern(owner, "/".join((*names, name)), copies)


def _frame(cs: Record) -> Array:
    """A mate coordinate system {origin, xAxis, yAxis, zAxis} as occurrence_from_frame (4, 4)."""
    frame = np.eye(4)
    for column, key in enumerate(("xAxis", "yAxis", "zAxis", "origin")):
        frame[:3, column] = numbers(cs[key], 3)
    check_rigid(frame)
    return frozen(frame)
