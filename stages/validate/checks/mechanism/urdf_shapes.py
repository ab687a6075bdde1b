"""Each link of a URDF has the shapes of the robot: as many, of their files and sizes, where they must be.

By the text: to a reader of URDF a capsule is a cylinder and two balls, and a mesh is where its origin says.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from linkwright.stages.formats.urdf.model import UrdfShape
from linkwright.stages.formats.urdf.parse import parse
from linkwright.stages.formats.xml import parse as read_xml
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.model.geometry import Role, Shape
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, link
from linkwright.stages.validate.same.shapes import (
    ShapeWords,
    WrittenShape,
    differences,
    solid_of,
    solids_by_link,
)

WORDS = ShapeWords("geometry", "mesh filename", "mesh scale", ("origin xyz", "origin rpy"), "material")
"""What a URDF calls what a shape is."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a robot whose shapes are known."""
    geometry = compiled.geometry
    if geometry is None or not geometry.shapes:
        return
    try:
        read = parse(compiled.path.read_bytes(), compiled.path.name)
    except SourceError:
        return
    expected = solids_by_link(geometry, _solids, compiled.held)
    if compiled.recolours:
        expected = {key: [replace(one, colour=None) for one in every] for key, every in expected.items()}
    found: list[Finding] = []
    total = 0
    for one in read.links:
        every: tuple[tuple[Role, Sequence[UrdfShape]], ...]
        every = (("visual", one.visuals), ("collision", one.collisions))
        for role, shapes in every:
            wanted = expected.get((one.name, role), [])
            total += len(wanted)
            # What the user's own XML adds to a link comes after what is the robot's.
            shapes = shapes[: len(wanted)] if compiled.written.amendments.of(compiled.path.name) else shapes
            found += differences(link(one.name, urdf=True), role, shapes, wanted, WORDS)
    found += _discarded(compiled)
    detail = f"{count(total, 'shape')} of the robot, with their files, sizes, places and colours"
    yield compiled.within("shapes", float(len(found)), 0.0, detail, few(found))


def _solids(shape: Shape) -> Iterator[WrittenShape]:
    one, look = shape.primitive, (shape.colour, shape.texture or "")
    if one is None or one.kind != "capsule":
        yield solid_of(shape)
        return
    yield replace(solid_of(shape), kind="cylinder")
    for end in (-one.size[1] / 2, one.size[1] / 2):
        moved = np.eye(4)
        moved[2, 3] = end
        yield WrittenShape("sphere", one.size[:1], "", one.link_from_shape @ moved, *look)


def _discarded(compiled: CompiledModel) -> Iterator[Finding]:
    """MuJoCo drops the visuals of a URDF unless it is told not to."""
    compiler = read_xml(compiled.path.read_bytes()).find("mujoco/compiler")
    word = "none" if compiler is None else compiler.get("discardvisual", "true")
    if word != "false" and "discardvisual" not in compiled.sets_of("compiler"):
        yield differs("compiler", "discardvisual", word, "false")
