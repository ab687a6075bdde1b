"""Each collider touches as the robot says: by its friction, stiffness, margin and priority, and by all of its
hull."""

from collections.abc import Iterator
from pathlib import PurePosixPath

from linkwright.stages.formats.xml import parse
from linkwright.stages.mujoco.names import body_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.text.globs import listed
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, named
from linkwright.stages.validate.model.contact_attributes import ATTRIBUTES, contact_differences, sets_defaults
from linkwright.stages.validate.model.shapes import named_geom, seen_and_solid

WHOLE_HULL = "-1"
"""MuJoCo's `maxhullvert` of a mesh whose hull may have any number of vertices."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a robot whose shapes are known."""
    geometry = compiled.geometry
    if geometry is None or not geometry.shapes or sets_defaults(compiled):
        return
    found = [*_of_geoms(compiled, geometry), *_of_hulls(compiled, geometry)]
    total = sum(shape.role == "collision" for shape in geometry.shapes)
    detail = f"{count(total, 'collider')} with the friction, stiffness and margin that the robot says"
    if found:
        detail = f"not what the robot says: {listed(f'{one.element} {one.attribute}' for one in found)}"
    yield compiled.within("contact properties", float(len(found)), 0.0, detail, few(found))


def _of_geoms(compiled: CompiledModel, geometry: Geometry) -> Iterator[Finding]:
    """Of each link that has as many colliders as the robot, before what the user's own XML adds: where it
    has not, that is found elsewhere."""
    model, shapes = compiled.model, geometry.by_link()
    every = seen_and_solid(model)
    mine = {attribute for attribute in ATTRIBUTES if compiled.sets(attribute)}
    changed = bool(compiled.written.amendments.of(compiled.path.name))
    for link in compiled.robot.links:
        own = shapes[link.name, "collision"]
        _, geoms = every.get(body_index(model, link.name), ([], []))
        if len(geoms) == len(own) or (changed and len(geoms) > len(own)):
            for shape, geom in zip(own, geoms, strict=False):
                element = named_geom(model, geom, link.name)
                yield from contact_differences(model, geom, element, shape.contact, mine)


def _of_hulls(compiled: CompiledModel, geometry: Geometry) -> Iterator[Finding]:
    if compiled.sets("maxhullvert"):
        return
    solid = {PurePosixPath(one.file).stem for one in geometry.shapes if one.role == "collision" and one.file}
    for mesh in parse(compiled.path.read_bytes(), large=True).iterfind("asset/mesh"):
        name = mesh.get("name") or PurePosixPath(mesh.get("file", "")).stem
        most = mesh.get("maxhullvert", WHOLE_HULL)
        if name in solid and most != WHOLE_HULL:
            yield differs(named("mesh", name), "maxhullvert", most, None)
