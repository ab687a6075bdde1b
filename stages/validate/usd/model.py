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


def unit_findings(usd: UsdRobot) -> list[Finding]:
    """Checks that the units are metres and kilograms, and that z points upwards."""
    findings = []
    for name, value in zip(("metersPerUnit", "kilogramsPerUnit"), usd.units, strict=True):
        if value != 1.0:
            findings.append(differs("layer", name, value, 1.0))
    if usd.up != "Z":
        findings.append(differs("layer", "upAxis", usd.up, "Z"))
    return findings


def articulation_findings(usd: UsdRobot, robot: Robot, names: UsdNames) -> Iterator[Finding]:
    """Checks that an articulation begins at the joint that holds a fixed robot, or else at its root link, and
    at each link on a free joint that carries a joint."""
    parents = {joint.parent for joint in robot.joints if joint.type != "free"}
    free_links = [joint.child for joint in robot.joints if joint.type == "free" and joint.child in parents]
    expected = {names.base_joint} if robot.base.fixed else {names.links[robot.root.name]}
    expected |= {names.links[link] for link in free_links}
    for name in sorted(expected - usd.roots.keys()):
        message = "begins no articulation, expected PhysicsArticulationRootAPI"
        yield Finding(named("def", name), "apiSchemas", message)
    for name in sorted(usd.roots.keys() - expected):
        message = "begins an articulation by PhysicsArticulationRootAPI, and the robot's begins elsewhere"
        yield Finding(named("def", name), "apiSchemas", message)


def placement_findings(
    usd: UsdRobot, robot: Robot, names: UsdNames, world_from_root: Array | None
) -> Iterator[Finding]:
    """Checks that the root is where the scene has the robot at `home`, and that a fixed root is held there.
    `world_from_root`: this pose (4, 4), None if it is not known."""
    if robot.base.fixed and names.base_joint in usd.joints:
        yield from _base_joint_differences(usd, robot, names)
    if world_from_root is None:
        return
    body = names.links[robot.root.name]
    attributes = ("xformOp:translate", "xformOp:orient")
    yield from pose_findings(
        named("def", body), usd.bodies[body].world_from_body, world_from_root, attributes, PLACE_TOLERANCE
    )
    if robot.base.fixed and names.base_joint in usd.joints:
        joint = usd.joints[names.base_joint]
        held_pose = joint.first_from_joint @ np.linalg.inv(joint.second_from_joint)
        attributes = ("physics:localPos0", "physics:localRot0")
        yield from pose_findings(
            named("def", names.base_joint), held_pose, world_from_root, attributes, FRAME_TOLERANCE
        )


def _base_joint_differences(usd: UsdRobot, robot: Robot, names: UsdNames) -> Iterator[Finding]:
    """Yields the differences of the joint that must fix the root link to the robot's own prim."""
    joint, element = usd.joints[names.base_joint], named("def", names.base_joint)
    if joint.type != "Fixed":
        yield differs(element, "type", f"Physics{joint.type}Joint", "PhysicsFixedJoint")
    if joint.first_path != usd.path:
        yield differs(element, "physics:body0", joint.first_path or "none", usd.path)
    root_link = names.links[robot.root.name]
    if joint.second != root_link:
        yield differs(element, "physics:body1", joint.second or "none", root_link)
    if joint.closes:
        yield differs(element, "physics:excludeFromArticulation", "true", "false")


def motion_findings(
    usd: UsdRobot, robot: Robot, names: UsdNames, geometry: Geometry | None
) -> Iterator[Finding]:
    """Checks that forces move every body, by its mass and from rest, and that the same bodies and colliders
    collide with each other as in the robot. Without a geometry, collisions are not checked."""
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
                actual, expected = (str(value).lower() for value in (collides, geometry.self_contact))
                yield differs(named("def", name), attribute, actual, expected)
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


def shape_findings(usd: UsdRobot, names: UsdNames, geometry: Geometry, folder: Path) -> Iterator[Finding]:
    """Checks that each body has the shapes of its link: their number, places and sizes. Bodies between the
    dofs of a joint must have none. `folder`: the folder of the USD, which has the files of its meshes."""
    link_of_body = {body: name for name, body in names.links.items()}
    shapes_by_link = geometry.by_link()
    roles: tuple[Role, ...] = ("visual", "collision")
    for body, read_body in usd.bodies.items():
        for role in roles:
            expected = shapes_by_link[link_of_body.get(body, ""), role]
            actual = [shape for shape in read_body.shapes if shape.collides == (role == "collision")]
            element = named("def", body)
            if len(actual) != len(expected):
                yield Finding(element, role, f"has {count(len(actual), role)}, expected {len(expected)}")
                continue
            yield from _shape_differences(element, role, actual, expected, folder)


def _shape_differences(
    element: str, role: str, actual: Sequence[ReadUsdShape], expected: Sequence[Shape], folder: Path
) -> Iterator[Finding]:
    """Yields the differences of a body's shapes of a role. `actual` and `expected` have the same length."""
    for number, (shape, expected_shape) in enumerate(zip(actual, expected, strict=True), 1):
        title = f"{role} {number}"
        yield from look_differences(element, title, shape, expected_shape)
        for attribute, actual_value, required_value in shape.flaws:
            yield differs(element, f"{title} {attribute}", actual_value, required_value)
        primitive = expected_shape.primitive
        kind = primitive.kind if primitive is not None else "mesh"
        if shape.kind != kind:
            yield differs(element, f"{title} type", shape.kind, kind)
        elif primitive is None:
            yield from _mesh_differences(element, title, shape, expected_shape, folder)
        elif not np.allclose(shape.size, primitive.size, rtol=PLACE_TOLERANCE, atol=PLACE_TOLERANCE):
            message = f"is {shown(shape.size)}, expected {shown(primitive.size)} [m]"
            yield Finding(element, f"{title} {kind} size", message)
        else:
            attributes = (f"{title} xformOp:translate", f"{title} xformOp:orient")
            yield from pose_findings(
                element, shape.body_from_shape, primitive.link_from_shape, attributes, PLACE_TOLERANCE
            )


def _mesh_differences(
    element: str, title: str, shape: ReadUsdShape, expected_shape: Shape, folder: Path
) -> Iterator[Finding]:
    """Yields the first differences of a mesh: of its pose, else of its bounds, else of its triangles, else of
    their texture coordinates."""
    attributes = (f"{title} xformOp:translate", f"{title} xformOp:orient")
    findings_on_pose = list(
        pose_findings(element, shape.body_from_shape, UNMOVED, attributes, PLACE_TOLERANCE)
    )
    yield from findings_on_pose
    if findings_on_pose or not expected_shape.bounds:
        return
    if not shape.bounds:
        yield Finding(
            element, f"{title} references", f"has no points, expected those of {expected_shape.file}"
        )
        return
    difference = float(np.abs(np.subtract(shape.bounds, expected_shape.bounds)).max())
    if not difference <= BOUNDS_TOLERANCE * max(1.0, float(np.abs(expected_shape.bounds).max())):
        message = f"its bounds are {shown(1e3 * difference)} mm off those of {expected_shape.file}"
        yield Finding(element, f"{title} references", message)
        return
    corners, texcoords = _corners_and_texcoords(folder, expected_shape)
    if corners is not None and not _is_same(shape.corners, corners):
        message = f"has other triangles than assets/{expected_shape.file}"
        yield Finding(element, f"{title} faceVertexIndices", message)
    elif texcoords is not None and not _is_same(shape.texcoords, texcoords):
        message = f"has other texture coordinates than assets/{expected_shape.file}"
        yield Finding(element, f"{title} primvars:st", message)


def _corners_and_texcoords(folder: Path, shape: Shape) -> tuple[Array | None, Array | None]:
    """Returns the corners (n, 3, 3) and the texture coordinates (n, 3, 2) of a mesh. Both are None if its
    file cannot be read, which another check reports; coordinates that it does not have are None."""
    try:
        return mesh_corners(str(shape.file), (folder / "assets" / str(shape.file)).read_bytes())
    except (OSError, ValueError, IndexError, struct.error):
        return None, None


def _is_same(actual: npt.NDArray[np.float32] | None, expected: Array) -> bool:
    """Tells whether two arrays have the same shape and, within the tolerance, the same numbers."""
    if actual is None or actual.shape != expected.shape:
        return False
    return np.allclose(actual, expected, rtol=0, atol=BOUNDS_TOLERANCE)
