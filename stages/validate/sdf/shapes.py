"""Checks the shapes of an SDF's links, and the model's placement."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from linkwright.stages.formats.sdf.model import SdfModel
from linkwright.stages.formats.sdf.shapes import SdfShape
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.poses import UNMOVED
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.model.scene import Scene
from linkwright.stages.validate.findings import differs, few, named, pose_findings, shown
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE
from linkwright.stages.validate.same.shapes import (
    COLOUR_TOLERANCE,
    ShapeWords,
    WrittenShape,
    differences,
    same_colour,
    solid_of,
    solids_by_link,
)

ATTRIBUTE_NAMES = ShapeWords("geometry", "mesh uri", "mesh scale", ("pose", "pose"), "material diffuse")
"""SDF's names for the properties of a shape."""


def mesh_file_check(path: Path) -> Check:
    """Checks that every mesh that the file names exists. The folder of the file counts as the model of
    `model://<model>/<path>`."""
    findings = []
    uris = {node.text or "" for node in parse(path.read_bytes()).iterfind(".//mesh/uri")}
    for uri in sorted(uris):
        relative_path = uri.partition("://")[2].partition("/")[2] if "://" in uri else uri
        if not (path.parent / relative_path).is_file():
            findings.append(Finding("mesh", "uri", f'"{uri}" does not exist'))
    missing = ", ".join(finding.message for finding in findings[:3])
    detail = f"missing: {missing}" if findings else "every mesh exists"
    return Check(
        f"{path.name}: meshes", not findings, detail, float(len(findings)), 0.0, findings=few(findings)
    )


def model_findings(model: SdfModel, robot: Robot, root: str, scene: Scene | None) -> list[Finding]:
    """Checks the model's name, that gravity and forces move its links, and that it is where the scene has the
    robot. The height of a free robot is not compared: the scene's is for MuJoCo's qpos0, from which the
    joints of the SDF may differ. `root`: the name of the root link in the SDF."""
    element, findings = named("model", model.name), list[Finding]()
    if model.name != robot.name:
        findings.append(differs(element, "name", model.name, robot.name))
    for link in model.links.values():
        title = named("link", link.name)
        findings += [] if link.falls else [differs(title, "gravity", "false", "true")]
        findings += [] if link.forced else [differs(title, "kinematic", "true", "false")]
    if scene is not None and robot.root.name != "world":
        world_from_root = model.world_from_model @ model.links[root].model_from_link
        if not robot.base.fixed:
            world_from_root[2, 3] = scene.world_from_root[2, 3]
        findings += pose_findings(
            element, world_from_root, scene.world_from_root, ("pose", "pose"), ENGINE_TOLERANCE
        )
    return findings


def shape_findings(model: SdfModel, links: Mapping[str, str], geometry: Geometry) -> list[Finding]:
    """Compares the shapes of links, and their friction. Links between the dofs of a joint have no shapes.
    `links`: link of the robot → its name in the SDF."""
    holders = {name: (title, UNMOVED) for name, title in links.items()}
    expected = solids_by_link(geometry.with_whole_visuals, lambda shape: (_solid(shape),), holders)
    colliders = {
        links[link]: shapes
        for (link, role), shapes in geometry.by_link().items()
        if role == "collision" and link in links
    }
    findings: list[Finding] = []
    for link in model.links.values():
        element = named("link", link.name)
        expected_shapes = expected.get((link.name, "visual"), [])
        different = list(differences(element, "visual", link.visuals, expected_shapes, ATTRIBUTE_NAMES))
        findings += different or _shade_differences(element, link.visuals, expected_shapes)
        expected_shapes = expected.get((link.name, "collision"), [])
        different = list(differences(element, "collision", link.collisions, expected_shapes, ATTRIBUTE_NAMES))
        findings += different or _friction_differences(element, link.collisions, colliders.get(link.name, []))
    return findings


def _solid(shape: Shape) -> WrittenShape:
    """Returns the expected solid of a shape. A mesh with an image has the colours of its file, so its own
    are not compared."""
    solid = solid_of(shape)
    return replace(solid, colour=None, texture="") if shape.texture else solid


def _shade_differences(
    element: str, actual: Sequence[SdfShape], expected: Sequence[WrittenShape]
) -> Iterator[Finding]:
    """Compares the shades of a link's visuals. `actual` and `expected` have the same length."""
    for number, (shape, solid) in enumerate(zip(actual, expected, strict=True), 1):
        if solid.colour is None:
            continue
        if not same_colour(shape.ambient, solid.colour):
            yield differs(element, f"visual {number} material ambient", shape.ambient, solid.colour)
        if not abs(shape.transparency - (1.0 - solid.colour[3])) <= COLOUR_TOLERANCE:
            yield differs(element, f"visual {number} transparency", shape.transparency, 1.0 - solid.colour[3])


def _friction_differences(
    element: str, actual: Sequence[SdfShape], expected: Sequence[Shape]
) -> Iterator[Finding]:
    """Compares the friction of a link's colliders. `actual` and `expected` have the same length."""
    for number, (shape, expected_shape) in enumerate(zip(actual, expected, strict=True), 1):
        contact = expected_shape.contact
        # SDF has a coefficient for each of two directions, the robot has one for both.
        sliding_friction = contact.friction[0] if contact and contact.friction else None
        for key, value in zip(("mu", "mu2"), shape.friction, strict=True):
            if not _is_same(value, sliding_friction):
                attribute = f"collision {number} surface friction ode {key}"
                yield differs(element, attribute, shown(value), shown(sliding_friction))


def _is_same(actual: float | None, expected: float | None) -> bool:
    """Tells whether two coefficients are equal within the tolerance, or both missing."""
    if actual is None or expected is None or actual == expected:
        return actual == expected
    return abs(actual - expected) <= ENGINE_TOLERANCE * max(1.0, abs(expected))
