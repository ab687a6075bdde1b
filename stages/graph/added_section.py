"""Configuration of the graph stage: links and frames that CAD does not have."""

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, model_validator

from linkwright.stages.graph.mass_section import Inertia
from linkwright.stages.robot.quantity_keys import Position, PositiveLength, Range, Turns, misfit
from linkwright.stages.robot.section import Positive, Section, Text, Triple, example, invalid

if TYPE_CHECKING:
    from linkwright.stages.robot.model.robot import PrimitiveKind


def _direction(axis: tuple[float, float, float]) -> tuple[float, float, float]:
    if math.hypot(*axis) < 1e-9:
        raise invalid("must not be zero")
    return axis


Direction = Annotated[Triple, AfterValidator(_direction)]
"""A vector of any length but zero."""


class AddedFrameSection(Section):
    """A frame that CAD does not have."""

    link: Annotated[Text, example("palm")]
    """The link or frame to which it is fixed."""

    xyz: Annotated[Position, example([0, 0.03, 0.02])] = (0, 0, 0)
    """Position in that link or frame [m]."""

    rpy: Annotated[Turns, example([0, -1.57, 0])] = (0, 0, 0)
    """Roll, pitch and yaw in that link or frame [rad]."""


class SphereSection(Section):
    """A sphere about the link's origin."""

    radius: Annotated[PositiveLength, example(0.03)]
    """Radius [m]."""


class BoxSection(Section):
    """A box about the link's origin."""

    size: Annotated[tuple[PositiveLength, PositiveLength, PositiveLength], example([0.1, 0.1, 0.05])]
    """Lengths along x, y and z [m]."""


class CylinderSection(Section):
    """A cylinder about the link's origin, along z."""

    radius: Annotated[PositiveLength, example(0.03)]
    """Radius [m]."""

    length: Annotated[PositiveLength, example(0.1)]
    """Length [m]."""


class CapsuleSection(Section):
    """A cylinder with a hemisphere at each end, about the link's origin, along z."""

    radius: Annotated[PositiveLength, example(0.03)]
    """Radius [m]."""

    length: Annotated[PositiveLength, example(0.1)]
    """Length without the hemispheres [m]."""


class GeometrySection(Section):
    """A shape: exactly one of these."""

    sphere: SphereSection | None = None
    """A sphere about the link's origin."""

    box: BoxSection | None = None
    """A box about the link's origin."""

    cylinder: CylinderSection | None = None
    """A cylinder about the link's origin, along z."""

    capsule: CapsuleSection | None = None
    """A cylinder with a hemisphere at each end, about the link's origin, along z."""

    @model_validator(mode="after")
    def _checked_kind(self) -> Self:
        if sum(getattr(self, name) is not None for name in type(self).model_fields) != 1:
            raise invalid("must be one of sphere, box, cylinder, capsule")
        return self

    def shape(self) -> "tuple[PrimitiveKind, tuple[float, ...]]":
        """Returns the kind and the size [m] of the shape, as in `Primitive`."""
        if self.sphere is not None:
            return "sphere", (self.sphere.radius,)
        if self.box is not None:
            return "box", self.box.size
        if self.cylinder is not None:
            return "cylinder", (self.cylinder.radius, self.cylinder.length)
        assert self.capsule is not None
        return "capsule", (self.capsule.radius, self.capsule.length)


JointType = Literal["fixed", "revolute", "continuous", "prismatic"]


class AddedJointSection(Section):
    """The joint between an added link and its parent. A plain type means `type: <type>`."""

    type: JointType = "fixed"
    """Type of the joint."""

    name: Annotated[Text | None, example("payload_joint")] = None
    """Name of the joint; null: <link>_joint."""

    axis: Direction = (0, 0, 1)
    """Axis of rotation or translation, in the link's frame."""

    limits: Annotated[Range | None, example([-1.57, 1.57])] = None
    """[lower, upper] [rad or m]; null leaves a side open."""

    @model_validator(mode="after")
    def _checked_limits(self) -> Self:
        if self.limits is not None and self.type in ("fixed", "continuous"):
            raise invalid(f"must have no limits: it is {self.type}")
        kind: Literal["slide", "turn"] = "slide" if self.type == "prismatic" else "turn"
        for end in self.limits or ():
            if wrong := misfit(end, kind):
                raise invalid(f"limits: {wrong}, and the joint is {self.type}")
        return self


def _type_alone(value: Any) -> Any:
    return {"type": value} if isinstance(value, str) else value


class AddedLinkSection(Section):
    """A link that CAD does not have, at `xyz` and `rpy` in its parent, or above the root."""

    parent: Annotated[Text | None, example("tool")] = None
    """The link or frame to which its joint connects it."""

    child: Annotated[Text | None, example("base_plate")] = None
    """Instead of a parent: the root link, which becomes the child of this link."""

    xyz: Annotated[Position, example([0, 0, 0.05])] = (0, 0, 0)
    """Position in the parent [m]; with `child`, the position of the child in this link."""

    rpy: Annotated[Turns, example([0, 0, 1.57])] = (0, 0, 0)
    """Roll, pitch and yaw in the parent [rad]; with `child`, those of the child in this link."""

    mass: Annotated[Positive | None, example(0.3)] = None
    """Mass [kg]; null: no mass, the link is a named frame."""

    com: Annotated[Position | None, example([0, 0, 0.01])] = None
    """Centre of mass in its own frame [m]; null: its origin."""

    inertia: Annotated[Inertia | None, example([1e-4, 1e-4, 1e-4])] = None
    """Inertia about the centre of mass [kg m²]: ixx, iyy, izz, or these and ixy, ixz, iyz; null: the inertia
    of the geometry as a solid of uniform density."""

    geometry: GeometrySection | None = None
    """Visual and collision shape."""

    joint: Annotated[
        AddedJointSection, BeforeValidator(_type_alone, json_schema_input_type=AddedJointSection | JointType)
    ] = AddedJointSection()
    """The joint between this link and its parent."""

    @model_validator(mode="after")
    def _checked_keys(self) -> Self:
        if (self.parent is None) == (self.child is None):
            raise invalid("must have a parent or a child, and not both")
        if self.child is not None and self.joint.type != "fixed":
            raise invalid("must have a fixed joint: it is the new root")
        if self.mass is None and (self.com is not None or self.inertia is not None):
            raise invalid("must have a mass, or neither com nor inertia")
        if self.mass is not None and self.inertia is None and self.geometry is None:
            raise invalid("must have a geometry or an inertia, since it has a mass")
        return self
