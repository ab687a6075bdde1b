"""Names links, joints and frames after what the designer typed.

A link is named by its `link_` connector, else by the sub-assembly of which it consists, else by its part with
the most mates to other links (ties: by volume, then by name). Names do not depend on the root or on the order
of anything, and a screw that is added to a link does not change them.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import TypeVar

from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.graph.onshape.assembly import Assembly, Connector, Path
from linkwright.stages.graph.onshape.bodies import Bodies
from linkwright.stages.graph.onshape.mates.joints import dof_names
from linkwright.stages.robot.text.names import legal_name, shortest_unique

Key = TypeVar("Key")

LINK_PREFIX = "link_"
MAIN_SHARE = 0.9
"""Smallest share of a link's volume that a sub-assembly holds if the link is named after it."""


@dataclass(frozen=True, slots=True)
class AssemblyNames:
    """The name of each body's link, and the path of the occurrence after which it is named; names of joints
    by `MateRef.key`; names of frames by (owner path, feature id)."""

    links: tuple[str, ...]
    paths: tuple[Path, ...]
    joints: Mapping[tuple[Path, str, str], str]
    frames: Mapping[tuple[Path, str], str]


def name_everything(assembly: Assembly, bodies: Bodies, volume: Mapping[Path, float]) -> AssemblyNames:
    """Returns unique names over links, joints, their dofs and frames; links choose first, frames last.

    `volume` [m³] of each part. A body without parts is the assembly's origin.
    """
    paths = tuple(_naming_paths(assembly, bodies, volume))
    connector_words = {
        bodies.of[c.entity.path]: (*c.names, c.name[len(LINK_PREFIX) :])
        for c in sorted(assembly.connectors, key=lambda c: (c.names, c.name, c.feature), reverse=True)
        if is_link_name(c) and c.entity.path in bodies.of
    }
    words = {
        _key(path): connector_words.get(body) or assembly.occurrences[path].names
        for body, path in enumerate(paths)
        if path
    }
    by_path = shortest_unique(words)
    links = tuple(by_path[_key(path)] if path else WORLD_LINK for path in paths)
    taken_names = set(links)
    mates = {mate.ref.key: (*_names(assembly, mate.ref.owner), mate.ref.name) for mate in bodies.moving}
    types = {mate.ref.key: mate.ref.type for mate in bodies.moving}
    joints = _feature_names(mates, taken_names, "_joint", lambda key, name: dof_names(name, types[key]))
    taken_names.update(joints.values())
    taken_names.update(name for key, joint in joints.items() for name in dof_names(joint, types[key]))
    markers = {
        (c.owner, c.feature): (*_names(assembly, c.owner), c.name)
        for c in assembly.connectors
        if not is_link_name(c)
    }
    return AssemblyNames(
        links, paths, joints, _feature_names(markers, taken_names, "_frame", lambda _, name: ())
    )


def is_link_name(connector: Connector) -> bool:
    """Tells whether a mate connector names a link: by `link_` and a usable name."""
    return connector.name.lower().startswith(LINK_PREFIX) and bool(
        legal_name(connector.name[len(LINK_PREFIX) :])
    )


def _key(path: Path) -> str:
    # Ids contain no space, so that the joined text sorts and compares as the path does.
    return " ".join(path)


def _names(assembly: Assembly, owner: Path) -> tuple[str, ...]:
    return assembly.occurrences[owner].names if owner else ()


def _feature_names(
    features: Mapping[Key, Sequence[str]],
    taken_names: set[str],
    suffix: str,
    parts: Callable[[Key, str], Sequence[str]],
) -> dict[Key, str]:
    """Returns a name for each feature from its words; neither the name nor what `parts` makes of it is in
    `taken_names`."""
    key_of_text = {repr(key): key for key in features}
    unique = shortest_unique({text: features[key] for text, key in key_of_text.items()})
    # A joint called like a link gets a word rather than a number ("elbow" → "elbow_joint").
    taken_names = set(taken_names)
    names = {}
    for text in sorted(unique, key=lambda text: (unique[text], text)):
        key, name = key_of_text[text], unique[text]
        if name in taken_names:
            name += suffix
        candidates = (name if number == 1 else f"{name}_{number}" for number in count(1))
        names[key] = next(
            candidate
            for candidate in candidates
            if taken_names.isdisjoint((candidate, *parts(key, candidate)))
        )
        taken_names.update((names[key], *parts(key, names[key])))
    return names


def _naming_paths(assembly: Assembly, bodies: Bodies, volume: Mapping[Path, float]) -> list[Path]:
    """Returns the path of the occurrence after which each body is named; () for a body without parts."""
    mates = Counter(entity.path for mate in bodies.moving for entity in mate.entities)
    bodies_of_path: dict[Path, set[int]] = {}
    volume_of_path: dict[Path, float] = {}
    for part in assembly.parts:
        for depth in range(1, len(part.path)):
            bodies_of_path.setdefault(part.path[:depth], set()).add(bodies.of[part.path])
            volume_of_path[part.path[:depth]] = volume_of_path.get(part.path[:depth], 0.0) + volume[part.path]
    paths_by_body: dict[int, list[Path]] = {}
    for path, bodies_inside in bodies_of_path.items():
        if len(bodies_inside) == 1:
            paths_by_body.setdefault(next(iter(bodies_inside)), []).append(path)
    naming_paths: list[Path] = []
    for body, members in enumerate(bodies.members):
        if not members:
            naming_paths.append(())
            continue
        total = sum(volume[path] for path in members)
        candidates = [
            path for path in paths_by_body.get(body, ()) if volume_of_path[path] >= MAIN_SHARE * total
        ]
        if candidates and len(members) > 1:
            naming_paths.append(
                min(candidates, key=lambda path: (len(path), assembly.occurrences[path].names))
            )
        else:
            naming_paths.append(
                min(members, key=lambda p: (-mates[p], -volume[p], assembly.occurrences[p].names, p))
            )
    return naming_paths
