"""Compares a USD's units, placement, shapes and collisions with the robot's."""

import struct
from collections.abc import Collection, Iterator, Sequence
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
from linkwright.stages.validate.findings import differs, named, pose_findings, shown
from linkwright.stages.validate.usd.looks import look_differences
from linkwright.stages.validate.usd.reader import UsdRobot
from linkwright.stages.validate.usd.shape_reader import ReadUsdShape

PLACE_TOLERANCE = 1e-6
"""Tolerance of the places of shapes [m, rad] and the sizes of primitives [m]."""

FRAME_TOLERANCE = 1e-5
"""Tolerance of the frames of joints [m, rad], which are in single precision."""

BOUNDS_TOLERANCE = 2e-5
"""Tolerance of the bounds of meshes [m], relative above a metre: points are in single precision."""


def units(usd: UsdRobot) -> list[Finding]:
    """Checks that the units are metres and kilograms, and that z points upwards."""
    findings = []
    for name, value in zip(("metersPerUnit", "kilogramsPerUnit"), usd.units, strict=True):
        if value != 1.0:
            findings.append(differs("layer", name, value, 1.0))
    if usd.up != "Z":
        findings.append(differs("layer", "upAxis", usd.up, "Z"))
    return findings


def rooted(usd: UsdRobot, robot: Robot, names: UsdNames) -> Iterator[Finding]:
    """Checks that an articulation begins at the joint that holds a fixed robot, or else at its root link, and
    at each link on a free joint that carries a joint."""
    carries = {joint.parent for joint in robot.joints if joint.type != "free"}
    free = [joint.child for joint in robot.joints if joint.type == "free" and joint.child in carries]
    expected = {names.base_joint} if robot.base.fixed else {names.links[robot.root.name]}
    expected |= {names.links[link] for link in free}
    for name in sorted(expected - usd.roots.keys()):
        message = "begins no articulation, expected PhysicsArticulationRootAPI"
        yield Finding(named("def", name), "apiSchemas", message)
    for name in sorted(usd.roots.keys() - expected):
        message = "begins an articulation by PhysicsArticulationRootAPI, and the robot's begins elsewhere"
        yield Finding(named("def", name), "apiSchemas", message)


def placed(usd: UsdRobot, robot: Robot, names: UsdNames, place: Array | None) -> Iterator[Finding]:
    """Checks that the root is where the scene has the robot at `home`, and that it is held there. `place`:
    this pose (4, 4), None if it is not known."""
    if robot.base.fixed and names.base_joint in usd.joints:
        yield from _base_joint_differences(usd, robot, names)
    if place is None:
        return
    body = names.links[robot.root.name]
    attributes = ("xformOp:translate", "xformOp:orient")
    yield from pose_findings(
        named("def", body), usd.bodies[body].world_from_body, place, attributes, PLACE_TOLERANCE
    )
    if robot.base.fixed and names.base_joint in usd.joints:
        joint = usd.joints[names.base_joint]
        world_from_root = joint.first_from_joint @ np.linalg.inv(joint.second_from_joint)
        attributes = ("physics:localPos0", "physics:localRot0")
        yield from pose_findings(
            named("def", names.base_joint), world_from_root, place, attributes, FRAME_TOLERANCE
        )


def _base_joint_differences(usd: UsdRobot, robot: Robot, names: UsdNames) -> Iterator[Finding]:
    """Yields the differences of the joint that must fix the root link to the robot's own prim."""
    joint, element = usd.joints[names.base_joint], named("def", names.base_joint)
    if joint.type != "Fixed":
        yield differs(element, "type", f"Physics{joint.type}Joint", "PhysicsFixedJoint")
    if joint.place != usd.path:
        yield differs(element, "physics:body0", joint.place or "none", usd.path)
    root_link = names.links[robot.root.name]
    if joint.second != root_link:
        yield differs(element, "physics:body1", joint.second or "none", root_link)
    if joint.closes:
        yield differs(element, "physics:excludeFromArticulation", "true", "false")


def moving(usd: UsdRobot, robot: Robot, names: UsdNames, geometry: Geometry | None) -> Iterator[Finding]:
    """Checks that forces move every body, by its mass and from rest, and that the same bodies collide with
    each other as in the robot."""
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
    # In engines, bodies that a joint of the tree connects never collide.
    joined_pairs = {
        frozenset((joint.first, joint.second)) for joint in usd.joints.values() if not joint.closes
    }
    excludes = {
        frozenset((names.links[exclude.link_a], names.links[exclude.link_b])): exclude
        for exclude in geometry.excludes
    }
    excluded_pairs = {pair for pair, exclude in excludes.items() if not exclude.geoms} - joined_pairs
    filtered = {frozenset((name, other)) for name, body in usd.bodies.items() for other in body.filtered}
    for pair in sorted(map(sorted, excluded_pairs ^ (filtered - joined_pairs))):
        message = (
            "collide, but not in the robot"
            if frozenset(pair) in excluded_pairs
            else "do not collide, but must, as in the robot"
        )
        yield Finding(named("def", pair[0]), "physics:filteredPairs", f"{' and '.join(pair)} {message}")
    yield from _collider_pair_differences(usd, names, geometry, joined_pairs)


def _collider_pair_differences(
    usd: UsdRobot, names: UsdNames, geometry: Geometry, joined_pairs: Collection[frozenset[str]]
) -> Iterator[Finding]:
    """Yields the pairs of colliders that collide although the robot's do not, and those that do not collide
    although the robot's do. `joined_pairs`: the bodies that never collide."""
    colliders = {
        name: [shape for shape in body.shapes if shape.collides] for name, body in usd.bodies.items()
    }
    body_of = {shape.path: name for name, shapes in colliders.items() for shape in shapes}
    expected = set()
    for exclude in geometry.excludes:
        first, second = (colliders[names.links[link]] for link in (exclude.link_a, exclude.link_b))
        for row, column in exclude.geoms:
            # The check of the shapes reports a body with another number of colliders.
            if row < len(first) and column < len(second):
                expected.add(frozenset((first[row].path, second[column].path)))
    actual = {
        frozenset((shape.path, path))
        for shapes in colliders.values()
        for shape in shapes
        for path in shape.filtered
        if path in body_of
    }
    for pair in sorted(map(sorted, expected ^ actual)):
        if frozenset(body_of[path] for path in pair) in joined_pairs:
            continue
        message = "do not collide, but must" if frozenset(pair) in actual else "collide, but must not"
        element = named("def", body_of[pair[0]])
        yield Finding(element, "physics:filteredPairs", f"{' and '.join(pair)} {message}")


def shapes(usd: UsdRobot, names: UsdNames, geometry: Geometry, folder: Path) -> Iterator[Finding]:
    """Checks that each body has the shapes of its link: their number, places and sizes. Bodies between the
    dofs of a joint must have none. `folder`: the folder of the USD, which has the files of its meshes."""
    links = {body: name for name, body in names.links.items()}
    by_link = geometry.by_link()
    roles: tuple[Role, ...] = ("visual", "collision")
    for body, read in usd.bodies.items():
        for role in roles:
            expected = by_link[links.get(body, ""), role]
            actual = [shape for shape in read.shapes if shape.collides == (role == "collision")]
            element = named("def", body)
            if len(actual) != len(expected):
                yield Finding(element, role, f"has {count(len(actual), role)}, expected {len(expected)}")
                continue
            yield from _differences(element, role, actual, expected, folder)


def _differences(
    element: str, role: str, actual: Sequence[ReadUsdShape], expected: Sequence[Shape], folder: Path
) -> Iterator[Finding]:
    for number, (shape, in_robot) in enumerate(zip(actual, expected, strict=True), 1):
        which = f"{role} {number}"
        yield from look_differences(element, which, shape, in_robot)
        for attribute, has, required in shape.lacks:
            yield differs(element, f"{which} {attribute}", has, required)
        kind = in_robot.primitive.kind if in_robot.primitive else "mesh"
        if shape.kind != kind:
            yield differs(element, f"{which} type", shape.kind, kind)
        elif in_robot.primitive is None:
            yield from _of_mesh(element, which, shape, in_robot, folder)
        elif not np.allclose(shape.size, in_robot.primitive.size, rtol=PLACE_TOLERANCE, atol=PLACE_TOLERANCE):
            message = f"is {shown(shape.size)}, expected {shown(in_robot.primitive.size)} [m]"
            yield Finding(element, f"{which} {kind} size", message)
        else:
            attributes = (f"{which} xformOp:translate", f"{which} xformOp:orient")
            expected_place = in_robot.primitive.link_from_shape
            yield from pose_findings(
                element, shape.body_from_shape, expected_place, attributes, PLACE_TOLERANCE
            )


def _of_mesh(
    element: str, which: str, shape: ReadUsdShape, in_robot: Shape, folder: Path
) -> Iterator[Finding]:
    attributes = (f"{which} xformOp:translate", f"{which} xformOp:orient")
    findings_on_place = list(
        pose_findings(element, shape.body_from_shape, UNMOVED, attributes, PLACE_TOLERANCE)
    )
    yield from findings_on_place
    if findings_on_place or not in_robot.bounds:
        return
    if not shape.bounds:
        yield Finding(element, f"{which} references", f"has no points, expected those of {in_robot.file}")
        return
    difference = float(np.abs(np.subtract(shape.bounds, in_robot.bounds)).max())
    if not difference <= BOUNDS_TOLERANCE * max(1.0, float(np.abs(in_robot.bounds).max())):
        message = f"its bounds are {shown(1e3 * difference)} mm off those of {in_robot.file}"
        yield Finding(element, f"{which} references", message)
        return
    corners, texcoords = _corners_and_texcoords(folder, in_robot)
    if corners is not None and not _is_same(shape.corners, corners):
        message = f"has other triangles than assets/{in_robot.file}"
        yield Finding(element, f"{which} faceVertexIndices", message)
    elif texcoords is not None and not _is_same(shape.texcoords, texcoords):
        message = f"are not the texture coordinates of assets/{in_robot.file}"
        yield Finding(element, f"{which} primvars:st", message)


def _corners_and_texcoords(folder: Path, shape: Shape) -> tuple[Array | None, Array | None]:
    """Returns the corners and the texture coordinates of a mesh's file; None if it cannot be read, which
    another check reports."""
    try:
        return mesh_corners(str(shape.file), (folder / "assets" / str(shape.file)).read_bytes())
    except (OSError, ValueError, IndexError, struct.error):
        return None, None


def _is_same(actual: npt.NDArray[np.float32] | None, expected: Array) -> bool:
    if actual is None or actual.shape != expected.shape:
        return False
    return np.allclose(actual, expected, rtol=0, atol=BOUNDS_TOLERANCE)
