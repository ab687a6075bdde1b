"""Defines the links of robot.json: mass properties, CAD's parts, and the user's own shapes."""

from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from linkwright.stages.formats.robot_json.codec import INLINE, JsonRecord, Key
from linkwright.stages.formats.robot_json.values import (
    Colour,
    Lengths,
    Number,
    Pose,
    PoseRecord,
    Position,
    Tensor,
)
from linkwright.stages.robot.model import robot as model

MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])
"""The reflection (4, 4) between the left-handed pose of a mirrored part and the right-handed pose that is
written for it."""


@dataclass(frozen=True)
class InertialRecord(JsonRecord[model.Inertial]):
    """The mass of a body.

    mass: mass [kg].
    com: the centre of mass [m].
    inertia: the 3x3 tensor about the centre of mass [kg m²], in the axes of the body.
    """

    mass: Number
    com: Position
    inertia: Tensor


@dataclass(frozen=True)
class PartRecord(JsonRecord[model.Part]):
    """An occurrence of a part in CAD. Its `mass`, `com`, `inertia` and `volume` are CAD's, in its own frame.

    name: its path in words, joined by "/".
    path: the ids of its instances, from the root.
    part: its id in the document.
    volume: volume [m³].
    pose: its pose in its link; for a mirrored part, with the quat of R · diag(1, 1, -1), where R is the
        orthogonal matrix of its left-handed pose.
    mirrored: whether its pose is left-handed.
    world: the pose of its occurrence in the assembly, written in the same way.
    visual: whether its shape is visible.
    collision: whether its shape collides.
    standard: whether it is standard content, such as a screw.
    estimated: whether its mass is estimated, from its volume.
    """

    name: str
    path: tuple[str, ...]
    part_id: Annotated[str, Key("part")]
    inertial: Annotated[InertialRecord, INLINE]
    volume: Number
    link_from_part: Pose
    mirrored: bool
    world_from_part: Annotated[PoseRecord, Key("world")]
    seen: Annotated[bool, Key("visual")]
    collides: Annotated[bool, Key("collision")]
    standard: bool
    estimated: bool

    @classmethod
    def from_model(cls, value: model.Part, **more: Any) -> "PartRecord":
        mirrored = bool(np.linalg.det(value.link_from_part[:3, :3]) < 0)
        return super().from_model(_flipped(value) if mirrored else value, mirrored=mirrored)

    def to_model(self, **more: Any) -> model.Part:
        """Returns the part, without its mesh, which robot.json does not name."""
        part = super().to_model(mesh=None)
        return _flipped(part) if self.mirrored else part


def _flipped(part: model.Part) -> model.Part:
    """Returns a part with its poses changed from left-handed to right-handed, or back."""

    def flip(pose: model.Array) -> model.Array:
        return model.frozen(pose @ MIRROR)

    return replace(part, link_from_part=flip(part.link_from_part), world_from_part=flip(part.world_from_part))


@dataclass(frozen=True)
class PrimitiveRecord(JsonRecord[model.Primitive]):
    """A shape that is not a mesh.

    kind: an ellipsoid is an ellipsoid only in the MJCF.
    size: for a box or ellipsoid the lengths along x, y and z; for a sphere the radius; for a cylinder or
        capsule the radius and the length along z, without the caps of a capsule [m].
    pose: its pose in its link.
    """

    kind: model.PrimitiveKind
    size: Lengths
    link_from_shape: Pose


@dataclass(frozen=True)
class LinkShapeRecord(PrimitiveRecord):
    """A shape of the user's own.

    colour: red, green, blue and alpha in 0..1; null for neutral grey.
    visual: whether it is visible.
    collision: whether it collides.
    """

    colour: Colour | None
    visual: bool
    collision: bool


@dataclass(frozen=True)
class PathRecord(JsonRecord[None]):
    """The occurrence in CAD that names a link.

    path: the ids of its instances, from the root.
    """

    path: tuple[str, ...]


@dataclass(frozen=True)
class LinkRecord(JsonRecord[model.Link]):
    """A rigid body, whose frame is that of its joint.

    name: unique among links.
    given: whether the mass properties are the user's, or the minimum that engines accept, instead of the sum
        of the parts.
    cad: the occurrence in CAD; null if CAD does not have the link.
    parts: the occurrences of its parts.
    shapes: shapes of the user's own.
    """

    name: str
    inertial: Annotated[InertialRecord, INLINE]
    given: bool
    cad: PathRecord | None
    parts: tuple[PartRecord, ...]
    shapes: tuple[LinkShapeRecord, ...]

    @classmethod
    def from_model(cls, value: model.Link, **more: Any) -> "LinkRecord":
        cad = PathRecord(value.path) if value.path or value.parts else None
        return super().from_model(value, given=value.given is not None, cad=cad)

    def to_model(self, **more: Any) -> model.Link:
        inertial = self.inertial.to_model() if self.given else None
        return super().to_model(given=inertial, path=self.cad.path if self.cad else ())
