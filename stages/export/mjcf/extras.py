"""Selects the features of an MJCF source that the written MJCF can carry, and reports the others."""

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
from linkwright.stages.robot.text.globs import name_list

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

VALUE_SECTIONS = ("tendon", "equality", "actuator")
"""Sections whose elements refer to joint values as the source counts them."""


def extras_of(robot: Robot, geometry: Geometry, keys: "ExportSections") -> MjcfExtras | None:
    """Returns the extras of an MJCF source that are kept; None without such a source.

    Elements are left out if they name a thing that the robot does not have, or a joint whose value counts
    differently. So are cameras and lights that the configuration replaces under the same name, and the scene
    if the configuration drops it.
    """
    extras = robot.mjcf
    if extras is None:
        return None
    keeps_scene = keys.scene.surroundings == "keep"
    if not keeps_scene:
        extras = replace(extras, scene=(), scene_qpos=(), has_ground=False)
    replaced = {("camera", name) for name in keys.scene.cameras} | {
        ("light", name) for name in keys.scene.lights
    }
    mounted = tuple(
        mount for mount in extras.mounted if (mount.element.tag, mount.element.name) not in replaced
    )
    names = _names(robot, geometry, replace(extras, mounted=mounted))
    excluded_pairs = _excluded_pairs(geometry)
    joints_counted_otherwise = {("joint", dof.name) for dof in robot.dofs if dof.mate_value != AS_THE_MATE}
    # Without shapes, nothing tells which geoms the robot has.
    shapes_unknown = not geometry.shapes

    def kept_elements(section: MjcfElement) -> Iterator[MjcfElement]:
        """Yields the elements of a section that are kept, and adds them to `names`."""
        # The contact filters of the configuration replace those of the source.
        if section.tag == "contact" and not shapes_unknown and not geometry.by_source:
            return
        for element in section.children:
            references = {pair for pair in element.named() if not (shapes_unknown and pair[0] == "geom")}
            if element.tag == "pair" and frozenset(element.named()) in excluded_pairs:
                continue
            if section.tag in ("asset", "worldbody"):
                if (element.tag, element.name) not in replaced:
                    yield element
            elif references <= names and not (
                section.tag in VALUE_SECTIONS and references & joints_counted_otherwise
            ):
                names.add((section.tag, element.name))
                yield element

    def kept_sections(sections: tuple[MjcfElement, ...]) -> tuple[MjcfElement, ...]:
        """Returns the sections with the elements that are kept, without empty sections."""
        filtered = (replace(section, children=tuple(kept_elements(section))) for section in sections)
        return tuple(section for section in filtered if section.children)

    return replace(
        extras, mounted=mounted, sections=kept_sections(extras.sections), scene=kept_sections(extras.scene)
    )


def _excluded_pairs(geometry: Geometry) -> set[frozenset[tuple[str, str]]]:
    """Returns the pairs of geoms, as (kind, name), of links that the configuration excludes from contact."""
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
    """Returns (kind, name) of everything that an element may refer to, without other elements of the
    extras."""
    names = {("body", "world"), *(("body", link.name) for link in robot.links)}
    names |= {("joint", dof.name) for dof in robot.dofs}
    names |= {("site", frame.name) for frame in robot.frames}
    names |= {("geom", shape.form.name) for shape in geometry.shapes}
    names |= {("actuator", actuator.name) for actuator in robot.actuators}
    names |= {(mount.element.tag, mount.element.name) for mount in extras.mounted}
    for section in extras.scene:
        if section.tag == "worldbody":
            names |= {(element.tag, element.name) for element in section.inside()}
    return names


def report_lost(written: Written) -> Iterator[Diagnostic]:
    """Reports elements of the source that the written MJCF does not have (W-MJCF-LEFT)."""
    robot, extras = written.robot, written.mjcf_form.extras
    if robot.mjcf is None or extras is None:
        return
    excluded_pairs = _excluded_pairs(written.shapes)
    old_names, new_names = (
        [
            f"{section.tag} {element.name}".rstrip()
            for section in (*side.sections, *side.scene)
            for element in section.children
            if section.tag not in ("asset", "worldbody")
            and not (element.tag == "pair" and frozenset(element.named()) in excluded_pairs)
        ]
        for side in (robot.mjcf, extras)
    )
    # Several elements can have the same text, if they have no name.
    lost_names = list(old_names)
    for name in new_names:
        lost_names.remove(name)
    if lost_names:
        text = (
            "not carried over, since it names what the robot has not, or a joint whose value counts "
            f"otherwise (zero, invert): {name_list(lost_names)}"
        )
        hint = "check frames.include, ignore, joints.*.zero and invert, contact.self and scene.surroundings"
        yield Diagnostic("W-MJCF-LEFT", text, f"{robot.name}.xml", hint)
