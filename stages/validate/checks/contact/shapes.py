"""Each body has the shapes of its links: as many, where they shall be, and of their size."""

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

WORDS = ShapeWords("type", "mesh", "mesh", ("pos", "quat"), "material")
"""What an MJCF calls what a geom is."""

SAME = 1e-6
"""Places [m, rad] and sizes [m] of shapes are to be the same within this."""

AREA = 1e-3
"""Areas of meshes, relatively: a file has single precision."""

GROUPS: dict[Role, int] = {"visual": 2, "collision": 3}
"""Viewers show groups 0 to 2."""

UNPAINTED = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom without one."""

KINDS = {BOX: "box", SPHERE: "sphere", CYLINDER: "cylinder", CAPSULE: "capsule", ELLIPSOID: "ellipsoid"}


@dataclass(frozen=True, slots=True, eq=False)
class GeomShape:
    """A geom as a `ReadShape`: MuJoCo does not say the file and the scale of a mesh, but its points: `bounds`
    and `area`, as in `geometry.Shape`."""

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
    """Of a robot whose shapes are known."""
    geometry, model = compiled.written.geometry, compiled.model
    if geometry is None or not geometry.shapes:
        return
    every, expected = seen_and_solid(model), solids_by_link(geometry, _solids, compiled.held)
    wrong: list[Finding] = []
    more: list[Finding] = []
    for link in compiled.robot.links:
        body, place = body_index(model, link.name), body_from_link(compiled.robot, link.name)
        place = placed_by_site(model, link.name) @ place if body == 0 else place
        for role, geoms in zip(ROLES, every.get(body, ((), ())), strict=True):
            wanted = [
                replace(one, link_from_shape=place @ one.link_from_shape)
                for one in expected.get((link.name, role), ())
            ]
            added = _added(compiled, wanted, geoms)
            more += [_more(model, link.name, role, geom) for geom in added]
            kept = [geom for geom in geoms if geom not in added]
            wrong += _differences(compiled, link.name, role, wanted, kept)
    total = count(len(geometry.shapes), "shape")
    detail = f"{total} in place, of their size and colour"
    if wrong or more:
        says = [f"{len(wrong)} of {total} not as the robot has them"] if wrong else []
        says += [f"{len(more)} more than the robot has: {more[0].element}"] if more else []
        detail = "; ".join(says)
    yield compiled.within("shapes", float(len(wrong) + len(more)), 0.0, detail, (*more, *wrong))


def _solids(shape: Shape) -> Iterator[WrittenShape]:
    """An ellipsoid is one in an MJCF."""
    own = shape if shape.ellipsoid is None else replace(shape, primitive=shape.ellipsoid, file=None)
    yield solid_of(own)


def _more(model: Any, link: str, role: Role, geom: int) -> Finding:
    text = f"is a {role} shape more than the robot's {named('body', link)} has"
    return Finding(named_geom(model, geom, link), "geom", text)


def _added(compiled: CompiledModel, wanted: Sequence[WrittenShape], geoms: Sequence[int]) -> list[int]:
    """The geoms that a body has more than the robot, wherever in their order they stand: those without which
    the others fit. None where the user's own XML changes the file: what that adds comes last."""
    more = len(geoms) - len(wanted)
    if more <= 0 or compiled.written.amendments.of(compiled.path.name):
        return []
    added: list[int] = []
    at = 0
    for geom in geoms:

        def fits(other: int, place: int = at) -> bool:
            return place < len(wanted) and not any(_form(compiled.model, "", wanted[place], other))

        later = at >= len(wanted) or any(fits(other) for other in geoms if other > geom)
        if fits(geom) or len(added) == more or not later:
            at += 1
        else:
            added.append(geom)
    return added


def _differences(
    compiled: CompiledModel, link: str, role: Role, wanted: Sequence[WrittenShape], geoms: Sequence[int]
) -> Iterator[Finding]:
    """What the user's own XML adds to a body comes after what is the robot's own."""
    model = compiled.model
    if len(geoms) < len(wanted):
        text = f"{link} has {count(len(geoms), f'{role} shape')} of {len(wanted)}"
        yield Finding(named("body", link), "geom", text)
        return
    for one, geom in zip(wanted, geoms, strict=False):
        element, group = named_geom(model, geom, link), int(model.geom_group[geom])
        yield from _form(model, element, one, geom)
        if group != GROUPS[role] and not compiled.sets("group"):
            yield differs(element, "group", group, GROUPS[role])
        if role == "visual" and not compiled.recolours:
            yield from look_differs(element, WORDS.colour, _read(model, geom), one)


def _form(model: Any, element: str, wanted: WrittenShape, geom: int) -> Iterator[Finding]:
    shape = _read(model, geom)
    found = list(form_differs(element, "", shape, wanted, WORDS, SAME))
    yield from found
    if found or wanted.kind != "mesh":
        return
    if abs(shape.area - wanted.area) > AREA * wanted.area:
        times = (shape.area / wanted.area) ** 0.5 if wanted.area else float("inf")
        text = f"has an area of {shape.area:.4g} m², not {wanted.area:.4g}: {times:.4g} times as long"
        yield Finding(element, WORDS.file, text)
    elif wanted.bounds:
        yield from bounds_differ(element, WORDS.file, shape.bounds, wanted)


def _read(model: Any, geom: int) -> GeomShape:
    kind, place = int(model.geom_type[geom]), placed(model.geom_quat[geom], model.geom_pos[geom])
    look = _look(model, geom)
    if kind != MESH:
        half = tuple(map(float, model.geom_size[geom]))
        full = tuple(2 * length for length in half)
        sizes = {BOX: full, ELLIPSOID: full, SPHERE: half[:1]}
        return GeomShape(KINDS[kind], sizes.get(kind, (half[0], full[1])), place, *look)
    mesh = int(model.geom_dataid[geom])
    # MuJoCo moves each mesh to its own centre and axes, and the geom with it.
    own = placed(model.mesh_quat[mesh], model.mesh_pos[mesh])
    corners = vertices(model, geom) @ own[:3, :3].T + own[:3, 3]
    bounds = (*map(float, corners.min(axis=0)), *map(float, corners.max(axis=0)))
    return GeomShape("mesh", (), place @ inverse(own), *look, bounds, area(model, geom))


def _look(model: Any, geom: int) -> tuple[tuple[float, ...], str]:
    """The colour of a geom, and the name of its image's file, "" for none: those of its material, but for a
    colour of its own."""
    own, material = model.geom_rgba[geom], int(model.geom_matid[geom])
    if material < 0:
        return tuple(own), ""
    colour = tuple(model.mat_rgba[material] if np.allclose(own, UNPAINTED) else own)
    texture = int(model.mat_texid[material][mujoco.mjtTextureRole.mjTEXROLE_RGB])
    if texture < 0:
        return colour, ""
    first = int(model.tex_pathadr[texture])
    path = model.paths[first : model.paths.find(b"\0", first)] if first >= 0 else b""
    return colour, PurePosixPath(path.decode()).name
