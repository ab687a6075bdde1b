"""Estimates mass properties from a part's triangles, for parts without mass properties."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats import triangles
from linkwright.stages.robot.bundle import OnshapeBundle, StudioKey
from linkwright.stages.robot.dynamics.inertia import solid_inertia
from linkwright.stages.robot.model.robot import Array, Inertial, frozen

Key = tuple[StudioKey, str]
"""A part studio and the id of a part in it."""

CLOSED = 1e-6
"""The largest net area of a closed surface, as a share of its area."""

SAME_VOLUME = 0.1
"""How far the volume inside a closed surface may be from CAD's, as a share of that."""


@dataclass(frozen=True, slots=True, eq=False)
class PartShape:
    """A part's shape with a mass of 1 kg, in the part's frame.

    A solid has closed triangles; a ball has the volume, at the middle of the box around them, where
    they are open; a shell is as thin as a sheet. `volume` [m³] is CAD's, else the triangles'; 0 for a
    shell.
    """

    kind: Literal["solid", "ball", "shell"]
    inertial: Inertial
    volume: float


def shapes_of(bundle: OnshapeBundle, volumes: Iterable[tuple[Key, float | None]]) -> dict[Key, PartShape]:
    """The shapes of parts, each with what `shape_of` takes as its volume; no triangles, no shape."""
    replies = {studio.key: studio.tessellation for studio in bundle.studios}
    wanted: dict[str, dict[Key, float | None]] = {}
    for key, volume in volumes:
        reply = replies.get(key[0])
        if reply is not None:
            wanted.setdefault(reply, {})[key] = volume
    found = {}
    for reply, parts in wanted.items():
        bodies = triangles.decode(bundle.body(reply), {part for _, part in parts})
        for key, volume in parts.items():
            shape = shape_of(bodies[key[1]], volume) if key[1] in bodies else None
            if shape is not None:
                found[key] = shape
    return found


def shape_of(body: triangles.Body, volume: float | None) -> PartShape | None:
    """The shape of a body with CAD's `volume` [m³], 0 if that is not known, None if the body is a sheet.

    None where there are no triangles.
    """
    corners = body.points[body.triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    sizes = np.linalg.norm(areas, axis=1)
    if not sizes.sum() > 0:
        return None
    if volume is None:
        return PartShape("shell", _shell(corners, sizes), 0.0)
    # The areas of a closed surface add up to nothing, however its triangles are joined.
    if np.linalg.norm(areas.sum(axis=0)) <= CLOSED * sizes.sum():
        solid = _solid(body, volume)
        if solid is not None:
            return solid
    if volume > 0:
        return PartShape("ball", _ball(body.points[body.triangles.ravel()], volume), volume)
    return PartShape("shell", _shell(corners, sizes), 0.0)


def _solid(body: triangles.Body, volume: float) -> PartShape | None:
    try:
        whole = solid_inertia(body.points, body.triangles, 1.0)
    except ValueError:
        return None
    if volume > 0 and abs(whole.mass - volume) > SAME_VOLUME * volume:
        return None
    unit = Inertial(1.0, whole.com, frozen(whole.inertia / whole.mass))
    return PartShape("solid", unit, volume or whole.mass)


def _ball(points: Array, volume: float) -> Inertial:
    """I = 2/5 m r²."""
    radius = (3 * volume / (4 * math.pi)) ** (1 / 3)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return Inertial(1.0, frozen(middle), frozen(2 / 5 * radius**2 * np.eye(3)))


def _shell(corners: npt.NDArray[np.float64], sizes: Array) -> Inertial:
    """Even matter over triangles (m, 3, 3) of areas `sizes` (m,).

    One with corners a, b, c has ∫x xᵀ dA = A/12 (a aᵀ + b bᵀ + c cᵀ + s sᵀ), s = a + b + c.
    """
    shares = sizes / sizes.sum()
    com = shares @ corners.mean(axis=1)
    arms = corners - com
    sums = arms.sum(axis=1)
    second = np.einsum("i,ikj,ikl->jl", shares, arms, arms) + np.einsum("i,ij,il->jl", shares, sums, sums)
    second /= 12
    return Inertial(1.0, frozen(com), frozen(np.trace(second) * np.eye(3) - second))
