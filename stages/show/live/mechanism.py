"""Describes the bodies, joints, relations, loops, keyframes and frames for the header."""

from typing import Any

import mujoco
import numpy as np

from linkwright.stages.show.live.compiled import LiveModel
from linkwright.stages.show.live.rounding import rounded, rounded_list

_BODY, _JOINT, _SITE = mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_SITE
_TYPES = {
    mujoco.mjtJoint.mjJNT_FREE: "free",
    mujoco.mjtJoint.mjJNT_BALL: "ball",
    mujoco.mjtJoint.mjJNT_SLIDE: "slide",
    mujoco.mjtJoint.mjJNT_HINGE: "hinge",
}
_UNITS = {"hinge": "rad", "slide": "m"}
_LOOP_TYPES = {mujoco.mjtEq.mjEQ_CONNECT: "connect", mujoco.mjtEq.mjEQ_WELD: "weld"}


def bodies(live: LiveModel, links: dict[str, int]) -> list[dict[str, Any]]:
    """Returns all bodies in MuJoCo's order, the world first. `links`: the index of each link by its name."""
    model = live.model
    entries = []
    for index in range(model.nbody):
        name = live.name(_BODY, index) or f"body {index}"
        entries.append(
            {
                "name": name,
                "parent": int(model.body_parentid[index]),
                "pos": rounded_list(model.body_pos[index]),
                "quat": rounded_list(model.body_quat[index]),
                "mass": rounded(model.body_mass[index]),
                "com": rounded_list(model.body_ipos[index]),
                "inertia": {
                    "quat": rounded_list(model.body_iquat[index]),
                    "diagonal": rounded_list(model.body_inertia[index]),
                },
                "link": links.get(name) if index else None,
            }
        )
    return entries


def joints(live: LiveModel) -> list[dict[str, Any]]:
    """Returns all joints in MuJoCo's order, with their addresses in qpos and qvel; lengths in m, angles in
    rad."""
    model = live.model
    entries = []
    for index in range(model.njnt):
        kind = _TYPES[mujoco.mjtJoint(int(model.jnt_type[index]))]
        body = int(model.jnt_bodyid[index])
        qpos = int(model.jnt_qposadr[index])
        name = live.name(_JOINT, index)
        entries.append(
            {
                "name": name,
                "body": body,
                "type": kind,
                "pos": rounded_list(model.jnt_pos[index]),
                "axis": rounded_list(model.jnt_axis[index]),
                "range": rounded_list(model.jnt_range[index]) if model.jnt_limited[index] else None,
                "qpos": qpos,
                "dof": int(model.jnt_dofadr[index]),
                "ref": rounded(model.qpos0[qpos]) if kind in _UNITS else 0.0,
                "label": name or f"{live.name(_BODY, body) or f'body {body}'} ({kind})",
                "unit": _UNITS.get(kind, ""),
            }
        )
    return entries


def relations(live: LiveModel) -> list[dict[str, Any]]:
    """Returns MuJoCo's joint equalities: joints that follow another joint, or are fixed (`driver` null). The
    follower's change from its `ref` is a polynomial of the driver's change."""
    model = live.model
    return [
        {
            "follower": int(model.eq_obj1id[index]),
            "driver": int(model.eq_obj2id[index]) if model.eq_obj2id[index] >= 0 else None,
            "polynomial": rounded_list(model.eq_data[index, :5]),
        }
        for index in _active(model)
        if model.eq_type[index] == mujoco.mjtEq.mjEQ_JOINT
    ]


def loops(live: LiveModel) -> list[dict[str, Any]]:
    """Returns the connects and welds, each as two frames, one in each body, that coincide when the loop is
    closed.

    A connect only keeps points together: its second frame gets the orientation that the first frame has at
    the closed pose.
    """
    return [
        _loop(live, index)
        for index in _active(live.model)
        if mujoco.mjtEq(int(live.model.eq_type[index])) in _LOOP_TYPES
    ]


def _active(model: Any) -> list[int]:
    return [index for index in range(model.neq) if model.eq_active0[index]]


def _loop(live: LiveModel, index: int) -> dict[str, Any]:
    model = live.model
    kind = _LOOP_TYPES[mujoco.mjtEq(int(model.eq_type[index]))]
    ends = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
    values = model.eq_data[index]
    identity = np.array([1.0, 0, 0, 0])
    if model.eq_objtype[index] == _SITE:
        end_bodies = [int(model.site_bodyid[site]) for site in ends]
        end_frames = [(model.site_pos[site], model.site_quat[site]) for site in ends]
    else:
        end_bodies = list(ends)
        # For a weld MuJoCo keeps the second body's point first, then the first body's point and orientation
        # (mj_instantiateEquality); for a connect the first body's point first.
        first = (values[3:6], values[6:10]) if kind == "weld" else (values[0:3], identity)
        second = (values[0:3], identity) if kind == "weld" else (values[3:6], identity)
        end_frames = [first, second]
    if kind == "connect":
        end_frames[1] = (
            end_frames[1][0],
            _orientation_in(live, end_bodies[1], end_bodies[0], end_frames[0][1]),
        )
    return {
        "name": live.name(mujoco.mjtObj.mjOBJ_EQUALITY, index),
        "type": kind,
        "bodies": end_bodies,
        "a_from": {"pos": rounded_list(end_frames[0][0]), "quat": rounded_list(end_frames[0][1])},
        "b_from": {"pos": rounded_list(end_frames[1][0]), "quat": rounded_list(end_frames[1][1])},
    }


def _orientation_in(live: LiveModel, target: int, body: int, quat: Any) -> Any:
    """Converts an orientation (4,) relative to `body` to the same orientation relative to `target`, at the
    closed pose."""
    target_from_world, world_from_frame, target_from_frame = np.zeros(4), np.zeros(4), np.zeros(4)
    mujoco.mju_mulQuat(world_from_frame, live.closed_data.xquat[body], quat)
    mujoco.mju_negQuat(target_from_world, live.closed_data.xquat[target])
    mujoco.mju_mulQuat(target_from_frame, target_from_world, world_from_frame)
    return target_from_frame


def keyframes(live: LiveModel) -> list[dict[str, Any]]:
    """Returns the keyframes, `home` first."""
    model = live.model
    entries = [
        {
            "name": live.name(mujoco.mjtObj.mjOBJ_KEY, index) or f"keyframe {index}",
            "qpos": rounded_list(model.key_qpos[index]),
            "ctrl": rounded_list(model.key_ctrl[index]),
            "act": rounded_list(model.key_act[index]),
        }
        for index in range(model.nkey)
    ]
    return sorted(entries, key=lambda entry: entry["name"] != "home")


def frames(live: LiveModel) -> list[dict[str, Any]]:
    """Returns the sites: frames of the robot, and links without a body of their own."""
    model = live.model
    return [
        {
            "name": live.name(_SITE, index) or f"site {index}",
            "body": int(model.site_bodyid[index]),
            "pos": rounded_list(model.site_pos[index]),
            "quat": rounded_list(model.site_quat[index]),
        }
        for index in range(model.nsite)
    ]
