"""What the graph stage is told about links and frames that CAD does not have."""

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, model_validator
from pydantic_core import PydanticCustomError

from stages.graph.mass_keys import Inertia, refused
from stages.robot.keys import Interval, Keys, Positive, Text, Triple

if TYPE_CHECKING:
    from stages.robot.model import PrimitiveKind


def _direction(axis: tuple[float, float, float]) -> tuple[float, float, float]:
    if math.hypot(*axis) < 1e-9:
        text = "must point somewhere"
        raise PydanticCustomError("direction", text)
    return axis


Direction = Annotated[Triple, AfterValidator(_direction)]
"""A vector of any length but zero."""


class AddedFrameKeys(Keys):
    """A frame that CAD does not have."""

    link: Text
    """The link or frame that it is fixed to."""

    xyz: Triple = (0, 0, 0)
    """Where it is there [m]."""

    rpy: Triple = (0, 0, 0)
    """Roll, pitch, yaw there [rad]."""


class SphereKeys(Keys):
    """A ball about the origin."""

    radius: Positive
    """Radius [m]."""


class BoxKeys(Keys):
    """A box about the origin."""

    size: tuple[Positive, Positive, Positive]
    """Lengths along x, y and z [m]."""


class CylinderKeys(Keys):
    """A cylinder about the origin, along z."""

    radius: Positive
    """Radius [m]."""

    length: Positive
    """Length [m]."""


class CapsuleKeys(Keys):
    """A cylinder about the origin, along z, with a half ball beyond each end."""

    radius: Positive
    """Radius [m]."""

    length: Positive
    """Length [m] without the half balls."""


class GeometryKeys(Keys):
    """A shape: exactly one of these."""

    sphere: SphereKeys | None = None
    """A ball about the link's origin."""

    box: BoxKeys | None = None
    """A box about the link's origin."""

    cylinder: CylinderKeys | None = None
    """A cylinder about the link's origin, along z."""

    capsule: CapsuleKeys | None = None
    """A cylinder with a half ball beyond each end, about the link's origin, along z."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        if sum(getattr(self, name) is not None for name in type(self).model_fields) != 1:
            raise refused("must be one of sphere, box, cylinder, capsule")
        return self

    def shape(self) -> "tuple[PrimitiveKind, tuple[float, ...]]":
        """Its kind and size [m] as in `model.Primitive`."""
        if self.sphere is not None:
            return "sphere", (self.sphere.radius,)
        if self.box is not None:
            return "box", self.box.size
        if self.cylinder is not None:
            return "cylinder", (self.cylinder.radius, self.cylinder.length)
        assert self.capsule is not None
        return "capsule", (self.capsule.radius, self.capsule.length)


class AddedJointKeys(Keys):
    """The joint by which an added link hangs on its parent. Its type alone stands for all of it."""

    type: Literal["fixed", "revolute", "continuous", "prismatic"] = "fixed"
    """How it moves."""

    name: Text | None = None
    """Its name; null: <link>_joint."""

    axis: Direction = (0, 0, 1)
    """What it turns about or slides along, in the link's frame."""

    limits: Interval | None = None
    """[lower, upper] [rad or m]; a side that is null is open."""

    @model_validator(mode="after")
    def _limited(self) -> Self:
        if self.limits is not None and self.type in ("fixed", "continuous"):
            raise refused(f"must have no limits: it is {self.type}")
        return self


def _type_alone(value: Any) -> Any:
    return {"type": value} if isinstance(value, str) else value


class AddedLinkKeys(Keys):
    """A link that CAD does not have, at `xyz` and `rpy` in its parent or above the root."""

    parent: Text | None = None
    """The link or frame that it hangs on."""

    child: Text | None = None
    """Instead of a parent: the root link, which then hangs on this one."""

    xyz: Triple = (0, 0, 0)
    """Where it is in its parent; with `child`, where the child is in it [m]."""

    rpy: Triple = (0, 0, 0)
    """Roll, pitch, yaw of the same [rad]."""

    mass: Positive | None = None
    """Mass [kg]; null: none, it is a frame with a name."""

    com: Triple | None = None
    """Centre of mass [m] in its own frame; null: its origin."""

    inertia: Inertia | None = None
    """Inertia about the centre of mass [kg m²]; null: that of the geometry as an even solid."""

    geometry: GeometryKeys | None = None
    """What is seen of it and collides."""

    joint: Annotated[AddedJointKeys, BeforeValidator(_type_alone)] = AddedJointKeys()
    """How it moves in its parent."""

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if (self.parent is None) == (self.child is None):
            raise refused("must have a parent, or else a child")
        if self.child is not None and self.joint.type != "fixed":
            raise refused("must have a fixed joint: it is the new root")
        if self.mass is None and (self.com is not None or self.inertia is not None):
            raise refused("must have a mass, or neither com nor inertia")
        if self.mass is not None and self.inertia is None and self.geometry is None:
            raise refused("must have a geometry or an inertia, as it has a mass")
        return self
