"""What the fetch stage is told: where the robot comes from."""

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from stages.robot.errors import ConfigError
from stages.robot.keys import Count, Flag, Keys, NonNegative, Positive, Text

ADDRESS = "address"
"""The error type of an address that cannot be one; its context holds `message` and `hint`."""


def _address(url: str) -> str:
    from stages.fetch.onshape.url import parse

    try:
        parse(url)
    except ConfigError as error:
        context = {"message": error.message, "hint": error.hint}
        raise PydanticCustomError(ADDRESS, "{message}", context) from None
    return url


class TessellationKeys(Keys):
    """How finely the server cuts curved faces into triangles."""

    angle: Annotated[Positive, Field(le=3.2)] = 0.2
    """Largest angle between neighbouring facets [rad]."""

    chord: Positive = 0.0005
    """Largest distance between a facet and the true surface [m]."""

    max_facet_width: Positive | None = None
    """Largest width of a facet [m]; null sets no bound."""


def _setting(value: Any) -> bool | float | str:
    if isinstance(value, bool | int | float | str) and (isinstance(value, str) or math.isfinite(value)):
        return value
    raise PydanticCustomError("setting", "must be text, a number, or true or false")


Setting = Annotated[Any, AfterValidator(_setting)]
"""A value that the document knows the meaning of."""


class OnshapeKeys(Keys):
    """An assembly in an Onshape document."""

    kind: Literal["onshape"] = "onshape"
    """Tells the sources apart."""

    url: Annotated[Text, AfterValidator(_address)]
    """The assembly's address as the browser shows it."""

    configuration: dict[Text, Setting] = Field(default_factory=dict)
    """The assembly's configuration, over what the address says: name or id of a parameter → an option by
    label or id, true or false, text, or a quantity: "0.25 m", or a number in SI."""

    variables: dict[Text, Setting] = Field(default_factory=dict)
    """Variables of the document's variable studios, set for the build and put back: name → expression,
    or a number in SI. Writes to the document, so it needs `allow_write` and a workspace."""

    allow_write: Annotated[Flag, Field(validate_default=True)] = False
    """Whether `variables` may be written to the document."""

    tessellation: TessellationKeys = TessellationKeys()
    """How finely curved faces are cut into triangles."""

    verify: Flag = True
    """After an edit: one call for the assembly's mass, which must equal our sum; else what was kept is
    fetched again."""

    offline: Flag = False
    """Make no call: use what earlier builds have cached."""

    refresh: Flag = False
    """Ask again, even for what is cached."""

    max_calls: Count = 200
    """Calls that one build may make; one that needs more ends before it makes them."""

    max_wait: NonNegative = 120
    """Longest wait in all that the server may ask for in one build [s]; where it asks for more the
    build ends, with what was fetched kept."""

    stale: Flag = False
    """Where the yearly quota is used up: whether to build from what was fetched last counts as success.
    Else the robot is built all the same, with exit status 3."""

    @field_validator("allow_write")
    @classmethod
    def _said_before_written(cls, value: bool, info: ValidationInfo) -> bool:
        if info.data.get("variables") and not value:
            text = "source.variables writes to the document: say true to allow it"
            raise PydanticCustomError("allow_write", text)
        return value


class UrdfKeys(Keys):
    """A URDF, or a xacro file that makes one, and the meshes that it names."""

    kind: Literal["urdf"] = "urdf"
    """Tells the sources apart."""

    path: Text
    """The file, relative to the working directory. One that ends in .xacro is expanded where `trust` says
    so."""

    packages: dict[Text, Text] = Field(default_factory=dict)
    """Folders of packages (`package://name/...`), before where ROS_PACKAGE_PATH, AMENT_PREFIX_PATH and the
    folders around the file have them: name → folder, relative to the working directory."""

    args: dict[Text, Setting] = Field(default_factory=dict)
    """Arguments of the xacro file: name → value."""

    trust: Flag = False
    """Whether a xacro file may be expanded: it is a program, so only where you would run it. Counts on the
    command line alone."""

    missing_meshes: Literal["refuse", "skip"] = "refuse"
    """Meshes that are not there or cannot be read: refuse the robot, or build it without them."""

    bad_inertia: Literal["refuse", "recompute", "project"] = "refuse"
    """Inertias that no body can have: refuse the robot; recompute: from the link's mass and shapes, solid;
    project: take the nearest that a body can have."""


class MjcfKeys(Keys):
    """An MJCF, MuJoCo's own format, as MuJoCo compiles it."""

    kind: Literal["mjcf"] = "mjcf"
    """Tells the sources apart."""

    path: Text
    """The file, relative to the working directory."""


class BundleKeys(Keys):
    """A bundle: the replies of an earlier fetch in one zip."""

    kind: Literal["bundle"] = "bundle"
    """Tells the sources apart."""

    path: Text
    """The zip file, relative to the working directory."""


class SampleKeys(Keys):
    """The robot that is shipped with the package."""

    kind: Literal["sample"] = "sample"
    """Tells the sources apart."""


def _kind(source: Any) -> Any:
    return source.get("kind") if isinstance(source, dict) else getattr(source, "kind", None)


SourceKeys = Annotated[
    Annotated[OnshapeKeys, Tag("onshape")]
    | Annotated[UrdfKeys, Tag("urdf")]
    | Annotated[MjcfKeys, Tag("mjcf")]
    | Annotated[BundleKeys, Tag("bundle")]
    | Annotated[SampleKeys, Tag("sample")],
    Discriminator(_kind),
]

SOURCES: dict[str, type[Keys]] = {
    "onshape": OnshapeKeys,
    "urdf": UrdfKeys,
    "mjcf": MjcfKeys,
    "bundle": BundleKeys,
    "sample": SampleKeys,
}
"""Kind of source → its keys."""


class FetchKeys(Keys):
    """The fetch stage's part of the configuration."""

    source: SourceKeys
    """Where the robot comes from."""
