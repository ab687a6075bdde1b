"""Estimates mass properties from a part's triangles, for parts without mass properties."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.robot.bundle import ElementKey, OnshapeBundle
from linkwright.stages.robot.dynamics.inertia import solid_inertia
from linkwright.stages.robot.model.robot import Array, Inertial, frozen

Key = tuple[ElementKey, str]
"""A part studio and the id of a part in it."""

NET_AREA_TOLERANCE = 1e-6
"""Largest sum of the area vectors of a closed surface, as a share of its area: it is 0 except for
rounding."""

VOLUME_TOLERANCE = 0.1
"""Largest difference between the volume inside a closed surface and the volume in CAD, as a share of that."""


@dataclass(frozen=True, slots=True, eq=False)
class PartShape:
    """A part's shape with a mass of 1 kg, in the part's frame."""

    kind: Literal["solid", "ball", "shell"]
    """solid: from closed triangles; ball: a ball of the part's volume at the centre of the box around open
    triangles; shell: a sheet of no thickness on the triangles."""
    inertial: Inertial
    volume: float
    """Volume [m³] in CAD, else of the triangles; 0 for a shell."""


def shapes_of(bundle: OnshapeBundle, volumes: Iterable[tuple[Key, float | None]]) -> dict[Key, PartShape]:
    """Returns the shape of each part; parts without triangles are left out. `volumes`: parts with their
    volumes, as `shape_of` takes them."""
    replies = {studio.key: studio.tessellation for studio in bundle.studios}
    parts_by_reply: dict[str, dict[Key, float | None]] = {}
    for key, volume in volumes:
        reply = replies.get(key[0])
        if reply is not None:
            parts_by_reply.setdefault(reply, {})[key] = volume
    shapes = {}
    for reply, parts in parts_by_reply.items():
        bodies = body_arrays.decode(bundle.body(reply), {part for _, part in parts})
        for key, volume in parts.items():
            shape = shape_of(bodies[key[1]], volume) if key[1] in bodies else None
            if shape is not None:
                shapes[key] = shape
    return shapes


def shape_of(body: body_arrays.Body, volume: float | None) -> PartShape | None:
    """Returns the shape of a body; None if it has no triangles.

    `volume` [m³]: volume in CAD; 0 if it is unknown, None if the body is a sheet.
    """
    corners = body.points[body.triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    sizes = np.linalg.norm(areas, axis=1)
    if not sizes.sum() > 0:
        return None
    if volume is None:
        return PartShape("shell", _shell(corners, sizes), 0.0)
    # The areas of a closed surface add up to nothing, however its triangles are joined.
    if np.linalg.norm(areas.sum(axis=0)) <= NET_AREA_TOLERANCE * sizes.sum():
        solid = _solid_shape(body, volume)
        if solid is not None:
            return solid
    if volume > 0:
        return PartShape("ball", _ball(body.points[body.triangles.ravel()], volume), volume)
    return PartShape("shell", _shell(corners, sizes), 0.0)


def _solid_shape(body: body_arrays.Body, volume: float) -> PartShape | None:
    try:
        solid = solid_inertia(body.points, body.triangles, 1.0)
    except ValueError:
        return None
    if volume > 0 and abs(solid.mass - volume) > VOLUME_TOLERANCE * volume:
        return None
    unit = Inertial(1.0, solid.com, frozen(solid.inertia / solid.mass))
    return PartShape("solid", unit, volume or solid.mass)


def _ball(points: Array, volume: float) -> Inertial:
    """Returns the inertial of a ball: I = 2/5 m r²."""
    radius = (3 * volume / (4 * math.pi)) ** (1 / 3)
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    return Inertial(1.0, frozen(centre), frozen(2 / 5 * radius**2 * np.eye(3)))


def _shell(corners: npt.NDArray[np.float64], sizes: Array) -> Inertial:
    """Returns the inertial of 1 kg that is spread evenly over triangles (m, 3, 3) of areas `sizes` (m,).

    A triangle with corners a, b, c has ∫x xᵀ dA = A/12 (a aᵀ + b bᵀ + c cᵀ + s sᵀ), s = a + b + c.
    """
    shares = sizes / sizes.sum()
    com = shares @ corners.mean(axis=1)
    arms = corners - com
    sums = arms.sum(axis=1)
    second_moment = np.einsum("i,ikj,ikl->jl", shares, arms, arms) + np.einsum(
        "i,ij,il->jl", shares, sums, sums
    )
    second_moment /= 12
    return Inertial(1.0, frozen(com), frozen(np.trace(second_moment) * np.eye(3) - second_moment))
