"""Each link of a URDF has the shapes of the robot: as many, of their files and sizes, where they must be.

By the text: to a reader of URDF a capsule is a cylinder and two balls, and a mesh is where its origin says.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from stages.formats.urdf.model import UrdfShape
from stages.formats.urdf.parse import parse
from stages.robot.check import Check, Finding
from stages.robot.errors import SourceError
from stages.robot.geometry import Role, Shape
from stages.robot.plural import count
from stages.validate.compiled import CompiledModel
from stages.validate.findings import few, link
from stages.validate.solids import ShapeWords, WrittenShape, differences, solid_of, solids_by_link

CODE = "C-SHAPE"

WORDS = ShapeWords("mesh filename", "mesh scale", ("origin xyz", "origin rpy"))
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
    found: list[Finding] = []
    total = 0
    for one in read.links:
        every: tuple[tuple[Role, Sequence[UrdfShape]], ...]
        every = (("visual", one.visuals), ("collision", one.collisions))
        for role, shapes in every:
            wanted = expected.get((one.name, role), [])
            total += len(wanted)
            # What the user's own XML adds to a link comes after what is the robot's.
            shapes = shapes[: len(wanted)] if compiled.amendments.of(compiled.path.name) else shapes
            found += differences(link(one.name, urdf=True), role, shapes, wanted, WORDS)
    detail = f"{count(total, 'shape')} of the robot, with their files, sizes and places"
    yield compiled.within("shapes", float(len(found)), 0.0, detail, few(found))


def _solids(shape: Shape) -> Iterator[WrittenShape]:
    one = shape.primitive
    if one is None or one.kind != "capsule":
        yield solid_of(shape)
        return
    yield replace(solid_of(shape), kind="cylinder")
    for end in (-one.size[1] / 2, one.size[1] / 2):
        moved = np.eye(4)
        moved[2, 3] = end
        yield WrittenShape("sphere", one.size[:1], "", one.link_from_shape @ moved)
