"""The bodies, joints, relations and loops of the header, and its keyframes, actuators and frames."""

from typing import Any

import mujoco
import numpy as np

from linkwright.stages.show.live.compiled import LiveModel
from linkwright.stages.show.live.rounding import rounded, vector

_BODY, _JOINT, _SITE = mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_SITE
_TYPES = {
    mujoco.mjtJoint.mjJNT_FREE: "free",
    mujoco.mjtJoint.mjJNT_BALL: "ball",
    mujoco.mjtJoint.mjJNT_SLIDE: "slide",
    mujoco.mjtJoint.mjJNT_HINGE: "hinge",
}
_UNITS = {"hinge": "rad", "slide": "m"}
_LOOPS = {mujoco.mjtEq.mjEQ_CONNECT: "connect", mujoco.mjtEq.mjEQ_WELD: "weld"}


def bodies(live: LiveModel, links: dict[str, int]) -> list[dict[str, Any]]:
    """Every body in MuJoCo's order, the world first. `links`: the index of each link by its name."""
    model = live.model
    found = []
    for index in range(model.nbody):
        name = live.name(_BODY, index) or f"body {index}"
        found.append(
            {
                "name": name,
                "parent": int(model.body_parentid[index]),
                "pos": vector(model.body_pos[index]),
                "quat": vector(model.body_quat[index]),
                "mass": rounded(model.body_mass[index]),
                "com": vector(model.body_ipos[index]),
                "inertia": {
                    "quat": vector(model.body_iquat[index]),
                    "diagonal": vector(model.body_inertia[index]),
                },
                "link": links.get(name) if index else None,
            }
        )
    return found


def joints(live: LiveModel) -> list[dict[str, Any]]:
    """Every joint in MuJoCo's order, with its addresses in qpos and qvel; lengths in m, angles in rad."""
    model = live.model
    found = []
    for index in range(model.njnt):
        kind = _TYPES[mujoco.mjtJoint(int(model.jnt_type[index]))]
        body = int(model.jnt_bodyid[index])
        qpos = int(model.jnt_qposadr[index])
        name = live.name(_JOINT, index)
        found.append(
            {
                "name": name,
                "body": body,
                "type": kind,
                "pos": vector(model.jnt_pos[index]),
                "axis": vector(model.jnt_axis[index]),
                "range": vector(model.jnt_range[index]) if model.jnt_limited[index] else None,
                "qpos": qpos,
                "dof": int(model.jnt_dofadr[index]),
                "ref": rounded(model.qpos0[qpos]) if kind in _UNITS else 0.0,
                "label": name or f"{live.name(_BODY, body) or f'body {body}'} ({kind})",
                "unit": _UNITS.get(kind, ""),
            }
        )
    return found


def relations(live: LiveModel) -> list[dict[str, Any]]:
    """The joints that follow another one, or (`driver` null) stand still, as MuJoCo's joint equalities: the
    follower's way from its `ref` is a polynomial of the driver's."""
    model = live.model
    return [
        {
            "follower": int(model.eq_obj1id[index]),
            "driver": int(model.eq_obj2id[index]) if model.eq_obj2id[index] >= 0 else None,
            "polynomial": vector(model.eq_data[index, :5]),
        }
        for index in _active(model)
        if model.eq_type[index] == mujoco.mjtEq.mjEQ_JOINT
    ]


def loops(live: LiveModel) -> list[dict[str, Any]]:
    """The connects and welds: two frames, one fixed in each body, that coincide where the loop is closed.

    A connect keeps points together; its second frame has the orientation that the first one has at the
    closed pose.
    """
    return [
        _loop(live, index)
        for index in _active(live.model)
        if mujoco.mjtEq(int(live.model.eq_type[index])) in _LOOPS
    ]


def _active(model: Any) -> list[int]:
    return [index for index in range(model.neq) if model.eq_active0[index]]


def _loop(live: LiveModel, index: int) -> dict[str, Any]:
    model = live.model
    kind = _LOOPS[mujoco.mjtEq(int(model.eq_type[index]))]
    ends = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
    values = model.eq_data[index]
    identity = np.array([1.0, 0, 0, 0])
    if model.eq_objtype[index] == _SITE:
        bodies = [int(model.site_bodyid[site]) for site in ends]
        frames = [(model.site_pos[site], model.site_quat[site]) for site in ends]
    else:
        bodies = list(ends)
        # Of a weld MuJoCo keeps the second body's point first, then the first body's point and orientation
        # (mj_instantiateEquality); of a connect the first body's point first.
        first = (values[3:6], values[6:10]) if kind == "weld" else (values[0:3], identity)
        second = (values[0:3], identity) if kind == "weld" else (values[3:6], identity)
        frames = [first, second]
    if kind == "connect":
        frames[1] = (frames[1][0], _seen_from(live, bodies[1], bodies[0], frames[0][1]))
    return {
        "name": live.name(mujoco.mjtObj.mjOBJ_EQUALITY, index),
        "type": kind,
        "bodies": bodies,
        "a_from": {"pos": vector(frames[0][0]), "quat": vector(frames[0][1])},
        "b_from": {"pos": vector(frames[1][0]), "quat": vector(frames[1][1])},
    }


def _seen_from(live: LiveModel, other: int, body: int, quat: Any) -> Any:
    """An orientation in `body` as `other` has it at the closed pose."""
    inverse, world, found = np.zeros(4), np.zeros(4), np.zeros(4)
    mujoco.mju_mulQuat(world, live.closed.xquat[body], quat)
    mujoco.mju_negQuat(inverse, live.closed.xquat[other])
    mujoco.mju_mulQuat(found, inverse, world)
    return found


def keyframes(live: LiveModel) -> list[dict[str, Any]]:
    """The keyframes, `home` first."""
    model = live.model
    found = [
        {
            "name": live.name(mujoco.mjtObj.mjOBJ_KEY, index) or f"keyframe {index}",
            "qpos": vector(model.key_qpos[index]),
            "ctrl": vector(model.key_ctrl[index]),
            "act": vector(model.key_act[index]),
        }
        for index in range(model.nkey)
    ]
    return sorted(found, key=lambda one: one["name"] != "home")


def frames(live: LiveModel) -> list[dict[str, Any]]:
    """The sites: frames of the robot, and links that are one body with another link."""
    model = live.model
    return [
        {
            "name": live.name(_SITE, index) or f"site {index}",
            "body": int(model.site_bodyid[index]),
            "pos": vector(model.site_pos[index]),
            "quat": vector(model.site_quat[index]),
        }
        for index in range(model.nsite)
    ]
