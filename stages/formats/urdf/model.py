"""Defines the values of a URDF, exactly as in the file.

Poses are (4, 4) float64 transforms, named by their frames; SI units, radians. A link's frame is the
URDF's own. `stages.formats.urdf.parse` reads a file into these values.
"""

import re
from dataclasses import dataclass
from hashlib import sha256
from pathlib import PurePosixPath
from typing import Literal

from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Colour
from linkwright.stages.robot.model.robot import Array, Inertial, Limits
from linkwright.stages.robot.model.robot import Transmission as Transmission

UrdfShapeKind = Literal["box", "cylinder", "sphere", "capsule", "mesh"]
UrdfJointType = Literal["revolute", "continuous", "prismatic", "fixed", "floating", "planar"]


@dataclass(frozen=True, slots=True, eq=False)
class UrdfShape:
    """The shape of a <visual> or <collision> element."""

    kind: UrdfShapeKind
    size: tuple[float, ...]
    """[m], as in `model.Primitive`: a box's lengths; a sphere's (radius,); a cylinder's or capsule's (radius,
    length); () for a mesh."""

    filename: str
    """The file's name of a mesh; "" for other shapes."""

    scale: tuple[float, float, float]
    """The scale of a mesh (x, y, z), which may be negative."""

    link_from_shape: Array
    colour: Colour | None
    """The material's RGBA in 0..1. None if the file has none: a mesh then keeps its own colours. A collision
    never has a colour."""

    texture: str
    """The material's image, or ""."""

    name: str
    """The element's name, mostly ""."""


@dataclass(frozen=True, slots=True, eq=False)
class UrdfLink:
    """A link of a URDF."""

    name: str
    inertial: Inertial | None
    """In the link's frame; None if the file has none. It may be unphysical."""

    visuals: tuple[UrdfShape, ...]
    collisions: tuple[UrdfShape, ...]
    line: int
    """The line of the file where the link begins."""


@dataclass(frozen=True, slots=True)
class UrdfMimic:
    """A <mimic>: the follower's position is multiplier · `joint` + offset [rad or m]."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True, eq=False)
class UrdfJoint:
    """A joint: the child's frame at q is `parent_from_joint @ motion(axis, q)`."""

    name: str
    type: UrdfJointType
    parent: str
    child: str
    parent_from_joint: Array
    axis: Array
    """(3,) unit vector in the joint's frame: the normal of a planar joint's plane; (1, 0, 0) if the file has
    no axis."""

    limits: Limits | None
    """The bounds; None if there is no <limit> element, or the type has no limits. A bound that <limit> leaves
    out is 0, as in ROS."""

    effort: float | None
    """The file's value [N m or N], even 0; None if it has none."""

    velocity: float | None
    """The file's value [rad/s or m/s], even 0; None if it has none."""

    damping: float | None
    """The file's value [N m s/rad or N s/m]; None if it has none."""

    friction: float | None
    """The file's value [N m or N]; None if it has none."""

    armature: float | None
    """The rotor's inertia, reflected at the joint [kg m² or kg]; None if the file has none."""

    mimic: UrdfMimic | None
    line: int
    """The line of the file where the joint begins."""


@dataclass(frozen=True, slots=True, eq=False)
class Urdf:
    """The content of a URDF file: links, joints and transmissions, in the file's order."""

    name: str
    links: tuple[UrdfLink, ...]
    joints: tuple[UrdfJoint, ...]
    transmissions: tuple[Transmission, ...]
    """An entry for each joint of each <transmission>."""

    controls: tuple[str, ...]
    """The XML text of each <transmission> and <ros2_control>."""

    diagnostics: tuple[Diagnostic, ...]
    """Errors (E-), doubts (W-) and omissions (I-). If there is an error, the other fields hold only what
    could be read: names may be duplicated, and a joint may refer to a missing link."""


def mesh_key(shape: UrdfShape) -> str:
    """Returns the key of a mesh's triangles in a bundle (request `mesh/<key>`, and the body's id in it),
    unique for each file, scale, colour and image. The key has letters, digits, "_" and "-"."""
    stem = re.sub(r"\W+", "_", PurePosixPath(shape.filename.replace("\\", "/")).stem, flags=re.ASCII)
    identity = repr((shape.filename, shape.scale, shape.colour, *filter(None, [shape.texture])))
    return f"{stem[:40]}-{sha256(identity.encode()).hexdigest()[:12]}"
