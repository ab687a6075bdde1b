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
from linkwright.stages.robot.model.semantics import NOTHING_MORE, RobotSemantics

WORLD_LINK = "world"
"""The link of the assembly's origin, where something moves relative to it."""


@dataclass(frozen=True, slots=True, eq=False)
class RigidBody:
    """Parts that move together. Their `link_from_part` is given in the world's frame."""

    name: str
    path: tuple[str, ...]
    """The occurrence that names it."""
    parts: tuple[Part, ...]
    titles: frozenset[str]
    """All its names, as typed in CAD."""
    fixed_reason: str
    """Why it is fixed to the world; "" if it is not."""
    world_from_body: Array
    """Its own frame (4, 4), which it keeps as the root."""
    own_inertial: Inertial | None = None
    """An inertial in the world's frame in place of the parts' sum."""
    shapes: tuple[Primitive, ...] = ()
    afloat: str | None = None
    """Name in the source of the joint by which the body floats in the world: "" for an unnamed joint, None if
    there is no such joint."""


@dataclass(frozen=True, slots=True, eq=False)
class Connection:
    """A mate, or a joint of a file: lets two bodies move relative to each other."""

    name: str
    type: JointType
    bodies: tuple[int, int]
    """The bodies of its first and second entity."""
    world_from_frames: tuple[Array, Array]
    """The frames of its first and second entity (4, 4 each, right-handed)."""
    dofs: tuple[Dof, ...]
    """The chain from the second entity to the first."""
    residual: float
    """Error of the chain at the saved pose [m or rad]."""
    ref: MateRef
    title: str
    """Its place in CAD."""
    closes: bool = False
    """Whether it closes a loop in the source itself, so that it is cut first."""
    solref: tuple[float, float] | None = None
    """MuJoCo's solref of an MJCF source."""

    @property
    def limited(self) -> bool:
        """Whether any of its dofs has a limit."""
        return any((dof.limits.lower, dof.limits.upper) != (None, None) for dof in self.dofs)


@dataclass(frozen=True, slots=True)
class RelationSpec:
    """A relation as drawn, between two connections, of which the second follows.

    A MIMIC is complete, and names dofs instead of connections: the second is `ratio` · the first + `offset`,
    whatever their kinds and sign.
    """

    title: str
    type: str
    connections: tuple[str, ...]
    """Names of its connections; "" for a connection that moves nothing."""
    ratio: float
    """Ratio of a GEAR or LINEAR, and factor of a MIMIC."""
    length: float
    """Length a turn [m] of a RACK_AND_PINION or SCREW."""
    reverse: bool
    """Whether the second connection follows in the same direction; otherwise in the opposite."""
    offset: float | None = None
    """[rad or m]; None means the offset of the saved pose."""
    name: str = ""
    """Its own name, if its source or the robot gives it one."""
    sure: bool = False
    """Whether the user has chosen the direction."""


@dataclass(frozen=True, slots=True, eq=False)
class Marker:
    """A frame that the designer named."""

    name: str
    title: str
    body: int
    world_from_frame: Array
    source: str
    """Name as typed."""
    joint: str = ""
    """Name of the fixed joint that holds it in the source; "" for none."""


@dataclass(frozen=True, slots=True, eq=False)
class Mechanism:
    """Bodies and the connections between them, which refer to bodies by number. Names are unique among
    bodies, among connections and dofs, and among markers; those of a CAD assembly over all of them."""

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
    semantics: RobotSemantics = NOTHING_MORE
    """Content of its SRDF, by the names in the source."""


class MechanismReader(Protocol):
    """Reads a bundle into a mechanism. There is a reader for each kind of source: `stages.graph.reader_of`.

    Also returns the keys, completed by the source's own conventions. AssemblyError for a source that cannot
    be read at all; every other problem goes to the log.
    """

    def __call__(
        self, bundle: Bundle, keys: GraphSections, log: Diagnostics
    ) -> tuple[Mechanism, GraphSections]: ...
