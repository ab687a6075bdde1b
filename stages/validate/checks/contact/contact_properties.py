"""Checks that each collider has the robot's friction, stiffness, margin and priority, and its whole hull."""

from collections.abc import Iterator
from pathlib import PurePosixPath

from linkwright.stages.formats.xml import parse
from linkwright.stages.mujoco.names import body_index
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, named
from linkwright.stages.validate.model.contact_attributes import ATTRIBUTES, contact_differences, sets_defaults
from linkwright.stages.validate.model.shapes import named_geom, seen_and_solid

WHOLE_HULL = "-1"
"""MuJoCo's `maxhullvert` of a mesh whose hull may have any number of vertices."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the colliders with the robot's; yields nothing if the robot's shapes are unknown."""
    geometry = compiled.geometry
    if geometry is None or not geometry.shapes or sets_defaults(compiled):
        return
    findings = [*_geom_differences(compiled, geometry), *_hull_differences(compiled, geometry)]
    total = sum(shape.role == "collision" for shape in geometry.shapes)
    detail = f"{count(total, 'collider')} with the robot's friction, stiffness and margin"
    if findings:
        attributes = name_list(f"{finding.element} {finding.attribute}" for finding in findings)
        detail = f"not as the robot has them: {attributes}"
    yield compiled.within("contact properties", float(len(findings)), 0.0, detail, few(findings))


def _geom_differences(compiled: CompiledModel, geometry: Geometry) -> Iterator[Finding]:
    """Yields differences of links that have as many colliders as in the robot, without those that the user's
    own XML adds; other checks report missing colliders."""
    model, shapes = compiled.model, geometry.by_link()
    geoms_by_body = seen_and_solid(model)
    set_by_user = {attribute for attribute in ATTRIBUTES if compiled.sets(attribute)}
    is_amended = bool(compiled.written.amendments.changes_of(compiled.path.name))
    for link in compiled.robot.links:
        expected = shapes[link.name, "collision"]
        _, geoms = geoms_by_body.get(body_index(model, link.name), ([], []))
        if len(geoms) == len(expected) or (is_amended and len(geoms) > len(expected)):
            for shape, geom in zip(expected, geoms, strict=False):
                element = named_geom(model, geom, link.name)
                yield from contact_differences(model, geom, element, shape.contact, set_by_user)


def _hull_differences(compiled: CompiledModel, geometry: Geometry) -> Iterator[Finding]:
    """Yields the meshes of colliders whose hull has a limited number of vertices."""
    if compiled.sets("maxhullvert"):
        return
    collider_meshes = {
        PurePosixPath(shape.file).stem
        for shape in geometry.shapes
        if shape.role == "collision" and shape.file
    }
    for mesh in parse(compiled.path.read_bytes(), large=True).iterfind("asset/mesh"):
        name = mesh.get("name") or PurePosixPath(mesh.get("file", "")).stem
        max_vertices = mesh.get("maxhullvert", WHOLE_HULL)
        if name in collider_meshes and max_vertices != WHOLE_HULL:
            yield differs(named("mesh", name), "maxhullvert", max_vertices, None)
