"""Writes the joints of a USD as prims: frames, limits, and the attributes from `joint_facts`."""

from collections.abc import Mapping

from linkwright.stages.export.usd.joints import UsdJoint
from linkwright.stages.export.usd.layer import Prim
from linkwright.stages.formats.numbers import LENGTH, TURN
from linkwright.stages.formats.usd.joint_facts import DEGREES, MUJOCO, JointFacts, resistance, units
from linkwright.stages.robot.model.robot import Array, Limits


def write_joint(prim: Prim, joint: UsdJoint) -> None:
    """Writes the type and limits of a joint, without its bodies and frames."""
    if joint.closes:
        prim.set("physics:excludeFromArticulation", "bool", True, uniform=True)
    if joint.dof is not None:
        prim.token("physics:axis", joint.axis)
        if not joint.closes:  # PhysX would warn: only joints of an articulation resist motion
            write_facts(prim, resistance(joint.dof), {})
    if joint.type == "":
        _locks(prim, joint)
    elif joint.type == "Spherical" and joint.limits.upper is not None:
        for key in ("coneAngle0Limit", "coneAngle1Limit"):
            prim.number(f"physics:{key}", joint.limits.upper * DEGREES, least=TURN)
    elif joint.type in ("Revolute", "Prismatic"):
        _limits(prim, joint)


def write_facts(prim: Prim, facts: JointFacts, joints: Mapping[str, Prim]) -> None:
    """Writes facts about a joint. `joints`: dof → prim, for the dofs that the facts refer to."""
    prim.apply(*facts.schemas)
    for name, value in facts.numbers.items():
        if name.startswith(MUJOCO):
            prim.number(name, value, "double", uniform=True)
        else:
            prim.number(name, value)
    for name, token in facts.tokens.items():
        prim.token(name, token)
    for name, dof in facts.targets.items():
        prim.point_to(name, joints[dof])


def write_frames(prim: Prim, first: Array, second: Array) -> None:
    """Writes a joint's frame (4, 4) on both of its bodies."""
    for number, pose in ((0, first), (1, second)):
        prim.floats(f"physics:localPos{number}", "point3f", pose[:3, 3], LENGTH)
        prim.rotation(f"physics:localRot{number}", pose[:3, :3])


def _limits(prim: Prim, joint: UsdJoint) -> None:
    assert joint.dof is not None
    scale, rounding_step = units(joint.dof)
    for key, end in (("lowerLimit", joint.limits.lower), ("upperLimit", joint.limits.upper)):
        if end is not None:
            prim.number(f"physics:{key}", end * scale, least=rounding_step)


def _locks(prim: Prim, joint: UsdJoint) -> None:
    """Writes the limits of a general joint's free axes. The other axes are locked, by a lower limit above the
    upper limit."""
    free_axes = {f"{freedom.kind}{freedom.axis}": freedom for freedom in joint.free}
    for kind in ("trans", "rot"):
        for axis in "XYZ":
            name = f"{kind}{axis}"
            limits = free_axes[name].limits if name in free_axes else None
            if limits == Limits():
                continue
            prim.apply(f"PhysicsLimitAPI:{name}")
            scale, rounding_step = (DEGREES, TURN * DEGREES) if kind == "rot" else (1.0, LENGTH)
            ends = (1.0, -1.0) if limits is None else (limits.lower, limits.upper)
            for key, end in zip(("low", "high"), ends, strict=True):
                if end is not None:
                    limit = end if limits is None else end * scale
                    prim.number(f"limit:{name}:physics:{key}", limit, least=rounding_step)
