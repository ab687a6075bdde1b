"""Decides the form of a robot's MJCF: which links become part of other bodies, and the source's extras."""

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.export.mjcf.contact.filters import filters_of
from linkwright.stages.export.mjcf.extras import extras_of
from linkwright.stages.export.sensors.mounts import links_with_load_sensors
from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.formats.mjcf.written import mjcf_form
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections


def form_of(robot: Robot, geometry: Geometry, keys: "ExportSections") -> MjcfForm:
    """Returns how the robot's MJCF differs from the robot.

    A link keeps its body if it is excluded from contacts that the merged body would have, or if a sensor
    measures its load. So does a link that has a body in an MJCF source, unless `fixed_joints` is "merge".
    """
    mjcf = keys.export.mjcf
    robot = replace(robot, mjcf=extras_of(robot, geometry, keys))
    if mjcf is None or mjcf.fixed_joints == "keep":
        return MjcfForm((), robot.mjcf)
    measured_links = links_with_load_sensors(robot, keys.sensors)
    merges_source_bodies = mjcf.fixed_joints == "merge"
    form = mjcf_form(robot, measured_links, merges_source_bodies)
    if not form.fused:
        return form
    written = Written(robot, geometry=geometry, mjcf_form=form)
    holders = written.as_mjcf.held
    merged_filters = filters_of(written.as_mjcf.robot, written.mjcf_shapes)
    unmerged_filters = filters_of(robot, geometry)
    # A body is in conflict if it is excluded as a whole instead of some of its geoms, or if merged bodies
    # need more colliding pairs of geoms than their links did.
    bodies_in_conflict = {link for pair in merged_filters.widened_pairs for link in pair}
    needed_pairs = Counter(
        frozenset(holders[link][0] for link, _ in pair) for pair in unmerged_filters.colliding_geoms
    )
    merged_pairs = Counter(frozenset(link for link, _ in pair) for pair in merged_filters.colliding_geoms)
    bodies_in_conflict |= {
        link for pair, count in merged_pairs.items() if count > needed_pairs[pair] for link in pair
    }
    links_to_keep = [link for link in form.fused if holders[link][0] in bodies_in_conflict]
    if not links_to_keep:
        return form
    return mjcf_form(robot, {*measured_links, *links_to_keep}, merges_source_bodies)
