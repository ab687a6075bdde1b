"""Defines the base of every section of the configuration.

A section is a frozen pydantic model. It defines the schema, the defaults and the documentation of its keys
(under each field, with its unit in brackets), and its part of a cache key (`identity`). Help, tab completion,
the reference of keys and the JSON Schema are generated from the sections. A key that is reserved, but not
implemented yet (`not_yet`), is refused by name and never ignored.
"""

import ast
import contextlib
import functools
import inspect
import itertools
import sys
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    Strict,
    StringConstraints,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    field_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError

NOT_YET = "not_yet"
"""The mark, in a field's JSON Schema, of a key that is reserved but not implemented yet, and the type of its
error."""

Text = Annotated[str, StringConstraints(strict=True, min_length=1)]
"""Non-empty text, never converted from a number: an id that YAML read as a number has lost its digits."""

Number = Annotated[float, Strict()]
"""A finite number; text and booleans are refused."""

Count = Annotated[int, Strict(), Field(ge=1)]
"""A whole number from 1."""

Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Flag = Annotated[bool, Strict()]

Triple = tuple[Number, Number, Number]
"""Three numbers: x, y and z [m], or roll, pitch and yaw [rad]."""


def not_yet(default: Any = None, **field_options: Any) -> Any:
    """Declares a field that is not implemented yet: only its default is accepted. `default`: the value, or a
    function that makes it."""
    extra: dict[str, Any] = {NOT_YET: True}
    if callable(default):
        return Field(default_factory=default, json_schema_extra=extra, **field_options)
    return Field(default=default, json_schema_extra=extra, **field_options)


def example(value: Any) -> Any:
    """Declares an example value of a field, for the reference of keys."""
    return Field(examples=[value])


def invalid(text: str) -> PydanticCustomError:
    """Returns the error that a validator raises. `text`: the message, such as "must be above 0"."""
    return PydanticCustomError("invalid", "{text}", {"text": text})


def _check_solref(solref: tuple[float, float]) -> tuple[float, float]:
    if not (min(solref) > 0 or max(solref) < 0):
        raise invalid("must be [time constant, damping ratio] above 0, or [-stiffness, -damping]")
    return solref


Solref = Annotated[tuple[Number, Number], AfterValidator(_check_solref)]
"""MuJoCo's solref: [time constant, damping ratio] in s and without unit, or [-stiffness, -damping]."""


@functools.cache
def _documentation(module: str) -> Mapping[str, Mapping[str, str]]:
    """Returns the texts under the fields of a module's classes: class → field → text. They are read from the
    module's source, and empty without source."""
    try:
        source = ast.parse(inspect.getsource(sys.modules[module]))
    except (KeyError, OSError, TypeError):
        return {}
    texts: dict[str, dict[str, str]] = {}
    for section_class in (node for node in ast.walk(source) if isinstance(node, ast.ClassDef)):
        for node, next_node in itertools.pairwise(section_class.body):
            if not (isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)):
                continue
            if isinstance(next_node, ast.Expr) and isinstance(next_node.value, ast.Constant):
                text_of_field = texts.setdefault(section_class.name, {})
                text_of_field[node.target.id] = inspect.cleandoc(str(next_node.value.value))
    return texts


class Section(BaseModel):
    """A section of the configuration: frozen, closed, strict about text and numbers."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        validate_by_name=True,
        validate_by_alias=True,
    )

    unknown_is_later: ClassVar[bool] = False
    """Whether an unknown key may be supported later: the section mirrors a longer list of another format."""

    @field_validator("*", mode="wrap")
    @classmethod
    def _refuse_unimplemented(
        cls, value: Any, handler: ValidatorFunctionWrapHandler, info: ValidationInfo
    ) -> Any:
        field = cls.model_fields[info.field_name or ""]
        extra = field.json_schema_extra
        if not (isinstance(extra, dict) and extra.get(NOT_YET)):
            return handler(value)
        # The key does nothing yet, so an error about the value's type would mislead.
        with contextlib.suppress(ValidationError):
            valid = handler(value)
            if valid == field.get_default(call_default_factory=True):
                return valid
        raise PydanticCustomError(NOT_YET, "not supported yet")

    @classmethod
    def meanings(cls) -> dict[str, str]:
        """Returns the documentation of each field by its key, without fields that have none.

        It is read from the source only when it is asked for: pydantic would parse the source of every section
        whenever the command starts, which would be a quarter of the time of importing all sections.
        """
        source_texts: dict[str, str] = {}
        for section in reversed(cls.__mro__):
            if issubclass(section, Section):
                source_texts |= _documentation(section.__module__).get(section.__name__, {})
        fields = cls.model_fields.items()
        texts = {
            field.alias or name: field.description or source_texts.get(name, "") for name, field in fields
        }
        return {key: text for key, text in texts.items() if text}

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        json_schema = handler(schema)
        properties = handler.resolve_ref_schema(json_schema).get("properties", {})
        for key, text in cls.meanings().items():
            properties[key]["description"] = text
        return json_schema

    def identity(self) -> dict[str, Any]:
        """Returns the section as plain data, its part of a cache key. Mappings keep their order."""
        return self.model_dump(mode="json", by_alias=True)
