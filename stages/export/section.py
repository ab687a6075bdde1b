"""Defines the configuration of the export stage."""

from typing import Annotated, Any, Self

from pydantic import Field, SerializerFunctionWrapHandler, create_model, model_serializer, model_validator

from linkwright.stages.export.configuration.actuator_section import ActuatorChoice
from linkwright.stages.export.configuration.element_section import AttributeChoice, ElementSection
from linkwright.stages.export.configuration.format_section import FormatSection
from linkwright.stages.export.configuration.motor_section import MotorSection
from linkwright.stages.export.configuration.scene_section import GroundSection, SceneSection
from linkwright.stages.export.configuration.sensor_section import SensorChoice
from linkwright.stages.export.configuration.variant_section import VariantSection
from linkwright.stages.export.mjcf.section import MjcfFormatSection
from linkwright.stages.export.python.section import PythonFormatSection
from linkwright.stages.export.ros2.section import Ros2FormatSection
from linkwright.stages.export.sdf.section import SdfFormatSection
from linkwright.stages.export.urdf.section import UrdfFormatSection
from linkwright.stages.export.usd.section import UsdFormatSection
from linkwright.stages.robot.optional_section import OptionalSection
from linkwright.stages.robot.section import (
    Section,
    Text,
    example,
    invalid,
)
from linkwright.stages.robot.text.file_names import VARIANTS
from linkwright.stages.targets.section import TargetSections

FORMATS: dict[str, type[FormatSection]] = {
    "urdf": UrdfFormatSection,
    "mjcf": MjcfFormatSection,
    "sdf": SdfFormatSection,
    "ros2": Ros2FormatSection,
    "usd": UsdFormatSection,
    "python": PythonFormatSection,
}
"""Format → its section, in the order in which formats are written."""


class _Formats(Section):
    """The formats that a build writes."""

    @property
    def chosen(self) -> tuple[str, ...]:
        """The names of the formats that are written, in the order of the table."""
        return tuple(name for name in FORMATS if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _check_chosen(self) -> Self:
        if not self.chosen:
            names = ", ".join(FORMATS)
            raise invalid(f"no format is chosen; allowed: {names}, [{names}]")
        return self

    @model_serializer(mode="wrap")
    def _only_chosen(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # A new format must change neither the configuration nor the cache key of builds without it.
        return {name: value for name, value in handler(self).items() if name in self.chosen}


def _section_of(name: str) -> Any:
    """Returns the field of one format: its section, or null."""
    files = " and ".join(f"`{path}`" for path in FORMATS[name].files)
    return (FORMATS[name] | None, Field(default=None, description=f"{files}."))


_AllFormats: Any = create_model(
    "_AllFormats", __base__=_Formats, **{name: _section_of(name) for name in FORMATS}
)


class ExportSection(_AllFormats):  # type: ignore[misc]
    """Formats to write; null leaves a format out."""


class ExportSections(OptionalSection, TargetSections):
    """The export stage's part of the configuration."""

    ground: GroundSection = GroundSection()
    """The ground of `scene.xml`."""

    scene: SceneSection = SceneSection()
    """The world around the robot."""

    actuators: Annotated[
        dict[Text, ActuatorChoice], example({"*": "position", "elbow": {"kp": 80}, "wrist": "none"})
    ] = Field(default_factory=dict)
    """Glob on names of dofs → what drives them; later entries win, property by property. A glob drives no
    followers of relations, and in closed loops only as many dofs as are free, those nearest to the root; a
    name without wildcards always drives its dof."""

    motors: Annotated[
        dict[Text, MotorSection],
        example(
            {
                "my_servo": {
                    "title": "My servo, 7.4 V",
                    "values": {"effort": {"value": 3, "source": "its maker's page", "kind": "datasheet"}},
                }
            }
        ),
    ] = Field(default_factory=dict)
    """Motors, by name. Motors of the library that `actuators` names are added here automatically; a robot may
    also describe its own motors here."""

    sensors: Annotated[
        dict[Text, SensorChoice], example({"imu": {"frame": "imu_mount", "type": "imu"}, "foot": "touch"})
    ] = Field(default_factory=dict)
    """Sensors, by name, in the MJCF; their names are unique, also among those of the source."""

    elements: Annotated[
        dict[Text, ElementSection],
        example({"front": {"into": {"name": "torso"}, "xml": "<camera name='front' pos='0.1 0 0'/>"}}),
    ] = Field(default_factory=dict)
    """Your own XML elements in the MJCF and the URDF, by a name of your choice; added in this order after
    everything else is written. The SDF gets none of them."""

    attributes: Annotated[dict[Text, AttributeChoice], example({"floor": {"friction": [1, 0.5, 0.5]}})] = (
        Field(default_factory=dict)
    )
    """Name of an element, of any kind → attributes to set on it, after everything else is written; null
    removes an attribute. Applies to the MJCF, or to the formats in `formats`: [urdf, mjcf]; never to the SDF.
    If several elements have the name, `tag` chooses one: a tag, or a section such as actuator."""

    export: ExportSection = ExportSection.model_validate({"urdf": {}, "mjcf": {}})
    """Formats to write; null leaves a format out."""

    variants: VariantSection = VariantSection()
    """Variants of the robot for learning."""

    @property
    def has_variants(self) -> bool:
        """Whether a file of variants is written."""
        return self.variants.n > 0 and "mjcf" in self.export.chosen


def expected_paths(keys: ExportSections, robot: str) -> list[str]:
    """Returns the paths of the files that a build of a robot with this name will write. Meshes have no names
    yet: a glob replaces them."""
    paths = [path for name in keys.export.chosen for path in FORMATS[name].paths(robot)]
    return ["robot.json", "assets/*", *paths, *([VARIANTS] if keys.has_variants else ())]
