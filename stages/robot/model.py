"""The robot as a value: links, joints, loops, relations, frames.

Conventions: SI units; radians; a transform `a_from_b` is a (4, 4) array that takes coordinates in
frame b to frame a, so names read left to right and cancel. Arrays are float64 and read-only.

A link's frame is its joint's frame; the root link's frame is the assembly origin. q = 0 is where
the two mate frames coincide, and q is the pose of the mate's first entity relative to its second.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from stages.robot.errors import Diagnostic

Array = npt.NDArray[np.float64]
JointType = Literal["revolute", "prismatic"]


def frozen(values: object) -> Array:
    """A read-only float64 array of `values`."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


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

    `path`: instance ids from the root; `name`: the same in words, joined by "/".
    `inertial` and `volume` [m³] are CAD's, in the part's own frame. `collides`: whether its shape
    takes part in contact; a sheet without mass is only seen.
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


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A rigid body. `path`: the occurrence that names it; `parts` are sorted by path."""

    name: str
    inertial: Inertial
    parts: tuple[Part, ...]
    path: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Limits:
    """The joint's range [rad or m] in the mate's own value; None is open."""

    lower: float | None = None
    upper: float | None = None


@dataclass(frozen=True, slots=True)
class Dynamics:
    """What moves and resists a joint; None is unset.

    damping [N m s/rad or N s/m], friction [N m or N], armature [kg m² or kg],
    effort [N m or N], velocity [rad/s or m/s].
    """

    damping: float | None = None
    friction: float | None = None
    armature: float | None = None
    effort: float | None = None
    velocity: float | None = None


@dataclass(frozen=True, slots=True)
class MateRef:
    """The CAD feature behind a joint: owning occurrence path, feature id, its name and mate type."""

    owner: tuple[str, ...]
    feature: str
    name: str
    type: str


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """One degree of freedom between a parent and a child link.

    The child's frame at value q is `parent_from_joint @ motion(q)`, where `motion` turns or slides
    about/along `axis` (3,), which is +z or −z: −z where the mate's first entity is the parent, so
    that q keeps the mate's own meaning. `saved` is q in the pose CAD was left in.
    """

    name: str
    type: JointType
    parent: str
    child: str
    parent_from_joint: Array
    axis: Array
    limits: Limits
    dynamics: Dynamics
    saved: float
    mate: MateRef


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """A mate that closes a loop: what the tree leaves open.

    The mate's first entity is on `link_a` at `a_from_frame`, its second on `link_b` at
    `b_from_frame`. `lever` [m] is a length on the loop's own scale; `solref` is MuJoCo's.
    `residual` [m] is how far the two frames' constraint is from met at the saved pose.
    """

    name: str
    type: JointType
    link_a: str
    link_b: str
    a_from_frame: Array
    b_from_frame: Array
    limits: Limits
    saved: float
    lever: float
    solref: tuple[float, float]
    residual: float
    mate: MateRef


@dataclass(frozen=True, slots=True)
class Relation:
    """`follower` = multiplier · `driver` + offset, in the joints' own values."""

    name: str
    follower: str
    driver: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A named frame fixed to a link (a mate connector, say)."""

    name: str
    link: str
    link_from_frame: Array
    source: str


@dataclass(frozen=True, slots=True)
class Base:
    """Whether the root link is fixed to the world, and why."""

    fixed: bool
    reason: str


@dataclass(frozen=True, slots=True)
class Provenance:
    """Which document this robot is: not the kind of source, nor the host."""

    document: str
    element: str
    microversion: str
    configuration: str


@dataclass(frozen=True, slots=True, eq=False)
class Robot:
    """Links and joints in tree order (a parent before its children; the root first)."""

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Loop, ...]
    relations: tuple[Relation, ...]
    frames: tuple[Frame, ...]
    base: Base
    provenance: Provenance
    diagnostics: tuple[Diagnostic, ...] = field(default=())

    @property
    def root(self) -> Link:
        return self.links[0]

    def link(self, name: str) -> Link:
        return next(link for link in self.links if link.name == name)
