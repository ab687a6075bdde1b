"""Describes the robot as a value: links, joints, loops, relations, frames.

Conventions: SI units; radians; a transform `a_from_b` is a (4, 4) array that takes coordinates in
frame b to frame a, so names read left to right and cancel. Arrays are float64 and read-only.

A link's frame is the frame of the joint that moves it; the frame of the root link is the assembly's origin,
or a frame that the user chose. The values q of a joint are the pose of its mate's first entity relative to
the second, and 0 where the frames of both coincide, unless the user chose another zero or direction.
"""

from dataclasses import dataclass, field
from typing import Literal

from linkwright.stages.robot.errors import Diagnostic

# Classes of the model that have modules of their own, exported here.
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
"""The type of a joint, as of a mate; `compound` is any other chain of dofs, such as three hinges of a body in
an MJCF."""


@dataclass(frozen=True, slots=True, eq=False)
class Inertial:
    """The mass [kg], the centre of mass (3,) [m] and the inertia about it (3, 3) [kg m²] of a body, in the
    frame of its owner. The off-diagonal entries of the inertia are −∫xy dm."""

    mass: float
    com: Array
    inertia: Array


@dataclass(frozen=True, slots=True)
class MeshRef:
    """A reference to a part's triangles: the digest of a reply or file of the bundle, and the part's id in
    it."""

    reply: str
    part: str


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """An occurrence of a part, as CAD has it. Its inertial and volume [m³] are in its own frame."""

    path: tuple[str, ...]
    """Ids of the instances from the root assembly down to the part."""
    name: str
    """Names of the same instances, joined by "/"."""
    part_id: str
    mesh: MeshRef | None
    """The triangles; None without triangles."""
    link_from_part: Array
    """Pose (4, 4) of the part in its link."""
    world_from_part: Array
    """Pose (4, 4) of the part in the assembly, at the saved pose."""
    inertial: Inertial
    volume: float
    collides: bool = True
    """Whether the part takes part in contact; a sheet without mass does not."""
    seen: bool = True
    """Whether the part is visual; a mesh that is only for contact is not."""
    standard: bool = False
    """Whether the part is standard content, such as a screw."""
    estimated: bool = False
    """Whether the mass is estimated from the volume."""
    form: GeomForm = PLAIN


PrimitiveKind = Literal["box", "sphere", "cylinder", "capsule", "ellipsoid"]
"""The kind of a primitive. No link has an ellipsoid: only `geometry.Shape.ellipsoid` is one."""


@dataclass(frozen=True, slots=True, eq=False)
class Primitive:
    """A shape that is described by a few lengths and not by a mesh."""

    kind: PrimitiveKind
    size: tuple[float, ...]
    """Lengths [m]: of a box or ellipsoid along x, y and z; (radius,) of a sphere; (radius, length along z) of
    a cylinder or capsule, without the caps of the capsule."""
    link_from_shape: Array
    """Pose (4, 4) of the shape in the link."""
    colour: tuple[float, float, float, float] | None = None
    """RGBA in 0..1; None for the default grey."""
    visual: bool = True
    collision: bool = True
    form: GeomForm = PLAIN


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A rigid body. A link without a counterpart in CAD has no path and no parts."""

    name: str
    inertial: Inertial
    parts: tuple[Part, ...]
    """Sorted by path."""
    path: tuple[str, ...]
    """Path of the occurrence that the link is named by."""
    given: Inertial | None = None
    """The inertial in place of the sum of the parts, by the user or raised to the minimum of engines."""
    shapes: tuple[Primitive, ...] = ()
    """The primitives of the link, beside its parts."""


@dataclass(frozen=True, slots=True)
class MateRef:
    """The mate in CAD that a joint or loop comes from, by the id of its feature, its name and its type."""

    owner: tuple[str, ...]
    """Path of the assembly that has the mate."""
    feature: str
    name: str
    type: str
    copy: str = ""
    """The instance for which a pattern or mirror repeats the mate; "" for the mate itself."""

    @property
    def key(self) -> tuple[tuple[str, ...], str, str]:
        """The identifier of the mate."""
        return self.owner, self.feature, self.copy


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """A parent link, a child link and the dofs between them, from parent to child.

    parent_from_child at q is `parent_from_joint @ Π dof.origin @ motion(dof, q)`. A mate is the chain second
    entity → slides → turn → first entity. If the second entity is on the child, the chain runs `backwards`:
    the dofs are in reverse order and each axis is negated (a ball's quaternion is conjugated), so that q has
    the same meaning as in the mate. `mate` is None for a joint without a mate.
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

    The mate's first entity is on `link_a` at `a_from_frame`, its second on `link_b` at `b_from_frame`. The
    loop is closed if world_from_a @ a_from_frame equals world_from_b @ b_from_frame @ Π dof.origin @
    motion(dof, q) for some q. `lever` [m] is a length of the scale of the loop, `solref` is that of MuJoCo,
    and `residual` [m, rad] is the error of the closure at the saved pose.
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
    """A relation of two dofs by their names: `follower` = multiplier · `driver` + offset [rad or m]."""

    name: str
    follower: str
    driver: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True)
class Keyframe:
    """A named pose. `given`: (dof, value [rad or m]) for the dofs that the user gives, in the order of the
    dofs."""

    name: str
    given: tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A named frame fixed to a link."""

    name: str
    link: str
    link_from_frame: Array
    source: str
    """Name of the mate connector in CAD; "" without a connector."""
    joint: str = ""
    """Name of the fixed joint that holds the frame in the source; "" without such a joint."""


@dataclass(frozen=True, slots=True)
class Base:
    """The connection of the root link to the world."""

    fixed: bool
    """Whether the root link is fixed to the world."""
    reason: str
    """Why it is fixed or not, in words."""
    joint: str = ""
    """Name of the joint in the source by which it floats; "" without a name."""


@dataclass(frozen=True, slots=True)
class Provenance:
    """The document that a robot comes from, without the kind of source and the host.

    document: the id of the document.
    element: the id of the tab with the assembly.
    microversion: the state of the document.
    configuration: the configuration of the assembly.
    """

    document: str
    element: str
    microversion: str
    configuration: str


@dataclass(frozen=True, slots=True)
class Mobility:
    """The mobility of a robot."""

    coordinates: int
    """Number of coordinates of the tree."""
    gruebler: int
    """`coordinates` minus the number of conditions of relations and loops, as if all were independent."""
    dof: int
    """`coordinates` minus the rank of these conditions at the saved pose."""
    redundant: tuple[tuple[str, int], ...]
    """(loop, number of its conditions that depend on others)."""


@dataclass(frozen=True, slots=True, eq=False)
class Robot:
    """A robot, with links and joints in tree order: the root first, a parent before its children. A root link
    called `world` is the assembly's origin. Names are unique among links, among joints and dofs (including
    those of loops), among frames, and among loops and relations."""

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
    """The elements <transmission> and <ros2_control> of the source's URDF, as text."""
    actuators: tuple[Actuator, ...] = ()
    """The actuators of the source."""
    sensors: tuple[Sensor, ...] = ()
    """The sensors of the source."""
    keyframes: tuple[Keyframe, ...] = ()
    """The poses that the user gives; `home` may be among them."""
    semantics: RobotSemantics = NO_SEMANTICS
    """The content of the source's SRDF."""
    mjcf: MjcfExtras | None = None
    """The extras of an MJCF source; None for other sources."""

    @property
    def root(self) -> Link:
        """The root link."""
        return self.links[0]

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """The coordinates of the tree, in the order of the joints."""
        return tuple(dof for joint in self.joints for dof in joint.dofs)

    def link(self, name: str) -> Link:
        """Returns the link with this name, which must exist."""
        return next(link for link in self.links if link.name == name)
