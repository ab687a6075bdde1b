"""The base of every section of the configuration.

A section is a frozen pydantic model: the schema, the defaults, each field's documentation (under
it, with its unit) and, as `identity()`, its part of a cache key. What the tree promises but no
stage does yet is refused by name, never ignored: a whole key by `not_yet`, one option by `Later`.
"""

from typing import Annotated, Any, ClassVar

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    Strict,
    StringConstraints,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    field_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

NOT_YET = "not_yet"
"""The error type of what is in the tree but has no function yet."""

Text = Annotated[str, StringConstraints(strict=True, min_length=1)]
"""Text, never made from a number: an id read as a number has already lost its digits."""

Number = Annotated[float, Strict()]
"""A finite number; text and booleans are refused."""

Count = Annotated[int, Strict(), Field(ge=1)]
"""A whole number from 1."""

Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Flag = Annotated[bool, Strict()]

Triple = tuple[Number, Number, Number]
"""Three numbers: metres for a position, radians for roll, pitch and yaw."""


def not_yet(default: Any = None, **more: Any) -> Any:
    """A field whose function is not there yet: only its default is accepted."""
    extra: dict[str, Any] = {NOT_YET: True}
    if callable(default):
        return Field(default_factory=default, json_schema_extra=extra, **more)
    return Field(default=default, json_schema_extra=extra, **more)


class Later:
    """Metadata of a field: options that are decided but not there yet, refused by name."""

    def __init__(self, *options: str) -> None:
        self.options = options

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        def refuse(value: Any) -> Any:
            if isinstance(value, str) and value in self.options:
                raise PydanticCustomError(NOT_YET, "not supported yet")
            return value

        return core_schema.no_info_before_validator_function(refuse, handler(source))


def _ascending(pair: tuple[float | None, float | None]) -> tuple[float | None, float | None]:
    lower, upper = pair
    if lower is not None and upper is not None and not lower < upper:
        raise PydanticCustomError("ascending", "must be [lower, upper] with lower < upper")
    return pair


Interval = Annotated[tuple[Number | None, Number | None], AfterValidator(_ascending)]
"""[lower, upper]; null is an open side."""


class Keys(BaseModel):
    """A section of the configuration: frozen, closed, strict about text and numbers."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        use_attribute_docstrings=True,
        allow_inf_nan=False,
        validate_by_name=True,
        validate_by_alias=True,
    )

    unknown_is_later: ClassVar[bool] = False
    """An open mapping of which only the named keys are supported yet."""

    @field_validator("*", mode="wrap")
    @classmethod
    def _only_the_default_yet(
        cls, value: Any, handler: ValidatorFunctionWrapHandler, info: ValidationInfo
    ) -> Any:
        field = cls.model_fields[info.field_name or ""]
        extra = field.json_schema_extra
        if not (isinstance(extra, dict) and extra.get(NOT_YET)):
            return handler(value)
        try:
            valid = handler(value)
        except ValidationError:
            # A wrong value of a key without function: telling its type would lead nowhere.
            valid = PydanticCustomError
        if valid != field.get_default(call_default_factory=True):
            raise PydanticCustomError(NOT_YET, "not supported yet")
        return valid

    def identity(self) -> dict[str, Any]:
        """The section as plain data: its part of a cache key. Mappings keep their order."""
        return self.model_dump(mode="json", by_alias=True)
