"""Computes the gap of a loop, and the values of its own dofs, at poses of the links."""

import math
from collections.abc import Mapping

import numpy as np

from linkwright.stages.robot.model.poses import at_rest, inverse, quat_from_rotation
from linkwright.stages.robot.model.robot import Array, Dof, Loop, Value
from linkwright.stages.robot.motion.kinematics import chain

MAX_CLOSED_GAP = 1e-6
"""Largest gap [m, and rad] of a loop that counts as closed."""

POINTWISE_TYPES = frozenset({"fixed", "revolute", "ball"})
"""Types of loops that a simulation closes by holding points together: it has none of their dofs."""


def gap(loop: Loop, poses: Mapping[str, Array]) -> float:
    """Returns the gap of a loop at the links' `poses`: the larger of the offset [m] and the turn [rad, exact
    for small angles] that remain at the best values of its own dofs."""
    relative = relative_pose(loop, poses)
    remainder = inverse(chain(loop.dofs, closing_values(loop, relative))) @ relative
    # For a turn by a small angle, the norm of R − 1 is √2 times the angle.
    return max(
        math.hypot(*remainder[:3, 3]), float(np.linalg.norm(remainder[:3, :3] - np.eye(3))) / math.sqrt(2)
    )


def relative_pose(loop: Loop, poses: Mapping[str, Array]) -> Array:
    """Returns second_from_first (4, 4) of a loop's two frames at the links' `poses`."""
    return inverse(poses[loop.link_b] @ loop.b_from_frame) @ poses[loop.link_a] @ loop.a_from_frame


def closing_values(loop: Loop, second_from_first: Array) -> dict[str, Value]:
    """Returns the values of a loop's dofs whose chain comes closest to `second_from_first` (4, 4).

    A mate has at most one turn or ball, and slides do not rotate, so its value follows from the rotations
    alone. With this value, the offset is linear in the slides.
    """
    q: dict[str, Value] = {dof.name: at_rest(dof.kind) for dof in loop.dofs}
    for index, dof in enumerate(loop.dofs):
        if dof.kind != "slide":
            dof_frame = chain(loop.dofs[:index], q) @ dof.origin
            after = chain(loop.dofs[index + 1 :], q)
            q[dof.name] = _rotation(dof, dof_frame[:3, :3].T @ second_from_first[:3, :3] @ after[:3, :3].T)
    slides = [index for index, dof in enumerate(loop.dofs) if dof.kind == "slide"]
    if slides:
        frames = [chain(loop.dofs[:index], q) @ loop.dofs[index].origin for index in slides]
        directions = [
            frame[:3, :3] @ loop.dofs[index].axis for frame, index in zip(frames, slides, strict=True)
        ]
        offset = (second_from_first - chain(loop.dofs, q))[:3, 3]
        lengths = np.linalg.lstsq(np.column_stack(directions), offset, rcond=None)[0]
        q |= {loop.dofs[index].name: float(length) for index, length in zip(slides, lengths, strict=True)}
    return q


def _rotation(dof: Dof, rotation: Array) -> Value:
    """Returns the value of a turn or ball that comes closest to `rotation` (3, 3). Of the values of a turn,
    which differ by whole turns, it is the nearest to the saved value."""
    quat = quat_from_rotation(rotation)
    if isinstance(dof.saved, tuple):
        return tuple(float(number) for number in quat)
    angle = 2.0 * math.atan2(float(quat[1:] @ dof.axis), float(quat[0]))
    return angle + 2.0 * math.pi * round((dof.saved - angle) / (2.0 * math.pi))
