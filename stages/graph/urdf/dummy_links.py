"""Converts links that only represent frames into frames, and gives mass to massless links between two
joints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.formats.urdf.model import Urdf, UrdfJoint, UrdfLink, UrdfShape
from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.graph.urdf.structure import top_ancestors
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import MIN_MOMENT, TINY_INERTIAL, TINY_MASS, merged, moved
from linkwright.stages.robot.model.robot import Array, Inertial, frozen
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.robot.text.plural import count


@dataclass(frozen=True, slots=True, eq=False)
class UrdfFrame:
    """A frame on `link` that replaces a dummy link, with the name of the dummy in the file."""

    name: str
    joint: str
    """The fixed joint of the dummy link."""
    link: str
    link_from_frame: Array


def without_dummies(urdf: Urdf, log: Diagnostics) -> tuple[Urdf, tuple[UrdfFrame, ...]]:
    """Returns the file with each dummy on a fixed joint merged into its parent, as a frame (I-URDF-FRAME).

    A dummy has no mass, or a mass with almost no inertia: a point that its parent carries. The parent gets
    its shapes and joints. Dummies on the link `world` stay links.
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
    dummies_of_link: dict[str, list[tuple[UrdfLink, Array]]] = {}
    for name in sorted(places):
        carrier, pose = places[name]
        dummies_of_link.setdefault(carrier, []).append((links[name], pose))
    remaining_links = [
        _with_dummies(link, dummies_of_link.get(link.name, []))
        for link in urdf.links
        if link.name not in dummies
    ]
    moved_joints = [_move_joint(joint, places) for joint in urdf.joints if joint.child not in dummies]
    if dummies:
        text = f"{count(len(dummies), 'link')} without a body became frames of their parent links"
        hint = f"these links: {name_list(dummies)}; the exported URDF has them as links again"
        log.report("I-URDF-FRAME", text, urdf.name, hint)
    frames = tuple(UrdfFrame(name, joints[name].name, *places[name]) for name in sorted(dummies))
    return replace(urdf, links=tuple(remaining_links), joints=tuple(moved_joints)), frames


def is_massless(inertial: Inertial | None) -> bool:
    """Tells whether an inertial is missing, or has neither mass nor inertia."""
    return inertial is None or (inertial.mass == 0 and not inertial.inertia.any())


def _is_point(inertial: Inertial | None) -> bool:
    if inertial is None or is_massless(inertial):
        return True
    return inertial.mass > 0 and bool(np.abs(inertial.inertia).max() < MIN_MOMENT)


def has_world(urdf: Urdf) -> bool:
    """Tells whether the link `world` is the world to which the robot is fixed: a root without mass."""
    children = {joint.child for joint in urdf.joints}
    return any(
        link.name == WORLD_LINK and link.name not in children and is_massless(link.inertial)
        for link in urdf.links
    )


def _places(dummies: set[str], joints: Mapping[str, UrdfJoint]) -> dict[str, tuple[str, Array]]:
    """Returns for each dummy the nearest link above it that is no dummy, and the dummy's pose in it (4,
    4)."""
    places: dict[str, tuple[str, Array]] = {}
    for name in dummies:
        path = []
        while name in dummies and name not in places:
            path.append(name)
            name = joints[name].parent
        for dummy in reversed(path):
            joint = joints[dummy]
            carrier, pose = places.get(joint.parent, (joint.parent, np.eye(4)))
            places[dummy] = carrier, frozen(pose @ joint.parent_from_joint)
    return places


def _with_dummies(link: UrdfLink, dummies: Sequence[tuple[UrdfLink, Array]]) -> UrdfLink:
    """Returns the link with the shapes and the mass of the dummies that it carries, each with its place in
    it."""
    if not dummies:
        return link
    points = [
        moved(dummy.inertial, pose) for dummy, pose in dummies if dummy.inertial and dummy.inertial.mass > 0
    ]
    inertial = link.inertial
    if points:
        inertial = merged([*([inertial] if inertial else []), *points])
    visuals, collisions = list(link.visuals), list(link.collisions)
    for dummy, pose in dummies:
        visuals += [_move_shape(shape, pose) for shape in dummy.visuals]
        collisions += [_move_shape(shape, pose) for shape in dummy.collisions]
    return replace(link, inertial=inertial, visuals=tuple(visuals), collisions=tuple(collisions))


def _move_shape(shape: UrdfShape, pose: Array) -> UrdfShape:
    return replace(shape, link_from_shape=frozen(pose @ shape.link_from_shape))


def _move_joint(joint: UrdfJoint, places: Mapping[str, tuple[str, Array]]) -> UrdfJoint:
    if joint.parent not in places:
        return joint
    parent, pose = places[joint.parent]
    return replace(joint, parent=parent, parent_from_joint=frozen(pose @ joint.parent_from_joint))


def with_carriers(urdf: Urdf, repair: bool, log: Diagnostics) -> Urdf:
    """Gives a tiny mass to moving links without mass that carry links with mass (I-URDF-MASSLESS). Such a
    link is between two joints, such as those of a ball joint made of three hinges.
    `repair`: whether moving links without mass that carry no mass get a tiny mass too (W-URDF-MASSLESS).
    """
    rigid = top_ancestors({joint.child: joint.parent for joint in urdf.joints if joint.type == "fixed"})

    def group(name: str) -> str:
        return rigid.get(name, name)

    heavy = {group(link.name) for link in urdf.links if not is_massless(link.inertial)}
    parents = {group(joint.child): group(joint.parent) for joint in urdf.joints if joint.type != "fixed"}
    carriers: set[str] = set()
    visited: set[str] = set()
    for name in sorted(heavy):
        while name in parents and name not in visited:
            visited.add(name)
            name = parents[name]
            if name in parents and name not in heavy:
                carriers.add(name)
    hint = "give them their mass: mass: {links: {...}}"
    if carriers:
        text = f"links between joints have no mass; {TINY_MASS:g} kg was used: {name_list(carriers)}"
        log.report("I-URDF-MASSLESS", text, urdf.name, hint)
    massless_leaves = set(parents) - heavy - carriers if repair else set()
    if massless_leaves:
        text = f"moving links have no mass; {TINY_MASS:g} kg was used, and the simulation may be unstable"
        log.report("W-URDF-MASSLESS", f"{text}: {name_list(massless_leaves)}", urdf.name, hint)
    carriers |= massless_leaves
    links = (replace(link, inertial=TINY_INERTIAL) if link.name in carriers else link for link in urdf.links)
    return replace(urdf, links=tuple(links))
