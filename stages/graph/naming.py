"""Names of links, joints and frames, from what the designer typed.

A link is named by its `link_` connector, else by the sub-assembly that it is, else by its part
with the most mates to other links (ties: by volume, then by name). Names do not depend on the
root nor on the order of anything, and adding a screw to a link leaves them alone.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stages.graph.assembly import Assembly, Connector, Mate, Path
from stages.graph.bodies import Bodies
from stages.graph.mass import PartKey
from stages.robot.bundle import StudioKey
from stages.robot.model import Inertial
from stages.robot.names import free, legal, shortest_unique

LINK_PREFIX = "link_"
MAIN_SHARE = 0.9
"""A sub-assembly names a link when it holds at least this share of the link's volume."""


@dataclass(frozen=True, slots=True)
class Names:
    """Link names and naming occurrences by body, joint names by (owner, feature), frames alike."""

    links: tuple[str, ...]
    paths: tuple[Path, ...]
    joints: Mapping[tuple[Path, str], str]
    frames: Mapping[tuple[Path, str], str]


def name_everything(
    assembly: Assembly, bodies: Bodies, masses: Mapping[PartKey, tuple[Inertial, float]]
) -> Names:
    """Unique names over links, joints and frames together; links choose first, frames last."""
    paths = tuple(_naming_paths(assembly, bodies, masses))
    given = {
        bodies.of[c.entity.path]: (*c.names, c.name[len(LINK_PREFIX) :])
        for c in sorted(assembly.connectors, key=lambda c: (c.names, c.name, c.feature), reverse=True)
        if is_link_name(c) and c.entity.path in bodies.of
    }
    words = {
        _key(paths[body]): given.get(body) or assembly.occurrences[paths[body]].names
        for body in range(len(paths))
    }
    by_path = shortest_unique(words)
    links = tuple(by_path[_key(path)] for path in paths)
    taken = set(links)
    joints = _feature_names([(mate.ref.owner, mate) for mate in bodies.moving], assembly, taken, "_joint")
    taken.update(joints.values())
    markers = [(c.owner, c) for c in assembly.connectors if not is_link_name(c)]
    frames = _feature_names(markers, assembly, taken, "_frame")
    return Names(links, paths, joints, frames)


def is_link_name(connector: Connector) -> bool:
    return connector.name.lower().startswith(LINK_PREFIX) and bool(legal(connector.name[len(LINK_PREFIX) :]))


def _key(path: Path) -> str:
    # Ids hold no space, so the joined text sorts and compares as the path does.
    return " ".join(path)


def _feature_names(
    features: Sequence[tuple[Path, Mate | Connector]], assembly: Assembly, taken: set[str], suffix: str
) -> dict[tuple[Path, str], str]:
    words: dict[str, tuple[str, ...]] = {}
    keys: dict[str, tuple[Path, str]] = {}
    for owner, feature in features:
        ident, name = (
            (feature.ref.feature, feature.ref.name)
            if isinstance(feature, Mate)
            else (feature.feature, feature.name)
        )
        key = _key((*owner, ident))
        owner_names = assembly.occurrences[owner].names if owner else ()
        words[key], keys[key] = (*owner_names, name), (owner, ident)
    unique = shortest_unique(words)
    # A joint called like a link says what it is rather than counting ("elbow" → "elbow_joint").
    taken = set(taken)
    names = {}
    for key in sorted(unique, key=lambda key: (unique[key], key)):
        name = unique[key]
        names[keys[key]] = free(name + suffix if name in taken else name, taken)
        taken.add(names[keys[key]])
    return names


def _naming_paths(
    assembly: Assembly, bodies: Bodies, masses: Mapping[PartKey, tuple[Inertial, float]]
) -> list[Path]:
    """The occurrence that names each body."""
    mates = Counter(entity.path for mate in bodies.moving for entity in mate.entities)
    volume = {}
    for part in assembly.parts:
        key = (StudioKey.of(part.record), part.record["partId"])
        volume[part.path] = masses[key][1] if key in masses else 0.0
    inside: dict[Path, list[int]] = {}
    for part in assembly.parts:
        for depth in range(1, len(part.path)):
            inside.setdefault(part.path[:depth], []).append(bodies.of[part.path])
    whole = {path: found[0] for path, found in inside.items() if len(set(found)) == 1}
    held: dict[int, list[Path]] = {}
    for path, body in whole.items():
        held.setdefault(body, []).append(path)
    named = []
    for body, members in enumerate(bodies.members):
        total = sum(volume[path] for path in members)
        candidates = [
            path
            for path in held.get(body, ())
            if sum(volume[m] for m in members if m[: len(path)] == path) >= MAIN_SHARE * total
        ]
        if candidates and len(members) > 1:
            named.append(min(candidates, key=lambda path: (len(path), assembly.occurrences[path].names)))
        else:
            named.append(
                min(members, key=lambda p: (-mates[p], -volume[p], assembly.occurrences[p].names, p))
            )
    return named
