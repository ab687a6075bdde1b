"""A mechanism at its saved pose: bodies, and what couples them. It has no root and no direction yet.

Every reader makes one, and all frames in it are given in the world: the assembly's own frame, at the
pose that the source was saved in.
"""

from dataclasses import dataclass
from typing import Protocol

from stages.graph.keys import GraphKeys
from stages.robot.bundle import Bundle
from stages.robot.diagnostics import Diagnostics
from stages.robot.errors import Diagnostic
from stages.robot.model import (
    Array,
    Dof,
    Inertial,
    JointType,
    MateRef,
    Part,
    Primitive,
    Provenance,
    Transmission,
)

WORLD_LINK = "world"
"""The link that the assembly's origin is, where something moves against it."""


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """What moves as one. Its parts have the world for their link's frame.

    `path`: the occurrence that names it. `titles`: all names that mean it, as typed in CAD. `held`:
    why it is fixed to the world; "" if it is not. `world_from_body` (4, 4): its own frame, which it
    keeps where it is the root. `given`: an inertial in the world's frame in place of the parts' sum.
    `afloat`: what the source calls the joint by which the body floats in the world ("" for no name), None
    where it does not say that it floats.
    """

    name: str
    path: tuple[str, ...]
    parts: tuple[Part, ...]
    titles: frozenset[str]
    held: str
    world_from_body: Array
    given: Inertial | None = None
    shapes: tuple[Primitive, ...] = ()
    afloat: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Coupling:
    """What lets two bodies move against each other: a mate, or a joint of a URDF.

    `bodies` and `world_from_frames` (4, 4 each, right-handed) are of its first and second entity; the
    chain `dofs` leads from the second to the first, and `residual` [m or rad] is what it does not
    explain of the saved pose. `title` is its place in CAD. `unknown` says why its limits, which CAD
    has, are not known; `doubts` which of them contradict themselves, `half_open` which are open where the
    other side is not. `closes`: the source itself has it close a loop, so it is cut before any other.
    """

    name: str
    type: JointType
    bodies: tuple[int, int]
    world_from_frames: tuple[Array, Array]
    dofs: tuple[Dof, ...]
    residual: float
    ref: MateRef
    title: str
    unknown: str = ""
    doubts: tuple[str, ...] = ()
    half_open: tuple[str, ...] = ()
    closes: bool = False

    @property
    def limited(self) -> bool:
        return any((dof.limits.lower, dof.limits.upper) != (None, None) for dof in self.dofs)


@dataclass(frozen=True, slots=True)
class Bond:
    """A relation as drawn: its type, the names of its couplings ("" for one that moves nothing).

    `ratio` counts for GEAR and LINEAR, `length` [m a turn] for RACK_AND_PINION and SCREW. The second
    coupling follows, in the opposite direction unless `reverse`. A MIMIC is said in full, of dofs instead of
    couplings: the second is `ratio` · the first + `offset`, whatever moves and whatever the sign. Of the
    others the offset is None, for that of the saved pose, unless the user gives one. `name`: the relation's
    own, where its source or the robot gives it one. `sure`: the user has said which way it goes.
    """

    title: str
    type: str
    couplings: tuple[str, ...]
    ratio: float
    length: float
    reverse: bool
    offset: float | None = None
    name: str = ""
    sure: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Marker:
    """A frame that the designer named. `source`: the name as typed."""

    name: str
    title: str
    body: int
    world_from_frame: Array
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class Mechanism:
    """Bodies and couplings by their numbers. Names are unique among bodies, among couplings and dofs, and
    among markers; those of a drawing over all of them.

    `root`: the body that the source itself hangs the others on, None where it says none. `posed`: whether
    someone left it in this pose; that of a file is where all its joints are at zero, and means nothing.
    `unstated_base`: what to report where nothing fixes the root, of a source that cannot say so.
    """

    bodies: tuple[Body, ...]
    couplings: tuple[Coupling, ...]
    bonds: tuple[Bond, ...]
    markers: tuple[Marker, ...]
    provenance: Provenance
    root: int | None = None
    posed: bool = True
    transmissions: tuple[Transmission, ...] = ()
    controls: tuple[str, ...] = ()
    unstated_base: Diagnostic | None = None


class Reader(Protocol):
    """Reads a bundle into a mechanism. One for each kind of source, as `stages.graph.READERS` lists them.

    The keys come back with what the source's own conventions imply. AssemblyError for what cannot be read
    at all; every other problem goes to the log.
    """

    def __call__(self, bundle: Bundle, keys: GraphKeys, log: Diagnostics) -> tuple[Mechanism, GraphKeys]: ...
