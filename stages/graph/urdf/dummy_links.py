"""Dummy links: frames that a file writes as links, and massless links between two joints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.formats.urdf.model import Urdf, UrdfJoint, UrdfLink, UrdfShape
from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.graph.urdf.structure import tops
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import LEAST_MOMENT, NEXT_TO_NOTHING, SPECK, merged, moved
from linkwright.stages.robot.model.robot import Array, Inertial, frozen
from linkwright.stages.robot.text.globs import listed
from linkwright.stages.robot.text.plural import count


@dataclass(frozen=True, slots=True, eq=False)
class UrdfFrame:
    """A dummy link turned into a frame: where it was on `link`, under its name in the file. `joint`: the
    fixed joint that held it there."""

    name: str
    joint: str
    link: str
    link_from_frame: Array


def without_dummies(urdf: Urdf, log: Diagnostics) -> tuple[Urdf, tuple[UrdfFrame, ...]]:
    """The file with each dummy on a fixed joint merged into its parent, as a frame (I-URDF-FRAME).

    A dummy has no mass, or has some but next to no extent: a point that its parent carries. Its shapes
    and its joints go to the parent with it. The link `world` takes in no dummies.
    """
    joints = {joint.child: joint for joint in urdf.joints}
    links = {link.name: link for link in urdf.links}
    world = WORLD_LINK if has_world(urdf) else None
    dummies = {
        child
        for child, joint in joints.items()
        if joint.type == "fixed" and joint.parent != world and _is_point(links[child].inertial)
    }
    places = _places(dummies, joints)
    carried: dict[str, list[tuple[UrdfLink, Array]]] = {}
    for name in sorted(places):
        carrier, pose = places[name]
        carried.setdefault(carrier, []).append((links[name], pose))
    kept = [_taking_in(link, carried.get(link.name, [])) for link in urdf.links if link.name not in dummies]
    moved_joints = [_moved(joint, places) for joint in urdf.joints if joint.child not in dummies]
    if dummies:
        text = f"{count(len(dummies), 'link')} without a body became frames of their parent links"
        hint = f"these links: {listed(dummies)}; the exported URDF has them as links again"
        log.report("I-URDF-FRAME", text, urdf.name, hint)
    frames = tuple(UrdfFrame(name, joints[name].name, *places[name]) for name in sorted(dummies))
    return replace(urdf, links=tuple(kept), joints=tuple(moved_joints)), frames


def weighs_nothing(inertial: Inertial | None) -> bool:
    return inertial is None or (inertial.mass == 0 and not inertial.inertia.any())


def _is_point(inertial: Inertial | None) -> bool:
    if inertial is None or weighs_nothing(inertial):
        return True
    return inertial.mass > 0 and bool(np.abs(inertial.inertia).max() < LEAST_MOMENT)


def has_world(urdf: Urdf) -> bool:
    """Whether the link `world` is the world that the robot is fixed to: a root without mass."""
    above = {joint.child for joint in urdf.joints}
    return any(
        link.name == WORLD_LINK and link.name not in above and weighs_nothing(link.inertial)
        for link in urdf.links
    )


def _places(dummies: set[str], joints: Mapping[str, UrdfJoint]) -> dict[str, tuple[str, Array]]:
    """The link that carries each dummy in the end, and the dummy's frame in it (4, 4)."""
    found: dict[str, tuple[str, Array]] = {}
    for name in dummies:
        way = []
        while name in dummies and name not in found:
            way.append(name)
            name = joints[name].parent
        for one in reversed(way):
            joint = joints[one]
            carrier, pose = found.get(joint.parent, (joint.parent, np.eye(4)))
            found[one] = carrier, frozen(pose @ joint.parent_from_joint)
    return found


def _taking_in(link: UrdfLink, mine: Sequence[tuple[UrdfLink, Array]]) -> UrdfLink:
    """The link with the shapes and the mass of the dummies that it carries, each with its place in it."""
    if not mine:
        return link
    points = [moved(one.inertial, pose) for one, pose in mine if one.inertial and one.inertial.mass > 0]
    inertial = link.inertial
    if points:
        inertial = merged([*([inertial] if inertial else []), *points])
    visuals, collisions = list(link.visuals), list(link.collisions)
    for one, pose in mine:
        visuals += [_at(shape, pose) for shape in one.visuals]
        collisions += [_at(shape, pose) for shape in one.collisions]
    return replace(link, inertial=inertial, visuals=tuple(visuals), collisions=tuple(collisions))


def _at(shape: UrdfShape, pose: Array) -> UrdfShape:
    return replace(shape, link_from_shape=frozen(pose @ shape.link_from_shape))


def _moved(joint: UrdfJoint, places: Mapping[str, tuple[str, Array]]) -> UrdfJoint:
    if joint.parent not in places:
        return joint
    parent, pose = places[joint.parent]
    return replace(joint, parent=parent, parent_from_joint=frozen(pose @ joint.parent_from_joint))


def with_carriers(urdf: Urdf, repair: bool, log: Diagnostics) -> Urdf:
    """The file with next to no mass (I-URDF-MASSLESS) on links that move without any, but carry others
    that have some: such a link is between two joints, like the inner links of a ball.

    `repair`: links that move without mass and carry none get some too (W-URDF-MASSLESS).
    """
    rigid = tops({joint.child: joint.parent for joint in urdf.joints if joint.type == "fixed"})

    def group(name: str) -> str:
        return rigid.get(name, name)

    heavy = {group(link.name) for link in urdf.links if not weighs_nothing(link.inertial)}
    above = {group(joint.child): group(joint.parent) for joint in urdf.joints if joint.type != "fixed"}
    carriers: set[str] = set()
    seen: set[str] = set()
    for name in sorted(heavy):
        while name in above and name not in seen:
            seen.add(name)
            name = above[name]
            if name in above and name not in heavy:
                carriers.add(name)
    hint = "give them their mass: mass: {links: {...}}"
    if carriers:
        text = f"links between joints have no mass; {NEXT_TO_NOTHING:g} kg was used: {listed(carriers)}"
        log.report("I-URDF-MASSLESS", text, urdf.name, hint)
    idle = set(above) - heavy - carriers if repair else set()
    if idle:
        text = (
            f"moving links have no mass; {NEXT_TO_NOTHING:g} kg was used, and the simulation may be unstable"
        )
        log.report("W-URDF-MASSLESS", f"{text}: {listed(idle)}", urdf.name, hint)
    carriers |= idle
    links = (replace(link, inertial=SPECK) if link.name in carriers else link for link in urdf.links)
    return replace(urdf, links=tuple(links))
