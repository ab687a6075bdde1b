"""Defines the whole of a robot.json: the model in no simulator's format, with its origins in CAD."""

from dataclasses import dataclass
from typing import Annotated, Any

from linkwright.stages.formats.robot_json.codec import INLINE, UNREAD, JsonRecord, Key, PairRecord, modelled
from linkwright.stages.formats.robot_json.driving import ActuationRecord, SensingRecord
from linkwright.stages.formats.robot_json.files import (
    CouplingRecord,
    FormatRecord,
    MergedLinkRecord,
    OrderRecord,
    PackageRecord,
    SplitJointRecord,
    SrdfRecord,
    UrdfPackageRecord,
    VariantsRecord,
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
    WholeVisualRecord,
)
from linkwright.stages.formats.robot_json.values import Number, PoseRecord
from linkwright.stages.robot.model import robot as model
from linkwright.stages.robot.model.amendments import Amendment, Surplus
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.semantics import NO_SEMANTICS, RobotSemantics


@dataclass(frozen=True)
class BaseRecord(JsonRecord[model.Base]):
    """Whether the root link is fixed to the world.

    fixed: whether the root link is fixed.
    reason: the reason, in words.
    joint: the joint by which the root link floats in the MJCF; null for a fixed root link.
    """

    fixed: bool
    reason: str
    joint: str | None

    def to_model(self, **more: Any) -> model.Base:
        return super().to_model(joint=self.joint or "")


@dataclass(frozen=True)
class RedundantRecord(PairRecord):
    """A loop with conditions that follow from other conditions.

    loop: the loop.
    conditions: the number of redundant conditions.
    """

    loop: str
    conditions: int


@dataclass(frozen=True)
class MobilityRecord(JsonRecord[model.Mobility]):
    """How the mechanism can move.

    coordinates: degrees of freedom of the tree of joints.
    gruebler: `coordinates` minus the conditions of relations and loops, counted as if all were independent.
    dof: degrees of freedom by the rank of the conditions at the saved pose.
    redundant: loops with conditions that follow from other conditions.
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
    source: the document that the robot comes from.
    root: the root link.
    root_pose: the pose of the root link in the assembly.
    base: whether the root link is fixed to the world.
    total_mass: mass of all links [kg].
    mobility: how the mechanism can move.
    links: rigid bodies in the order of the tree: a parent before its children, the root first.
    joints: joints in the order of the tree.
    relations: degrees of freedom that follow others.
    loops: mates that close loops of joints.
    frames: named frames on links.
    lowered: joints that become several joints in the URDF.
    couplings: degrees of freedom that follow others because of closed loops.
    urdf: present if the URDF names its meshes by a package.
    merged: links that are merged into other links in the URDF.
    fused: the links that are sites in the MJCF.
    mjcf: present if the source was an MJCF: its content that no other format has.
    transmissions: present if the source has transmissions or drives of the joints.
    keyframes: named poses besides `cad`, which is `saved` of each degree of freedom.
    semantics: present if the source has an SRDF: its further statements, by the robot's names.
    order: the order of the joints, actuators and sensors in each file.
    shapes: visual shapes and colliders, by link. This key and the four after it are missing if a build ends
        before its shapes are made.
    colliders: how the colliders are made, and why.
    self_contact: whether the links collide with each other, except the pairs of `excludes`.
    excludes: pairs of links that do not collide.
    touching: other pairs that touch at `home`.
    whole_visuals: the GLB of each link, which the URDF and the SDF show in the place of its visual meshes.
        Missing if they show the meshes.
    scene: the pose of the robot in the files. Missing if `shapes` are missing.
    amendments: the changes that the keys `elements` and `attributes` made to the files.
    surplus: the number of elements that these keys added to a file, after the robot's own.
    files: the paths of the robot's other files, except the files of a Python package, which are copies.
    srdf: present if an SRDF is written.
    sdf: present if an SDF is written.
    usd: present if a USD is written that differs from the robot.
    ros2: present if a package for ROS 2 is written.
    python: present if a Python package is written.
    variants: present if variants for learning are written.
    """

    format: str
    version: int
    name: str
    provenance: Annotated[model.Provenance, Key("source")]
    root: Annotated[str, UNREAD]
    world_from_root: Annotated[PoseRecord, Key("root_pose")]
    base: BaseRecord
    total_mass: Annotated[Number, UNREAD]
    mobility: MobilityRecord
    links: tuple[LinkRecord, ...]
    joints: tuple[JointRecord, ...]
    relations: tuple[RelationRecord, ...]
    loops: tuple[LoopRecord, ...]
    frames: tuple[FrameRecord, ...]
    lowered: Annotated[tuple[SplitJointRecord, ...], UNREAD]
    couplings: tuple[CouplingRecord, ...] = ()
    urdf: UrdfPackageRecord | None = None
    merged: tuple[MergedLinkRecord, ...] = ()
    fused: tuple[MergedLinkRecord, ...] = ()
    mjcf: MjcfRecord | None = None
    transmissions: tuple[model.Transmission, ...] = ()
    actuation: Annotated[ActuationRecord, INLINE]
    keyframes: tuple[KeyframeRecord, ...]
    semantics: RobotSemantics = NO_SEMANTICS
    sensing: Annotated[SensingRecord, INLINE]
    order: Annotated[OrderRecord | None, UNREAD] = None
    shapes: tuple[ShapeRecord, ...] | None = None
    colliders: tuple[ColliderRecord, ...] | None = None
    self_contact: bool | None = None
    excludes: tuple[ExcludeRecord, ...] | None = None
    touching: tuple[TouchRecord, ...] | None = None
    whole_visuals: tuple[WholeVisualRecord, ...] = ()
    scene: SceneRecord | None = None
    amendments: tuple[Amendment, ...] = ()
    surplus: tuple[Surplus, ...] = ()
    files: tuple[str, ...] = ()
    srdf: SrdfRecord | None = None
    sdf: Annotated[FormatRecord | None, UNREAD] = None
    usd: Annotated[FormatRecord | None, UNREAD] = None
    ros2: PackageRecord | None = None
    python: PackageRecord | None = None
    variants: Annotated[VariantsRecord | None, UNREAD] = None

    def to_model(self, **more: Any) -> model.Robot:
        """Returns the robot, with only those keyframes that have the user's values: the others are
        computed."""
        user_keyframes = tuple(keyframe.to_model() for keyframe in self.keyframes if keyframe.given)
        return super().to_model(keyframes=user_keyframes)

    @property
    def geometry(self) -> Geometry | None:
        """Returns the shapes, without the files of the meshes; None if a build ended before it made them."""
        if self.shapes is None:
            return None
        return Geometry(
            shapes=modelled(self.shapes),
            files={},
            self_contact=bool(self.self_contact),
            excludes=modelled(self.excludes or ()),
            touching=modelled(self.touching or ()),
            whole_visuals=modelled(self.whole_visuals),
        )
