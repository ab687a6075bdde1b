"""Names from an MJCF: bodies, joints, sites and equalities keep theirs; what has none gets one."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from stages.formats.mjcf import Mjcf
from stages.graph.mechanism import WORLD_LINK
from stages.graph.mjcf.equalities import Closing
from stages.graph.naming import Key, Namer
from stages.robot.diagnostics import Diagnostics

WORLD_NUMBER = 0
"""The body that is the world."""


@dataclass(frozen=True, slots=True)
class Names:
    """`links` by body, `dofs` by joint, `couplings` by the body below (of those with no or several
    joints), `sites` by body and place in it, `relations` by number; `loops` and `loop_dofs` by closing."""

    links: dict[int, str]
    dofs: dict[int, str]
    couplings: dict[int, str]
    sites: dict[tuple[int, int], str]
    relations: dict[int, str]
    loops: dict[int, str]
    loop_dofs: dict[int, str]


def names_of(
    mjcf: Mjcf,
    found: Sequence[Closing],
    joining: Collection[Closing],
    hidden: Collection[str],
    log: Diagnostics,
) -> Names:
    """The file's own names wherever they can stay; each that changes is told (W-NAME).

    `joining`: those of the closings `found` that become joints. `hidden`: sites that are no frames.
    """
    namer = Namer()
    bodies = list(enumerate(mjcf.bodies))[1:]
    links = _kept(namer, "link", {number: body.name for number, body in bodies})
    joints = [joint for _, body in bodies for joint in body.joints]
    dofs = _kept(namer, "joint", {index: joint.name for index, joint in enumerate(joints)})
    sites = _kept(namer, "frame", _sites(mjcf, hidden))
    said = {("loop", index): one.closure.name for index, one in enumerate(found)}
    said |= {("relation", index): one.name for index, one in enumerate(mjcf.relations)}
    ties = _kept(namer, "equality", said)
    namer.tell(log)
    # What has no name gets one once all are known that have.
    links |= {number: namer.make("link", f"body_{number}") for number, _ in bodies if number not in links}
    for index, wanted in enumerate(_joint_names(mjcf, links)):
        dofs[index] = dofs.get(index) or namer.make("joint", wanted)
    relations = {
        index: ties.get(("relation", index)) or namer.make("equality", f"{dofs[one.follower]}_relation")
        for index, one in enumerate(mjcf.relations)
    }
    loops, loop_dofs = {}, {}
    for index, one in enumerate(found):
        name = ties.get(("loop", index)) or namer.make("equality", "loop")
        alone = namer.is_free("joint", name)
        loop_dofs[index] = name if alone else namer.make("joint", f"{name}_loop")
        loops[index] = loop_dofs[index] if one in joining else name
        if alone:
            namer.keep("joint", [(index, name)])
    return Names(
        {WORLD_NUMBER: WORLD_LINK} | links,
        dofs,
        {
            number: namer.make("joint", f"{links[number]}_{'joints' if body.joints else 'fixed'}")
            for number, body in bodies
            if len(body.joints) != 1
        },
        sites,
        relations,
        loops,
        loop_dofs,
    )


def _kept(namer: Namer, kind: str, names: Mapping[Key, str]) -> dict[Key, str]:
    """The names of what has one."""
    return namer.keep(kind, [(key, name) for key, name in names.items() if name])


def _sites(mjcf: Mjcf, hidden: Collection[str]) -> dict[tuple[int, int], str]:
    return {
        (number, index): site.name
        for number, body in enumerate(mjcf.bodies)
        for index, site in enumerate(body.sites)
        if site.name not in hidden
    }


def _joint_names(mjcf: Mjcf, links: Mapping[int, str]) -> list[str]:
    """What each joint is called if it has no name of its own: after its body, with a number where that has
    several."""
    return [
        f"{links[number]}_joint" + (f"_{place}" if len(body.joints) > 1 else "")
        for number, body in enumerate(mjcf.bodies)
        for place in range(1, len(body.joints) + 1)
    ]
