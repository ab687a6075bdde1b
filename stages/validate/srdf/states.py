"""The poses of an SRDF's groups, against the robot's keyframes."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.poses import motion
from linkwright.stages.robot.model.robot import Configuration
from linkwright.stages.robot.motion.start_pose import HOME, keyframes
from linkwright.stages.validate.findings import differs, named, shown
from linkwright.stages.validate.model.coordinates import SAME, distance
from linkwright.stages.validate.srdf.known import ReadSrdf, state


def states(read: ReadSrdf) -> Iterator[Finding]:
    """Each group has `home` and the user's own keyframes, each with every joint of the group at the robot's
    value; poses of other names are within limits."""
    names = [HOME, *(one.name for one in read.robot.keyframes if one.name != HOME)]
    every = keyframes(read.robot)
    there = {(node.get("name"), node.get("group")) for node in read.root.findall("group_state")}
    for group in read.groups:
        for name in names if read.is_own(group) and read.moved_by(group) else ():
            if (name, group) not in there:
                element = f"{named('group_state', name)} of {named('group', group)}"
                yield Finding(element, "name", "there is none")
    for node in read.root.findall("group_state"):
        if node.get("group") in read.groups:
            values = {one.get("name", ""): _value(one) for one in node.findall("joint")}
            yield from _joints(read, node, values)
            pose = every[node.get("name")] if node.get("name") in names else None
            yield from _within(read, node, values) if pose is None else _at(read, node, values, pose)


def _joints(read: ReadSrdf, node: Element, values: Mapping[str, float]) -> Iterator[Finding]:
    own = read.moved_by(node.get("group", ""))
    for joint in sorted((own ^ values.keys()) & read.chains.joints.keys()):
        words = "has no value" if joint in own else "is no joint of the group that moves"
        yield Finding(state(node), f"joint {joint}", words)
    for joint, value in values.items():
        if not math.isfinite(value):
            yield Finding(state(node), f"joint {joint} value", "is no number")


def _at(read: ReadSrdf, node: Element, values: Mapping[str, float], pose: Configuration) -> Iterator[Finding]:
    """Where the values are others than those of a pose of the robot."""
    balls: dict[str, list[tuple[str, float]]] = {}
    for joint, value in values.items():
        step = read.chains.joints.get(joint)
        if step is None or step.dof is None or not step.moves or not math.isfinite(value):
            continue
        wanted = pose[step.dof.name]
        if isinstance(wanted, tuple):
            balls.setdefault(step.dof.name, []).append((joint, value))
        elif abs(value - wanted) > SAME * max(1.0, abs(wanted)):
            yield differs(state(node), f"joint {joint} value", value, wanted)
    order = list(read.chains.joints)
    for name, turns in balls.items():
        turns.sort(key=lambda one: order.index(one[0]))  # about x, then y, then z
        found = np.eye(4)
        for (_, angle), axis in zip(turns, np.eye(3), strict=False):
            found = found @ motion("turn", axis, angle)
        off = distance(found, motion("ball", np.zeros(3), pose[name]))
        if len(turns) == 3 and off > SAME:
            message = f"is turned by {shown(math.degrees(off))} degrees from where the robot has it"
            yield Finding(state(node), f"joint {turns[0][0]} value", message)


def _within(read: ReadSrdf, node: Element, values: Mapping[str, float]) -> Iterator[Finding]:
    """Where the values of a pose that is the user's own are beyond the limits."""
    for joint, value in values.items():
        step = read.chains.joints.get(joint)
        low, high = step.limits.interval if step is not None else (-math.inf, math.inf)
        if not low - SAME <= value <= high + SAME and math.isfinite(value):
            words = f"is {shown(value)}, expected {shown(low)} to {shown(high)}"
            yield Finding(state(node), f"joint {joint} value", words)


def _value(node: Element) -> float:
    try:
        return float(node.get("value", ""))
    except ValueError:
        return math.nan
