"""Configuration of `mesh.colliders`: how the colliders of some links or parts are made."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from linkwright.stages.mesh import COLLIDERS, PRIMITIVES
from linkwright.stages.mesh.configuration.decompose_options import coacd_parameters
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.quantity_keys import PositiveLength
from linkwright.stages.robot.section import Count, NonNegative, Section, Text, example, invalid

if TYPE_CHECKING:
    ColliderName = str
    MakerName = str
else:
    ColliderName = Literal[tuple(COLLIDERS)]
    MakerName = Literal[(*COLLIDERS, "none", *PRIMITIVES)]


def _checked_coacd(parameters: dict[str, Any]) -> dict[str, Any]:
    try:
        coacd_parameters("normal", parameters)
    except ConfigError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise invalid(f"{error.where.rpartition('.')[2]}: {error.message}{hint}") from None
    return parameters


CoacdParameters = Annotated[
    dict[Text, Any], AfterValidator(_checked_coacd), example({"mcts_iterations": 100})
]
VertexCount = Annotated[Count, Field(ge=4)]


class RoundSizeSection(Section):
    """The size of a sphere."""

    radius: Annotated[PositiveLength | None, example(0.02)] = None
    """Radius [m]; null: what fits."""


class LongSizeSection(Section):
    """The size of a cylinder or capsule."""

    radius: Annotated[PositiveLength | None, example(0.02)] = None
    """Radius [m]; null: what fits."""

    length: Annotated[PositiveLength | None, example(0.1)] = None
    """Length [m], of a capsule without its caps; null: what fits."""


class BoxSizeSection(Section):
    """The size of a box that stands along the axes of the part, or of the link."""

    size: Annotated[
        tuple[PositiveLength | None, PositiveLength | None, PositiveLength | None] | None,
        example([0.1, 0.05, None]),
    ] = None
    """Lengths along x, y and z [m]; null: what fits."""


class ColliderSection(Section):
    """How colliders are made: exactly one of make, sphere, box, cylinder and capsule. A plain name means
    `make: <name>`."""

    make: Annotated[MakerName | None, example("coacd")] = None
    """One of the options of mesh.collider; none: no collider; box, sphere, capsule or cylinder: the
    best-fitting primitive of that kind."""

    sphere: RoundSizeSection | None = None
    """A sphere of this size, where it fits best."""

    box: BoxSizeSection | None = None
    """A box of this size, where it fits best."""

    cylinder: LongSizeSection | None = None
    """A cylinder of this size, where it fits best."""

    capsule: LongSizeSection | None = None
    """A capsule of this size, where it fits best."""

    tolerance: Annotated[PositiveLength | None, example(0.001)] = None
    """Overrides mesh.tolerance [m]; null: the value of mesh.tolerance."""

    extra_volume: Annotated[NonNegative | None, example(0.3)] = None
    """Overrides mesh.extra_volume; null: the value of mesh.extra_volume."""

    max_vertices: Annotated[VertexCount | None, example(32)] = None
    """Overrides mesh.max_vertices; null: the value of mesh.max_vertices."""

    coacd: CoacdParameters = Field(default_factory=dict)
    """Parameters as in mesh.coacd, in addition to those."""

    @model_validator(mode="after")
    def _checked_maker(self) -> Self:
        if sum(getattr(self, name) is not None for name in ("make", *PRIMITIVES)) != 1:
            raise invalid(f"must have one of make, {', '.join(PRIMITIVES)}")
        return self

    def primitive(self) -> tuple[str, tuple[float | None, ...]] | None:
        """Returns the kind of primitive that the section chooses, and its lengths as in `Primitive.size`;
        None if it chooses no primitive."""
        if self.make is not None:
            return (self.make, ()) if self.make in PRIMITIVES else None
        if self.sphere is not None:
            return "sphere", (self.sphere.radius,)
        if self.box is not None:
            return "box", self.box.size or ()
        kind = "cylinder" if self.cylinder is not None else "capsule"
        size = self.cylinder or self.capsule or LongSizeSection()
        return kind, (size.radius, size.length)


def _section_of_name(value: Any) -> Any:
    return {"make": value} if isinstance(value, str) else value


ColliderChoice = Annotated[
    ColliderSection, BeforeValidator(_section_of_name, json_schema_input_type=ColliderSection | MakerName)
]
