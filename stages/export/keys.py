"""What the export stage is told: formats, ground, scene."""

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import model_validator
from pydantic_core import PydanticCustomError

from stages.robot.keys import Keys, Later, NonNegative, Number, Positive, Text, Triple, not_yet

LATER_FORMATS = ("sdf", "usd", "ros")
"""Formats that are decided but not there yet."""


class GroundKeys(Keys):
    """The ground of `scene.xml`."""

    kind: Literal["none", "plane"] = "plane"
    """plane, or none."""

    size: tuple[Positive, Positive] = (4, 4)
    """Length along x and y of the plane that is drawn [m]; it carries everywhere."""

    xyz: Triple = (0, 0, 0)
    """Position in the world [m]."""

    rpy: Triple = (0, 0, 0)
    """Roll, pitch and yaw in the world [rad]."""

    friction: tuple[NonNegative, NonNegative, NonNegative] = (1, 0.005, 0.0001)
    """MuJoCo's sliding [-], torsional [m] and rolling [m] friction."""

    material: Literal["checker"] = not_yet("checker")
    """How it looks."""


class PoseKeys(Keys):
    """Where the robot's root stands in the world."""

    xyz: Triple = (0, 0, 0)
    """Position [m]."""

    rpy: Triple = (0, 0, 0)
    """Roll, pitch and yaw [rad]."""


class OptionKeys(Keys):
    """MuJoCo's `<option>`."""

    unknown_is_later: ClassVar[bool] = True

    timestep: Positive = 0.002
    """Step of the simulation [s]."""


class SceneKeys(Keys):
    """The world around the robot."""

    pose: Annotated[PoseKeys, Later("touch")] = PoseKeys()
    """Where the robot's root stands."""

    lights: dict[Text, Any] = not_yet(dict)
    """Lights, by name."""

    cameras: dict[Text, Any] = not_yet(dict)
    """Cameras, by name."""

    compiler: dict[Text, Any] = not_yet(dict)
    """MuJoCo's `<compiler>`."""

    option: OptionKeys = OptionKeys()
    """MuJoCo's `<option>`."""


class UrdfKeys(Keys):
    """The URDF."""

    meshes: Annotated[Literal["relative"], Later("package")] = "relative"
    """How mesh files are named. relative: to the URDF's own folder."""

    fixed_joints: Annotated[Literal["keep"], Later("merge")] = "keep"
    """keep: frames are links on fixed joints."""


class MjcfKeys(Keys):
    """The MJCF and its scene."""


class ExportSection(Keys):
    """The formats; null leaves a format out."""

    urdf: UrdfKeys | None = None
    """`<name>.urdf`."""

    mjcf: MjcfKeys | None = None
    """`<name>.xml` and `scene.xml`."""

    @model_validator(mode="after")
    def _some_format(self) -> Self:
        if self.urdf is None and self.mjcf is None:
            text = "no format is chosen; allowed: urdf, mjcf, [urdf, mjcf]"
            raise PydanticCustomError("no_format", text)
        return self


class ExportKeys(Keys):
    """The export stage's part of the configuration."""

    ground: GroundKeys = GroundKeys()
    """The ground of `scene.xml`."""

    scene: SceneKeys = SceneKeys()
    """The world around the robot."""

    actuators: dict[Text, Any] = not_yet(dict)
    """Glob on joint names → actuator."""

    sensors: dict[Text, Any] = not_yet(dict)
    """Sensors, by name."""

    keyframes: dict[Text, dict[Text, Number]] = not_yet(dict)
    """Name → glob on joint names → value [rad or m]."""

    elements: dict[Text, Any] = not_yet(dict)
    """XML of the user's own, by name."""

    attributes: dict[Text, Any] = not_yet(dict)
    """Name of an element → attributes that are set on it."""

    export: ExportSection = ExportSection(urdf=UrdfKeys(), mjcf=MjcfKeys())
    """The formats that are written."""
