"""Reads the frames and the cameras on the bodies of a USD, in metres."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import UsdGeom

from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array

_PRIM_FROM_IMAGE = np.diag([1.0, -1.0, -1.0, 1.0])
"""prim_from_image (4, 4): a camera of USD looks along −z, with y up; a camera of the robot along z, with y
down."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdPlace:
    """A frame or a camera on a body."""

    body_from_place: Array
    """The pose (4, 4) on the body; a camera has the robot's axes."""

    fovy: float = 0.0
    """The vertical field of view [deg] of a camera; 0 for a frame."""

    aspect: float = 0.0
    """The width of a camera's image divided by its height; 0 for a frame."""


def places_of(body: Any) -> Iterator[tuple[str, ReadUsdPlace]]:
    """Yields the frames and cameras of a body, with the names of their prims."""
    cache = UsdGeom.XformCache()
    # USD's matrices act on rows.
    body_from_world = inverse(np.array(cache.GetLocalToWorldTransform(body)).T)
    for prim in body.GetChildren():
        body_from_prim = body_from_world @ np.array(cache.GetLocalToWorldTransform(prim)).T
        if prim.IsA(UsdGeom.Camera):
            yield prim.GetName(), _camera(UsdGeom.Camera(prim), body_from_prim @ _PRIM_FROM_IMAGE)
        elif prim.GetTypeName() == "Xform":
            yield prim.GetName(), ReadUsdPlace(body_from_prim)


def _camera(camera: Any, body_from_image: Array) -> ReadUsdPlace:
    """Reads a camera with the axes of the robot's cameras at a pose (4, 4) on its body."""
    focal_length, height, width = (
        float(attribute.Get())
        for attribute in (
            camera.GetFocalLengthAttr(),
            camera.GetVerticalApertureAttr(),
            camera.GetHorizontalApertureAttr(),
        )
    )
    fovy = math.degrees(2 * math.atan2(height, 2 * focal_length))
    return ReadUsdPlace(body_from_image, fovy, width / height if height else math.inf)
