"""What an MJCF source alone has, as far as the MJCF that is written can carry it."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.dofs import AS_THE_MATE
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.mjcf_extras import MjcfElement, MjcfExtras
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.text.globs import listed

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

COUNTED = ("tendon", "equality", "actuator")
"""Sections whose elements mean values of joints as the source counts them."""


def extras_of(robot: Robot, geometry: Geometry, keys: "ExportSections") -> MjcfExtras | None:
    """The extras without what names a thing that the robot has not, or a joint whose value counts otherwise;
    without cameras and lights that the configuration gives under the same name, and without the scene where
    the configuration leaves that out."""
    extras = robot.mjcf
    if extras is None:
        return None
    kept = keys.scene.surroundings == "keep"
    if not kept:
        extras = replace(extras, scene=(), scene_qpos=(), has_ground=False)
    given = {("camera", name) for name in keys.scene.cameras} | {
        ("light", name) for name in keys.scene.lights
    }
    mounted = tuple(one for one in extras.mounted if (one.element.tag, one.element.name) not in given)
    names = _names(robot, geometry, replace(extras, mounted=mounted))
    apart = _parted(geometry)
    recounted = {("joint", dof.name) for dof in robot.dofs if dof.in_mate != AS_THE_MATE}
    unsure = not geometry.shapes

    def carried(section: MjcfElement) -> Iterator[MjcfElement]:
        if section.tag == "contact" and not unsure and not geometry.by_source:
            return
        for element in section.children:
            wanted = {pair for pair in element.named() if not (unsure and pair[0] == "geom")}
            if element.tag == "pair" and frozenset(element.named()) in apart:
                continue
            if section.tag in ("asset", "worldbody"):
                if (element.tag, element.name) not in given:
                    yield element
            elif wanted <= names and not (section.tag in COUNTED and wanted & recounted):
                names.add((section.tag, element.name))
                yield element

    def whole(sections: tuple[MjcfElement, ...]) -> tuple[MjcfElement, ...]:
        found = (replace(section, children=tuple(carried(section))) for section in sections)
        return tuple(section for section in found if section.children)

    return replace(extras, mounted=mounted, sections=whole(extras.sections), scene=whole(extras.scene))


def _parted(geometry: Geometry) -> set[frozenset[tuple[str, str]]]:
    """Pairs of geoms, as (kind, name), of links that the configuration excludes from contact."""
    geoms: dict[str, list[tuple[str, str]]] = {}
    for shape in geometry.shapes:
        geoms.setdefault(shape.link, []).append(("geom", shape.form.name))
    return {
        frozenset(pair)
        for exclude in geometry.excludes
        if exclude.reason == "User"
        for pair in product(geoms.get(exclude.link_a, ()), geoms.get(exclude.link_b, ()))
    }


def _names(robot: Robot, geometry: Geometry, extras: MjcfExtras) -> set[tuple[str, str]]:
    """(kind, name) of all that an element may name, but for other elements."""
    names = {("body", "world"), *(("body", link.name) for link in robot.links)}
    names |= {("joint", dof.name) for dof in robot.dofs}
    names |= {("site", frame.name) for frame in robot.frames}
    names |= {("geom", shape.form.name) for shape in geometry.shapes}
    names |= {("actuator", actuator.name) for actuator in robot.actuators}
    names |= {(one.element.tag, one.element.name) for one in extras.mounted}
    for section in extras.scene:
        if section.tag == "worldbody":
            names |= {(element.tag, element.name) for element in section.inside()}
    return names


def lost(written: Written) -> Iterator[Diagnostic]:
    """W-MJCF-LEFT: what the source has and the MJCF that is written has not."""
    robot, extras = written.robot, written.mjcf_form.extras
    if robot.mjcf is None or extras is None:
        return
    apart = _parted(written.shapes)
    before, after = (
        [
            f"{section.tag} {element.name}".rstrip()
            for section in (*one.sections, *one.scene)
            for element in section.children
            if section.tag not in ("asset", "worldbody")
            and not (element.tag == "pair" and frozenset(element.named()) in apart)
        ]
        for one in (robot.mjcf, extras)
    )
    gone = list(before)
    for name in after:
        gone.remove(name)
    if gone:
        text = (
            "not carried over, since it names what the robot has not, or a joint whose value counts "
            f"otherwise (zero, invert): {listed(gone)}"
        )
        hint = "check frames.include, ignore, joints.*.zero and invert, contact.self and scene.surroundings"
        yield Diagnostic("W-MJCF-LEFT", text, f"{robot.name}.xml", hint)
