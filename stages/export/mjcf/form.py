"""The form of a robot's MJCF, as the configuration wants it."""

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

from stages.export.mjcf.extras import extras_of
from stages.export.mjcf.filters import Filters, filters
from stages.export.sensor_mounts import loaded_links
from stages.formats.mjcf_form import MjcfForm
from stages.formats.mjcf_written import as_written, form_with, holders
from stages.robot.fused_geometry import fused_geometry
from stages.robot.geometry import Geometry
from stages.robot.model import Robot

if TYPE_CHECKING:
    from stages.export.keys import ExportKeys


def form_of(robot: Robot, geometry: Geometry, keys: "ExportKeys") -> MjcfForm:
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
    held = holders(robot, form)
    kept_apart = filters_of(robot, geometry, form)
    unfused = filters_of(robot, geometry, MjcfForm((), robot.mjcf))
    crowded = {link for pair in kept_apart.wide for link in pair}
    needed = Counter(frozenset(held[link][0] for link, _ in pair) for pair in unfused.kept)
    written = Counter(frozenset(link for link, _ in pair) for pair in kept_apart.kept)
    crowded |= {link for pair, number in written.items() if number > needed[pair] for link in pair}
    lost = [link for link in form.fused if held[link][0] in crowded]
    return form_with(robot, {*loaded, *lost}, merges) if lost else form


def filters_of(robot: Robot, geometry: Geometry, form: MjcfForm) -> Filters:
    """What keeps the excludes of `geometry` from colliding, by the links that have bodies."""
    return filters(as_written(robot, form), fused_geometry(robot, geometry, holders(robot, form)))
