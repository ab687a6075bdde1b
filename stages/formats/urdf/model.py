"""A URDF as a value, exactly as in the file.

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
    """A visual or a collision.

    `size` [m] as in `model.Primitive`: a box's lengths; a sphere's (radius,); a cylinder's or
    capsule's (radius, length); () for a mesh. `filename` as the file has it, "" unless a mesh;
    `scale` (x, y, z), negative too, of a mesh. `colour`: the material's RGBA in 0..1, None where the
    file gives none (a mesh then has its own colours; a collision never has one). `texture`: the
    material's image, "" for none. `name`: the element's own, mostly "".
    """

    kind: UrdfShapeKind
    size: tuple[float, ...]
    filename: str
    scale: tuple[float, float, float]
    link_from_shape: Array
    colour: Colour | None
    texture: str
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class UrdfLink:
    """A link. `inertial` in the link's frame, None where the file gives none; it may be unphysical.
    `line`: where the file has it."""

    name: str
    inertial: Inertial | None
    visuals: tuple[UrdfShape, ...]
    collisions: tuple[UrdfShape, ...]
    line: int


@dataclass(frozen=True, slots=True)
class UrdfMimic:
    """This joint = multiplier · `joint` + offset [rad or m]."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True, eq=False)
class UrdfJoint:
    """A joint: the child's frame at q is `parent_from_joint @ motion(axis, q)`.

    `axis` (3,) unit vector in the joint's frame (the normal of a planar joint's plane; (1, 0, 0) where
    the file gives none). `limits` None where there is no <limit> element, or for a type that has
    none; a bound that it leaves out is 0, as in ROS. `effort` [N m or N] and `velocity` [rad/s or m/s]
    as the file says, 0 too; None where it says nothing. `damping`, `friction` and `armature` (the rotor's
    inertia as the joint feels it) likewise, None unset.
    """

    name: str
    type: UrdfJointType
    parent: str
    child: str
    parent_from_joint: Array
    axis: Array
    limits: Limits | None
    effort: float | None
    velocity: float | None
    damping: float | None
    friction: float | None
    armature: float | None
    mimic: UrdfMimic | None
    line: int


@dataclass(frozen=True, slots=True, eq=False)
class Urdf:
    """A robot's file: links, joints and transmissions (one for each joint of each) in the file's order, and
    `controls`: the text of each <transmission> and <ros2_control>.

    `diagnostics`: all that is wrong (E-), doubtful (W-) or left out (I-). With an E- among them the
    rest is what could be read: names may be double, a joint may name a link that is not there.
    """

    name: str
    links: tuple[UrdfLink, ...]
    joints: tuple[UrdfJoint, ...]
    transmissions: tuple[Transmission, ...]
    controls: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]


def mesh_key(shape: UrdfShape) -> str:
    """What names a mesh's triangles in a bundle (request `mesh/<key>`, and the body's id in it): one
    for each file, scale, colour and image. Letters, digits, "_" and "-"."""
    stem = re.sub(r"\W+", "_", PurePosixPath(shape.filename.replace("\\", "/")).stem, flags=re.ASCII)
    identity = repr((shape.filename, shape.scale, shape.colour, *filter(None, [shape.texture])))
    return f"{stem[:40]}-{sha256(identity.encode()).hexdigest()[:12]}"
