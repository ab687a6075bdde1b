"""Checks that each link of a URDF has the robot's shapes: their number, files, sizes and poses.

The check reads the file and not the compiled model, in which MuJoCo moves meshes. URDF has no capsule: it is
written as a cylinder and two spheres.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from linkwright.stages.formats.meshes.gltf_conventions import SUFFIX
from linkwright.stages.formats.urdf.model import UrdfLink, UrdfShape
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

ATTRIBUTE_NAMES = ShapeWords(
    "geometry", "mesh filename", "mesh scale", ("origin xyz", "origin rpy"), "material"
)
"""URDF's names for the properties of a shape."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the shapes of a URDF with the robot's; yields nothing if the robot's shapes are unknown, or if
    the file is not read as a URDF, which another check reports."""
    geometry = compiled.geometry
    if geometry is None or not geometry.shapes:
        return
    try:
        urdf = parse(compiled.path.read_bytes(), compiled.path.name)
    except SourceError:
        return
    expected = solids_by_link(geometry.with_whole_visuals, _solids, compiled.held)
    if compiled.recolours:
        expected = {
            key: [replace(solid, colour=None) for solid in solids] for key, solids in expected.items()
        }
    is_amended = bool(compiled.written.amendments.changes_of(compiled.path.name))
    findings = [
        finding for row in urdf.links for finding in _link_differences(row, expected, is_amended=is_amended)
    ]
    has_glb = any(solid.file.endswith(SUFFIX) for solids in expected.values() for solid in solids)
    findings += _discardvisual(compiled, "true" if has_glb else "false")
    total = sum(
        len(expected.get((row.name, role), ())) for row in urdf.links for role in ("visual", "collision")
    )
    detail = f"{count(total, 'shape')} of the robot, with their files, sizes, places and colours"
    yield compiled.within("shapes", float(len(findings)), 0.0, detail, few(findings))


def _link_differences(
    urdf_link: UrdfLink, expected: Mapping[tuple[str, Role], list[WrittenShape]], *, is_amended: bool
) -> Iterator[Finding]:
    """Yields the differences of a link's shapes. `is_amended`: whether the user's own XML changes the
    file."""
    by_role: tuple[tuple[Role, Sequence[UrdfShape]], ...]
    by_role = (("visual", urdf_link.visuals), ("collision", urdf_link.collisions))
    for role, shapes in by_role:
        expected_shapes = expected.get((urdf_link.name, role), [])
        # The shapes that the user's own XML adds to a link come after the robot's.
        compared = shapes[: len(expected_shapes)] if is_amended else shapes
        element = link(urdf_link.name, urdf=True)
        yield from differences(element, role, compared, expected_shapes, ATTRIBUTE_NAMES)


def _solids(shape: Shape) -> Iterator[WrittenShape]:
    primitive, colour_and_texture = shape.primitive, (shape.colour, shape.texture or "")
    if primitive is None or primitive.kind != "capsule":
        yield solid_of(shape)
        return
    yield replace(solid_of(shape), kind="cylinder")
    for end in (-primitive.size[1] / 2, primitive.size[1] / 2):
        cylinder_from_cap = np.eye(4)
        cylinder_from_cap[2, 3] = end
        link_from_cap = primitive.link_from_shape @ cylinder_from_cap
        yield WrittenShape("sphere", primitive.size[:1], "", link_from_cap, *colour_and_texture)


def _discardvisual(compiled: CompiledModel, expected: str) -> Iterator[Finding]:
    """Yields a finding if the `discardvisual` of the URDF is not `expected`. By default MuJoCo discards the
    visuals of a URDF; visuals in GLB files must be discarded, since MuJoCo cannot read them."""
    compiler = read_xml(compiled.path.read_bytes()).find("mujoco/compiler")
    value = "none" if compiler is None else compiler.get("discardvisual", "true")
    if value != expected and "discardvisual" not in compiled.sets_of("compiler"):
        yield differs("compiler", "discardvisual", value, expected)
