"""Reads the frames and the cameras on the bodies of a USD, in metres and radians."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import UsdGeom

from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array

_IMAGE = np.diag([1.0, -1.0, -1.0, 1.0])
"""prim_from_image (4, 4): cameras of USD look along −z, with y up; ours along z, with y down."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadUsdPlace:
    """A frame or a camera: where it is on its body (4, 4); a camera as ours are. `fovy`: the vertical field
    of view of a camera [deg], and `aspect` its width by its height; 0 of a frame."""

    body_from_place: Array
    fovy: float = 0.0
    aspect: float = 0.0


def places_of(body: Any) -> Iterator[tuple[str, ReadUsdPlace]]:
    """By the names of their prims."""
    cache = UsdGeom.XformCache()
    body_from_world = inverse(np.array(cache.GetLocalToWorldTransform(body)).T)
    for prim in body.GetChildren():
        pose = body_from_world @ np.array(cache.GetLocalToWorldTransform(prim)).T
        if prim.IsA(UsdGeom.Camera):
            yield prim.GetName(), _camera(UsdGeom.Camera(prim), pose @ _IMAGE)
        elif prim.GetTypeName() == "Xform":
            yield prim.GetName(), ReadUsdPlace(pose)


def _camera(camera: Any, pose: Array) -> ReadUsdPlace:
    focal, height, width = (
        float(one.Get())
        for one in (
            camera.GetFocalLengthAttr(),
            camera.GetVerticalApertureAttr(),
            camera.GetHorizontalApertureAttr(),
        )
    )
    fovy = math.degrees(2 * math.atan2(height, 2 * focal))
    return ReadUsdPlace(pose, fovy, width / height if height else math.inf)
