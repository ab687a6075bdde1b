"""Converts records to JSON and back: the class of a record is the schema of its table.

A field's key is its name, unless a `Key` says otherwise. A field with a default is left out where it has that
value, and may be missing or null where the table is read. Keys that no field has are not read.
"""

import sys
import typing
from collections.abc import Callable, Collection, Mapping
from dataclasses import MISSING, dataclass, fields
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Generic, Literal, Self, TypeVar, Union, cast, get_args, get_origin

T = TypeVar("T")

Names = Mapping[str, Collection[str]]
"""Kind of thing → the existing names: a field that refers to such a thing must have one of these."""


class RobotJsonError(Exception):
    """The error that robot.json lacks required content, or has invalid content. Its message names the field.

    `place`: the path of the field, "" for the value that is read itself; None if the message names the field.
    """

    def __init__(self, message: str, place: str | None = None) -> None:
        super().__init__(message if place is None else f"{place or 'the file'}: {message}")
        self._message, self._place = message, place

    def within(self, step: str) -> "RobotJsonError":
        """Returns the same error, as seen from the table or list that contains the field."""
        place = self._place or ""
        return RobotJsonError(self._message, f"{step}{'' if place[:1] in ('', '[') else '.'}{place}")


def refusal(expected: str, value: Any) -> RobotJsonError:
    """Returns the error of a value that is not as expected. Its place is that of the value itself."""
    value_text = "nothing" if value is None else repr(value)
    value_text = value_text if len(value_text) <= 60 else f"{value_text[:57]}..."
    return RobotJsonError(f"expected {expected}, found {value_text}", "")


@dataclass(frozen=True, slots=True, eq=False)
class Form:
    """The conversion between a type's values and JSON."""

    write: Callable[[Any], Any]
    """Converts a value to plain data."""

    read: Callable[[Any, Names], Any]
    """Converts plain data to a value; raises RobotJsonError for invalid data."""

    schema: Mapping[str, Any]
    """The JSON Schema of the data."""


@dataclass(frozen=True, slots=True)
class Key:
    """The key of a field that has another name in the model."""

    name: str


INLINE = object()
"""Marks a field whose own fields are in the table in its place."""

UNREAD = object()
"""Marks a field that only other programs read: it follows from the rest."""


class JsonRecord(Generic[T]):
    """A table of robot.json about a value of the model, T."""

    @classmethod
    def from_model(cls, value: Any, **more: Any) -> Self:
        """Returns the record of a value, whose attributes have the names of the fields.

        `more`: other fields. Fields that the value lacks keep their defaults.
        """
        names = [entry.name for entry in entries_of(cast(Any, cls)) if entry.name not in more]
        return cls(**{name: getattr(value, name) for name in names if hasattr(value, name)}, **more)

    def to_model(self, **more: Any) -> T:
        """Returns the value of the record; `more`: attributes that no field has."""
        model_class, names = _class_and_names(cast(Any, type(self)))
        attributes = {name: modelled(getattr(self, name)) for name in names if name not in more}
        value: T = model_class(**attributes, **more)
        return value


@cache
def _class_and_names(record: Any) -> tuple[Any, tuple[str, ...]]:
    """Returns the class of the model behind a record, and the names that both have."""
    model_class = get_args(record.__orig_bases__[0])[0]
    names = {entry.name for entry in entries_of(record)}
    return model_class, tuple(field.name for field in fields(model_class) if field.name in names)


class PairRecord(JsonRecord[tuple[Any, ...]]):
    """A table of robot.json for a tuple of the model."""

    @classmethod
    def from_model(cls, value: Any, **more: Any) -> Self:
        return cls(*value)

    def to_model(self, **more: Any) -> tuple[Any, ...]:
        return tuple(getattr(self, entry.name) for entry in entries_of(cast(Any, type(self))))


def modelled(value: Any) -> Any:
    """Converts records to the model's values, also in tuples; returns other values unchanged."""
    if isinstance(value, tuple):
        return tuple(map(modelled, value))
    return value.to_model() if isinstance(value, JsonRecord) else value


def write(record: Any) -> dict[str, Any]:
    """Returns the record as plain data."""
    table: dict[str, Any] = form_of(cast(Any, type(record))).write(record)
    return table


def read(record_class: type[T], data: Any, names: Names) -> T:
    """Returns the record in plain data. Raises RobotJsonError for invalid data."""
    record: T = form_of(cast(Any, record_class)).read(data, names)
    return record


@dataclass(frozen=True, slots=True)
class FieldEntry:
    """A field of a record."""

    name: str
    key: str
    kind: Any
    """The annotated type."""

    form: Form
    default: Any
    """The default; MISSING if the field is always there."""

    inline: bool
    unread: bool


@cache
def entries_of(record_class: Any) -> tuple[FieldEntry, ...]:
    """Returns the fields of a record. A class of the model may be used as a record itself; then every field
    is written, even with its default."""
    hints = typing.get_type_hints(record_class, include_extras=True)
    entries = []
    for field in fields(record_class):
        hint = hints[field.name]
        marks = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
        key = next((mark.name for mark in marks if isinstance(mark, Key)), field.name)
        default = field.default if issubclass(record_class, JsonRecord) else MISSING
        flags = INLINE in marks, UNREAD in marks
        entries.append(FieldEntry(field.name, key, hint, form_of(hint), default, *flags))
    return tuple(entries)


@cache
def form_of(annotation: Any) -> Form:
    """Returns the form of an annotated type's values in JSON."""
    origin, inside = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return next((mark for mark in reversed(inside) if isinstance(mark, Form)), None) or form_of(inside[0])
    if origin is Literal:
        return _choice_form(*inside)
    if origin in (Union, UnionType):
        return _nullable_form(form_of(next(option for option in inside if option is not NoneType)))
    if origin is tuple:
        return _list_form(form_of(inside[0]), None if inside[-1] is ... else len(inside))
    if origin is not None and issubclass(origin, Mapping):
        return table_of(form_of(inside[1]))
    return _PLAIN_FORMS.get(annotation) or _record_form(annotation)


def _plain_form(kinds: Any, expected: str, schema: str) -> Form:
    """Returns the form of a type of JSON. `kinds`: its Python types; `expected`: its name in messages;
    `schema`: its name in a schema."""

    def read(data: Any, names: Names) -> Any:
        if not isinstance(data, kinds) or (isinstance(data, bool) and kinds is not bool):
            raise refusal(expected, data)
        return data

    return Form(lambda value: value, read, {"type": schema})


def _read_finite(data: Any, names: Names) -> float:
    if isinstance(data, bool) or not isinstance(data, int | float):
        raise refusal("a number", data)
    # Also for whole numbers, which may be too large for a float. NaN fails every comparison.
    if not abs(data) <= sys.float_info.max:
        raise refusal("a finite number", data)
    return float(data)


_PLAIN_FORMS = {
    float: Form(lambda value: value, _read_finite, {"type": "number"}),
    str: _plain_form(str, "a text", "string"),
    bool: _plain_form(bool, "true or false", "boolean"),
    int: _plain_form(int, "a whole number", "integer"),
}
_LIST, _TABLE = _plain_form(list, "a list", "array"), _plain_form(Mapping, "a table", "object")


def refers_to(kind: str) -> Form:
    """Returns the form of a name that must be one of the existing names of this kind."""

    def read(data: Any, names: Names) -> str:
        text: str = _PLAIN_FORMS[str].read(data, names)
        if text not in names[kind]:
            raise RobotJsonError(f"there is no {kind} {text!r}", "")
        return text

    return Form(str, read, {"type": "string"})


def _choice_form(*words: str) -> Form:
    """Returns the form of a text that must be one of these words."""

    def read(data: Any, names: Names) -> str:
        text: str = _PLAIN_FORMS[str].read(data, names)
        if text not in words:
            raise refusal(f"one of {', '.join(words)}", data)
        return text

    return Form(str, read, {"enum": list(words)})


def _nullable_form(form: Form) -> Form:
    """Returns the form of values that are None or have the given form."""
    return Form(
        lambda value: None if value is None else form.write(value),
        lambda data, names: None if data is None else form.read(data, names),
        {"anyOf": [form.schema, {"type": "null"}]},
    )


def _list_form(form: Form, count: int | None) -> Form:
    """Returns the form of a list; a missing list is empty if its length is not fixed."""

    def read(data: Any, names: Names) -> tuple[Any, ...]:
        if data is None and count is None:
            return ()
        items = _LIST.read(data, names)
        if count not in (None, len(items)):
            raise refusal(f"{count} values", data)
        values = []
        for index, item in enumerate(items):
            try:
                values.append(form.read(item, names))
            except RobotJsonError as error:
                raise error.within(f"[{index}]") from None
        return tuple(values)

    length = {} if count is None else {"minItems": count, "maxItems": count}
    schema = {"type": "array", "items": form.schema, **length}
    return Form(lambda value: [form.write(item) for item in value], read, schema)


def table_of(form: Form, make: Callable[[dict[str, Any]], Any] = dict) -> Form:
    """Returns the form of a table by names of the robot; `make`: makes the model's mapping."""

    def read(data: Any, names: Names) -> Any:
        values: dict[str, Any] = {}
        for key, item in _TABLE.read(data, names).items():
            try:
                values[key] = form.read(item, names)
            except RobotJsonError as error:
                raise error.within(key) from None
        return make(values)

    schema = {"type": "object", "additionalProperties": form.schema}
    return Form(lambda value: {key: form.write(item) for key, item in dict(value).items()}, read, schema)


def _record_form(record_class: type) -> Form:
    """Returns the form of a record, whose schema is in `$defs`. A value of the model is converted to its
    record before it is written."""

    def write(value: Any) -> dict[str, Any]:
        is_record = isinstance(value, record_class)
        record = value if is_record else record_class.from_model(value)  # type: ignore[attr-defined]
        table: dict[str, Any] = {}
        for entry in entries_of(record_class):
            value_of_field = getattr(record, entry.name)
            if entry.inline:
                table |= entry.form.write(value_of_field)
            elif entry.default is MISSING or value_of_field != entry.default:
                table[entry.key] = entry.form.write(value_of_field)
        return table

    def read(data: Any, names: Names) -> Any:
        _TABLE.read(data, names)
        values: dict[str, Any] = {}
        for entry in entries_of(record_class):
            if entry.unread:
                values[entry.name] = None
            elif entry.inline:
                values[entry.name] = entry.form.read(data, names)
            elif data.get(entry.key) is not None or entry.default is MISSING:
                try:
                    values[entry.name] = entry.form.read(data.get(entry.key), names)
                except RobotJsonError as error:
                    raise error.within(entry.key) from None
        return record_class(**values)

    return Form(write, read, {"$ref": f"#/$defs/{record_class.__name__}"})
