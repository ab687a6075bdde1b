"""Names from a file: kept as they are wherever every simulator accepts them, and mapped where not."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from stages.graph.mechanism import WORLD_LINK
from stages.graph.notes import Notes
from stages.graph.urdf.dummies import has_world
from stages.robot.names import RESERVED, free, plain
from stages.robot.urdf import Urdf

SUFFIXES = {"planar": ("_x", "_y", "_turn")}
"""What the names of a joint's dofs end in, where it has several."""


@dataclass(frozen=True, slots=True)
class Names:
    """The robot's names by those in the file: of links, of frames, of joints."""

    links: dict[str, str]
    frames: dict[str, str]
    joints: dict[str, str]


def names_of(urdf: Urdf, frames: Iterable[str], notes: Notes) -> Names:
    """Unique names over all of them, those that are fine untouched; each that changes is told (W-NAME).

    Links come before frames and these before joints: a joint that is called as a link is gives way.
    """
    taken = set(RESERVED)
    found = Names({WORLD_LINK: WORLD_LINK} if has_world(urdf) else {}, {}, {})
    links = sorted(link.name for link in urdf.links if link.name not in found.links)
    joints = sorted(urdf.joints, key=lambda joint: joint.name)
    groups: list[tuple[dict[str, str], list[tuple[str, tuple[str, ...]]], str]] = [
        (found.links, [(name, ("",)) for name in links], "_link"),
        (found.frames, [(name, ("",)) for name in sorted(frames)], "_frame"),
        (found.joints, [(joint.name, SUFFIXES.get(joint.type, ("",))) for joint in joints], "_joint"),
    ]
    for names, wanted, kind in groups:
        # What is fine as it is comes first, so that nothing that is mended takes its name.
        for fine in (True, False):
            for name, ends in wanted:
                if (plain(name) == name) is fine:
                    names[name] = _free(plain(name), ends, kind, taken)
                    taken |= {names[name], *(names[name] + end for end in ends)}
    _tell(found, notes)
    return found


def _free(name: str, ends: tuple[str, ...], kind: str, taken: set[str]) -> str:
    def is_free(stem: str) -> bool:
        return taken.isdisjoint({stem, *(stem + end for end in ends)})

    if is_free(name):
        return name
    return _first(free(f"{name}{kind}", taken), is_free)


def _first(name: str, is_free: Callable[[str], bool]) -> str:
    found, count = name, 2
    while not is_free(found):
        found, count = f"{name}_{count}", count + 1
    return found


def _tell(names: Names, notes: Notes) -> None:
    groups = (("link", names.links), ("frame", names.frames), ("joint", names.joints))
    for kind, found in groups:
        changed = [f"{old!r} → {new}" for old, new in sorted(found.items()) if new != old]
        if changed:
            text = (
                f"{len(changed)} {kind} name(s) would not be legal and unique over links, frames and joints: "
                f"{', '.join(changed)}"
            )
            notes.tell("W-NAME", text, kind, "robot.json has the file's own names, under cad")
