"""Configuration of the source `onshape`."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from stages.fetch.source_keys import ADDRESS, Setting, SourceKeys
from stages.robot.errors import ConfigError
from stages.robot.keys import Count, Flag, Keys, NonNegative, Positive, Text


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


class OnshapeSourceKeys(SourceKeys):
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


KEYS = OnshapeSourceKeys
