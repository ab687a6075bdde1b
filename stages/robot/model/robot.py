"""Describes the robot as a value: links, joints, loops, relations, frames.

Conventions: SI units; radians; a transform `a_from_b` is a (4, 4) array that takes coordinates in
frame b to frame a, so names read left to right and cancel. Arrays are float64 and read-only.

A link's frame is its joint's frame; the root link's frame is the assembly origin, or the frame that
the user chose. q = 0 is where the two mate frames coincide, and q is the pose of the mate's first
entity relative to its second, unless the user counts it from another zero or in the opposite direction.
"""

from dataclasses import dataclass, field
from typing import Literal

from linkwright.stages.robot.errors import Diagnostic

# Part of the model, each in a module of its own.
from linkwright.stages.robot.model.actuation import Actuator as Actuator
from linkwright.stages.robot.model.arrays import Array as Array
from linkwright.stages.robot.model.arrays import frozen as frozen
from linkwright.stages.robot.model.dofs import Configuration as Configuration
from linkwright.stages.robot.model.dofs import Dof as Dof
from linkwright.stages.robot.model.dofs import DofKind as DofKind
from linkwright.stages.robot.model.dofs import Dynamics as Dynamics
from linkwright.stages.robot.model.dofs import Limits as Limits
from linkwright.stages.robot.model.dofs import MateValue as MateValue
from linkwright.stages.robot.model.dofs import Spring as Spring
from linkwright.stages.robot.model.dofs import Value as Value
from linkwright.stages.robot.model.geom_form import PLAIN, GeomForm
from linkwright.stages.robot.model.mjcf_extras import MjcfExtras
from linkwright.stages.robot.model.semantics import NO_SEMANTICS, RobotSemantics
from linkwright.stages.robot.model.sensing import Sensor as Sensor
from linkwright.stages.robot.model.transmission import Transmission as Transmission

JointType = Literal[
    "fixed",
    "revolute",
    "prismatic",
    "cylindrical",
    "ball",
    "planar",
    "pin_slot",
    "parallel",
    "free",
    "compound",
]
"""A mate's types; `compound` is any other chain of dofs, such as three hinges that a file gives one body."""


@dataclass(frozen=True, slots=True, eq=False)
class Inertial:
    """The mass [kg], the centre of mass [m] (3,) and the inertia about it [kg m²] (3, 3) of a body, in the
    axes of the owning frame.

    The tensor has true signs: off-diagonal entries are −∫xy dm.
    """

    mass: float
    com: Array
    inertia: Array


@dataclass(frozen=True, slots=True)
class MeshRef:
    """A reference to a part's triangles: a reply of the bundle (by digest) and the part's id in it."""

    reply: str
    part: str


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """An occurrence of a part, as CAD has it. Its inertial and volume [m³] are in its own frame."""

    path: tuple[str, ...]
    """Ids of instances from the root."""
    name: str
    """The same in words, joined by "/"."""
    part_id: str
    mesh: MeshRef | None
    link_from_part: Array
    world_from_part: Array
    inertial: Inertial
    volume: float
    collides: bool = True
    """Whether its shape takes part in contact; a sheet without mass is only visual."""
    seen: bool = True
    """Whether it is visual; a mesh made only for contact is not."""
    standard: bool = False
    """Whether it is standard content, such as a screw."""
    estimated: bool = False
    """Whether its mass is estimated from its volume."""
    form: GeomForm = PLAIN


PrimitiveKind = Literal["box", "sphere", "cylinder", "capsule", "ellipsoid"]
"""Only an MJCF has ellipsoids: no link has an ellipsoid as a shape."""


@dataclass(frozen=True, slots=True, eq=False)
class Primitive:
    """A shape that is no mesh."""

    kind: PrimitiveKind
    size: tuple[float, ...]
    """[m]: lengths of a box along x, y, z; (radius,) of a sphere; (radius, length) of a cylinder or capsule
    along z, without the capsule's caps."""
    link_from_shape: Array
    colour: tuple[float, float, float, float] | None = None
    """RGBA in 0..1; None for neutral grey."""
    visual: bool = True
    collision: bool = True
    form: GeomForm = PLAIN


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A rigid body. A link that CAD does not have has no path and no parts."""

    name: str
    inertial: Inertial
    parts: tuple[Part, ...]
    """Sorted by path."""
    path: tuple[str, ...]
    """The occurrence that names it."""
    given: Inertial | None = None
    """The inertial that replaces the sum of the parts, given by the user or raised to the minimum of
    engines."""
    shapes: tuple[Primitive, ...] = ()
    """Primitives beside the parts."""


@dataclass(frozen=True, slots=True)
class MateRef:
    """The CAD feature behind a joint: owning occurrence path, feature id, its name and mate type.

    `copy`: the instance for which a pattern or mirror repeats it; "" for the feature itself.
    """

    owner: tuple[str, ...]
    feature: str
    name: str
    type: str
    copy: str = ""

    @property
    def key(self) -> tuple[tuple[str, ...], str, str]:
        """Its identifier."""
        return self.owner, self.feature, self.copy


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """A parent link, a child link and the dofs between them, from parent to child.

    The child's frame at q is `parent_from_joint @ Π dof.origin @ motion(dof, q)`. A mate is the chain
    second entity → slides → turn → first entity; where the second is the child it runs `backwards`:
    the dofs in reverse, each axis negated (a ball's quaternion conjugated), so that q keeps the mate's
    own meaning. `mate` is None for a joint that CAD does not have.
    """

    name: str
    type: JointType
    parent: str
    child: str
    parent_from_joint: Array
    dofs: tuple[Dof, ...]
    backwards: bool
    mate: MateRef | None


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """A mate that closes a loop and is not in the tree.

    The mate's first entity is on `link_a` at `a_from_frame`, its second on `link_b` at `b_from_frame`: closed
    where world_from_a @ a_from_frame is world_from_b @ b_from_frame @ Π dof.origin @ motion(dof, q) for some
    q. `lever` [m] is a length on the loop's own scale; `solref` is MuJoCo's. `residual` [m, rad] is the
    closure error at the saved pose.
    """

    name: str
    type: JointType
    link_a: str
    link_b: str
    a_from_frame: Array
    b_from_frame: Array
    dofs: tuple[Dof, ...]
    lever: float
    solref: tuple[float, float]
    residual: float
    mate: MateRef


@dataclass(frozen=True, slots=True)
class Relation:
    """A relation: `follower` = multiplier · `driver` + offset, by names of dofs."""

    name: str
    follower: str
    driver: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True)
class Keyframe:
    """A named pose: the values [rad or m] of the dofs that it gives, in the order of the dofs."""

    name: str
    given: tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A named frame fixed to a link."""

    name: str
    link: str
    link_from_frame: Array
    source: str
    """The mate connector's name as typed; "" without a connector."""
    joint: str = ""
    """Name of the fixed joint that holds it in the source; "" for none."""


@dataclass(frozen=True, slots=True)
class Base:
    """How the root link is connected to the world."""

    fixed: bool
    """Whether it is fixed to the world."""
    reason: str
    """Why."""
    joint: str = ""
    """Name in the source of the joint by which it floats; "" for no name."""


@dataclass(frozen=True, slots=True)
class Provenance:
    """The document of this robot, without the kind of source and the host.

    document: id of the document.
    element: id of its tab.
    microversion: state of the document.
    configuration: configuration of the assembly.
    """

    document: str
    element: str
    microversion: str
    configuration: str


@dataclass(frozen=True, slots=True)
class Mobility:
    """The mobility of a mechanism."""

    coordinates: int
    """Dofs of the tree."""
    gruebler: int
    """Coordinates less the conditions of relations and loops, counted as if all were independent."""
    dof: int
    """Coordinates less the rank of these conditions at the saved pose."""
    redundant: tuple[tuple[str, int], ...]
    """(loop, number of its conditions that follow from others)."""


@dataclass(frozen=True, slots=True, eq=False)
class Robot:
    """A robot, with links and joints in tree order: the root first, a parent before its children. A root link
    called `world` is the assembly's origin. Names are unique among links, among joints and dofs (those of
    loops too), among frames, and among loops and relations."""

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    relations: tuple[Relation, ...]
    frames: tuple[Frame, ...]
    base: Base
    world_from_root: Array
    """Pose (4, 4) of the root link's frame in the assembly at the saved pose."""
    mobility: Mobility
    provenance: Provenance
    diagnostics: tuple[Diagnostic, ...] = field(default=())
    transmissions: tuple[Transmission, ...] = ()
    controls: tuple[str, ...] = ()
    """Texts of the <transmission>s and <ros2_control>s of the source's URDF."""
    actuators: tuple[Actuator, ...] = ()
    """Those of the source."""
    sensors: tuple[Sensor, ...] = ()
    """Those of the source."""
    keyframes: tuple[Keyframe, ...] = ()
    """Poses that the user gives; `home` may be among them."""
    semantics: RobotSemantics = NO_SEMANTICS
    """Content of the source's SRDF."""
    mjcf: MjcfExtras | None = None
    """Extras of an MJCF source."""

    @property
    def root(self) -> Link:
        """The root link."""
        return self.links[0]

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """All coordinates, in the order of the joints."""
        return tuple(dof for joint in self.joints for dof in joint.dofs)

    def link(self, name: str) -> Link:
        """Returns the link with a name."""
        return next(link for link in self.links if link.name == name)
