"""What robot.json says of joints and loops, with their degrees of freedom."""

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from stages.export.json_values import as_float, as_floats, as_pose, as_value
from stages.export.provenance import provenance
from stages.export.urdf.lowering import unset
from stages.formats.numbers import TURN, least_of
from stages.robot.actuation import Supplied
from stages.robot.model import Configuration, Dof, Joint, Loop, MateRef, Value
from stages.robot.poses import at_rest


def joint_record(
    joint: Joint, start: Configuration, estimated: Collection[str], motors: Sequence[Supplied]
) -> dict[str, Any]:
    return {
        "name": joint.name,
        "type": joint.type,
        "parent": joint.parent,
        "child": joint.child,
        "origin": as_pose(joint.parent_from_joint),
        "backwards": joint.backwards,
        "dofs": [
            {
                **_dof(dof, joint.backwards),
                "unset": unset(dof),
                "provenance": provenance(dof, dof.name in estimated, motors),
                **({"estimated": ["armature"]} if dof.name in estimated else {}),
                "qpos0": as_value(start[dof.name]),
                **({"zero": _zero(start[dof.name])} if dof.kind == "ball" else {}),
            }
            for dof in joint.dofs
        ],
        "cad": _mate(joint.mate),
    }


def _dof(dof: Dof, backwards: bool = False) -> dict[str, Any]:
    scalar = dof.kind in ("turn", "slide")
    table = {
        "name": dof.name,
        "kind": dof.kind,
        "axis": as_floats(dof.axis) if scalar else None,
        "origin": None if np.array_equal(dof.origin, np.eye(4)) else as_pose(dof.origin),
        "limits": [as_float(end, least_of(dof.kind)) for end in (dof.limits.lower, dof.limits.upper)],
        "damping": as_float(dof.dynamics.damping),
        "friction": as_float(dof.dynamics.friction),
        "armature": as_float(dof.dynamics.armature),
        "effort": as_float(dof.dynamics.effort),
        "velocity": as_float(dof.dynamics.velocity),
        "saved": as_value(dof.saved),
        "mate": {"sign": dof.in_mate.sign, "zero": as_value(dof.in_mate.zero)},
    }
    if dof.spring is not None:
        stiffness, reference = as_float(dof.spring.stiffness), as_float(dof.spring.reference, TURN)
        table["spring"] = {"stiffness": stiffness, "reference": reference}
    if dof.kind == "ball" and isinstance(dof.saved, tuple):
        w, x, y, z = dof.saved
        table["mate_quat"] = as_value((w, -x, -y, -z) if backwards else dof.saved)
    return table


def _zero(start: Value) -> dict[str, Any]:
    """Where a ball's q = 0 is, by format, as its chain's quaternion."""
    return {"urdf": as_value(at_rest("ball")), "mjcf": as_value(start)}


def _mate(mate: MateRef | None) -> dict[str, Any] | None:
    if mate is None:
        return None
    copy = {"copy": mate.copy} if mate.copy else {}
    return {"owner": list(mate.owner), "feature": mate.feature, "name": mate.name, "type": mate.type, **copy}


def loop_record(loop: Loop, ends: tuple[str, str], mimic: bool, estimated: Collection[str]) -> dict[str, Any]:
    return {
        "name": loop.name,
        "type": loop.type,
        "link_a": loop.link_a,
        "link_b": loop.link_b,
        "frame_a": as_pose(loop.a_from_frame),
        "frame_b": as_pose(loop.b_from_frame),
        "urdf": list(ends),
        "mimic": mimic,
        "dofs": [{**_dof(dof), "provenance": provenance(dof, dof.name in estimated)} for dof in loop.dofs],
        "residual": as_float(loop.residual, TURN),
        "lever": as_float(loop.lever),
        "solref": as_floats(loop.solref),
        "cad": _mate(loop.mate),
    }
