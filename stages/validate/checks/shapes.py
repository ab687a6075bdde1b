"""Each body has the shapes of its links: as many, where they shall be, and of their size."""

from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check, Finding
from stages.robot.geometry import Role, Shape
from stages.robot.model import Array, Primitive
from stages.robot.plural import count
from stages.robot.poses import UNMOVED, inverse
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import body_from_link, body_index, distance, placed_by_site
from stages.validate.findings import differs, named
from stages.validate.mujoco_poses import placed
from stages.validate.shapes import (
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
from stages.validate.solids import same_colour

CODE = "C-SHAPE"

SAME = 1e-6
"""Places [m, rad] and sizes [m] of shapes are to be the same within this."""

AREA = 1e-3
"""Areas of meshes, relatively: a file has single precision."""

WITHIN = 2e-5
"""Bounds of meshes [m], and relatively beyond a metre: both are written in single precision."""

ROLES: tuple[Role, Role] = ("visual", "collision")

GROUPS: dict[Role, int] = {"visual": 2, "collision": 3}
"""Viewers show groups 0 to 2."""

UNPAINTED = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom without one."""

KINDS = {
    "box": BOX,
    "sphere": SPHERE,
    "cylinder": CYLINDER,
    "capsule": CAPSULE,
    "ellipsoid": ELLIPSOID,
}


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a robot whose shapes are known."""
    if compiled.geometry is None or not compiled.geometry.shapes:
        return
    every = seen_and_solid(compiled.model)
    shapes = compiled.geometry.by_link()
    wrong: list[Finding] = []
    more: list[Finding] = []
    for link in compiled.robot.links:
        body = body_index(compiled.model, link.name)
        places = [pose for holder, pose in compiled.held.values() if holder == link.name] or [UNMOVED]
        own_place = body_from_link(compiled.robot, link.name)
        places = [own_place @ pose for pose in places]
        if body == 0:
            places = [placed_by_site(compiled.model, link.name) @ pose for pose in places]
        for role, geoms in zip(ROLES, every.get(body, ((), ())), strict=True):
            own = shapes[link.name, role]
            added = _added(compiled, own, geoms, places)
            more += [_more(compiled.model, link.name, role, geom) for geom in added]
            kept = [geom for geom in geoms if geom not in added]
            wrong += _differences(compiled.model, link.name, role, own, kept, places)
            wrong += _looks(compiled, link.name, role, own, kept)
    total = len(compiled.geometry.shapes)
    detail = f"{count(total, 'shape')} in place, of their size and colour"
    if wrong or more:
        says = [f"{len(wrong)} of {count(total, 'shape')} not as the robot has them"] if wrong else []
        says += [f"{len(more)} more than the robot has: {more[0].element}"] if more else []
        detail = "; ".join(says)
    number = float(len(wrong) + len(more))
    yield compiled.within("shapes", number, 0.0, detail, (*more, *wrong))


def _more(model: Any, link: str, role: Role, geom: int) -> Finding:
    text = f"is a {role} shape more than the robot's {named('body', link)} has"
    return Finding(named_geom(model, geom, link), "geom", text)


def _added(
    compiled: CompiledModel, shapes: Sequence[Shape], geoms: Sequence[int], places: Sequence[Array]
) -> list[int]:
    """The geoms that a body has more than the robot, wherever in their order they stand: those without which
    the others fit. None where the user's own XML changes the file: what that adds comes last."""
    more = len(geoms) - len(shapes)
    if more <= 0 or compiled.written.amendments.of(compiled.path.name):
        return []
    added: list[int] = []
    at = 0
    for geom in geoms:
        fits = at < len(shapes) and not _wrong(compiled.model, shapes[at], geom, places)
        if fits or len(added) == more or not _fits_later(compiled, shapes, geoms, places, geom, at):
            at += 1
        else:
            added.append(geom)
    return added


def _fits_later(
    compiled: CompiledModel,
    shapes: Sequence[Shape],
    geoms: Sequence[int],
    places: Sequence[Array],
    geom: int,
    at: int,
) -> bool:
    """Whether the shape at this place is that of a later geom, or there is none left."""
    rest = [one for one in geoms if one > geom]
    if at >= len(shapes):
        return True
    return any(not _wrong(compiled.model, shapes[at], one, places) for one in rest)


def _wrong(model: Any, shape: Shape, geom: int, places: Sequence[Array]) -> tuple[str, str] | None:
    primitive = shape.ellipsoid or shape.primitive
    if primitive is None:
        return _of_mesh(model, shape, geom, places)
    return _of_primitive(model, primitive, geom, places)


def _differences(
    model: Any, link: str, role: Role, shapes: Sequence[Shape], geoms: Sequence[int], places: Sequence[Array]
) -> Iterator[Finding]:
    """What the user's own XML adds to a body comes after what is the robot's own."""
    if len(geoms) < len(shapes):
        text = f"{link} has {count(len(geoms), f'{role} shape')} of {len(shapes)}"
        yield Finding(named("body", link), "geom", text)
        return
    for shape, geom in zip(shapes, geoms, strict=False):
        wrong = _wrong(model, shape, geom, places)
        if wrong:
            attribute, text = wrong
            element = named_geom(model, geom, link)
            yield Finding(element, attribute, f"{element} of {link} {text}")


def _of_mesh(model: Any, shape: Shape, geom: int, places: Sequence[Array]) -> tuple[str, str] | None:
    if model.geom_type[geom] != MESH:
        return "type", f"is no mesh, and shall be {shape.file}"
    mesh = int(model.geom_dataid[geom])
    # MuJoCo moves each mesh to its own centre and axes, and the geom with it.
    own = placed(model.mesh_quat[mesh], model.mesh_pos[mesh])
    place = placed(model.geom_quat[geom], model.geom_pos[geom]) @ inverse(own)
    off = min(distance(place, expected) for expected in places)
    if off > SAME:
        return "pos", f"is {off:.3g} m or rad from its link's frame, where its mesh belongs"
    found = area(model, geom)
    if abs(found - shape.area) > AREA * shape.area:
        times = (found / shape.area) ** 0.5 if shape.area else float("inf")
        return "mesh", f"has an area of {found:.4g} m², not {shape.area:.4g}: {times:.4g} times as long"
    if shape.bounds:
        corners = vertices(model, geom) @ own[:3, :3].T + own[:3, 3]
        moved = np.abs([*corners.min(axis=0), *corners.max(axis=0)] - np.array(shape.bounds))
        if moved.max() > WITHIN * max(1.0, float(np.abs(shape.bounds).max())):
            return "mesh", f"has its points elsewhere: its bounds are {1e3 * moved.max():.3g} mm off"
    return None


def _of_primitive(
    model: Any, primitive: Primitive, geom: int, places: Sequence[Array]
) -> tuple[str, str] | None:
    if model.geom_type[geom] != KINDS[primitive.kind]:
        return "type", f"is no {primitive.kind}"
    sizes = primitive.size
    wanted = (
        [length / 2 for length in sizes]
        if primitive.kind in ("box", "ellipsoid")
        else [sizes[0], *(x / 2 for x in sizes[1:])]
    )
    off = float(np.abs(model.geom_size[geom][: len(wanted)] - wanted).max())
    if off > SAME:
        return "size", f"is {1e3 * off:.3g} mm off in size"
    place = placed(model.geom_quat[geom], model.geom_pos[geom])
    off = min(distance(place, expected @ primitive.link_from_shape) for expected in places)
    return ("pos", f"is {off:.3g} m or rad from its place") if off > SAME else None


def _looks(
    compiled: CompiledModel, link: str, role: Role, shapes: Sequence[Shape], geoms: Sequence[int]
) -> Iterator[Finding]:
    """The colours of what is seen, and the group by which viewers show or hide it."""
    model = compiled.model
    if len(geoms) < len(shapes):
        return
    for shape, geom in zip(shapes, geoms, strict=False):
        element, group = named_geom(model, geom, link), int(model.geom_group[geom])
        if group != GROUPS[role] and not compiled.sets("group"):
            yield differs(element, "group", group, GROUPS[role])
        if shape.colour is None or role == "collision" or compiled.recolours:
            continue
        colour, image = _look(model, geom)
        if image != (shape.texture or ""):
            yield differs(element, "material", image or "no image", shape.texture or "no image")
        elif not same_colour(colour, shape.colour):
            yield differs(element, "material", colour, shape.colour)


def _look(model: Any, geom: int) -> tuple[Array, str]:
    """The colour of a geom, and the name of its image's file, "" for none: those of its material, but for a
    colour of its own."""
    own, material = model.geom_rgba[geom], int(model.geom_matid[geom])
    if material < 0:
        return own, ""
    colour = model.mat_rgba[material] if np.allclose(own, UNPAINTED) else own
    texture = int(model.mat_texid[material][mujoco.mjtTextureRole.mjTEXROLE_RGB])
    if texture < 0:
        return colour, ""
    first = int(model.tex_pathadr[texture])
    path = model.paths[first : model.paths.find(b"\0", first)] if first >= 0 else b""
    return colour, PurePosixPath(path.decode()).name
