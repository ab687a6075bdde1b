"""What a URDF does not say of a robot, or not to all readers: its named poses, relations and loops."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.model.robot import Array, Loop, Robot
from linkwright.stages.robot.motion.start_pose import keyframes as named_poses
from linkwright.stages.show.live.rounding import rounded, vector

_POINTS = {"revolute": (0.0, 1.0), "ball": (0.0,)}
"""Of each type of loop the points on its axis that stay together, in levers from its origin."""


def with_poses(header: dict[str, Any], robot: Robot) -> dict[str, Any]:
    """The header of a URDF with the robot's keyframes, relations and loops. A loop that slides stays open:
    the page has no frames for it."""
    bodies = {body["name"]: index for index, body in enumerate(header["bodies"])}
    loops = [entry for loop in robot.loops for entry in _loop(loop, bodies)]
    return {
        **header,
        "keyframes": _keyframes(header, robot),
        "relations": _relations(header, robot),
        "loops": [*header["loops"], *loops],
    }


def _keyframes(header: dict[str, Any], robot: Robot) -> list[dict[str, Any]]:
    found = []
    for name, values in named_poses(robot).items():
        qpos = list(header["qpos0"])
        for joint in header["joints"]:
            value = values.get(joint["name"])
            if joint["unit"] and isinstance(value, int | float):
                qpos[joint["qpos"]] = rounded(value)
        found.append({"name": name, "qpos": qpos, "ctrl": [], "act": []})
    return found


def _relations(header: dict[str, Any], robot: Robot) -> list[dict[str, Any]]:
    """Those that MuJoCo reads of the URDF, which older versions do not, and the robot's others."""
    found = list(header["relations"])
    known = {one["follower"] for one in found}
    numbers = {joint["name"]: index for index, joint in enumerate(header["joints"]) if joint["unit"]}
    for one in robot.relations:
        follower, driver = numbers.get(one.follower), numbers.get(one.driver)
        if follower is not None and driver is not None and follower not in known:
            polynomial = [rounded(one.offset), rounded(one.multiplier), 0.0, 0.0, 0.0]
            found.append({"follower": follower, "driver": driver, "polynomial": polynomial})
    return found


def _loop(loop: Loop, bodies: Mapping[str, int]) -> list[dict[str, Any]]:
    if loop.link_a not in bodies or loop.link_b not in bodies:
        return []
    ends = [bodies[loop.link_a], bodies[loop.link_b]]
    frames = loop.a_from_frame, loop.b_from_frame
    if loop.type == "fixed":
        return [_entry(loop.name, "weld", ends, frames)]
    axis = loop.dofs[0].axis if loop.dofs else np.zeros(3)
    return [
        _entry(
            loop.name, "connect", ends, tuple(_moved(frame, share * loop.lever * axis) for frame in frames)
        )
        for share in _POINTS.get(loop.type, ())
    ]


def _moved(frame: Array, way: Array) -> Array:
    found = frame.copy()
    found[:3, 3] += frame[:3, :3] @ way
    return found


def _entry(name: str, kind: str, bodies: list[int], frames: tuple[Array, ...]) -> dict[str, Any]:
    first, second = (
        {"pos": vector(frame[:3, 3]), "quat": vector(_quaternion(frame[:3, :3]))} for frame in frames
    )
    return {"name": name, "type": kind, "bodies": bodies, "a_from": first, "b_from": second}


def _quaternion(turn: Array) -> Array:
    found: Array = np.zeros(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(turn).ravel())
    return found
