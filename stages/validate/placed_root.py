"""Where the MJCF of a folder has the robot, for the formats that say where it stands too."""

from pathlib import Path

import numpy as np

from stages.formats.xml import Malformed, parse
from stages.robot.amendments import Amendments
from stages.robot.model import Array, Robot
from stages.robot.poses import from_parts, rotation_from_quat

_OTHERS = {"axisangle", "xyaxes", "zaxis", "euler"}
"""Attributes that turn a body, and that this product does not write."""

_PLACE = {"pos", "quat", *_OTHERS}


def world_from_root(
    folder: Path, robot: Robot, amendments: Amendments, keyframe: str | None = None
) -> Array | None:
    """The pose (4, 4) of the root link in the MJCF; of a free robot in this keyframe, if it has it. None
    where the folder has no MJCF, it cannot be read, it has no such body, or the user's own XML moved that."""
    file, name = f"{robot.name}.xml", robot.root.name
    if any(one.target == f"body {name}" and _PLACE & {*one.sets} for one in amendments.of(file)):
        return None
    try:
        root = parse((folder / file).read_bytes())
        (body,) = [one for one in root.iterfind("worldbody/body") if one.get("name") == name]
        keys = [one for one in root.iterfind("keyframe/key") if one.get("name") == keyframe]
        if keys and not robot.base.fixed:
            numbers = np.array([float(word) for word in keys[0].get("qpos", "").split()][:7])
            place, turn = numbers[:3], numbers[3:]
        else:
            place, turn = (
                np.array([float(word) for word in body.get(key, unless).split()])
                for key, unless in (("pos", "0 0 0"), ("quat", "1 0 0 0"))
            )
    except (OSError, Malformed, ValueError):
        return None
    if place.shape != (3,) or turn.shape != (4,) or _OTHERS & {*body.keys()}:
        return None
    if not np.isfinite([*place, *turn]).all() or not turn.any():
        return None
    return from_parts(rotation_from_quat(turn / np.linalg.norm(turn)), place)
