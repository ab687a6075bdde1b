"""An MJCF as a value, as MuJoCo compiled it.

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
    """A joint of a body: with its `anchor` (3,) p, its `axis` (3,) and `ref` q₀ it takes the body's frame
    by T(p) M(axis, q − q₀) T(−p). `axis` is a unit vector, zero for a ball or free motion. `attributes`: what
    the file says of it beside that."""

    name: str
    type: MjcfJointType
    anchor: Array
    axis: Array
    ref: float
    limits: Limits
    dynamics: Dynamics
    spring: Spring | None = None
    attributes: Attributes = ()


@dataclass(frozen=True, slots=True, eq=False)
class MjcfGeom:
    """A shape of a body. `size` [m] as in `model.Primitive`, () for a mesh, whose triangles are `mesh`.

    `collides`: whether any other geom may touch it; `seen`: whether it is looked at. `form`: its name, and
    what the file says of it beside its shape; an ellipsoid is a mesh here.
    """

    form: GeomForm
    kind: MjcfGeomKind
    size: tuple[float, ...]
    mesh: MeshRef | None
    body_from_geom: Array
    colour: Colour | None
    collides: bool
    seen: bool


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
    """A body: its `joints` act one after the other. `inertial` in the body's frame, None without mass;
    `axes` (3, 3): those of its inertia there, in the file's order."""

    name: str
    parent: int
    parent_from_body: Array
    inertial: Inertial | None
    joints: tuple[MjcfJoint, ...]
    geoms: tuple[MjcfGeom, ...]
    sites: tuple[MjcfSite, ...]
    axes: Array | None = None
    attributes: Attributes = ()
    mounted: tuple[MjcfPlaced, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class MjcfClosure:
    """An equality that holds two frames together, `a_from_frame` on the first of `bodies` and
    `b_from_frame` on the second: a connect their origins, a weld all of them. `sites`: the names of the
    two sites that it names, "" where it names bodies."""

    name: str
    type: Literal["connect", "weld"]
    bodies: tuple[int, int]
    sites: tuple[str, str]
    a_from_frame: Array
    b_from_frame: Array
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
    """An actuator of a hinge or slide, as `actuation.Actuator`."""

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
    """What a sensor is on: a joint, actuator, site, body or xbody by its number; "" and -1 for nothing."""

    kind: str
    number: int


@dataclass(frozen=True, slots=True)
class MjcfSensor:
    """A sensor, as `sensing.Sensor`."""

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
    """A keyframe: (joint, value) [rad or m] of every hinge and slide, and the balls and free joints that are
    elsewhere than at qpos0, all by their numbers. `floating`: (joint, numbers in `qpos`) of free joints;
    `scene`: the numbers in `qpos` of what is in the scene beside the robot."""

    name: str
    values: tuple[tuple[int, float], ...]
    moved: tuple[int, ...] = ()
    floating: tuple[tuple[int, tuple[float, ...]], ...] = ()
    scene: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Mjcf:
    """A model's robot. `bodies[0]` is the world; a body's parent comes before it, and the joints are counted
    from 0 through the bodies, as are the sites. `diagnostics`: what is left out. `extras`: what only an MJCF
    says, but for what is at the bodies, joints and other things here; in the order of actuators and sensors
    there, "" stands for the next of those here that has no name."""

    name: str
    bodies: tuple[MjcfBody, ...]
    closures: tuple[MjcfClosure, ...]
    relations: tuple[MjcfRelation, ...]
    diagnostics: tuple[Diagnostic, ...]
    actuators: tuple[MjcfActuator, ...] = ()
    sensors: tuple[MjcfSensor, ...] = ()
    keyframes: tuple[MjcfNamedPose, ...] = ()
    extras: MjcfExtras = NO_EXTRAS
