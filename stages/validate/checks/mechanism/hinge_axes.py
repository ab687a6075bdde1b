"""Checks that the axis of each hinge passes near the links that it joins. An axis that misses both by far was
drawn, or edited, at another place."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.coordinates import HINGE
from linkwright.stages.validate.model.shapes import reach, seen_and_solid

MAX_DISTANCE_SHARE = 0.5
"""Largest distance of the axis from both links, as a share of the extent of the smaller link."""

DIRECTIONS = 48
"""Number of directions about the axis in which the hulls of the links are measured."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks the hinges between two links with shapes."""
    model = compiled.model
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    # Colliders reach as far as the visual shapes, but have few vertices, which takes less time.
    geoms = {body: solid or seen for body, (seen, solid) in seen_and_solid(model).items()}
    findings, worst, hinges = [], 0.0, 0
    for joint in range(model.njnt):
        child = int(model.jnt_bodyid[joint])
        parent = int(model.body_parentid[child])
        if model.jnt_type[joint] != HINGE or child not in geoms or parent not in geoms:
            continue
        hinges += 1
        axis_distance = min(_distance(model, data, joint, body, geoms[body]) for body in (child, parent))
        extent = min(_extent(model, geoms[body]) for body in (child, parent))
        worst = max(worst, axis_distance / extent if extent else 0.0)
        if axis_distance > MAX_DISTANCE_SHARE * extent:
            name, links = model.joint(joint).name, [model.body(body).name for body in (parent, child)]
            text = f"the axis of {name} passes {1e3 * axis_distance:.3g} mm outside {links[0]} and {links[1]}"
            findings.append((-axis_distance, Finding(named("joint", name), "pos", text)))
    if not hinges:
        return
    misses = [finding for _, finding in sorted(findings, key=lambda row: row[0])]
    detail = f"the axes of {count(hinges, 'hinge')} pass through the links that they join, or near them"
    if misses:
        detail = f"{len(misses)} of {count(hinges, 'hinge')} with an axis that misses both links"
    yield compiled.result("axes of hinges", not misses, detail, worst, MAX_DISTANCE_SHARE, misses, "warning")


def _distance(model: Any, data: Any, joint: int, body: int, geoms: Sequence[int]) -> float:
    """Returns the distance [m] of a joint's axis from the convex hull of a body's geoms, 0 if it passes
    through."""
    world_from_body = data.xmat[body].reshape(3, 3)
    anchor = world_from_body.T @ (data.xanchor[joint] - data.xpos[body])
    across = _directions_across(world_from_body.T @ data.xaxis[joint])
    # Seen along the axis, which is then a point, the hull contains the axis if it reaches beyond this point
    # in every direction.
    return max(0.0, -float((reach(model, geoms, across) - across @ anchor).min()))


def _directions_across(axis: Array) -> Array:
    """Returns `DIRECTIONS` unit vectors (n, 3) perpendicular to an axis (3,), evenly around it."""
    across = np.eye(3)[int(np.abs(axis).argmin())]
    first = np.cross(axis, across)
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    turns = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)
    return np.asarray(np.outer(np.cos(turns), first) + np.outer(np.sin(turns), second))


def _extent(model: Any, geoms: Sequence[int]) -> float:
    """Returns the diagonal of the box around a body's geoms [m]."""
    along = np.concatenate([np.eye(3), -np.eye(3)])
    reaches = reach(model, geoms, along)
    return float(np.linalg.norm(reaches[:3] + reaches[3:]))
