"""The form of a robot's MJCF, as the configuration wants it."""

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.export.mjcf.contact.filters import filters
from linkwright.stages.export.mjcf.extras import extras_of
from linkwright.stages.export.sensors.mounts import loaded_links
from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.formats.mjcf.written import form_with
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections


def form_of(robot: Robot, geometry: Geometry, keys: "ExportSections") -> MjcfForm:
    """How the robot's MJCF differs from the robot. Links keep their bodies where these are excluded from
    contact, and those that they would be part of are not; where a sensor measures their load; and where an
    MJCF source has them, unless they are to be merged."""
    mjcf = keys.export.mjcf
    robot = replace(robot, mjcf=extras_of(robot, geometry, keys))
    if mjcf is None or mjcf.fixed_joints == "keep":
        return MjcfForm((), robot.mjcf)
    loaded, merges = loaded_links(robot, keys.sensors), mjcf.fixed_joints == "merge"
    form = form_with(robot, loaded, merges)
    if not form.fused:
        return form
    written = Written(robot, geometry=geometry, mjcf_form=form)
    held = written.as_mjcf.held
    kept_apart = filters(written.as_mjcf.robot, written.mjcf_shapes)
    unfused = filters(robot, geometry)
    crowded = {link for pair in kept_apart.wide for link in pair}
    wanted = Counter(frozenset(held[link][0] for link, _ in pair) for pair in unfused.kept)
    kept = Counter(frozenset(link for link, _ in pair) for pair in kept_apart.kept)
    crowded |= {link for pair, number in kept.items() if number > wanted[pair] for link in pair}
    lost = [link for link in form.fused if held[link][0] in crowded]
    return form_with(robot, {*loaded, *lost}, merges) if lost else form
