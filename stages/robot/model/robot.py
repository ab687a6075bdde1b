"""The robot as a value: links, joints, loops, relations, frames.

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
from linkwright.stages.robot.model.semantics import NOTHING_MORE, RobotSemantics
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
    """Mass [kg], centre of mass [m] (3,), inertia about it [kg m²] (3, 3), axes of the owning frame.

    The tensor has true signs: off-diagonal entries are −∫xy dm.
    """

    mass: float
    com: Array
    inertia: Array


@dataclass(frozen=True, slots=True)
class MeshRef:
    """Where a part's triangles are: a reply of the bundle (by digest) and the part's id in it."""

    reply: str
    part: str


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One occurrence of a part, as CAD has it.

    `path`: instance ids from the root; `name`: the same in words, joined by "/". `inertial` and `volume` [m³]
    are CAD's, in the part's own frame. `collides`: whether its shape takes part in contact; a sheet without
    mass is only visual. `seen`: whether it is visual; a mesh made only for contact is not. `standard`:
    whether it is standard content, such as a screw. `estimated`: whether its mass is, from its volume.
    `form`: how an MJCF source has it.
    """

    path: tuple[str, ...]
    name: str
    part_id: str
    mesh: MeshRef | None
    link_from_part: Array
    world_from_part: Array
    inertial: Inertial
    volume: float
    collides: bool = True
    seen: bool = True
    standard: bool = False
    estimated: bool = False
    form: GeomForm = PLAIN


PrimitiveKind = Literal["box", "sphere", "cylinder", "capsule", "ellipsoid"]
"""An ellipsoid is one in an MJCF alone: no link has it as a shape."""


@dataclass(frozen=True, slots=True, eq=False)
class Primitive:
    """A shape that is no mesh. `size` [m]: a box's lengths along x, y, z; a sphere's (radius,); a
    cylinder's or capsule's (radius, length), along z, the caps of a capsule beyond its length.
    `colour`: RGBA in 0..1, None for neutral grey. `form`: how an MJCF source has it."""

    kind: PrimitiveKind
    size: tuple[float, ...]
    link_from_shape: Array
    colour: tuple[float, float, float, float] | None = None
    visual: bool = True
    collision: bool = True
    form: GeomForm = PLAIN


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A rigid body. `path`: the occurrence that names it; `parts` are sorted by path.

    `given`: the inertial that replaces the sum of the parts, as the user wants it or because engines
    take no less. `shapes`: primitives beside the parts. A link that CAD does not have has no path and
    no parts.
    """

    name: str
    inertial: Inertial
    parts: tuple[Part, ...]
    path: tuple[str, ...]
    given: Inertial | None = None
    shapes: tuple[Primitive, ...] = ()


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
    """`follower` = multiplier · `driver` + offset: names of dofs."""

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
    """A named frame fixed to a link. `source`: the mate connector's name as typed; "" if it is not one.
    `joint`: the name of the fixed joint that holds it in the source; "" for none."""

    name: str
    link: str
    link_from_frame: Array
    source: str
    joint: str = ""


@dataclass(frozen=True, slots=True)
class Base:
    """Whether the root link is fixed to the world, and why. `joint`: what the source calls the joint by
    which it floats; "" for no name."""

    fixed: bool
    reason: str
    joint: str = ""


@dataclass(frozen=True, slots=True)
class Provenance:
    """Which document this robot is: not the kind of source, nor the host.

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
    """How a mechanism can move. `coordinates`: dofs of the tree. `gruebler`: these less the conditions of
    relations and loops, counted as if all were independent. `dof`: the same by the rank of the conditions at
    the saved pose. `redundant`: (loop, how many of its conditions follow from others)."""

    coordinates: int
    gruebler: int
    dof: int
    redundant: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Robot:
    """Links and joints in tree order (a parent before its children; the root first).

    `world_from_root` (4, 4): where the root link's frame is in the assembly at the saved pose. A root
    link called `world` is the assembly's origin itself. Names are unique among links, among joints and
    dofs (those of loops too), among frames, and among loops and relations. `controls`: how the joints are
    driven, in the words of the source's URDF: the text of its <transmission>s and <ros2_control>s.
    `actuators` and `sensors`: those that the source has itself.
    `keyframes`: the poses that the user gives; `home` may be one of them. `semantics`: what the source's
    SRDF says. `mjcf`: what only an MJCF has, of a source that is one.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    relations: tuple[Relation, ...]
    frames: tuple[Frame, ...]
    base: Base
    world_from_root: Array
    mobility: Mobility
    provenance: Provenance
    diagnostics: tuple[Diagnostic, ...] = field(default=())
    transmissions: tuple[Transmission, ...] = ()
    controls: tuple[str, ...] = ()
    actuators: tuple[Actuator, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    keyframes: tuple[Keyframe, ...] = ()
    semantics: RobotSemantics = NOTHING_MORE
    mjcf: MjcfExtras | None = None

    @property
    def root(self) -> Link:
        return self.links[0]

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """All coordinates, in the order of the joints."""
        return tuple(dof for joint in self.joints for dof in joint.dofs)

    def link(self, name: str) -> Link:
        return next(link for link in self.links if link.name == name)
