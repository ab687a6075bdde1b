"""Writes the joints of a USD as prims: frames, limits, and the attributes from `joint_facts`."""

from collections.abc import Mapping

from linkwright.stages.export.usd.joints import UsdJoint
from linkwright.stages.export.usd.layer import Prim
from linkwright.stages.formats.numbers import LENGTH, TURN
from linkwright.stages.formats.usd.joint_facts import DEGREES, MUJOCO, JointFacts, resistance, units
from linkwright.stages.robot.model.robot import Array, Limits


def write_joint(prim: Prim, joint: UsdJoint) -> None:
    """Writes the limits of a joint, its axis and its resistance to motion. Its prim has the type already; its
    bodies, frames, state and drive are written elsewhere."""
    if joint.closes:
        prim.set("physics:excludeFromArticulation", "bool", True, uniform=True)
    if joint.dof is not None:
        prim.token("physics:axis", joint.axis)
        if not joint.closes:  # PhysX would warn: only joints of an articulation resist motion
            write_facts(prim, resistance(joint.dof), {})
    if joint.type == "":
        _write_general_limits(prim, joint)
    elif joint.type == "Spherical" and joint.limits.upper is not None:
        for key in ("coneAngle0Limit", "coneAngle1Limit"):
            prim.number(f"physics:{key}", joint.limits.upper * DEGREES, least=TURN)
    elif joint.type in ("Revolute", "Prismatic"):
        _write_limits(prim, joint)


def write_facts(prim: Prim, facts: JointFacts, prims_by_dof: Mapping[str, Prim]) -> None:
    """Writes facts about a joint. `prims_by_dof`: dof → prim of its joint, for the dofs that the facts refer
    to."""
    prim.apply(*facts.schemas)
    for name, value in facts.numbers.items():
        if name.startswith(MUJOCO):
            prim.number(name, value, "double", uniform=True)
        else:
            prim.number(name, value)
    for name, token in facts.tokens.items():
        prim.token(name, token)
    for name, dof in facts.targets.items():
        prim.point_to(name, prims_by_dof[dof])


def write_frames(prim: Prim, first_from_joint: Array, second_from_joint: Array) -> None:
    """Writes the frame (4, 4) of a joint on its first and on its second body."""
    for number, pose in ((0, first_from_joint), (1, second_from_joint)):
        prim.floats(f"physics:localPos{number}", "point3f", pose[:3, 3], LENGTH)
        prim.rotation(f"physics:localRot{number}", pose[:3, :3])


def _write_limits(prim: Prim, joint: UsdJoint) -> None:
    """Writes the limits [deg or m] of a turn or a slide; an open end is not written."""
    assert joint.dof is not None
    scale, rounding_scale = units(joint.dof)
    for key, end in (("lowerLimit", joint.limits.lower), ("upperLimit", joint.limits.upper)):
        if end is not None:
            prim.number(f"physics:{key}", end * scale, least=rounding_scale)


def _write_general_limits(prim: Prim, joint: UsdJoint) -> None:
    """Writes the limits of a general joint's free axes. The other axes are locked, by a lower limit above the
    upper limit."""
    free_axes = {f"{free_axis.kind}{free_axis.axis}": free_axis for free_axis in joint.free_axes}
    for kind in ("trans", "rot"):
        for axis in "XYZ":
            name = f"{kind}{axis}"
            # None: the axis is locked.
            limits = free_axes[name].limits if name in free_axes else None
            if limits == Limits():
                continue
            prim.apply(f"PhysicsLimitAPI:{name}")
            scale, rounding_scale = (DEGREES, TURN * DEGREES) if kind == "rot" else (1.0, LENGTH)
            ends = (1.0, -1.0) if limits is None else (limits.lower, limits.upper)
            for key, end in zip(("low", "high"), ends, strict=True):
                if end is not None:
                    limit = end if limits is None else end * scale
                    prim.number(f"limit:{name}:physics:{key}", limit, least=rounding_scale)
