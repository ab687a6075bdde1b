"""Joints, loops, relations and frames of robot.json."""

from dataclasses import fields
from typing import get_args

import numpy as np

from stages.formats.robot_json.fields import Fields
from stages.robot.model import (
    Array,
    Dof,
    DofKind,
    Dynamics,
    Frame,
    Joint,
    JointType,
    Keyframe,
    Limits,
    Loop,
    MateRef,
    MateValue,
    Relation,
    Spring,
    frozen,
)

TYPES, KINDS = get_args(JointType), get_args(DofKind)


def joint_of(record: Fields) -> Joint:
    return Joint(
        name=record.text("name"),
        type=record.one_of("type", *TYPES),
        parent=record.text("parent"),
        child=record.text("child"),
        parent_from_joint=record.pose("origin"),
        dofs=tuple(_dof(one) for one in record.records("dofs")),
        backwards=record.truth("backwards"),
        mate=_mate(record),
    )


def loop_of(record: Fields) -> Loop:
    constant, ratio = record.numbers("solref", 2)
    return Loop(
        name=record.text("name"),
        type=record.one_of("type", *TYPES),
        link_a=record.text("link_a"),
        link_b=record.text("link_b"),
        a_from_frame=record.pose("frame_a"),
        b_from_frame=record.pose("frame_b"),
        dofs=tuple(_dof(one) for one in record.records("dofs")),
        lever=record.number("lever"),
        solref=(constant, ratio),
        residual=record.number("residual"),
        mate=_mate(record) or MateRef((), "", "", ""),
    )


def relation_of(record: Fields) -> Relation:
    ends = record.text("follower"), record.text("driver")
    return Relation(record.text("name"), *ends, record.number("multiplier"), record.number("offset"))


def frame_of(record: Fields) -> Frame:
    source = record.inside("cad").text("name") if record.has("cad") else ""
    joint = record.text("joint") if record.has("joint") else ""
    return Frame(record.text("name"), record.text("link"), record.pose("pose"), source, joint)


def keyframe_of(record: Fields) -> Keyframe | None:
    """The values that the user gives; None where there are none: then the pose is worked out."""
    given = Fields(dict(record.items("given")), f"{record.place}.given")
    values = tuple((name, given.number(name)) for name in given.table)
    return Keyframe(record.text("name"), values) if values else None


def _dof(record: Fields) -> Dof:
    kind = record.one_of("kind", *KINDS)
    provenance = dict(record.items("provenance"))
    named = {"lower": "limits", "upper": "limits"}
    given = dict.fromkeys(named.get(key, key) for key, where in provenance.items() if where == "given")
    dynamics = {one.name: record.number_or_none(one.name) for one in fields(Dynamics)}
    mate = record.inside("mate")
    return Dof(
        name=record.text("name"),
        kind=kind,
        axis=_axis(record),
        origin=record.pose_or_none("origin"),
        limits=Limits(*record.ends("limits")),
        dynamics=Dynamics(**dynamics),
        saved=record.value("saved"),
        given=tuple(given),
        in_mate=MateValue(mate.whole("sign"), mate.value("zero")),
        spring=_spring(record.inside("spring")) if record.has("spring") else None,
    )


def _spring(record: Fields) -> Spring:
    return Spring(record.number("stiffness"), record.number("reference"))


def _axis(record: Fields) -> Array:
    """A unit vector (3,): what is written is one up to its last digit. Zero for null."""
    axis = record.vector("axis") if record.has("axis") else np.zeros(3)
    return frozen(axis / (np.linalg.norm(axis) or 1.0))


def _mate(record: Fields) -> MateRef | None:
    if not record.has("cad"):
        return None
    cad = record.inside("cad")
    copy = cad.text("copy") if cad.has("copy") else ""
    return MateRef(cad.texts("owner"), cad.text("feature"), cad.text("name"), cad.text("type"), copy)
