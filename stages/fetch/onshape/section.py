"""Configuration of the source `onshape`."""

from typing import Annotated, Any, Literal

from pydantic import Field, GetCoreSchemaHandler, GetPydanticSchema, ValidationInfo, field_validator
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from linkwright.stages.fetch.onshape.url import AssemblyUrl, parse
from linkwright.stages.fetch.source_section import ADDRESS, Setting, SourceSection
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.quantity_keys import PositiveAngle, PositiveLength
from linkwright.stages.robot.section import Count, Flag, NonNegative, Section, Text, example, invalid


def _parsed(text: str) -> AssemblyUrl:
    try:
        return parse(text)
    except ConfigError as error:
        context = {"message": error.message, "hint": error.hint}
        raise PydanticCustomError(ADDRESS, "{message}", context) from None


def _from_text(_: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
    """Returns the schema of an address: text is parsed to an AssemblyUrl, and written out as it was typed."""
    as_typed = core_schema.plain_serializer_function_ser_schema(
        lambda url: url.text, return_schema=core_schema.str_schema()
    )
    return core_schema.no_info_after_validator_function(
        _parsed, handler.generate_schema(Text), serialization=as_typed
    )


Address = Annotated[AssemblyUrl, GetPydanticSchema(_from_text)]
"""The address of an assembly: text in the configuration."""


class TessellationSection(Section):
    """How finely Onshape divides curved faces into triangles."""

    angle: Annotated[PositiveAngle, Field(le=3.2)] = 0.2
    """Largest angle between neighbouring facets [rad]."""

    chord: PositiveLength = 0.0005
    """Largest distance between a facet and the true surface [m]."""

    max_facet_width: Annotated[PositiveLength | None, example(0.005)] = None
    """Largest width of a facet [m]; null: no bound."""


class OnshapeSourceSection(SourceSection):
    """An assembly in an Onshape document."""

    kind: Literal["onshape"] = "onshape"
    """Kind of the source; `source=KIND` chooses it."""

    url: Annotated[Address, example("https://cad.onshape.com/documents/.../w/.../e/...")]
    """Address of the assembly, as the browser shows it: https and a host of onshape.com. An address on this
    computer is accepted only on the command line, in Python, or if LINKWRIGHT_HOST names it:
    `http://127.0.0.1:PORT`."""

    configuration: Annotated[dict[Text, Setting], example({"leg_length": "0.25 m"})] = Field(
        default_factory=dict
    )
    """Configuration of the assembly; overrides the configuration in the address. Name or id of a parameter →
    an option by label or id, true or false, text, or a quantity: text with a unit, or a number in SI
    units."""

    variables: Annotated[dict[Text, Setting], example({"reach": "0.3 m"})] = Field(default_factory=dict)
    """Variables of the document's variable studios, set for the build and restored after it: name →
    expression, or a number in SI units. Writes to the document: needs `source.allow_write`, and a
    workspace."""

    allow_write: Annotated[Flag, Field(validate_default=True)] = False
    """Whether `source.variables` may be written to the document."""

    tessellation: TessellationSection = TessellationSection()
    """How finely Onshape divides curved faces into triangles."""

    verify: Flag = True
    """Whether a build after an edit compares the assembly's mass (one call) with the sum of its cached parts,
    and fetches the parts again if they differ."""

    offline: Flag = False
    """Whether the build makes no API call and uses the replies that earlier builds cached."""

    refresh: Flag = False
    """Whether everything is fetched again, even if it is cached."""

    max_calls: Count = 200
    """Largest number of API calls of one build, or of a whole sweep, which ends before it makes more
    calls."""

    max_wait: NonNegative = 120
    """Longest total wait for the server's rate limit in one build [s]; if the server asks for a longer wait,
    the build ends and keeps what was fetched."""

    stale: Flag = False
    """Whether the exit status is 0 if the yearly quota of calls is used up and the robot is built from the
    last fetched state. With false the robot is built from that state too, but the exit status is 3."""

    @field_validator("allow_write")
    @classmethod
    def _allowed_before_written(cls, value: bool, info: ValidationInfo) -> bool:
        if info.data.get("variables") and not value:
            raise invalid("source.variables writes to the document: set true to allow it")
        return value
