"""Converts a robot to the robot that its MJCF describes: fused links are frames on their holders."""

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.robot.dynamics.fusing import Holders, fused, links_on_fixed_joints
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, MjcfExtras, children_of
from linkwright.stages.robot.model.robot import Frame, Robot, frozen
from linkwright.stages.robot.model.sensing import SensorTarget


def mjcf_form(robot: Robot, kept_links: Collection[str] = (), merges: bool = False) -> MjcfForm:
    """Returns the form in which links on fixed joints have no bodies, except `kept_links` and those that need
    a body.

    A link needs a body if a sensor is on it, another frame has its name, or both ends of a loop would be on
    the same body. The bodies of an MJCF source stay bodies; with `merges`, only those that an element names
    or that have attributes of their own.
    """
    bodies = {*kept_links, *_measured(robot, "body", "xbody"), *_loaded(robot), *_named_twice(robot)}
    if robot.mjcf is not None:
        bodies |= _named_bodies(robot.mjcf)
        bodies |= set() if merges else {body.link for body in robot.mjcf.bodies}
    candidates = set(links_on_fixed_joints(robot)) - bodies
    # Nothing is fused with these: sensors at their centre of mass would move with it, and excludes hold for
    # their own shapes only.
    unfused_holders = {*_measured(robot, "body"), *_excluded(robot.mjcf or NO_EXTRAS)}
    holder = {robot.root.name: robot.root.name}
    for joint in robot.joints:
        above = holder[joint.parent]
        fuses = joint.child in candidates and above not in unfused_holders
        holder[joint.child] = above if fuses else joint.child
    ends = {
        end
        for loop in robot.loops
        if holder[loop.link_a] == holder[loop.link_b]
        for end in (loop.link_a, loop.link_b)
    }
    fused_links = (link for link, above in holder.items() if link != above and link not in ends)
    return MjcfForm(tuple(fused_links), robot.mjcf)


def mjcf_robot(robot: Robot, form: MjcfForm, held: Holders) -> Robot:
    """Returns the robot that the MJCF of this form describes: the content of fused links is moved to the
    links that hold them (`held`), and each fused link is a frame there."""
    robot = replace(robot, mjcf=form.extras)
    if not form.fused:
        return robot
    frame_names = {frame.name for frame in robot.frames}
    link_frames = tuple(
        Frame(link, held[link][0], frozen(held[link][1]), "")
        for link in form.fused
        if link not in frame_names
    )
    fused_robot = fused(robot, held)
    return replace(fused_robot, frames=(*link_frames, *fused_robot.frames))


def _excluded(extras: MjcfExtras) -> Iterator[str]:
    """Yields the bodies that excludes name."""
    for element in children_of(extras.sections, "contact"):
        if element.tag == "exclude":
            yield from (name for _, name in element.named())


def _named_bodies(extras: MjcfExtras) -> set[str]:
    """Returns the links whose bodies an element of the source names, or have attributes of their own."""
    sections = (*extras.sections, *extras.scene)
    body_names = {name for section in sections for kind, name in section.named() if kind == "body"}
    return body_names | {entry.name for entry in extras.attributes if entry.kind == "body"}


def _measured(robot: Robot, *kinds: SensorTarget) -> Iterator[str]:
    """Yields the names of the objects of these `kinds` that sensors are on."""
    for sensor in robot.sensors:
        for kind, name in (
            (sensor.target, sensor.name_of_target),
            (sensor.relative_to, sensor.name_of_relative),
        ):
            if kind in kinds:
                yield name


def _loaded(robot: Robot) -> Iterator[str]:
    """Yields the links on which sensors measure the load from the body above."""
    links = {frame.name: frame.link for frame in robot.frames}
    for sensor in robot.sensors:
        if sensor.type in ("force", "torque") and sensor.name_of_target in links:
            yield links[sensor.name_of_target]


def _named_twice(robot: Robot) -> Iterator[str]:
    """Yields the names of frames that are not at the pose of a link of the same name: no site of a fused link
    may take them."""
    for frame in robot.frames:
        if frame.link != frame.name or not np.array_equal(frame.link_from_frame, np.eye(4)):
            yield frame.name
