"""Adds the robot's named poses, relations and loops to the header of a URDF."""

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.robot.model.robot import Array, Loop, Robot
from linkwright.stages.robot.motion.start_pose import keyframes as named_poses
from linkwright.stages.show.live.rounding import rounded, rounded_list

_LEVERS_OF_POINTS = {"revolute": (0.0, 1.0), "ball": (0.0,)}
"""Type of loop → the points of its axis that stay together, at these multiples of the loop's lever [m]."""


def with_poses_and_constraints(header: dict[str, Any], robot: Robot) -> dict[str, Any]:
    """Returns the `header` of a URDF, as `scene._head` makes it, with the robot's keyframes, relations and
    loops. Loops with a slide are left out, and stay open: no points of theirs stay together."""
    bodies = {body["name"]: index for index, body in enumerate(header["bodies"])}
    loops = [entry for loop in robot.loops for entry in _loop_entries(loop, bodies)]
    return {
        **header,
        "keyframes": _keyframes(header, robot),
        "relations": _relations(header, robot),
        "loops": [*header["loops"], *loops],
    }


def _keyframes(header: dict[str, Any], robot: Robot) -> list[dict[str, Any]]:
    entries = []
    for name, values in named_poses(robot).items():
        qpos = list(header["qpos0"])
        for joint in header["joints"]:
            value = values.get(joint["name"])
            # Only hinges and slides have a unit, and a single value.
            if joint["unit"] and isinstance(value, int | float):
                qpos[joint["qpos"]] = rounded(value)
        entries.append({"name": name, "qpos": qpos, "ctrl": [], "act": []})
    return entries


def _relations(header: dict[str, Any], robot: Robot) -> list[dict[str, Any]]:
    """Returns the relations that MuJoCo has read from the URDF (older versions read none), and the other
    relations of the robot."""
    entries = list(header["relations"])
    followers = {entry["follower"] for entry in entries}
    joint_indices = {joint["name"]: index for index, joint in enumerate(header["joints"]) if joint["unit"]}
    for relation in robot.relations:
        follower, driver = joint_indices.get(relation.follower), joint_indices.get(relation.driver)
        if follower is not None and driver is not None and follower not in followers:
            polynomial = [rounded(relation.offset), rounded(relation.multiplier), 0.0, 0.0, 0.0]
            entries.append({"follower": follower, "driver": driver, "polynomial": polynomial})
    return entries


def _loop_entries(loop: Loop, bodies: Mapping[str, int]) -> list[dict[str, Any]]:
    if loop.link_a not in bodies or loop.link_b not in bodies:
        return []
    ends = [bodies[loop.link_a], bodies[loop.link_b]]
    frames = loop.a_from_frame, loop.b_from_frame
    if loop.type == "fixed":
        return [_equality_entry(loop.name, "weld", ends, frames)]
    # The first dof of a revolute loop is its turn; a ball's point is on every axis.
    axis = loop.dofs[0].axis if loop.dofs else np.zeros(3)
    return [
        _equality_entry(
            loop.name,
            "connect",
            ends,
            tuple(_shifted(frame, lever_count * loop.lever * axis) for frame in frames),
        )
        for lever_count in _LEVERS_OF_POINTS.get(loop.type, ())
    ]


def _shifted(frame: Array, shift: Array) -> Array:
    """Returns a pose (4, 4) moved by `shift` (3,) [m] along its own axes."""
    shifted_frame = frame.copy()
    shifted_frame[:3, 3] += frame[:3, :3] @ shift
    return shifted_frame


def _equality_entry(name: str, kind: str, bodies: list[int], frames: tuple[Array, ...]) -> dict[str, Any]:
    first, second = (
        {"pos": rounded_list(frame[:3, 3]), "quat": rounded_list(_quaternion(frame[:3, :3]))}
        for frame in frames
    )
    return {"name": name, "type": kind, "bodies": bodies, "a_from": first, "b_from": second}


def _quaternion(rotation: Array) -> Array:
    """Returns MuJoCo's quaternion (4,), w first, of a rotation (3, 3)."""
    quat: Array = np.zeros(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(rotation).ravel())
    return quat
