"""Describes a mechanism at its saved pose: rigid bodies and the connections between them, without a root.

Every reader makes a mechanism. All frames in it are given in the world: the assembly's own frame, at the
pose that the source was saved in.
"""

from dataclasses import dataclass
from typing import Protocol

from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.mjcf_extras import MjcfExtras
from linkwright.stages.robot.model.robot import (
    Actuator,
    Array,
    Dof,
    Inertial,
    JointType,
    Keyframe,
    MateRef,
    Part,
    Primitive,
    Provenance,
    Sensor,
    Transmission,
)
from linkwright.stages.robot.model.semantics import NO_SEMANTICS, RobotSemantics

WORLD_LINK = "world"
"""The link of the assembly's origin, where something moves relative to it."""


@dataclass(frozen=True, slots=True, eq=False)
class RigidBody:
    """Parts that move together. Their `link_from_part` is given in the world's frame."""

    name: str
    path: tuple[str, ...]
    """Path of the occurrence after which the body is named."""
    parts: tuple[Part, ...]
    titles: frozenset[str]
    """All names of the body in CAD, as typed."""
    fixed_reason: str
    """The reason why the body is fixed to the world; "" if it is not fixed."""
    world_from_body: Array
    """Pose of the body's own frame (4, 4), which stays its frame if the body is the root."""
    own_inertial: Inertial | None = None
    """An inertial in the world's frame in place of the parts' sum."""
    shapes: tuple[Primitive, ...] = ()
    floating_joint: str | None = None
    """Name in the source of the joint by which the body floats in the world: "" for an unnamed joint, None if
    there is no such joint."""


@dataclass(frozen=True, slots=True, eq=False)
class Connection:
    """A mate, or a joint of a file, by which two bodies move relative to each other."""

    name: str
    type: JointType
    bodies: tuple[int, int]
    """The bodies of its first and second entity."""
    world_from_frames: tuple[Array, Array]
    """The frames of its first and second entity (4, 4 each, right-handed)."""
    dofs: tuple[Dof, ...]
    """The chain from the second entity to the first."""
    residual: float
    """Difference between the chain and the bodies at the saved pose [m or rad]."""
    ref: MateRef
    title: str
    """Name of the connection with its path in CAD."""
    closes: bool = False
    """Whether the source itself has it as the closure of a loop, so that loops are cut here first."""
    solref: tuple[float, float] | None = None
    """MuJoCo's solref of an MJCF source."""

    @property
    def has_limits(self) -> bool:
        """Whether any of its dofs has a limit."""
        return any((dof.limits.lower, dof.limits.upper) != (None, None) for dof in self.dofs)


@dataclass(frozen=True, slots=True)
class RelationSpec:
    """A relation of the source: the second of two connections follows the first.

    A MIMIC is complete, and names dofs instead of connections: the second is `ratio` · the first + `offset`,
    whatever their kinds and sign.
    """

    title: str
    type: str
    connections: tuple[str, ...]
    """Names of the connections; "" for a connection that moves nothing."""
    ratio: float
    """Ratio of a GEAR or LINEAR, and factor of a MIMIC."""
    length: float
    """Length for each turn [m] of a RACK_AND_PINION or SCREW."""
    reverse: bool
    """Whether the second connection follows in the same direction; otherwise in the opposite."""
    offset: float | None = None
    """Offset [rad or m] of the follower; None for the offset at the saved pose."""
    name: str = ""
    """Name of the relation, if the source or the configuration gives one."""
    is_direction_chosen: bool = False
    """Whether the user has chosen the direction."""


@dataclass(frozen=True, slots=True, eq=False)
class Marker:
    """A frame that the designer named."""

    name: str
    title: str
    body: int
    world_from_frame: Array
    source: str
    """Name of the frame in the source, as typed."""
    joint: str = ""
    """Name of the fixed joint that holds the frame in the source; "" without one."""


@dataclass(frozen=True, slots=True, eq=False)
class Mechanism:
    """Bodies and the connections between them, which refer to bodies by index. Names are unique among bodies,
    among connections and dofs, and among markers; names of a CAD assembly are unique among all of these."""

    bodies: tuple[RigidBody, ...]
    connections: tuple[Connection, ...]
    relations: tuple[RelationSpec, ...]
    markers: tuple[Marker, ...]
    provenance: Provenance
    root: int | None = None
    """The body that is the root in the source itself, if any."""
    has_saved_pose: bool = True
    """Whether the source has a saved pose. A robot file has none, so all its joints are at zero."""
    transmissions: tuple[Transmission, ...] = ()
    controls: tuple[str, ...] = ()
    actuators: tuple[Actuator, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    keyframes: tuple[Keyframe, ...] = ()
    """Named poses of the source, in the values of its joints."""
    mjcf: MjcfExtras | None = None
    """The extras of an MJCF; then the bodies are in its order."""
    unstated_base: Diagnostic | None = None
    """The diagnostic for a root that nothing fixes, if the source cannot express whether it is fixed."""
    demands_limits: bool = False
    """Whether the source's format demands numbers for limits, so that some numbers mean no limit."""
    semantics: RobotSemantics = NO_SEMANTICS
    """Content of the source's SRDF, by the names in the source."""


class MechanismReader(Protocol):
    """A function that reads a bundle into a mechanism; `stages.graph.reader_of` has one for each kind of
    source. It also returns the keys, completed by the conventions of the source. It raises AssemblyError for
    a source that cannot be read at all; every other problem goes to the log.
    """

    def __call__(
        self, bundle: Bundle, keys: GraphSections, log: Diagnostics
    ) -> tuple[Mechanism, GraphSections]: ...
