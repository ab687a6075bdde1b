"""Defines the values of an SDF: poses in the model's frame, as in the file."""

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
    """Whether forces move the link."""

    self_collides: bool
    """Whether the link collides with other links of its model."""


@dataclass(frozen=True, slots=True)
class SdfMimic:
    """A mimic: value = multiplier · (value of `joint` − reference) + offset."""

    joint: str
    multiplier: float
    offset: float
    reference: float


@dataclass(frozen=True, slots=True, eq=False)
class ReadJoint:
    """A joint between two links."""

    name: str
    type: str
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
    """The link whose pose is the model's, unless the file says otherwise."""

    links: Mapping[str, SdfLink]
    joints: Mapping[str, ReadJoint]
    frames: Mapping[str, SdfFrame]
    world_from_model: Array
    """(4, 4)."""

    self_collides: bool
    """Whether the links collide with each other."""
