"""Poses as MJCF attributes."""

import numpy as np

from stages.formats.numbers import spaced
from stages.robot.model import Array
from stages.robot.poses import quat_from_rotation


def placement(pose: Array) -> dict[str, str]:
    """`pos` and `quat` of a (4, 4) pose; identity is left out."""
    out = {}
    # Below a tenth of a picometre a position is the noise of its making.
    position = spaced(pose[:3, 3], max(0.1, float(np.abs(pose[:3, 3]).max())))
    if position != "0 0 0":
        out["pos"] = position
    quat = spaced(quat_from_rotation(pose[:3, :3]))
    if quat != "1 0 0 0":
        out["quat"] = quat
    return out
