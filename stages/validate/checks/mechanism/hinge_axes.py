"""The axis of each hinge passes near what it joins: one that misses both links by far was drawn, or edited,
at another place."""

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

SHARE = 0.5
"""Of the extent of the smaller link: how far the axis may be outside both."""

AROUND = 48
"""Directions about the axis in which the hulls of the links are measured."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of hinges between links that both have shapes."""
    model = compiled.model
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    # A link's colliders have few vertices, and reach as far as what is seen of it.
    geoms = {body: solid or seen for body, (seen, solid) in seen_and_solid(model).items()}
    findings, worst, hinges = [], 0.0, 0
    for joint in range(model.njnt):
        child = int(model.jnt_bodyid[joint])
        parent = int(model.body_parentid[child])
        if model.jnt_type[joint] != HINGE or child not in geoms or parent not in geoms:
            continue
        hinges += 1
        away = min(_distance(model, data, joint, body, geoms[body]) for body in (child, parent))
        extent = min(_extent(model, geoms[body]) for body in (child, parent))
        worst = max(worst, away / extent if extent else 0.0)
        if away > SHARE * extent:
            name, links = model.joint(joint).name, [model.body(body).name for body in (parent, child)]
            text = f"the axis of {name} passes {1e3 * away:.3g} mm outside {links[0]} and {links[1]}"
            findings.append((-away, Finding(named("joint", name), "pos", text)))
    if not hinges:
        return
    found = [one for _, one in sorted(findings, key=lambda pair: pair[0])]
    detail = f"the axes of {count(hinges, 'hinge')} pass through what they join, or near it"
    if found:
        detail = f"{len(found)} of {count(hinges, 'hinge')} with an axis that misses both links"
    yield compiled.result("axes of hinges", not found, detail, worst, SHARE, found, "warning")


def _distance(model: Any, data: Any, joint: int, body: int, geoms: Sequence[int]) -> float:
    """How far a joint's axis is outside the convex hull of a body's geoms [m], 0 where it passes through."""
    world_from_body = data.xmat[body].reshape(3, 3)
    anchor = world_from_body.T @ (data.xanchor[joint] - data.xpos[body])
    across = _around(world_from_body.T @ data.xaxis[joint])
    # Seen along the axis the hull is where, in each direction, it reaches beyond the point that the axis is.
    return max(0.0, -float((reach(model, geoms, across) - across @ anchor).min()))


def _around(axis: Array) -> Array:
    """Unit vectors (N, 3) across an axis."""
    some = np.eye(3)[int(np.abs(axis).argmin())]
    first = np.cross(axis, some)
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    turns = np.arange(AROUND) * (2.0 * math.pi / AROUND)
    return np.asarray(np.outer(np.cos(turns), first) + np.outer(np.sin(turns), second))


def _extent(model: Any, geoms: Sequence[int]) -> float:
    """The diagonal of the box around a body's geoms [m]."""
    along = np.concatenate([np.eye(3), -np.eye(3)])
    reaches = reach(model, geoms, along)
    return float(np.linalg.norm(reaches[:3] + reaches[3:]))
