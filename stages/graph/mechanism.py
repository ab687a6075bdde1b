"""A mechanism at its saved pose: rigid bodies and the connections between them, without a root.

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
    """Parts that move as one. Their `link_from_part` is given in the world's frame.

    `path`: the occurrence that names it. `titles`: all its names, as typed in CAD.
    `fixed_reason`: why it is fixed to the world; "" if it is not. `world_from_body` (4, 4): its own frame,
    which it keeps as the root. `given`: an inertial in the world's frame in place of the parts'
    sum. `afloat`: the name in the source of the joint by which the body floats in the world ("" for no
    name), None where the source has no such joint.
    """

    name: str
    path: tuple[str, ...]
    parts: tuple[Part, ...]
    titles: frozenset[str]
    fixed_reason: str
    world_from_body: Array
    given: Inertial | None = None
    shapes: tuple[Primitive, ...] = ()
    afloat: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Connection:
    """A mate, or a joint of a file: lets two bodies move relative to each other.

    `bodies` and `world_from_frames` (4, 4 each, right-handed) are of its first and second entity; the
    chain `dofs` leads from the second to the first, and `residual` [m or rad] is its error at
    the saved pose. `title` is its place in CAD. `closes`: it closes a loop in the source itself, so it is cut
    first. `solref`: MuJoCo's, of an MJCF source.
    """

    name: str
    type: JointType
    bodies: tuple[int, int]
    world_from_frames: tuple[Array, Array]
    dofs: tuple[Dof, ...]
    residual: float
    ref: MateRef
    title: str
    closes: bool = False
    solref: tuple[float, float] | None = None

    @property
    def limited(self) -> bool:
        return any((dof.limits.lower, dof.limits.upper) != (None, None) for dof in self.dofs)


@dataclass(frozen=True, slots=True)
class RelationSpec:
    """A relation as drawn: its type and the names of its connections ("" for a connection that moves
    nothing).

    `ratio` counts for GEAR and LINEAR, `length` [m a turn] for RACK_AND_PINION and SCREW. The second
    connection follows, in the opposite direction unless `reverse`. A MIMIC is complete, and names dofs
    instead of connections: the second is `ratio` · the first + `offset`, whatever their kinds and sign. In
    the other types an `offset` of None means that of the saved pose. `name`: the relation's own, where its
    source or the robot gives it one. `sure`: the user has chosen the direction.
    """

    title: str
    type: str
    connections: tuple[str, ...]
    ratio: float
    length: float
    reverse: bool
    offset: float | None = None
    name: str = ""
    sure: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Marker:
    """A frame that the designer named. `source`: the name as typed; `joint`: the name of the fixed joint that
    holds it in the source; "" for none."""

    name: str
    title: str
    body: int
    world_from_frame: Array
    source: str
    joint: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Mechanism:
    """Bodies and the connections between them, which refer to bodies by number. Names are unique among
    bodies, among connections and dofs, and among markers; those of a CAD assembly over all of them.

    `root`: the body that is the root in the source itself, if any. `has_saved_pose`: whether the source has
    a saved pose; a robot file has none, so all its joints are at zero. `unstated_base`: the diagnostic
    for a root that nothing fixes, where the source cannot express whether it is fixed. `keyframes`: the named
    poses of the source, in its own values. `mjcf`: what only an MJCF has; then the bodies are in its order.
    `demands_limits`: whether the source's format demands numbers for limits, so that some stand for none.
    `semantics`: what its SRDF says, by the names in the source.
    """

    bodies: tuple[RigidBody, ...]
    connections: tuple[Connection, ...]
    relations: tuple[RelationSpec, ...]
    markers: tuple[Marker, ...]
    provenance: Provenance
    root: int | None = None
    has_saved_pose: bool = True
    transmissions: tuple[Transmission, ...] = ()
    controls: tuple[str, ...] = ()
    actuators: tuple[Actuator, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    keyframes: tuple[Keyframe, ...] = ()
    mjcf: MjcfExtras | None = None
    unstated_base: Diagnostic | None = None
    demands_limits: bool = False
    semantics: RobotSemantics = NOTHING_MORE


class MechanismReader(Protocol):
    """Reads a bundle into a mechanism. There is a reader for each kind of source: `stages.graph.reader_of`.

    Also returns the keys, completed by the source's own conventions. AssemblyError for a source that cannot
    be read at all; every other problem goes to the log.
    """

    def __call__(
        self, bundle: Bundle, keys: GraphSections, log: Diagnostics
    ) -> tuple[Mechanism, GraphSections]: ...
