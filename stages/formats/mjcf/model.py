"""Defines the values of an MJCF, as MuJoCo compiled it.

Everything is as compiled: defaults, includes, angles, inertias from geoms and sizes from meshes are
resolved. Poses are (4, 4) float64 transforms at qpos0, named by their frames; SI units, radians. Bodies
and joints are referred to by their numbers, which are MuJoCo's; a name is "" where the file gives none.
"""

from dataclasses import dataclass
from typing import Literal

from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geom_form import GeomForm
from linkwright.stages.robot.model.geometry import Colour
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS, Attributes, MjcfElement, MjcfExtras
from linkwright.stages.robot.model.robot import Array, Dynamics, Inertial, Limits, MeshRef, Spring

MjcfJointType = Literal["hinge", "slide", "ball", "free"]
MjcfGeomKind = Literal["box", "sphere", "cylinder", "capsule", "mesh"]


@dataclass(frozen=True, slots=True, eq=False)
class MjcfJoint:
    """A joint of a body: it moves the body's frame by T(p) M(axis, q − q₀) T(−p)."""

    name: str
    type: MjcfJointType
    anchor: Array
    """p (3,) [m]."""

    axis: Array
    """Unit vector (3,), zero for a ball or free motion."""

    ref: float
    """q₀ [rad or m]."""

    limits: Limits
    dynamics: Dynamics
    spring: Spring | None = None
    attributes: Attributes = ()
    """The other attributes in the file."""


@dataclass(frozen=True, slots=True, eq=False)
class MjcfGeom:
    """A shape of a body."""

    form: GeomForm
    """The name, and the other properties in the file; an ellipsoid is a mesh here."""

    kind: MjcfGeomKind
    size: tuple[float, ...]
    """[m], as in `model.Primitive`; () for a mesh."""

    mesh: MeshRef | None
    """The triangles of a mesh, otherwise None."""

    body_from_geom: Array
    colour: Colour | None
    collides: bool
    """Whether any other geom may touch it."""

    seen: bool
    """Whether it is visible."""


@dataclass(frozen=True, slots=True, eq=False)
class MjcfSite:
    """A named frame on a body."""

    name: str
    body_from_site: Array
    attributes: Attributes = ()


@dataclass(frozen=True, slots=True, eq=False)
class MjcfPlaced:
    """An element on a body, which no other format has."""

    body_from_element: Array
    element: MjcfElement


@dataclass(frozen=True, slots=True, eq=False)
class MjcfBody:
    """A body."""

    name: str
    parent: int
    parent_from_body: Array
    inertial: Inertial | None
    """In the body's frame; None without mass."""

    joints: tuple[MjcfJoint, ...]
    """The joints, which act one after the other."""

    geoms: tuple[MjcfGeom, ...]
    sites: tuple[MjcfSite, ...]
    axes: Array | None = None
    """The axes of the inertia (3, 3) in the body's frame, in the file's order."""

    attributes: Attributes = ()
    mounted: tuple[MjcfPlaced, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class MjcfClosure:
    """An equality that holds two frames together: a connect holds their origins, a weld the whole frames."""

    name: str
    type: Literal["connect", "weld"]
    bodies: tuple[int, int]
    """The bodies of the two frames."""

    sites: tuple[str, str]
    """The names of the two sites that it names; "" if it names bodies."""

    a_from_frame: Array
    """The frame on the first body."""

    b_from_frame: Array
    """The frame on the second body."""

    attributes: Attributes = ()


@dataclass(frozen=True, slots=True)
class MjcfRelation:
    """An equality of two joints, in the values of both: `follower` = multiplier · `driver` + offset."""

    name: str
    follower: int
    driver: int
    multiplier: float
    offset: float
    attributes: Attributes = ()


@dataclass(frozen=True, slots=True)
class MjcfActuator:
    """An actuator of a hinge or slide, as in `actuation.Actuator`."""

    name: str
    joint: int
    type: str
    gear: float
    kp: float | None
    kv: float | None
    control: tuple[float, float] | None
    force: tuple[float, float] | None
    terms: tuple[tuple[str, str], ...]
    attributes: Attributes = ()


@dataclass(frozen=True, slots=True)
class MjcfSensorEnd:
    """The object of a sensor: a joint, actuator, site, body or xbody by its number; "" and -1 without an
    object."""

    kind: str
    number: int


@dataclass(frozen=True, slots=True)
class MjcfSensor:
    """A sensor, as in `sensing.Sensor`."""

    name: str
    type: str
    on: MjcfSensorEnd
    relative_to: MjcfSensorEnd
    noise: float
    cutoff: float
    shape: str = ""
    size: tuple[float, ...] = ()
    attributes: Attributes = ()


@dataclass(frozen=True, slots=True)
class MjcfNamedPose:
    """A keyframe. Joints are referred to by their numbers."""

    name: str
    values: tuple[tuple[int, float], ...]
    """(joint, value) [rad or m] of every hinge and slide."""

    moved: tuple[int, ...] = ()
    """The balls and free joints that are not at qpos0."""

    floating: tuple[tuple[int, tuple[float, ...]], ...] = ()
    """(joint, numbers in `qpos`) of free joints."""

    scene: tuple[float, ...] = ()
    """The numbers in `qpos` of the objects of the scene around the robot."""


@dataclass(frozen=True, slots=True, eq=False)
class Mjcf:
    """The robot of a model. Joints are counted from 0 through the bodies, and so are sites."""

    name: str
    bodies: tuple[MjcfBody, ...]
    """The world first; a body's parent comes before it."""

    closures: tuple[MjcfClosure, ...]
    relations: tuple[MjcfRelation, ...]
    diagnostics: tuple[Diagnostic, ...]
    """The elements left out."""

    actuators: tuple[MjcfActuator, ...] = ()
    sensors: tuple[MjcfSensor, ...] = ()
    keyframes: tuple[MjcfNamedPose, ...] = ()
    extras: MjcfExtras = NO_EXTRAS
    """The content that only an MJCF has, except that of the bodies, joints and other things here. In its
    order of actuators and sensors, "" is the next of these that has no name."""
