"""What the fetch stage is told: where the robot comes from."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from stages.robot.errors import ConfigError
from stages.robot.keys import Count, Flag, Keys, NonNegative, Positive, Text, not_yet

ADDRESS = "address"
"""The error type of an address that cannot be one; its context holds `message` and `hint`."""


def _address(url: str) -> str:
    from stages.fetch.url import parse

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


class OnshapeKeys(Keys):
    """An assembly in an Onshape document."""

    kind: Literal["onshape"] = "onshape"
    """Tells the sources apart."""

    url: Annotated[Text, AfterValidator(_address)]
    """The assembly's address as the browser shows it."""

    configuration: dict[str, Any] = not_yet(dict)
    """The assembly's configuration: parameter → value."""

    variables: dict[str, Any] = not_yet(dict)
    """Variables of the document, set before a build; needs `allow_write`."""

    allow_write: Flag = not_yet(False)
    """Whether `variables` may be written to the document."""

    tessellation: TessellationKeys = TessellationKeys()
    """How finely curved faces are cut into triangles."""

    verify: Flag = not_yet(True)
    """After an edit: one call that must equal our sum of masses."""

    offline: Flag = not_yet(False)
    """Make no call: use what earlier builds have cached."""

    refresh: Flag = not_yet(False)
    """Ask again, even for what is cached."""

    max_calls: Count = not_yet(200)
    """Calls that one build may make."""

    max_wait: NonNegative = not_yet(120)
    """Longest wait that the server may ask for [s]."""


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
    | Annotated[BundleKeys, Tag("bundle")]
    | Annotated[SampleKeys, Tag("sample")],
    Discriminator(_kind),
]

SOURCES: dict[str, type[Keys]] = {"onshape": OnshapeKeys, "bundle": BundleKeys, "sample": SampleKeys}
"""Kind of source → its keys."""

LATER_SOURCES = ("urdf", "mjcf")
"""Kinds of source that are decided but not there yet."""


class FetchKeys(Keys):
    """The fetch stage's part of the configuration."""

    source: SourceKeys
    """Where the robot comes from."""
