"""Checks that each body has the shapes of its links: their number, places and sizes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePosixPath
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.geometry import Role, Shape
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.model.coordinates import body_from_link, placed_by_site
from linkwright.stages.validate.model.poses import placed
from linkwright.stages.validate.model.shapes import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    MESH,
    SPHERE,
    area,
    named_geom,
    seen_and_solid,
    vertices,
)
from linkwright.stages.validate.same.shapes import (
    ROLES,
    ShapeWords,
    WrittenShape,
    bounds_differ,
    form_differs,
    look_differs,
    solid_of,
    solids_by_link,
)

ATTRIBUTE_NAMES = ShapeWords("type", "mesh", "mesh", ("pos", "quat"), "material")
"""MJCF's names for the properties of a geom."""

SHAPE_TOLERANCE = 1e-6
"""Tolerance of the places [m, rad] and sizes [m] of shapes."""

AREA_TOLERANCE = 1e-3
"""Relative tolerance of mesh areas: files have single precision."""

GROUPS: dict[Role, int] = {"visual": 2, "collision": 3}
"""Group of geoms by role: viewers show groups 0 to 2."""

DEFAULT_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom without a colour."""

KINDS = {BOX: "box", SPHERE: "sphere", CYLINDER: "cylinder", CAPSULE: "capsule", ELLIPSOID: "ellipsoid"}
"""MuJoCo's type of a geom → the kind of primitive."""


@dataclass(frozen=True, slots=True, eq=False)
class GeomShape:
    """A geom in the form of a shape that was read. MuJoCo keeps the points of a mesh instead of its file and
    scale, so that a mesh has bounds and an area."""

    kind: str
    size: tuple[float, ...]
    link_from_shape: Array
    colour: tuple[float, ...]
    texture: str
    bounds: tuple[float, ...] = ()
    area: float = 0.0
    filename: str | None = None
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the shapes with the robot's; yields nothing if the robot's are unknown."""
    geometry, model = compiled.written.geometry, compiled.model
    if geometry is None or not geometry.shapes:
        return
    geoms_by_body, expected = seen_and_solid(model), solids_by_link(geometry, _solids, compiled.held)
    wrong: list[Finding] = []
    surplus_findings: list[Finding] = []
    for link in compiled.robot.links:
        body, place = body_index(model, link.name), body_from_link(compiled.robot, link.name)
        place = placed_by_site(model, link.name) @ place if body == 0 else place
        for role, geoms in zip(ROLES, geoms_by_body.get(body, ((), ())), strict=True):
            expected_shapes = [
                replace(shape, link_from_shape=place @ shape.link_from_shape)
                for shape in expected.get((link.name, role), ())
            ]
            added = _added_geoms(compiled, expected_shapes, geoms)
            surplus_findings += [_surplus(model, link.name, role, geom) for geom in added]
            expected_geoms = [geom for geom in geoms if geom not in added]
            wrong += _differences(compiled, link.name, role, expected_shapes, expected_geoms)
    total = count(len(geometry.shapes), "shape")
    detail = f"{total} in place, of their size and colour"
    if wrong or surplus_findings:
        texts = [f"{len(wrong)} of {total} not as the robot has them"] if wrong else []
        texts += (
            [f"{len(surplus_findings)} more than the robot has: {surplus_findings[0].element}"]
            if surplus_findings
            else []
        )
        detail = "; ".join(texts)
    yield compiled.within(
        "shapes", float(len(wrong) + len(surplus_findings)), 0.0, detail, (*surplus_findings, *wrong)
    )


def _solids(shape: Shape) -> Iterator[WrittenShape]:
    """Yields the expected geom of a shape: MJCF has all primitives, ellipsoids too."""
    solid = shape if shape.ellipsoid is None else replace(shape, primitive=shape.ellipsoid, file=None)
    yield solid_of(solid)


def _surplus(model: Any, link: str, role: Role, geom: int) -> Finding:
    text = f"is a {role} shape more than the robot's {named('body', link)} has"
    return Finding(named_geom(model, geom, link), "geom", text)


def _added_geoms(
    compiled: CompiledModel, expected: Sequence[WrittenShape], geoms: Sequence[int]
) -> list[int]:
    """Returns the geoms that a body has in addition to the robot's, wherever they are in the order: without
    them the rest fits. Returns an empty list if the user's own XML changes the file, since its geoms come
    last."""
    surplus_count = len(geoms) - len(expected)
    if surplus_count <= 0 or compiled.written.amendments.changes_of(compiled.path.name):
        return []
    added: list[int] = []
    at = 0
    for geom in geoms:

        def fits(other: int, place: int = at) -> bool:
            return place < len(expected) and not any(
                _form_differences(compiled.model, "", expected[place], other)
            )

        later = at >= len(expected) or any(fits(other) for other in geoms if other > geom)
        if fits(geom) or len(added) == surplus_count or not later:
            at += 1
        else:
            added.append(geom)
    return added


def _differences(
    compiled: CompiledModel, link: str, role: Role, expected: Sequence[WrittenShape], geoms: Sequence[int]
) -> Iterator[Finding]:
    """Compares the first geoms of a body. Geoms that the user's own XML adds come after the robot's."""
    model = compiled.model
    if len(geoms) < len(expected):
        text = f"{link} has {count(len(geoms), f'{role} shape')} of {len(expected)}"
        yield Finding(named("body", link), "geom", text)
        return
    for shape, geom in zip(expected, geoms, strict=False):
        element, group = named_geom(model, geom, link), int(model.geom_group[geom])
        yield from _form_differences(model, element, shape, geom)
        if group != GROUPS[role] and not compiled.sets("group"):
            yield differs(element, "group", group, GROUPS[role])
        if role == "visual" and not compiled.recolours:
            yield from look_differs(element, ATTRIBUTE_NAMES.colour, _geom_shape(model, geom), shape)


def _form_differences(model: Any, element: str, expected: WrittenShape, geom: int) -> Iterator[Finding]:
    shape = _geom_shape(model, geom)
    findings = list(form_differs(element, "", shape, expected, ATTRIBUTE_NAMES, SHAPE_TOLERANCE))
    yield from findings
    if findings or expected.kind != "mesh":
        return
    if abs(shape.area - expected.area) > AREA_TOLERANCE * expected.area:
        times = (shape.area / expected.area) ** 0.5 if expected.area else float("inf")
        areas = f"has an area of {shape.area:.4g} m², not {expected.area:.4g}"
        text = f"{areas}: its lengths are {times:.4g} times as long"
        yield Finding(element, ATTRIBUTE_NAMES.file, text)
    elif expected.bounds:
        yield from bounds_differ(element, ATTRIBUTE_NAMES.file, shape.bounds, expected)


def _geom_shape(model: Any, geom: int) -> GeomShape:
    """Returns a compiled geom as a shape, with full sizes where MuJoCo has half sizes."""
    kind, place = int(model.geom_type[geom]), placed(model.geom_quat[geom], model.geom_pos[geom])
    look = _look(model, geom)
    if kind != MESH:
        half = tuple(map(float, model.geom_size[geom]))
        full = tuple(2 * length for length in half)
        sizes = {BOX: full, ELLIPSOID: full, SPHERE: half[:1]}
        return GeomShape(KINDS[kind], sizes.get(kind, (half[0], full[1])), place, *look)
    mesh = int(model.geom_dataid[geom])
    # MuJoCo moves each mesh to its own centre and axes, and the geom with it.
    from_mesh = placed(model.mesh_quat[mesh], model.mesh_pos[mesh])
    corners = vertices(model, geom) @ from_mesh[:3, :3].T + from_mesh[:3, 3]
    bounds = (*map(float, corners.min(axis=0)), *map(float, corners.max(axis=0)))
    return GeomShape("mesh", (), place @ inverse(from_mesh), *look, bounds, area(model, geom))


def _look(model: Any, geom: int) -> tuple[tuple[float, ...], str]:
    """Returns the colour of a geom and the name of its image's file ("" without an image). They are those of
    the material, unless the geom has its own colour."""
    rgba, material = model.geom_rgba[geom], int(model.geom_matid[geom])
    if material < 0:
        return tuple(rgba), ""
    colour = tuple(model.mat_rgba[material] if np.allclose(rgba, DEFAULT_COLOUR) else rgba)
    texture = int(model.mat_texid[material][mujoco.mjtTextureRole.mjTEXROLE_RGB])
    if texture < 0:
        return colour, ""
    first = int(model.tex_pathadr[texture])
    path = model.paths[first : model.paths.find(b"\0", first)] if first >= 0 else b""
    return colour, PurePosixPath(path.decode()).name
