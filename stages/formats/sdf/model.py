"""An SDF as a reader has it: poses in the model's frame, as the file's links stand."""

from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.formats.sdf.shapes import SdfShape
from linkwright.stages.robot.model.robot import Array, Dynamics, Inertial, Limits


@dataclass(frozen=True, slots=True, eq=False)
class SdfLink:
    """A link. `model_from_link` (4, 4); `inertial` in the link's axes. `falls`: whether gravity pulls it;
    `forced`: whether forces move it; `self_collides`: whether it collides with other links of its model."""

    name: str
    model_from_link: Array
    inertial: Inertial
    visuals: tuple[SdfShape, ...]
    collisions: tuple[SdfShape, ...]
    falls: bool
    forced: bool
    self_collides: bool


@dataclass(frozen=True, slots=True)
class SdfMimic:
    """value = multiplier · (value of `joint` − reference) + offset."""

    joint: str
    multiplier: float
    offset: float
    reference: float


@dataclass(frozen=True, slots=True, eq=False)
class ReadJoint:
    """A joint between two links; its parent may be `world`. `model_from_joint` (4, 4); `axis` (3,) in the
    joint's frame, None where it has none."""

    name: str
    type: str
    parent: str
    child: str
    model_from_joint: Array
    axis: Array | None
    limits: Limits
    dynamics: Dynamics
    mimic: SdfMimic | None


@dataclass(frozen=True, slots=True, eq=False)
class SdfFrame:
    """A frame. `link`: that it moves with; `model_from_frame` (4, 4)."""

    name: str
    link: str
    model_from_frame: Array


@dataclass(frozen=True, slots=True, eq=False)
class SdfModel:
    """The only model of a file. Names are unique over `links`, `joints` and `frames`; `root`: the link whose
    pose is the model's, unless the file says otherwise. `world_from_model` (4, 4); `self_collides`: whether
    its links collide with each other."""

    name: str
    root: str
    links: Mapping[str, SdfLink]
    joints: Mapping[str, ReadJoint]
    frames: Mapping[str, SdfFrame]
    world_from_model: Array
    self_collides: bool
