"""Writes the joints of a URDF: pose, axis, limits and damping."""

import math

from linkwright.stages.export.urdf.bodies import write_origin
from linkwright.stages.export.urdf.lowering import LoweredJoint
from linkwright.stages.formats.numbers import LENGTH, TURN, number, numbers, spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.robot import Limits

DEFAULT_EFFORT = 100.0
"""Effort [N m or N] of a joint without such a limit: URDF requires a number."""

DEFAULT_VELOCITY = 10.0
"""Velocity [rad/s or m/s] of a joint without such a limit: URDF requires a number."""

DEFAULT_REACH = {"revolute": 2 * math.pi, "prismatic": 1.0}
"""Type of a joint → distance [rad or m] of an open end of its range: URDF requires a number."""


def write_joint(root: Element, joint: LoweredJoint) -> Element:
    """Writes a joint with its pose and, if it has an axis, its axis, limits and dynamics. Returns its
    element."""
    node = element(root, "joint", name=joint.name, type=joint.type)
    write_origin(node, joint.parent_from_joint)
    element(node, "parent", link=joint.parent)
    element(node, "child", link=joint.child)
    if joint.axis is None:
        return node
    limits, dynamics = joint.limits, joint.dynamics
    element(node, "axis", xyz=spaced(joint.axis))
    low, high = (None, None) if joint.type == "continuous" else _range_texts(joint.type, limits)
    element(
        node,
        "limit",
        lower=low,
        upper=high,
        effort=number(DEFAULT_EFFORT if dynamics.effort is None else dynamics.effort),
        velocity=number(DEFAULT_VELOCITY if dynamics.velocity is None else dynamics.velocity),
    )
    if dynamics.damping is not None or dynamics.friction is not None:
        element(
            node,
            "dynamics",
            damping=number(dynamics.damping or 0.0),
            friction=number(dynamics.friction or 0.0),
        )
    return node


def _range_texts(kind: str, limits: Limits) -> list[str]:
    """Returns the texts of both ends of a joint's range. `kind`: its type in the URDF."""
    return numbers(_full_range(kind, limits), least=LENGTH if kind == "prismatic" else TURN)


def _full_range(kind: str, limits: Limits) -> tuple[float, float]:
    """Returns both ends [rad or m] of a joint's range. An open end is placed at `DEFAULT_REACH` from zero or
    from the other end, whichever makes the range larger."""
    reach = DEFAULT_REACH[kind]
    low, high = limits.lower, limits.upper
    if low is None:
        low = -reach if high is None else min(-reach, high - reach)
    if high is None:
        high = max(reach, low + reach)
    return low, high
