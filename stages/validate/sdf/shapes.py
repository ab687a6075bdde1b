"""The checks of what an SDF's links look like, and how the model stands."""

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
from linkwright.stages.validate.findings import differs, few, named, place_differs, shown
from linkwright.stages.validate.model.coordinates import SAME
from linkwright.stages.validate.same.shapes import (
    COLOUR,
    ShapeWords,
    WrittenShape,
    differences,
    same_colour,
    solid_of,
    solids_by_link,
)

WORDS = ShapeWords("geometry", "mesh uri", "mesh scale", ("pose", "pose"), "material diffuse")
"""What an SDF calls what a shape is."""


def missing_meshes(path: Path) -> Check:
    """Every mesh that the file names is there."""
    found = []
    texts = {node.text or "" for node in parse(path.read_bytes()).iterfind(".//mesh/uri")}
    for text in sorted(texts):
        inside = text.partition("://")[2].partition("/")[2] if "://" in text else text
        if not (path.parent / inside).is_file():
            found.append(Finding("mesh", "uri", f'"{text}" does not exist'))
    detail = f"missing: {', '.join(one.message for one in found[:3])}" if found else "every mesh is there"
    return Check(f"{path.name}: meshes", not found, detail, float(len(found)), 0.0, findings=few(found))


def of_model(model: SdfModel, robot: Robot, root: str, scene: Scene | None) -> list[Finding]:
    """Its name, that gravity and forces move its links, and that it stands where the scene has the robot. At
    what height a free robot touches the ground depends on its joints, which need not stand as at qpos0.
    `root`: its root link."""
    element, found = named("model", model.name), list[Finding]()
    if model.name != robot.name:
        found.append(differs(element, "name", model.name, robot.name))
    for one in model.links.values():
        own = named("link", one.name)
        found += [] if one.falls else [differs(own, "gravity", "false", "true")]
        found += [] if one.forced else [differs(own, "kinematic", "true", "false")]
    if scene is not None and robot.root.name != "world":
        place = model.world_from_model @ model.links[root].model_from_link
        if not robot.base.fixed:
            place[2, 3] = scene.world_from_root[2, 3]
        found += place_differs(element, place, scene.world_from_root, ("pose", "pose"), SAME)
    return found


def shapes(model: SdfModel, links: Mapping[str, str], geometry: Geometry) -> list[Finding]:
    """What the shapes of links are otherwise, and how slippery; what is between the dofs of a joint has none.
    `links`: the names in the SDF of the robot's links."""
    held = {name: (own, UNMOVED) for name, own in links.items()}
    wanted = solids_by_link(geometry, lambda shape: (_solid(shape),), held)
    colliders = {
        links[link]: every
        for (link, role), every in geometry.by_link().items()
        if role == "collision" and link in links
    }
    found: list[Finding] = []
    for link in model.links.values():
        element = named("link", link.name)
        own = wanted.get((link.name, "visual"), [])
        different = list(differences(element, "visual", link.visuals, own, WORDS))
        found += different or _shades(element, link.visuals, own)
        own = wanted.get((link.name, "collision"), [])
        different = list(differences(element, "collision", link.collisions, own, WORDS))
        found += different or _frictions(element, link.collisions, colliders.get(link.name, []))
    return found


def _solid(shape: Shape) -> WrittenShape:
    """A mesh with an image has the colours of its own file."""
    solid = solid_of(shape)
    return replace(solid, colour=None, texture="") if shape.texture else solid


def _shades(element: str, found: Sequence[SdfShape], wanted: Sequence[WrittenShape]) -> Iterator[Finding]:
    """`found` and `wanted`: a link's visuals, as many of the one as of the other."""
    for number, (shape, own) in enumerate(zip(found, wanted, strict=True), 1):
        if own.colour is None:
            continue
        if not same_colour(shape.ambient, own.colour):
            yield differs(element, f"visual {number} material ambient", shape.ambient, own.colour)
        if not abs(shape.transparency - (1.0 - own.colour[3])) <= COLOUR:
            yield differs(element, f"visual {number} transparency", shape.transparency, 1.0 - own.colour[3])


def _frictions(element: str, found: Sequence[SdfShape], wanted: Sequence[Shape]) -> Iterator[Finding]:
    """`found` and `wanted`: a link's colliders, as many of the one as of the other."""
    for number, (shape, own) in enumerate(zip(found, wanted, strict=True), 1):
        which = f"collision {number} surface"
        friction = own.contact.friction[0] if own.contact and own.contact.friction else None
        for key, value in zip(("mu", "mu2"), shape.friction, strict=True):
            if value != friction and not _alike(value, friction):
                yield differs(element, f"{which} friction ode {key}", shown(value), shown(friction))


def _alike(value: float | None, wanted: float | None) -> bool:
    return value is not None and wanted is not None and abs(value - wanted) <= SAME * max(1.0, abs(wanted))
