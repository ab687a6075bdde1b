"""The robot that an MJCF describes, where its form differs from that of the robot."""

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.robot.dynamics.fusing import Holders, fused, on_fixed_joints
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, MjcfExtras, children_of
from linkwright.stages.robot.model.robot import Frame, Robot, frozen
from linkwright.stages.robot.model.sensing import SensorTarget


def form_with(robot: Robot, kept: Collection[str] = (), merges: bool = False) -> MjcfForm:
    """The form in which links on fixed joints have no bodies, but for those that are `kept` or need one: a
    sensor is on it, another place has its name, or both ends of a loop would be on one body. The bodies of an
    MJCF source stay bodies, unless the form `merges` those that nothing names."""
    bodies = {*kept, *_measured(robot, "body", "xbody"), *_loaded(robot), *_named_twice(robot)}
    if robot.mjcf is not None:
        bodies |= _named_bodies(robot.mjcf)
        bodies |= set() if merges else {one.link for one in robot.mjcf.bodies}
    candidates = set(on_fixed_joints(robot)) - bodies
    # Their sensors are at the centre of mass, which what is fused would move; their excludes are of their own
    # shapes.
    alone = {*_measured(robot, "body"), *_excluded(robot.mjcf or NO_EXTRAS)}
    holder = {robot.root.name: robot.root.name}
    for joint in robot.joints:
        above = holder[joint.parent]
        fuses = joint.child in candidates and above not in alone
        holder[joint.child] = above if fuses else joint.child
    ends = {
        end
        for loop in robot.loops
        if holder[loop.link_a] == holder[loop.link_b]
        for end in (loop.link_a, loop.link_b)
    }
    fused = (link for link, above in holder.items() if link != above and link not in ends)
    return MjcfForm(tuple(fused), robot.mjcf)


def as_written(robot: Robot, form: MjcfForm, held: Holders) -> Robot:
    """The robot that the MJCF of this form describes: all that was on fused links is on their holders `held`,
    and each is a frame there."""
    robot = replace(robot, mjcf=form.extras)
    if not form.fused:
        return robot
    named = {frame.name for frame in robot.frames}
    places = tuple(
        Frame(link, held[link][0], frozen(held[link][1]), "") for link in form.fused if link not in named
    )
    whole = fused(robot, held)
    return replace(whole, frames=(*places, *whole.frames))


def _excluded(extras: MjcfExtras) -> Iterator[str]:
    """The bodies that excludes name."""
    for element in children_of(extras.sections, "contact"):
        if element.tag == "exclude":
            yield from (name for _, name in element.named())


def _named_bodies(extras: MjcfExtras) -> set[str]:
    """The links that an element names, or whose body has attributes of its own."""
    sections = (*extras.sections, *extras.scene)
    named = {name for section in sections for kind, name in section.named() if kind == "body"}
    return named | {one.name for one in extras.attributes if one.kind == "body"}


def _measured(robot: Robot, *kinds: SensorTarget) -> Iterator[str]:
    """The names of what sensors of these `kinds` are on."""
    for one in robot.sensors:
        for kind, name in ((one.target, one.name_of_target), (one.relative_to, one.name_of_relative)):
            if kind in kinds:
                yield name


def _loaded(robot: Robot) -> Iterator[str]:
    """The links on which sensors measure what the body above exerts."""
    links = {frame.name: frame.link for frame in robot.frames}
    for one in robot.sensors:
        if one.type in ("force", "torque") and one.name_of_target in links:
            yield links[one.name_of_target]


def _named_twice(robot: Robot) -> Iterator[str]:
    """The names of frames that are elsewhere than the links of these names."""
    for frame in robot.frames:
        if frame.link != frame.name or not np.array_equal(frame.link_from_frame, np.eye(4)):
            yield frame.name
