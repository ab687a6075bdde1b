"""Names from an MJCF: kept as they are wherever every simulator accepts them, made up where there is none."""

from dataclasses import dataclass

from stages.graph.mechanism import WORLD_LINK
from stages.graph.notes import Notes
from stages.robot.mjcf import Mjcf
from stages.robot.names import RESERVED, free, plain

Wanted = list[tuple[tuple[int, int], str, str]]
"""(key, the file's name or "", the name to make up)."""


@dataclass(frozen=True, slots=True)
class Names:
    """`links` by body, `dofs` by joint, `couplings` by the body below (of those with no or several
    joints), `sites` by body and place in it."""

    links: dict[int, str]
    dofs: dict[int, str]
    couplings: dict[int, str]
    sites: dict[tuple[int, int], str]


def names_of(mjcf: Mjcf, hidden: frozenset[str], notes: Notes) -> Names:
    """Unique names over all of them; each of the file's that changes is told (W-NAME).

    Links come before joints and these before sites, which give way. `hidden`: sites that are no frames.
    """
    taken = set(RESERVED)
    changed: list[str] = []

    def settle(wanted: Wanted, kind: str) -> dict[tuple[int, int], str]:
        names = {}
        # What is fine as it is comes first, so that nothing that is mended or made up takes its name.
        ranked = sorted(wanted, key=lambda one: (one[1] == "", plain(one[1] or "x") != one[1], one[0]))
        for key, given, made_up in ranked:
            name = plain(given) if given else made_up
            if name in taken:
                name = free(f"{name}_{kind}" if given else name, taken)
            taken.add(name)
            names[key] = name
            if given and name != given:
                changed.append(f"{given!r} → {name!r}")
        return names

    bodies = list(enumerate(mjcf.bodies))[1:]
    links = settle([((i, 0), body.name, f"body_{i}") for i, body in bodies], "link")
    joints: Wanted = []
    for number, body in bodies:
        for index, joint in enumerate(body.joints):
            suffix = "" if len(body.joints) == 1 else f"_{index + 1}"
            joints.append(((len(joints), 0), joint.name, f"{links[number, 0]}_joint{suffix}"))
    dofs = settle(joints, "joint")
    ends = {0: "fixed", 1: ""}
    more: Wanted = [
        ((number, 0), "", f"{links[number, 0]}_{ends.get(len(body.joints), 'joints')}")
        for number, body in bodies
        if len(body.joints) != 1
    ]
    couplings = settle(more, "joint")
    sites = settle(
        [
            ((number, index), site.name, "")
            for number, body in enumerate(mjcf.bodies)
            for index, site in enumerate(body.sites)
            if site.name not in hidden
        ],
        "frame",
    )
    if changed:
        text = f"not legal, or not unique over links, joints and frames: {', '.join(changed)}"
        notes.tell("W-NAME", text, mjcf.name, "names of links, joints and sites are in one space here")
    return Names(
        {WORLD_NUMBER: WORLD_LINK} | {number: name for (number, _), name in links.items()},
        {number: name for (number, _), name in dofs.items()},
        {number: name for (number, _), name in couplings.items()},
        sites,
    )


WORLD_NUMBER = 0
"""The body that is the world."""
