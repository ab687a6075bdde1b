"""What a USD says of its units, of where the robot stands, of its shapes and of what collides."""

import struct
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes.faces import mesh_corners
from linkwright.stages.formats.usd.names import UsdNames
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.geometry import Geometry, Role, Shape
from linkwright.stages.robot.model.poses import UNMOVED
from linkwright.stages.robot.model.robot import Array, Robot
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import differs, named, place_differs, shown
from linkwright.stages.validate.usd.looks import looks
from linkwright.stages.validate.usd.reader import UsdRobot
from linkwright.stages.validate.usd.shape_reader import ReadUsdShape

PLACE = 1e-6
"""Places of shapes [m, rad] and sizes of primitives [m] are the same within this."""

SINGLE = 1e-5
"""The frames of joints [m, rad] are in single precision."""

WITHIN = 2e-5
"""Bounds of meshes [m], and relatively beyond a metre: points are in single precision."""


def units(usd: UsdRobot) -> list[Finding]:
    """All numbers are of metres and kilograms, and z points upwards."""
    found = []
    for name, value in zip(("metersPerUnit", "kilogramsPerUnit"), usd.units, strict=True):
        if value != 1.0:
            found.append(differs("layer", name, value, 1.0))
    if usd.up != "Z":
        found.append(differs("layer", "upAxis", usd.up, "Z"))
    return found


def rooted(usd: UsdRobot, robot: Robot, names: UsdNames) -> Iterator[Finding]:
    """An articulation begins at the joint that holds a fixed robot, else at its root link, and at each link
    that moves freely from another and carries a joint."""
    carries = {joint.parent for joint in robot.joints if joint.type != "free"}
    free = [joint.child for joint in robot.joints if joint.type == "free" and joint.child in carries]
    wanted = {names.base} if robot.base.fixed else {names.links[robot.root.name]}
    wanted |= {names.links[link] for link in free}
    for name in sorted(wanted - usd.roots.keys()):
        words = "begins no articulation, expected PhysicsArticulationRootAPI"
        yield Finding(named("def", name), "apiSchemas", words)
    for name in sorted(usd.roots.keys() - wanted):
        words = "begins an articulation by PhysicsArticulationRootAPI, and the robot's begins elsewhere"
        yield Finding(named("def", name), "apiSchemas", words)


def placed(usd: UsdRobot, robot: Robot, names: UsdNames, place: Array | None) -> Iterator[Finding]:
    """The root stands, and is held, where the scene has the robot at `home`: `place` (4, 4), None where that
    is not known."""
    if place is None:
        return
    body = names.links[robot.root.name]
    attributes = ("xformOp:translate", "xformOp:orient")
    yield from place_differs(named("def", body), usd.bodies[body].world_from_body, place, attributes, PLACE)
    if robot.base.fixed and names.base in usd.joints:
        joint = usd.joints[names.base]
        if joint.place != usd.path:
            yield differs(named("def", names.base), "physics:body0", joint.place or "none", usd.path)
        held = joint.first_from_joint @ np.linalg.inv(joint.second_from_joint)
        attributes = ("physics:localPos0", "physics:localRot0")
        yield from place_differs(named("def", names.base), held, place, attributes, SINGLE)


def moving(usd: UsdRobot, robot: Robot, names: UsdNames, geometry: Geometry | None) -> Iterator[Finding]:
    """Forces move every body, by its own mass and from rest, and those bodies collide with each other that do
    in the robot."""
    for name, body in usd.bodies.items():
        if not body.moves:
            yield Finding(named("def", name), "physics:rigidBodyEnabled", "no force moves it")
        if "PhysicsMassAPI" not in body.schemas:
            yield differs(named("def", name), "apiSchemas", "no PhysicsMassAPI", "PhysicsMassAPI")
        for attribute, value in body.starts.items():
            if value:
                yield differs(named("def", name), attribute, value, 0.0)
    if geometry is None:
        return
    for name, engines in usd.roots.items():
        for attribute, collides in engines.items():
            if collides != geometry.self_contact:
                word = str(geometry.self_contact).lower()
                yield differs(named("def", name), attribute, str(collides).lower(), word)
    # Engines leave out by themselves what a joint of the tree holds together.
    joined = {frozenset((one.first, one.second)) for one in usd.joints.values() if not one.closes}
    own = {frozenset((names.links[one.link_a], names.links[one.link_b])): one for one in geometry.excludes}
    whole = {pair for pair, one in own.items() if not one.geoms} - joined
    found = {frozenset((name, other)) for name, body in usd.bodies.items() for other in body.apart}
    for pair in sorted(map(sorted, whole ^ (found - joined))):
        words = (
            "collide, and do not in the robot"
            if frozenset(pair) in whole
            else "do not collide, but in the robot"
        )
        yield Finding(named("def", pair[0]), "physics:filteredPairs", f"{' and '.join(pair)} {words}")


def shapes(usd: UsdRobot, names: UsdNames, geometry: Geometry, folder: Path) -> Iterator[Finding]:
    """Each body has the shapes of its link: as many, where they must be, of their size; and what is between
    the dofs of a joint has none. `folder`: that of the USD, which has the files of its meshes."""
    links = {own: name for name, own in names.links.items()}
    by_link = geometry.by_link()
    roles: tuple[Role, ...] = ("visual", "collision")
    for body, read in usd.bodies.items():
        for role in roles:
            wanted = by_link[links.get(body, ""), role]
            found = [one for one in read.shapes if one.collides == (role == "collision")]
            element = named("def", body)
            if len(found) != len(wanted):
                yield Finding(element, role, f"has {count(len(found), role)}, expected {len(wanted)}")
                continue
            yield from _differences(element, role, found, wanted, folder)


def _differences(
    element: str, role: str, found: Sequence[ReadUsdShape], wanted: Sequence[Shape], folder: Path
) -> Iterator[Finding]:
    for number, (shape, one) in enumerate(zip(found, wanted, strict=True), 1):
        which = f"{role} {number}"
        yield from looks(element, which, shape, one)
        for attribute, has, expected in shape.lacks:
            yield differs(element, f"{which} {attribute}", has, expected)
        kind = one.primitive.kind if one.primitive else "mesh"
        if shape.kind != kind:
            yield differs(element, f"{which} type", shape.kind, kind)
        elif one.primitive is None:
            yield from _of_mesh(element, which, shape, one, folder)
        elif not np.allclose(shape.size, one.primitive.size, rtol=PLACE, atol=PLACE):
            words = f"is {shown(shape.size)}, expected {shown(one.primitive.size)} [m]"
            yield Finding(element, f"{which} {kind} size", words)
        else:
            attributes = (f"{which} xformOp:translate", f"{which} xformOp:orient")
            expected_place = one.primitive.link_from_shape
            yield from place_differs(element, shape.body_from_shape, expected_place, attributes, PLACE)


def _of_mesh(element: str, which: str, shape: ReadUsdShape, wanted: Shape, folder: Path) -> Iterator[Finding]:
    attributes = (f"{which} xformOp:translate", f"{which} xformOp:orient")
    moved = list(place_differs(element, shape.body_from_shape, UNMOVED, attributes, PLACE))
    yield from moved
    if moved or not wanted.bounds:
        return
    if not shape.bounds:
        yield Finding(element, f"{which} references", f"has no points, expected those of {wanted.file}")
        return
    off = float(np.abs(np.subtract(shape.bounds, wanted.bounds)).max())
    if off > WITHIN * max(1.0, float(np.abs(wanted.bounds).max())):
        words = f"its bounds are {shown(1e3 * off)} mm off those of {wanted.file}"
        yield Finding(element, f"{which} references", words)
        return
    corners, texcoords = _written(folder, wanted)
    if corners is not None and not _alike(shape.corners, corners):
        words = f"has other triangles than assets/{wanted.file}"
        yield Finding(element, f"{which} faceVertexIndices", words)
    elif texcoords is not None and not _alike(shape.texcoords, texcoords):
        words = f"are not the texture coordinates of assets/{wanted.file}"
        yield Finding(element, f"{which} primvars:st", words)


def _written(folder: Path, shape: Shape) -> tuple[Array | None, Array | None]:
    """The corners and the texture coordinates of a mesh's file; None where it cannot be read, which another
    check says."""
    try:
        return mesh_corners(str(shape.file), (folder / "assets" / str(shape.file)).read_bytes())
    except (OSError, ValueError, IndexError, struct.error):
        return None, None


def _alike(found: npt.NDArray[np.float32] | None, wanted: Array) -> bool:
    if found is None or found.shape != wanted.shape:
        return False
    return np.allclose(found, wanted, rtol=0, atol=WITHIN)
