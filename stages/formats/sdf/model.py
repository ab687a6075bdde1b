"""Defines the content of an SDF; poses are converted to the model's frame."""

from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.formats.sdf.shapes import SdfShape
from linkwright.stages.robot.model.robot import Array, Dynamics, Inertial, Limits


@dataclass(frozen=True, slots=True, eq=False)
class SdfLink:
    """A link."""

    name: str
    model_from_link: Array
    """(4, 4)."""

    inertial: Inertial
    """In the link's axes."""

    visuals: tuple[SdfShape, ...]
    collisions: tuple[SdfShape, ...]
    falls: bool
    """Whether gravity pulls the link."""

    forced: bool
    """Whether forces move the link: it is not `kinematic`."""

    self_collides: bool
    """Whether the link collides with other links of its model."""


@dataclass(frozen=True, slots=True)
class SdfMimic:
    """A mimic: value = multiplier · (value of `joint` − reference) + offset."""

    joint: str
    """The joint that drives it."""

    multiplier: float
    offset: float
    reference: float


@dataclass(frozen=True, slots=True, eq=False)
class ReadJoint:
    """A joint between two links."""

    name: str
    type: str
    """The type, with SDF's name."""

    parent: str
    """A link, or `world`."""

    child: str
    model_from_joint: Array
    """(4, 4)."""

    axis: Array | None
    """(3,) in the joint's frame; None without an axis."""

    limits: Limits
    dynamics: Dynamics
    mimic: SdfMimic | None


@dataclass(frozen=True, slots=True, eq=False)
class SdfFrame:
    """A frame."""

    name: str
    link: str
    """The link that the frame moves with."""

    model_from_frame: Array
    """(4, 4)."""


@dataclass(frozen=True, slots=True, eq=False)
class SdfModel:
    """The only model of a file. Names are unique over `links`, `joints` and `frames`."""

    name: str
    root: str
    """The canonical link: that of the attribute `canonical_link`, or else the first link."""

    links: Mapping[str, SdfLink]
    joints: Mapping[str, ReadJoint]
    frames: Mapping[str, SdfFrame]
    world_from_model: Array
    """(4, 4)."""

    self_collides: bool
    """Whether the links collide with each other."""
