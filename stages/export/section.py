"""Configuration of the export stage: formats, ground, scene."""

from typing import Annotated, Any, Self

from pydantic import Field, SerializerFunctionWrapHandler, create_model, model_serializer, model_validator

from linkwright.stages.export.configuration.actuator_section import ActuatorChoice
from linkwright.stages.export.configuration.element_section import AttributeChoice, ElementSection
from linkwright.stages.export.configuration.format_section import FormatSection
from linkwright.stages.export.configuration.motor_section import MotorSection
from linkwright.stages.export.configuration.scene_section import GroundSection, SceneSection
from linkwright.stages.export.configuration.sensor_section import SensorChoice
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

FORMATS: dict[str, type[FormatSection]] = {
    "urdf": UrdfFormatSection,
    "mjcf": MjcfFormatSection,
    "sdf": SdfFormatSection,
    "ros2": Ros2FormatSection,
    "usd": UsdFormatSection,
    "python": PythonFormatSection,
}
"""All formats, in the order in which they are written, and what configures them."""


class _Formats(Section):
    """The formats that a build writes."""

    @property
    def chosen(self) -> tuple[str, ...]:
        """The names of the formats that are written, in the order of the table."""
        return tuple(name for name in FORMATS if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _some_format(self) -> Self:
        if not self.chosen:
            names = ", ".join(FORMATS)
            raise invalid(f"no format is chosen; allowed: {names}, [{names}]")
        return self

    @model_serializer(mode="wrap")
    def _only_chosen(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # A new format must change neither the configuration nor the cache key of builds without it.
        return {name: value for name, value in handler(self).items() if name in self.chosen}


def _section_of(name: str) -> Any:
    """The field of one format: its section, or null."""
    files = " and ".join(f"`{path}`" for path in FORMATS[name].files)
    return (FORMATS[name] | None, Field(default=None, description=f"{files}."))


_EveryFormat: Any = create_model(
    "_EveryFormat", __base__=_Formats, **{name: _section_of(name) for name in FORMATS}
)


class ExportSection(_EveryFormat):  # type: ignore[misc]
    """Formats to write; null leaves a format out."""


class ExportSections(OptionalSection):
    """The export stage's part of the configuration."""

    ground: GroundSection = GroundSection()
    """The ground of `scene.xml`."""

    scene: SceneSection = SceneSection()
    """The world around the robot."""

    actuators: Annotated[
        dict[Text, ActuatorChoice], example({"*": "position", "elbow": {"kp": 80}, "wrist": "none"})
    ] = Field(default_factory=dict)
    """Glob on names of dofs → what drives them; later entries win, property by property. A glob leaves out
    the followers of relations, and of closed loops drives as many dofs as these leave free, the nearest to
    the root; a name without wildcards drives that dof."""

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
    """Motors, by name. Those of the library that `actuators` names are put here when the configuration is
    made; a robot may also describe its own here."""

    sensors: Annotated[
        dict[Text, SensorChoice], example({"imu": {"frame": "imu_mount", "type": "imu"}, "foot": "touch"})
    ] = Field(default_factory=dict)
    """Sensors, by name, in the MJCF; their names are unique, also among those of the source."""

    elements: Annotated[
        dict[Text, ElementSection],
        example({"front": {"into": {"name": "torso"}, "xml": "<camera name='front' pos='0.1 0 0'/>"}}),
    ] = Field(default_factory=dict)
    """XML elements of your own in the MJCF and the URDF, by a name of your choice; added in this order when
    all else is written. The SDF gets none of them."""

    attributes: Annotated[dict[Text, AttributeChoice], example({"floor": {"friction": [1, 0.5, 0.5]}})] = (
        Field(default_factory=dict)
    )
    """Name of an element, of any kind → attributes to set on it, last of all; null takes an attribute away.
    In the MJCF, or in those of `formats`: [urdf, mjcf]; never in the SDF. Where several have the name, `tag`
    says which: a tag, or a section such as actuator."""

    export: ExportSection = ExportSection.model_validate({"urdf": {}, "mjcf": {}})
    """Formats to write; null leaves a format out."""


def expected_paths(keys: ExportSections, robot: str) -> list[str]:
    """The paths of the files of a robot of this name, before they are made. The names of the meshes are
    not known by then: a glob stands for them."""
    paths = [path for name in keys.export.chosen for path in FORMATS[name].paths(robot)]
    return ["robot.json", "assets/*", *paths]
