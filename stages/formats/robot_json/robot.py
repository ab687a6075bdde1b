"""The whole of a robot.json: the model in no simulator's format, with its origins in CAD."""

from dataclasses import dataclass
from typing import Annotated, Any

from linkwright.stages.formats.robot_json.codec import INLINE, UNREAD, JsonRecord, Key, PairRecord, modelled
from linkwright.stages.formats.robot_json.driving import ActuationRecord, SensingRecord
from linkwright.stages.formats.robot_json.files import (
    CouplingRecord,
    FormatRecord,
    HeldRecord,
    LoweredRecord,
    OrderRecord,
    PackageRecord,
    SrdfRecord,
    UrdfRecord,
)
from linkwright.stages.formats.robot_json.joints import FrameRecord, JointRecord, LoopRecord, RelationRecord
from linkwright.stages.formats.robot_json.links import LinkRecord
from linkwright.stages.formats.robot_json.mjcf import MjcfRecord
from linkwright.stages.formats.robot_json.scene import KeyframeRecord, SceneRecord
from linkwright.stages.formats.robot_json.shapes import (
    ColliderRecord,
    ExcludeRecord,
    ShapeRecord,
    TouchRecord,
)
from linkwright.stages.formats.robot_json.values import Number, PoseRecord
from linkwright.stages.robot.model import robot as model
from linkwright.stages.robot.model.amendments import Amendment, Surplus
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.semantics import NOTHING_MORE, RobotSemantics


@dataclass(frozen=True)
class BaseRecord(JsonRecord[model.Base]):
    """Whether the root link is fixed to the world.

    fixed: whether it is.
    reason: why, in words.
    joint: the joint by which it floats in the MJCF; null for a fixed one.
    """

    fixed: bool
    reason: str
    joint: str | None

    def to_model(self, **more: Any) -> model.Base:
        return super().to_model(joint=self.joint or "")


@dataclass(frozen=True)
class RedundantRecord(PairRecord):
    """A loop of which conditions follow from others.

    loop: the loop.
    conditions: how many of them.
    """

    loop: str
    conditions: int


@dataclass(frozen=True)
class MobilityRecord(JsonRecord[model.Mobility]):
    """How the mechanism can move.

    coordinates: degrees of freedom of the tree of joints.
    gruebler: these less the conditions of relations and loops, counted as if all were independent.
    dof: the same by the rank of the conditions at the saved pose.
    redundant: the loops of which conditions follow from others.
    """

    coordinates: int
    gruebler: int
    dof: int
    redundant: tuple[RedundantRecord, ...]


@dataclass(frozen=True, kw_only=True)
class RobotRecord(JsonRecord[model.Robot]):
    """A robot. Lengths are in metres, angles in radians, masses in kilograms.

    format: the kind of file.
    version: the version of that kind.
    name: name of the robot.
    source: the document.
    root: the root link.
    root_pose: where the root link is in the assembly.
    base: whether the root link is fixed to the world.
    mass: mass of all links [kg].
    mobility: how the mechanism can move.
    links: rigid bodies in the order of the tree: a parent before its children, the root first.
    joints: joints in the order of the tree.
    relations: degrees of freedom that follow others.
    loops: mates that close loops of joints.
    frames: named frames on links.
    lowered: the joints that are several joints in the URDF.
    couplings: what closed loops make follow what.
    urdf: present where the URDF names its meshes by a package.
    merged: the links that are part of others in the URDF.
    fused: the links that are sites in the MJCF.
    mjcf: present where the source was an MJCF: what no other format has.
    transmissions: present where the source names what drives the joints.
    keyframes: named poses beside `cad`, which is `saved` of each degree of freedom.
    semantics: present where the source has an SRDF: what that says besides, by the robot's names.
    order: the order of the joints, actuators and sensors in each file.
    shapes: what is seen and what collides, by link. Missing, as the four keys after it, where a build ends
        before its shapes are made.
    colliders: what they are made as, and why.
    self_contact: whether the links collide with each other, but for `excludes`.
    excludes: pairs of links that do not collide.
    touching: other pairs that touch at `home`.
    scene: where the files put the robot. Missing as `shapes` are.
    amendments: what the keys `elements` and `attributes` added to the files and set in them.
    surplus: how much a file has after the robot's own by that.
    files: the paths of the robot's other files, but for those of a Python package, which are copies.
    srdf: present where an SRDF is written.
    sdf: present where an SDF is written.
    usd: present where a USD is written that has something otherwise than the robot.
    ros2: present where a package for ROS 2 is written.
    python: present where a Python package is written.
    """

    format: str
    version: int
    name: str
    provenance: Annotated[model.Provenance, Key("source")]
    root: Annotated[str, UNREAD]
    world_from_root: Annotated[PoseRecord, Key("root_pose")]
    base: BaseRecord
    mass: Annotated[Number, UNREAD]
    mobility: MobilityRecord
    links: tuple[LinkRecord, ...]
    joints: tuple[JointRecord, ...]
    relations: tuple[RelationRecord, ...]
    loops: tuple[LoopRecord, ...]
    frames: tuple[FrameRecord, ...]
    lowered: Annotated[tuple[LoweredRecord, ...], UNREAD]
    couplings: tuple[CouplingRecord, ...] = ()
    urdf: UrdfRecord | None = None
    merged: tuple[HeldRecord, ...] = ()
    fused: tuple[HeldRecord, ...] = ()
    mjcf: MjcfRecord | None = None
    transmissions: tuple[model.Transmission, ...] = ()
    actuation: Annotated[ActuationRecord, INLINE]
    keyframes: tuple[KeyframeRecord, ...]
    semantics: RobotSemantics = NOTHING_MORE
    sensing: Annotated[SensingRecord, INLINE]
    order: Annotated[OrderRecord | None, UNREAD] = None
    shapes: tuple[ShapeRecord, ...] | None = None
    colliders: tuple[ColliderRecord, ...] | None = None
    self_contact: bool | None = None
    excludes: tuple[ExcludeRecord, ...] | None = None
    touching: tuple[TouchRecord, ...] | None = None
    scene: SceneRecord | None = None
    amendments: tuple[Amendment, ...] = ()
    surplus: tuple[Surplus, ...] = ()
    files: tuple[str, ...] = ()
    srdf: SrdfRecord | None = None
    sdf: Annotated[FormatRecord | None, UNREAD] = None
    usd: Annotated[FormatRecord | None, UNREAD] = None
    ros2: PackageRecord | None = None
    python: PackageRecord | None = None

    def to_model(self, **more: Any) -> model.Robot:
        """Of the keyframes, those with values that the user gives: the others are worked out."""
        given = tuple(keyframe.to_model() for keyframe in self.keyframes if keyframe.given)
        return super().to_model(keyframes=given)

    @property
    def geometry(self) -> Geometry | None:
        """The shapes, without the files of the meshes; None where a build ended before it made them."""
        if self.shapes is None:
            return None
        return Geometry(
            shapes=modelled(self.shapes),
            files={},
            self_contact=bool(self.self_contact),
            excludes=modelled(self.excludes or ()),
            touching=modelled(self.touching or ()),
        )
