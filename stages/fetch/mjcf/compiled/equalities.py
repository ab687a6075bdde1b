"""Reads the equalities of a compiled model that our robot model has: loops, and joints that follow another
joint."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.mjcf.model import MjcfClosure, MjcfRelation
from linkwright.stages.formats.numbers import exact
from linkwright.stages.mujoco.bodies import pose_of
from linkwright.stages.mujoco.fields import EQUALITY, attributes
from linkwright.stages.mujoco.names import OBJ
from linkwright.stages.robot.model.mjcf_extras import Attributes
from linkwright.stages.robot.model.robot import frozen

_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
"""The quaternion of no rotation."""


def is_carried_over(model: Any, eq: int, robot_bodies: Collection[int]) -> bool:
    """Tells whether our robot model can represent an equality: a connect, a weld, or a joint that follows
    another in proportion, between bodies that are kept."""
    kind, first, second = (int(model.eq_type[eq]), int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq]))
    if not model.eq_active0[eq]:
        return False
    if kind == mujoco.mjtEq.mjEQ_JOINT:
        is_proportional = second >= 0 and model.eq_data[eq][1] != 0 and not model.eq_data[eq][2:5].any()
        return is_proportional and all(
            int(model.jnt_bodyid[joint]) in robot_bodies for joint in (first, second)
        )
    if kind not in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
        return False
    if model.eq_objtype[eq] == OBJ.mjOBJ_SITE:
        first, second = int(model.site_bodyid[first]), int(model.site_bodyid[second])
    return first in robot_bodies and second in robot_bodies


def _attributes(model: Any, eq: int) -> Attributes:
    """Returns the attributes of an equality; solref and solimp also if they are MuJoCo's defaults, since our
    defaults are stiffer."""
    stiffness = attributes(model, EQUALITY, eq, always=("solref", "solimp"))
    scale = float(model.eq_data[eq][10])
    is_weld = int(model.eq_type[eq]) == mujoco.mjtEq.mjEQ_WELD
    return (*stiffness, ("torquescale", exact([scale]))) if is_weld and scale != 1 else stiffness


def closures(model: Any, body_numbers: Mapping[int, int]) -> Iterator[MjcfClosure]:
    """Yields connects and welds. Without sites, `eq_data` of a connect has the point in the first body, then
    in the second; `eq_data` of a weld has the point in the second body, then in the first, then
    first_from_second as a quaternion."""
    for eq in range(model.neq):
        kind = int(model.eq_type[eq])
        if kind == mujoco.mjtEq.mjEQ_JOINT or not is_carried_over(model, eq, body_numbers):
            continue
        ends = int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq])
        by_sites = model.eq_objtype[eq] == OBJ.mjOBJ_SITE
        bodies = tuple(int(model.site_bodyid[end]) for end in ends) if by_sites else ends
        data = model.eq_data[eq]
        sites = ("", "")
        if by_sites:
            sites = (model.site(ends[0]).name, model.site(ends[1]).name)
            frames = [pose_of(model.site_pos[end], model.site_quat[end]) for end in ends]
        elif kind == mujoco.mjtEq.mjEQ_CONNECT:
            frames = [pose_of(data[0:3], _IDENTITY), pose_of(data[3:6], _IDENTITY)]
        else:
            frames = [pose_of(data[3:6], data[6:10]), pose_of(data[0:3], _IDENTITY)]
        yield MjcfClosure(
            name=model.equality(eq).name,
            type="connect" if kind == mujoco.mjtEq.mjEQ_CONNECT else "weld",
            bodies=(body_numbers[bodies[0]], body_numbers[bodies[1]]),
            sites=sites,
            a_from_frame=frozen(frames[0]),
            b_from_frame=frozen(frames[1]),
            attributes=_attributes(model, eq),
        )


def relations(
    model: Any, body_numbers: Mapping[int, int], order: Mapping[int, int]
) -> Iterator[MjcfRelation]:
    """Yields linear joint equalities: y − y₀ = a₀ + a₁ (x − x₀)."""
    for eq in range(model.neq):
        if model.eq_type[eq] != mujoco.mjtEq.mjEQ_JOINT or not is_carried_over(model, eq, body_numbers):
            continue
        follower, driver = int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq])
        y, x = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (follower, driver))
        constant, slope = (float(value) for value in model.eq_data[eq][:2])
        offset, equality_attributes = y + constant - slope * x, _attributes(model, eq)
        yield MjcfRelation(
            model.equality(eq).name, order[follower], order[driver], slope, offset, equality_attributes
        )
