"""Reads Onshape's assembly definition into an `Assembly`; unknown keys are ignored."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field, replace

import numpy as np
import orjson

from linkwright.stages.graph.onshape.assembly import (
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
    without_empty,
)
from linkwright.stages.graph.onshape.mates.joints import JOINT_TYPES
from linkwright.stages.graph.onshape.reply_fields import (
    check_rigid,
    id_path,
    number,
    numbers,
    protocol_errors,
    text,
)
from linkwright.stages.robot.bundle import ElementKey
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.robot import Array, MateRef, frozen


@dataclass(frozen=True, slots=True, eq=False)
class _AssemblyContent:
    """The contents of an assembly that have been read so far."""

    occurrences: dict[Path, Occurrence] = field(default_factory=dict)
    mates: list[Mate] = field(default_factory=list)
    relations: list[MateRelation] = field(default_factory=list)
    groups: list[MateGroup] = field(default_factory=list)
    connectors: list[Connector] = field(default_factory=list)
    patterns: list[Pattern] = field(default_factory=list)
    log: Diagnostics = field(default_factory=Diagnostics)


def read_assembly(body: bytes) -> Assembly:
    """Returns the assembly in an assembly-definition reply; raises ProtocolError for a malformed reply."""
    with protocol_errors("assembly definition", ""):
        definition = orjson.loads(body)
        root = definition["rootAssembly"]
        subs = {ElementKey.of(sub): sub for sub in definition.get("subAssemblies") or ()}
        body_types = {
            (ElementKey.of(part), part.get("partId", "")): part.get("bodyType", "solid")
            for part in definition.get("parts") or ()
        }
        standard = {
            (ElementKey.of(part), part.get("partId", ""))
            for part in definition.get("parts") or ()
            if part.get("isStandardContent") is True
        }
        occurrences = {id_path(o["path"]): o for o in root.get("occurrences") or ()}
        content = _AssemblyContent()
        owners: list[tuple[Path, tuple[str, ...], Record]] = [((), (), root)]
        for path, names, record in owners:
            owners.extend(_expand(content, path, names, record, occurrences, subs))
    content_without_empty = replace(content, occurrences=without_empty(content.occurrences))
    # Features need every occurrence to be known: a mate of one assembly may reach into another.
    for path, names, record in owners:
        with protocol_errors("list of features", "/".join(names)):
            features = [feature for feature in record.get("features") or () if not feature.get("suppressed")]
            _check_ids(features)
        for feature in features:
            with protocol_errors("feature", "/".join((*names, feature["id"]))):
                _read_feature(content_without_empty, path, names, feature)
        with protocol_errors("pattern", "/".join(names)):
            content_without_empty.patterns.extend(_read_patterns(path, names, record))
    assembly = Assembly(
        root=root,
        occurrences=content_without_empty.occurrences,
        mates=content_without_empty.mates,
        relations=content_without_empty.relations,
        groups=content_without_empty.groups,
        connectors=content_without_empty.connectors,
        patterns=content_without_empty.patterns,
        body_types=body_types,
        standard=frozenset(standard),
        diagnostics=(*content_without_empty.log.problems, *content_without_empty.log.notes),
    )
    check_parts(assembly, "insert at least one part, or unsuppress an existing one")
    return assembly


def _expand(
    content: _AssemblyContent,
    path: Path,
    names: tuple[str, ...],
    record: Record,
    occurrences: Mapping[Path, Record],
    subs: Mapping[ElementKey, Record],
) -> Iterator[tuple[Path, tuple[str, ...], Record]]:
    """Reads the instances of an assembly; yields the sub-assemblies among them."""
    for instance in record.get("instances") or ():
        if instance.get("suppressed"):
            continue
        child, child_names = (*path, text(instance["id"])), (*names, text(instance.get("name") or "unnamed"))
        title = "/".join(child_names)
        if instance.get("type") not in ("Part", "Assembly"):
            kind = instance.get("type") or "without a type"
            message = f"the instance is {kind}, neither a part nor an assembly: left out"
            hint = "suppress it, or put a part or an assembly in its place"
            content.log.report("W-INSTANCE", message, title, hint)
            continue
        with protocol_errors("instance", title):
            occurrence = _occurrence(child, child_names, instance, occurrences)
            if child in content.occurrences:
                msg = f"another instance has the same id, {child[-1]!r}, too"
                raise ValueError(msg)
            content.occurrences[child] = occurrence
        if instance["type"] == "Assembly":
            sub = subs.get(ElementKey.of(instance))
            if sub is None:
                msg = "the definition lacks this sub-assembly"
                raise ProtocolError(msg, where=title)
            yield child, child_names, sub


def _occurrence(
    path: Path, names: tuple[str, ...], instance: Record, occurrences: Mapping[Path, Record]
) -> Occurrence:
    for key_part in astuple(ElementKey.of(instance)):
        text(key_part)
    if instance["type"] == "Part":
        text(instance["partId"])
    if path not in occurrences:
        msg = "the definition gives no transform for this instance"
        raise ProtocolError(msg, where="/".join(names))
    place = occurrences[path]
    transform = numbers(place["transform"], 16).reshape(4, 4)
    check_rigid(transform)
    return Occurrence(
        path, names, instance, frozen(transform), bool(place.get("fixed")), bool(place.get("hidden"))
    )


def _check_ids(features: Sequence[Record]) -> None:
    """Raises ValueError or TypeError unless the ids of the features are unique."""
    known_ids: set[str] = set()
    for feature_id in (text(feature["id"]) for feature in features):
        if feature_id in known_ids:
            msg = f"two features have the id {feature_id!r}"
            raise ValueError(msg)
        known_ids.add(feature_id)


def _read_feature(content: _AssemblyContent, owner: Path, names: tuple[str, ...], feature: Record) -> None:
    data, kind = feature.get("featureData") or {}, feature.get("featureType")
    name = text(data.get("name") or feature["id"])
    title = "/".join((*names, name))
    if kind == "mate":
        _read_mate(content, owner, title, name, feature, data)
    elif kind == "mateRelation":
        content.relations.append(
            MateRelation(
                owner,
                feature["id"],
                title,
                text(data.get("relationType", "UNKNOWN")),
                tuple(
                    (owner + id_path(m.get("occurrence")), text(m["featureId"]))
                    for m in data.get("mates") or ()
                ),
                number(data.get("relationRatio") or 0.0),
                number(data.get("relationLength") or 0.0),
                bool(data.get("reverseDirection")),
            )
        )
    elif kind == "mateGroup":
        members = tuple(owner + id_path(o.get("occurrence")) for o in data.get("occurrences") or ())
        content.groups.append(MateGroup(owner, title, tuple(m for m in members if m in content.occurrences)))
    elif kind == "mateConnector":
        path = owner + id_path(data.get("occurrence"))
        if path and path not in content.occurrences:
            return  # its instance is suppressed, or has no parts
        frame = _frame(data["mateConnectorCS"])
        content.connectors.append(Connector(owner, feature["id"], name, names, Entity(path, frame)))
    else:
        content.log.report(
            "W-FEATURE",
            f"a feature of type {kind} is not supported: the robot moves as if it were not there",
            title,
            "replace it by a mate, or suppress it",
        )


def _read_mate(
    content: _AssemblyContent, owner: Path, title: str, name: str, feature: Record, data: Record
) -> None:
    entities = tuple(
        Entity(owner + id_path(e.get("matedOccurrence")), _frame(e["matedCS"]))
        for e in data["matedEntities"] or ()
    )
    has_both_sides = len(entities) == 2 and all(not e.path or e.path in content.occurrences for e in entities)
    if not has_both_sides:
        content.log.report(
            "W-MATE-BROKEN",
            "the mate lacks one of its two sides (deleted or suppressed): left out",
            title,
            "repair or delete the mate in Onshape",
        )
        return
    ref = MateRef(owner, feature["id"], name, text(data.get("mateType", "UNKNOWN")))
    if ref.type not in JOINT_TYPES:
        content.log.report(
            "E-MATE-TYPE",
            f"unknown mate type {ref.type}: its degrees of freedom are unknown",
            title,
            f"suppress it, or use one of the types {', '.join(JOINT_TYPES)}",
        )
        return
    limits = data.get("mateLimits")
    if limits is not None:
        limits = {key: number(value) for key, value in limits.items() if value is not None}
    content.mates.append(Mate(ref, title, entities, limits))


def _read_patterns(owner: Path, names: tuple[str, ...], record: Record) -> Iterator[Pattern]:
    """Yields the patterns and mirrors of an assembly, in the order of their ids.
    Parametric instances count as mirrors unless their type contains "pattern" or "replicate": Onshape's
    documentation does not list the types.
    """
    instances = [
        (pattern, False, list((pattern.get("seedToPatternInstances") or {}).items()))
        for pattern in record.get("patterns") or ()
    ] + [
        (
            mirror,
            not re.search("pattern|replicate", str(mirror.get("type")), re.IGNORECASE),
            [
                (child["seedOccurrence"], child.get("instanceIds"))
                for child in mirror.get("children") or ()
                if child.get("seedOccurrence")
            ],
        )
        for mirror in record.get("parametricInstances") or ()
    ]
    for pattern, mirrors, pairs in sorted(instances, key=lambda triple: str(triple[0].get("id"))):
        if pattern.get("suppressed"):
            continue
        copies: dict[Path, tuple[Path, ...]] = {}
        for seed, ids in pairs:
            path = owner + id_path([seed] if isinstance(seed, str) else seed)
            copies[path] = copies.get(path, ()) + tuple((*owner, instance_id) for instance_id in id_path(ids))
        name = pattern.get("name") or pattern.get("type") or "pattern"
        yield Pattern(owner, "/".join((*names, name)), copies, mirrors)


def _frame(coordinate_system: Record) -> Array:
    """Returns a mate coordinate system {origin, xAxis, yAxis, zAxis} as occurrence_from_frame (4, 4)."""
    frame = np.eye(4)
    for column, key in enumerate(("xAxis", "yAxis", "zAxis", "origin")):
        frame[:3, column] = numbers(coordinate_system[key], 3)
    check_rigid(frame)
    return frozen(frame)
