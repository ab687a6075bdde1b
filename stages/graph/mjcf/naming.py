"""Names the bodies, joints, sites and equalities of an MJCF: they keep their names, or get new names."""

from collections.abc import Collection, Iterator, Mapping, Sequence

from linkwright.stages.formats.mjcf.model import Mjcf
from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.graph.mjcf.equalities import ClosureJoint
from linkwright.stages.graph.naming import FileNames, Namer
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.mjcf_extras import MjcfElement

WORLD_NUMBER = 0
"""Number of the body that is the world."""

MjcfFileNames = FileNames[int, tuple[int, int]]
"""Joints and dofs are keyed by the body that they move, sites by their body and their index in it."""


def names_of(
    mjcf: Mjcf,
    closure_joints: Sequence[ClosureJoint],
    joining: Collection[ClosureJoint],
    hidden_sites: Collection[str],
    log: Diagnostics,
) -> MjcfFileNames:
    """Keeps the file's own names wherever they can stay; reports W-NAME for each that changes.

    `joining`: the closure joints that become joints of the tree. `hidden_sites`: names of the sites that are
    no frames.
    """
    namer = Namer()
    namer.reserve(name for section in mjcf.extras.scene for name in _names_in(section))
    bodies = list(enumerate(mjcf.bodies))[1:]
    links = namer.keep("link", ((number, body.name) for number, body in bodies))
    dofs = namer.keep("joint", _dofs(mjcf))
    frames = namer.keep("frame", _sites(mjcf, hidden_sites))
    equalities = namer.keep("equality", _equalities(mjcf, closure_joints))
    namer.report(log)
    # Unnamed elements are named once all names in the file are known.
    links = namer.fill("link", links, ((number, f"body_{number}") for number, _ in bodies))
    dofs = namer.fill("joint", dofs, _proposed_dofs(mjcf, links))
    joints = list(dofs.values())
    relations = namer.fill("equality", equalities, _proposed_relations(mjcf, joints))
    loops = _loops(namer, closure_joints, joining, equalities)
    names_by_body = {
        number: tuple(dofs[number, place] for place in range(len(body.joints)))
        for number, body in enumerate(mjcf.bodies)
    }
    return FileNames(
        links={WORLD_NUMBER: WORLD_LINK} | links,
        frames=frames,
        joints={number: _joint_name(namer, links[number], names_by_body[number]) for number, _ in bodies},
        dofs=names_by_body,
        relations={index: name for (_, index), name in relations.items()},
        loops=loops,
    )


def _names_in(element: MjcfElement) -> Iterator[str]:
    """Yields the names of an element and of all in it."""
    if element.name:
        yield element.name
    for child in element.children:
        yield from _names_in(child)


def _dofs(mjcf: Mjcf) -> Iterator[tuple[tuple[int, int], str]]:
    for number, body in enumerate(mjcf.bodies):
        for index, joint in enumerate(body.joints):
            yield (number, index), joint.name


def _proposed_dofs(mjcf: Mjcf, links: Mapping[int, str]) -> Iterator[tuple[tuple[int, int], str]]:
    """Yields proposals for names of dofs: that of the body and "joint", with a number if the body has
    several."""
    for (number, index), _ in _dofs(mjcf):
        has_several = len(mjcf.bodies[number].joints) > 1
        yield (number, index), f"{links[number]}_joint" + (f"_{index + 1}" if has_several else "")


def _sites(mjcf: Mjcf, hidden_sites: Collection[str]) -> Iterator[tuple[tuple[int, int], str]]:
    for number, body in enumerate(mjcf.bodies):
        for index, site in enumerate(body.sites):
            if site.name not in hidden_sites:
                yield (number, index), site.name


def _equalities(mjcf: Mjcf, closure_joints: Sequence[ClosureJoint]) -> Iterator[tuple[tuple[str, int], str]]:
    for index, joint in enumerate(closure_joints):
        yield ("loop", index), joint.closure.name
    for index, relation in enumerate(mjcf.relations):
        yield ("relation", index), relation.name


def _proposed_relations(mjcf: Mjcf, joints: Sequence[str]) -> Iterator[tuple[tuple[str, int], str]]:
    for index, relation in enumerate(mjcf.relations):
        yield ("relation", index), f"{joints[relation.follower]}_relation"


def _loops(
    namer: Namer,
    closure_joints: Sequence[ClosureJoint],
    joining: Collection[ClosureJoint],
    kept_names: Mapping[tuple[str, int], str],
) -> dict[int, tuple[str, str]]:
    """Returns the name of each equality, and that of its dof, which is the same unless a joint has it."""
    names = {}
    for index, joint in enumerate(closure_joints):
        name = kept_names.get(("loop", index)) or namer.make("equality", "loop")
        is_free = namer.is_free("joint", name)
        dof_name = name if is_free else namer.make("joint", f"{name}_loop")
        names[index] = (dof_name if joint in joining else name, dof_name)
        if is_free:
            namer.keep("joint", [(index, name)])
    return names


def _joint_name(namer: Namer, link: str, dofs: Sequence[str]) -> str:
    """Returns the name of a body's combined joint: that of its only joint, else a new name."""
    if len(dofs) == 1:
        return dofs[0]
    return namer.make("joint", f"{link}_{'joints' if dofs else 'fixed'}")
