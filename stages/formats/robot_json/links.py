"""Links of robot.json: mass properties, CAD's parts, and the user's own shapes."""

from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from linkwright.stages.formats.robot_json.codec import INLINE, JsonRecord, Key
from linkwright.stages.formats.robot_json.values import (
    Colour,
    Lengths,
    Number,
    Place,
    Pose,
    PoseRecord,
    Tensor,
)
from linkwright.stages.robot.model import robot as model

MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])
"""What takes the right-handed pose that is written of a mirrored part to its own (4, 4)."""


@dataclass(frozen=True)
class InertialRecord(JsonRecord[model.Inertial]):
    """The mass of a body.

    mass: mass [kg].
    com: the centre of mass [m].
    inertia: the 3x3 tensor about the centre of mass [kg m²], in the axes of the body.
    """

    mass: Number
    com: Place
    inertia: Tensor


@dataclass(frozen=True)
class PartRecord(JsonRecord[model.Part]):
    """An occurrence of a part in CAD. Its `mass`, `com`, `inertia` and `volume` are CAD's, in its own frame.

    name: its path in words, joined by "/".
    path: the ids of its instances, from the root.
    part: its id in the document.
    volume: volume [m³].
    pose: where it is in its link; of one that is mirrored, with the quat of R · diag(1, 1, -1), R the
        orthogonal matrix of its left-handed pose.
    mirrored: whether its pose is left-handed.
    world: where its occurrence is in the assembly, likewise.
    visual: whether its shape is seen.
    collision: whether its shape collides.
    standard: whether it is standard content, such as a screw.
    estimated: whether its mass is, from its volume.
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
        """Its mesh is not known."""
        part = super().to_model(mesh=None)
        return _flipped(part) if self.mirrored else part


def _flipped(part: model.Part) -> model.Part:
    def flip(pose: model.Array) -> model.Array:
        return model.frozen(pose @ MIRROR)

    return replace(part, link_from_part=flip(part.link_from_part), world_from_part=flip(part.world_from_part))


@dataclass(frozen=True)
class PrimitiveRecord(JsonRecord[model.Primitive]):
    """A shape that is no mesh.

    kind: an ellipsoid is one in the MJCF alone.
    size: of a box or ellipsoid its lengths along x, y and z; of a sphere its radius; of a cylinder or capsule
        its radius and its length along z, the caps of a capsule beyond that [m].
    pose: where it is in its link.
    """

    kind: model.PrimitiveKind
    size: Lengths
    link_from_shape: Pose


@dataclass(frozen=True)
class LinkShapeRecord(PrimitiveRecord):
    """A shape of the user's own.

    colour: red, green, blue and alpha in 0..1; null for neutral grey.
    visual: whether it is seen.
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
    given: whether the mass properties are the user's, or the least that engines take, and not the sum of the
        parts.
    cad: null where CAD does not have the link.
    parts: the occurrences of parts that it is made of.
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
        given = self.inertial.to_model() if self.given else None
        return super().to_model(given=given, path=self.cad.path if self.cad else ())
