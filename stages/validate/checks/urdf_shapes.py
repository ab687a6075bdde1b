"""Each link of a URDF has the shapes of the robot: as many, of their files and sizes, where they must be.

By the text: to a reader of URDF a capsule is a cylinder and two balls, and a mesh is where its origin says.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import PurePosixPath

import numpy as np

from stages.formats.urdf.model import UrdfShape
from stages.formats.urdf.parse import parse
from stages.robot.check import Check, Finding
from stages.robot.errors import SourceError
from stages.robot.fusing import Holders
from stages.robot.geometry import Geometry, Role, Shape
from stages.robot.model import Array
from stages.robot.plural import count
from stages.robot.poses import UNMOVED
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import SAME
from stages.validate.findings import differs, few, link, place_differs, shown

CODE = "C-SHAPE"

Solid = tuple[str, tuple[float, ...], str, Array]
"""Kind, size as a URDF has it, name of the file, link_from_solid (4, 4)."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a robot whose shapes are known."""
    geometry = compiled.geometry
    if geometry is None or not geometry.shapes:
        return
    try:
        read = parse(compiled.path.read_bytes(), compiled.path.name)
    except SourceError:
        return
    expected = _expected(geometry, compiled.held)
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
            found += _differences(link(one.name, urdf=True), role, shapes, wanted)
    detail = f"{count(total, 'shape')} of the robot, with their files, sizes and places"
    yield compiled.within("shapes", float(len(found)), 0.0, detail, few(found))


def _expected(geometry: Geometry, held: Holders) -> Mapping[tuple[str, Role], list[Solid]]:
    """By link of the URDF and role: what it has, in the order of the links that it holds."""
    by_link = geometry.by_link()
    found: dict[tuple[str, Role], list[Solid]] = {}
    roles: tuple[Role, ...] = ("visual", "collision")
    names = dict.fromkeys((*held, *(shape.link for shape in geometry.shapes)))
    for name in names:
        holder, place = held.get(name, (name, UNMOVED))
        for role in roles:
            for shape in by_link[name, role]:
                own = found.setdefault((holder, role), [])
                own += [(kind, size, file, place @ pose) for kind, size, file, pose in _solids(shape)]
    return found


def _solids(shape: Shape) -> Iterator[Solid]:
    one = shape.primitive
    if one is None:
        yield "mesh", (), str(shape.file), UNMOVED
        return
    size = tuple(one.size)
    if one.kind != "capsule":
        yield one.kind, size, "", one.link_from_shape
        return
    yield "cylinder", size, "", one.link_from_shape
    for end in (-size[1] / 2, size[1] / 2):
        moved = np.eye(4)
        moved[2, 3] = end
        yield "sphere", size[:1], "", one.link_from_shape @ moved


def _differences(
    element: str, role: str, shapes: Sequence[UrdfShape], wanted: Sequence[Solid]
) -> Iterator[Finding]:
    if len(shapes) != len(wanted):
        yield Finding(element, role, f"has {count(len(shapes), role)}, expected {len(wanted)}")
        return
    for number, (shape, (kind, size, file, pose)) in enumerate(zip(shapes, wanted, strict=True)):
        which = f"{role} {number + 1}"
        if shape.kind != kind:
            yield differs(element, f"{which} geometry", shape.kind, kind)
        elif file and PurePosixPath(shape.filename).name != PurePosixPath(file).name:
            yield differs(element, f"{which} mesh filename", shape.filename, file)
        elif file and shape.scale != (1.0, 1.0, 1.0):
            yield differs(element, f"{which} mesh scale", shape.scale, (1.0, 1.0, 1.0))
        elif not np.allclose(shape.size, size, rtol=SAME, atol=SAME):
            yield Finding(
                element, f"{which} {kind} size", f"is {shown(shape.size)}, expected {shown(size)} [m]"
            )
        else:
            attributes = (f"{which} origin xyz", f"{which} origin rpy")
            yield from place_differs(element, shape.link_from_shape, pose, attributes, SAME)
