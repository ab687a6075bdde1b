"""Lists the joints of a robot, and what each of them lacks."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.show.graph_view.labels import limits, rules

WHEEL = re.compile("wheel", re.IGNORECASE)
"""Part of the names of joints that turn without end."""

_LIMIT_REACHES = {"turn": 1.57, "slide": 0.1}
"""Distance of proposed limits from the saved value [rad or m]."""

_EFFORTS = {"turn": 10, "slide": 100}
"""Proposed effort [N m or N]."""

_VELOCITIES = {"turn": 3, "slide": 0.2}
"""Proposed velocity [rad/s or m/s]."""

_UNITS = {"turn": "rad", "slide": "m", "ball": "rad", "free": ""}


@dataclass(frozen=True, slots=True)
class JointRow:
    """A coordinate of a joint; a joint with several has a row for each."""

    name: str
    """The name of the coordinate, by which the keys `joints` and `actuators` know it."""
    type: str
    kind: str
    """turn, slide, ball or free."""
    unit: str
    """The unit of `lower` and `upper`."""
    lower: float | None
    upper: float | None
    range: str
    """The limits in words: "-90..90 deg"."""
    follows: str
    """What it follows: "-1.5 × drive"; "" for an independent joint."""
    loop: bool
    """Whether it closes a loop, so that it is no joint of the tree."""
    missing: Mapping[str, Any]
    """Keys without a value in the source → a value to fill in."""
    note: str = ""
    """Why its limits are not known."""

    @property
    def is_drivable(self) -> bool:
        """Whether an actuator can drive it."""
        return self.kind in _LIMIT_REACHES and not self.follows and not self.loop

    @property
    def text(self) -> str:
        """Its range, or what it does instead of moving within one."""
        if self.loop:
            return "closes a loop"
        text = "no limits" if self.range == "free" and self.kind in _LIMIT_REACHES else self.range
        text = f"{text} ({self.note})" if self.note else text
        return f"{text}, follows: {self.follows}" if self.follows else text


def joint_table(robot: Robot, kind: str) -> tuple[JointRow, ...]:
    """Returns the rows of all joints that move, in tree order, and then those that close loops.

    `kind`: the kind of source. An MJCF may leave out effort and velocity on purpose, so there only limits can
    be missing."""
    followers = rules(robot)
    rows = [
        _row(dof, joint.type, followers.get(dof.name, ""), limits_only=kind == "mjcf")
        for joint in robot.joints
        for dof in joint.dofs
    ]
    loops = [JointRow(loop.name, loop.type, "", "", None, None, "", "", True, {}) for loop in robot.loops]
    return (*rows, *loops)


def _row(dof: Dof, joint_type: str, follows: str, *, limits_only: bool) -> JointRow:
    note = "not in the definition: a build asks for them" if dof.limits.origin.unknown else ""
    return JointRow(
        name=dof.name,
        type=joint_type,
        kind=dof.kind,
        unit=_UNITS[dof.kind],
        lower=dof.limits.lower,
        upper=dof.limits.upper,
        range=limits(dof),
        follows=follows,
        loop=False,
        missing={} if follows else _missing(dof, limits_only=limits_only),
        note=note,
    )


def _missing(dof: Dof, *, limits_only: bool) -> dict[str, Any]:
    """Returns the keys that the source gives no value, with values to fill in."""
    if dof.kind not in _LIMIT_REACHES or not isinstance(dof.saved, float):
        return {}
    keys: dict[str, Any] = {}
    is_unlimited = (dof.limits.lower, dof.limits.upper) == (None, None)
    if is_unlimited and not dof.limits.origin.unknown and not WHEEL.search(dof.name):
        middle = dof.mate_value.to_mate(dof.saved)
        reach = _LIMIT_REACHES[dof.kind]
        keys["limits"] = [round(middle - reach, 3), round(middle + reach, 3)]
    if limits_only:
        return keys
    if dof.dynamics.effort is None:
        keys["effort"] = _EFFORTS[dof.kind]
    if dof.dynamics.velocity is None:
        keys["velocity"] = _VELOCITIES[dof.kind]
    return keys
