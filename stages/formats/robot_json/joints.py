"""Defines the joints, loops, relations and frames of robot.json."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from linkwright.stages.formats.numbers import least_of
from linkwright.stages.formats.robot_json.codec import INLINE, UNREAD, JsonRecord, Key
from linkwright.stages.formats.robot_json.values import (
    Coordinate,
    DofName,
    DofValue,
    Ends,
    LinkName,
    Number,
    Pose,
    PoseRecord,
    Range,
    Vector,
    as_float,
)
from linkwright.stages.robot.model import robot as model
from linkwright.stages.robot.model.poses import UNMOVED


@dataclass(frozen=True)
class MateRecord(JsonRecord[model.MateRef]):
    """The mate in CAD behind a joint or loop.

    owner: the path of the assembly that has it.
    feature: its id.
    name: its name in CAD.
    type: its type in CAD.
    copy: the instance for which a pattern or mirror repeats it; missing for the mate itself.
    """

    owner: tuple[str, ...]
    feature: str
    name: str
    type: str
    copy: str = ""


@dataclass(frozen=True)
class DynamicsRecord(JsonRecord[model.Dynamics]):
    """Forces and inertia of a degree of freedom; null if unset.

    damping: force per speed [N m s/rad or N s/m].
    friction: force of dry friction [N m or N].
    armature: inertia that moves with it [kg m² or kg].
    effort: the largest force [N m or N].
    velocity: the largest speed [rad/s or m/s].
    """

    damping: Number | None
    friction: Number | None
    armature: Number | None
    effort: Number | None
    velocity: Number | None


@dataclass(frozen=True)
class MateValueRecord(JsonRecord[model.MateValue]):
    """The conversion of a value to the mate's own, as CAD shows it: zero + sign · value; for a ball or free
    motion, the pose `zero` times the value.

    sign: 1 or -1.
    zero: the mate's own value where the value is 0.
    """

    sign: int
    zero: DofValue


@dataclass(frozen=True)
class SpringRecord(JsonRecord[model.Spring]):
    """A spring of an MJCF source.

    stiffness: force per displacement [N m/rad or N/m].
    reference: the value at which the spring is slack [rad or m].
    """

    stiffness: Number
    reference: Coordinate


@dataclass(frozen=True)
class BallZeroRecord(JsonRecord[None]):
    """The orientation of a ball at q = 0 in each format, as a quaternion (w, x, y, z) along the chain.

    urdf: the zero of its mate.
    mjcf: its pose at qpos0, since `ref` does not apply to ball joints in an MJCF.
    """

    urdf: DofValue
    mjcf: DofValue


@dataclass(frozen=True, kw_only=True)
class DofRecord(JsonRecord[model.Dof]):
    """A degree of freedom. Its values are numbers [rad or m], a ball's quaternion (w, x, y, z), or the seven
    numbers of free motion (x, y, z, quaternion).

    name: unique among the degrees of freedom of all joints and loops; the only degree of freedom of a joint
        has the joint's name.
    kind: a turn about the axis, a slide along it, a ball, or free motion.
    axis: a unit vector in its own frame; null for a ball and for free motion.
    origin: its own frame, in the frame that the previous degree of freedom moves; null if the two are the
        same.
    limits: the lowest and the highest value, each null without a limit; for a ball the second is the half
        angle of the cone in which its z axis stays.
    saved: the value in the pose that was saved in CAD, counted along the chain from parent to child.
    mate: the conversion of a value to the mate's own.
    spring: present where an MJCF source has a spring.
    mate_quat: a ball's saved value as the mate has it: the inverse where the joint runs backwards.
    unset: the unset quantities, for which the URDF has a default, since it requires numbers; missing for a
        loop.
    provenance: limit or quantity → where it comes from: given (by the configuration), source (by CAD or the
        file), estimated, a motor with where its value comes from, or unset.
    estimated: the values of a joint that Linkwright chose.
    qpos0: the value in a fresh simulation of the MJCF; missing for a loop.
    zero: where a ball's q = 0 is, by format.
    """

    name: str
    kind: model.DofKind
    axis: Vector | None
    origin: PoseRecord | None
    limits: Ends
    dynamics: Annotated[DynamicsRecord, INLINE]
    saved: DofValue
    mate_value: Annotated[MateValueRecord, Key("mate")]
    spring: SpringRecord | None = None
    mate_quat: Annotated[DofValue | None, UNREAD] = None
    unset: Annotated[tuple[str, ...] | None, UNREAD] = None
    provenance: Mapping[str, str]
    estimated: Annotated[tuple[str, ...], UNREAD] = ()
    qpos0: Annotated[DofValue | None, UNREAD] = None
    zero: Annotated[BallZeroRecord | None, UNREAD] = None

    @classmethod
    def from_model(cls, value: model.Dof, **more: Any) -> "DofRecord":
        least = least_of(value.kind)
        ends = (
            None if end is None else as_float(end, least) for end in (value.limits.lower, value.limits.upper)
        )
        axis = value.axis if value.kind in ("turn", "slide") else None
        origin = None if np.array_equal(value.origin, UNMOVED) else value.origin
        return super().from_model(value, axis=axis, origin=origin, limits=tuple(ends), **more)

    def to_model(self, **more: Any) -> model.Dof:
        # A written axis has unit length only up to its last digit.
        axis = np.zeros(3) if self.axis is None else self.axis / (np.linalg.norm(self.axis) or 1.0)
        key_of_end = {"lower": "limits", "upper": "limits"}
        configured = [
            key_of_end.get(key, key) for key, origin in self.provenance.items() if origin == "given"
        ]
        return super().to_model(
            axis=model.frozen(axis),
            origin=UNMOVED if self.origin is None else self.origin.to_model(),
            limits=model.Limits(*self.limits),
            given=tuple(dict.fromkeys(configured)),
        )


@dataclass(frozen=True)
class JointRecord(JsonRecord[model.Joint]):
    """A parent link, a child link and the degrees of freedom between them.

    name: unique among joints.
    type: the type of its mate; compound is any other chain of degrees of freedom.
    parent: the link that carries it.
    child: the link that it moves.
    origin: its frame in the parent, before its degrees of freedom move it.
    backwards: whether the joint runs from the mate's first entity to its second.
    dofs: from parent to child, each in the frame that the previous degree of freedom moves.
    cad: the mate; null if CAD does not have the joint.
    """

    name: str
    type: model.JointType
    parent: str
    child: str
    parent_from_joint: Annotated[PoseRecord, Key("origin")]
    backwards: bool
    dofs: tuple[DofRecord, ...]
    mate: Annotated[MateRecord | None, Key("cad")]


@dataclass(frozen=True)
class LoopRecord(JsonRecord[model.Loop]):
    """A mate that closes a loop of joints.

    name: unique among loops and relations.
    type: the type of its mate.
    link_a: the link of its first frame.
    link_b: the link of its second frame.
    frame_a: its first frame in that link.
    frame_b: its second frame in that link, from which its degrees of freedom lead to the first.
    urdf: the links of the URDF that are its first and its second frame.
    mimic: whether <mimic> joints alone close it in the URDF.
    dofs: the degrees of freedom of the mate.
    residual: the gap of the loop in the saved pose [m, rad].
    lever: half the loop's reach from the joint that closes it [m].
    solref: MuJoCo's `solref` of its constraints.
    cad: the mate; null if CAD does not have it.
    """

    name: str
    type: model.JointType
    link_a: LinkName
    link_b: LinkName
    a_from_frame: Annotated[PoseRecord, Key("frame_a")]
    b_from_frame: Annotated[PoseRecord, Key("frame_b")]
    urdf: Annotated[tuple[str, str], UNREAD]
    mimic: bool
    dofs: tuple[DofRecord, ...]
    residual: Coordinate
    lever: Number
    solref: Range
    mate: Annotated[MateRecord | None, Key("cad")]

    def to_model(self, **more: Any) -> model.Loop:
        return super().to_model(mate=self.mate.to_model() if self.mate else model.MateRef((), "", "", ""))


@dataclass(frozen=True)
class RelationRecord(JsonRecord[model.Relation]):
    """A degree of freedom that follows another: follower = multiplier · driver + offset.

    name: unique among loops and relations.
    follower: the degree of freedom that follows.
    driver: the degree of freedom that is followed.
    multiplier: factor of the driver's value.
    offset: the value that is added [rad or m].
    """

    name: str
    follower: DofName
    driver: DofName
    multiplier: Number
    offset: Coordinate


@dataclass(frozen=True)
class NameRecord(JsonRecord[None]):
    """The name of an element in CAD.

    name: the name as it is typed in CAD.
    """

    name: str


@dataclass(frozen=True, kw_only=True)
class FrameRecord(JsonRecord[model.Frame]):
    """A named frame fixed to a link.

    name: unique among frames.
    link: the link that has it.
    urdf: the link of the URDF that represents it.
    joint: the fixed joint that holds it in the source, if that joint has a name.
    pose: its pose in the link.
    cad: its mate connector; null without a mate connector.
    """

    name: str
    link: LinkName
    urdf: Annotated[str, UNREAD]
    joint: str = ""
    link_from_frame: Pose
    cad: NameRecord | None

    @classmethod
    def from_model(cls, value: model.Frame, **more: Any) -> "FrameRecord":
        return super().from_model(value, cad=NameRecord(value.source) if value.source else None, **more)

    def to_model(self, **more: Any) -> model.Frame:
        return super().to_model(source=self.cad.name if self.cad else "")
