"""robot.json: the model, neutral, with the way back to CAD."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from stages.export.urdf import unset
from stages.robot.model import Array, Joint, Link, Loop, Robot
from stages.robot.numbers import number, numbers
from stages.robot.poses import quat_from_rotation

FORMAT = "linkwright-robot"


def describe(robot: Robot, start: Mapping[str, float]) -> bytes:
    """Links, joints, loops, relations and frames; `start` is the MJCF's qpos0 (rad or m).

    Poses are {xyz [m], quat (w, x, y, z)}; inertia is the 3x3 tensor about the centre of mass in
    the link's axes [kg m²].
    """
    table = {
        "format": FORMAT,
        "version": 1,
        "name": robot.name,
        "source": {
            "document": robot.provenance.document,
            "element": robot.provenance.element,
            "microversion": robot.provenance.microversion,
            "configuration": robot.provenance.configuration,
        },
        "root": robot.root.name,
        "base": {"fixed": robot.base.fixed, "reason": robot.base.reason},
        "mass": _float(sum(link.inertial.mass for link in robot.links)),
        "links": [_link(link) for link in robot.links],
        "joints": [_joint(joint, start[joint.name]) for joint in robot.joints],
        "relations": [
            {
                "name": relation.name,
                "follower": relation.follower,
                "driver": relation.driver,
                "multiplier": _float(relation.multiplier),
                "offset": _float(relation.offset),
            }
            for relation in robot.relations
        ],
        "loops": [_loop(loop) for loop in robot.loops],
        "frames": [
            {
                "name": frame.name,
                "link": frame.link,
                "pose": _pose(frame.link_from_frame),
                "cad": {"name": frame.source},
            }
            for frame in robot.frames
        ],
    }
    return (json.dumps(table, indent=2, ensure_ascii=False) + "\n").encode()


def _float(value: float | None, scale: float | None = None) -> float | None:
    return None if value is None else float(number(value, scale))


def _floats(values: Array) -> Any:
    """Nested lists of the array's shape, each number as short as the formatter makes it."""
    return np.array([float(text) for text in numbers(values)]).reshape(np.shape(values)).tolist()


def _pose(pose: Array) -> dict[str, Any]:
    return {"xyz": _floats(pose[:3, 3]), "quat": _floats(quat_from_rotation(pose[:3, :3]))}


def _link(link: Link) -> dict[str, Any]:
    return {
        "name": link.name,
        "mass": _float(link.inertial.mass),
        "com": _floats(link.inertial.com),
        "inertia": _floats(link.inertial.inertia),
        "cad": {"path": list(link.path)},
        "parts": [
            {
                "name": part.name,
                "path": list(part.path),
                "part": part.part_id,
                "mass": _float(part.inertial.mass),
                "pose": _pose(part.link_from_part),
            }
            for part in link.parts
        ],
    }


def _joint(joint: Joint, start: float) -> dict[str, Any]:
    return {
        "name": joint.name,
        "type": joint.type,
        "parent": joint.parent,
        "child": joint.child,
        "origin": _pose(joint.parent_from_joint),
        "axis": _floats(joint.axis),
        "limits": [_float(joint.limits.lower), _float(joint.limits.upper)],
        "damping": _float(joint.dynamics.damping),
        "friction": _float(joint.dynamics.friction),
        "armature": _float(joint.dynamics.armature),
        "effort": _float(joint.dynamics.effort),
        "velocity": _float(joint.dynamics.velocity),
        "unset": unset(joint),
        "saved": _float(joint.saved, max(1.0, abs(joint.saved))),
        "qpos0": _float(start, max(1.0, abs(start))),
        "cad": _mate(joint),
    }


def _mate(joint: Joint | Loop) -> dict[str, Any]:
    mate = joint.mate
    return {"owner": list(mate.owner), "feature": mate.feature, "name": mate.name, "type": mate.type}


def _loop(loop: Loop) -> dict[str, Any]:
    return {
        "name": loop.name,
        "type": loop.type,
        "link_a": loop.link_a,
        "link_b": loop.link_b,
        "frame_a": _pose(loop.a_from_frame),
        "frame_b": _pose(loop.b_from_frame),
        "limits": [_float(loop.limits.lower), _float(loop.limits.upper)],
        "saved": _float(loop.saved, max(1.0, abs(loop.saved))),
        "residual": _float(loop.residual, 1.0),
        "cad": _mate(loop),
    }
