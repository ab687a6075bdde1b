"""Defines the configuration of the world around the robot: `ground` and `scene`."""

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from linkwright.stages.export.configuration.mujoco_section import CompilerSection, OptionSection
from linkwright.stages.robot.quantity_keys import Degrees, Position, PositiveLength, Turns
from linkwright.stages.robot.section import (
    Count,
    Flag,
    NonNegative,
    Number,
    Section,
    Text,
    Triple,
    example,
    invalid,
)

Share = Annotated[Number, Field(ge=0, le=1)]
Colour = tuple[Share, Share, Share]
"""Red, green and blue, from 0 to 1."""


class GroundSection(Section):
    """The ground of `scene.xml`."""

    kind: Literal["none", "plane"] = "plane"
    """Shape of the ground."""

    size: tuple[PositiveLength, PositiveLength] | None = (4, 4)
    """Length along x and y of the plane that is drawn [m]; null: drawn as far as one sees. Contact is not
    limited to it."""

    xyz: Position = (0, 0, 0)
    """Position in the world [m]."""

    rpy: Turns = (0, 0, 0)
    """Roll, pitch and yaw in the world [rad]."""

    friction: tuple[NonNegative, NonNegative, NonNegative] = (1, 0.005, 0.0001)
    """MuJoCo's sliding [-], torsional [m] and rolling [m] friction."""

    material: Literal["checker", "plain"] = "checker"
    """Look of the ground: a pattern that shows motion, or one colour."""


def _kind_alone(value: Any) -> Any:
    return {"kind": value} if isinstance(value, str) else value


class PoseSection(Section):
    """Pose of the robot's root in the world. May be given as the kind alone."""

    kind: Literal["touch", "given"] = "given"
    """touch: upright at the origin, with its lowest collider (without colliders, its lowest shape) on the
    ground, at `home` and in each other keyframe. For a fixed base only the colliders that are fixed count,
    and it stays where CAD has it if that is within 2 mm of the ground. Without a ground the robot is at the
    origin; if an MJCF source has its own ground, the robot is where the source has it. given: as the other
    keys say."""

    xyz: Annotated[Position, example([0, 0, 0.2])] = (0, 0, 0)
    """Position [m]."""

    rpy: Turns = (0, 0, 0)
    """Roll, pitch and yaw [rad]."""

    @model_validator(mode="after")
    def _check_kind(self) -> Self:
        if self.kind == "touch" and (any(self.xyz) or any(self.rpy)):
            raise invalid("touch takes neither xyz nor rpy")
        return self


class LightSection(Section):
    """A light of `scene.xml`. May be given as the kind alone."""

    kind: Literal["directional", "point", "spot", "none"] = "directional"
    """directional: parallel, like the sun's; point: to all sides; spot: a cone; none: no light."""

    xyz: Position = (0, 0, 2.5)
    """Position [m]."""

    direction: Annotated[Triple, example([0, 0, -1])] = (0, 0, -1)
    """Direction in which it shines."""

    diffuse: Colour = (0.7, 0.7, 0.7)
    """Colour of what it lights."""

    ambient: Colour = (0, 0, 0)
    """Colour that it adds everywhere."""

    specular: Colour = (0.3, 0.3, 0.3)
    """Colour of its reflections."""

    shadow: Flag = True
    """Whether it casts shadows."""

    cutoff: Annotated[Degrees, Field(gt=0, le=180)] = 45
    """For a spot: half angle of the cone [deg], as in MuJoCo."""

    @model_validator(mode="after")
    def _check_direction(self) -> Self:
        if not any(self.direction):
            raise invalid("direction must not be 0 0 0")
        return self


class CameraSection(Section):
    """A camera. It looks along the z axis of its frame, with x to the right and y down in the image."""

    frame: Annotated[Text | None, example("camera_mount")] = None
    """A frame or link of the robot that carries it, in whose axes the pose is; null: the world."""

    xyz: Annotated[Position, example([1.2, -0.8, 0.6])] = (0, 0, 0)
    """Position [m]."""

    rpy: Turns = (0, 0, 0)
    """Roll, pitch and yaw [rad]."""

    look_at: Annotated[Position | None, example([0, 0, 0.2])] = None
    """For a camera in the world: the point [m] that it looks at, upright; excludes `rpy`."""

    fovy: Annotated[Degrees, Field(gt=0, lt=180)] = 45
    """Vertical field of view [deg], as in MuJoCo."""

    resolution: tuple[Count, Count] = (640, 480)
    """Width and height of the image [pixels]."""

    @model_validator(mode="after")
    def _check_look_at(self) -> Self:
        if self.look_at is None:
            return self
        if self.frame is not None:
            raise invalid("look_at is for a camera in the world, without frame")
        if any(self.rpy):
            raise invalid("look_at and rpy exclude each other")
        if self.look_at == self.xyz:
            raise invalid("look_at must differ from xyz")
        return self


class SkySection(Section):
    """The sky. May be given as the kind alone."""

    kind: Literal["gradient", "none"] = "gradient"
    """gradient: between two colours; none: black."""

    top: Colour = (0.3, 0.5, 0.7)
    """Colour above."""

    bottom: Colour = (0, 0, 0)
    """Colour below the horizon."""


PoseChoice = Annotated[
    PoseSection, BeforeValidator(_kind_alone, json_schema_input_type=PoseSection | Literal["touch", "given"])
]
LightChoice = Annotated[
    LightSection,
    BeforeValidator(
        _kind_alone, json_schema_input_type=LightSection | Literal["directional", "point", "spot", "none"]
    ),
]
SkyChoice = Annotated[
    SkySection, BeforeValidator(_kind_alone, json_schema_input_type=SkySection | Literal["gradient", "none"])
]


class SceneSection(Section):
    """The world around the robot."""

    pose: PoseChoice = PoseSection(kind="touch")
    """Pose of the robot's root in the world."""

    lights: Annotated[
        dict[Text, LightChoice], example({"sun": "none", "lamp": {"kind": "spot", "xyz": [0, 0, 2]}})
    ] = Field(default_factory=dict)
    """Lights, by name. `sun` is always there, unless `sun: none` removes it."""

    cameras: Annotated[
        dict[Text, CameraSection], example({"wrist": {"frame": "camera_mount", "fovy": 60}})
    ] = Field(default_factory=dict)
    """Cameras, by name. A camera in the world is in `scene.xml`, a camera that a frame carries is in the
    robot's file. `overview`, which shows the whole robot, is always there."""

    skybox: SkyChoice = SkySection()
    """The sky."""

    surroundings: Literal["keep", "drop"] = "keep"
    """What an MJCF source has beside the robot: its ground, which replaces Linkwright's, other objects, and
    the lights and cameras of its world. keep: in `scene.xml`; drop: left out."""

    compiler: CompilerSection = CompilerSection()
    """MuJoCo's `<compiler>`."""

    option: OptionSection = OptionSection()
    """MuJoCo's `<option>`."""
