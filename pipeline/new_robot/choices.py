"""Chooses base, actuators and contact of a new robot from what its source shows, with the reasons."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any, Literal

from linkwright.pipeline.new_robot.joint_table import WHEEL, JointRow
from linkwright.stages.robot.model.robot import Link, Robot
from linkwright.stages.robot.text.globs import exact_glob, name_list, without_number

FOOT_GLOB = "*[Ff]oot*"
"""The glob of feet in `conf/robot/legged.yaml`."""

GRIPPER_WORDS = ("finger", "jaw", "gripper", "claw")
"""Parts of the names of links that hold things."""

GRIPPER_CONTACT = {"friction": [1.2, 0.02, 0.0001], "condim": 4}
"""Contact of links that hold things: what they hold neither slips nor spins about the contact's normal."""

_MIN_LEGGED_MASS = 8.0
"""Least mass [kg] of a robot for which the gains of `conf/actuators/legged.yaml` are right."""


@dataclass(frozen=True, slots=True)
class RobotChoices:
    """The choices for a new robot."""

    base: Literal["auto", "fixed", "legged"]
    """The option of the group root, or the robot that the new one begins with."""
    base_reason: str
    actuators: Literal["none", "position"]
    """The option of the group actuators; a legged robot has that of /robot/legged."""
    actuators_reason: str
    entries: Mapping[str, Any] = field(default_factory=dict)
    """Entries of the key `actuators`."""
    entries_reason: str = ""
    geoms: Mapping[str, Any] = field(default_factory=dict)
    """Entries of the key `geoms`."""
    geoms_reason: str = ""


def choose(
    robot: Robot, rows: Sequence[JointRow], kind: str, *, has_masses: bool, for_peer: bool = False
) -> RobotChoices:
    """Returns the choices for a robot from a `kind` of source.

    `has_masses`: whether its masses are known. `for_peer`: whether the robot must equal that of
    onshape-to-robot: the base is fixed only if CAD fixes it, and joints and parts get no choices of ours.
    """
    base, base_reason = _base(robot, rows, kind, for_peer)
    actuators, actuators_reason = _actuators(robot, rows)
    if for_peer:
        return RobotChoices(base, base_reason, actuators, actuators_reason)
    entries, entries_reason = _entries(robot, rows, base, has_masses) if actuators == "position" else ({}, "")
    geoms, geoms_reason = _geoms(robot, kind)
    return RobotChoices(
        base, base_reason, actuators, actuators_reason, entries, entries_reason, geoms, geoms_reason
    )


def _base(
    robot: Robot, rows: Sequence[JointRow], kind: str, for_peer: bool
) -> tuple[Literal["auto", "fixed", "legged"], str]:
    is_fixed = robot.base.fixed
    base_text = f"{'fixed' if is_fixed else 'free'}: {robot.base.reason}"
    feet = [link.name for link in robot.links if _is_called(link, FOOT_GLOB)]
    if kind == "mjcf" or for_peer:
        return "auto", f"the base is {base_text}"
    if len(feet) > 1:
        contrast = f"; in the source it is {base_text}" if is_fixed else ""
        reason = (
            f"these links look like feet, so the base is free, and the feet do not slip: {name_list(feet)}"
        )
        return "legged", reason + contrast
    wheels = [row.name for row in rows if row.is_drivable and WHEEL.search(row.name)]
    if is_fixed or not rows:
        return "auto", f"the base is {base_text}"
    if wheels:
        return "auto", f"the base is {base_text}; it has wheels: {name_list(wheels)}"
    missing_fact = "a URDF does not say whether the base is fixed" if kind == "urdf" else "CAD fixes no part"
    return "fixed", f"{missing_fact}, and no name has foot or wheel in it; with free it could move"


def _actuators(robot: Robot, rows: Sequence[JointRow]) -> tuple[Literal["none", "position"], str]:
    if robot.actuators:
        return "none", "the actuators of the source stay"
    if not any(row.is_drivable for row in rows):
        return "none", "there is no joint to drive"
    return "position", "servos that hold a value, stiff enough for the robot's weight"


def _entries(
    robot: Robot, rows: Sequence[JointRow], base: str, has_masses: bool
) -> tuple[dict[str, Any], str]:
    """Returns entries of the key `actuators`, and the reason."""
    entries: dict[str, Any] = {}
    reasons = []
    mass = sum(link.inertial.mass for link in robot.links)
    if base == "legged" and has_masses and mass < _MIN_LEGGED_MASS:
        entries["*"] = {"kp": None, "kv": None}
        reasons.append(
            f"gains by the weight of the robot ({mass:.3g} kg): those of legged are for 13 kg and more"
        )
    wheels = [row.name for row in rows if row.is_drivable and WHEEL.search(row.name)]
    if wheels:
        entries |= {exact_glob(name): {"type": "velocity"} for name in wheels}
        reasons.append("wheels hold a speed")
    return entries, "; ".join(reasons)


def _geoms(robot: Robot, kind: str) -> tuple[dict[str, Any], str]:
    """Returns entries of the key `geoms` for a gripper, and the reason. Geoms of an MJCF have their own
    contact."""
    if kind == "mjcf":
        return {}, ""
    globs = {}
    for word in GRIPPER_WORDS:
        glob = f"*[{word[0].upper()}{word[0]}]{word[1:]}*"
        holders = [link.name for link in robot.links if _is_called(link, glob)]
        if holders:
            globs[glob] = holders
    names = name_list(name for holders in globs.values() for name in holders)
    reason = f"what a gripper holds neither slips nor spins; these links look like one: {names}"
    return {glob: {"collision": GRIPPER_CONTACT} for glob in globs}, reason if globs else ""


def _is_called(link: Link, glob: str) -> bool:
    """Tells whether a glob of the key `geoms` matches the link, or a part of it."""
    return any(fnmatchcase(name, glob) for name in _names(link))


def _names(link: Link) -> Iterator[str]:
    """Yields the names of a link and its parts."""
    yield link.name
    for part in link.parts:
        yield without_number(re.sub(r"^.*/", "", part.name))
