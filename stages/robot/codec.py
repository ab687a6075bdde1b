"""Converts the values that stages pass on through the cache to bytes and back, exactly.

Values are frozen dataclasses of numbers, texts, arrays and tuples; their classes are the schema.
Floats keep every bit (shortest round-trip text).
"""

import functools
import types
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import orjson

from linkwright.stages.robot.bundle import Bundle, FileBundle, OnshapeBundle
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Geometry

if TYPE_CHECKING:  # the model imports numpy, and a fully cached build needs neither
    from linkwright.stages.robot.model.robot import Robot

T = TypeVar("T")

ASSETS = "assets/"
"""Folder of the meshes of a geometry."""

REPLIES = "replies/"
"""Folder of the replies of a bundle."""


def dump(value: object) -> bytes:
    """Returns a value as JSON, one key a line, so that files compare well."""
    return orjson.dumps(plain_data(value), option=orjson.OPT_INDENT_2) + b"\n"


def load(kind: type[T], data: bytes) -> T:
    """Returns the value of class `kind` that `dump` wrote."""
    value: T = typed(kind, orjson.loads(data))
    return value


def plain_data(value: Any) -> Any:
    """Returns a value as plain data: dataclasses as mappings, tuples and arrays as lists, everything else
    unchanged."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain_data(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, tuple | list):
        return [plain_data(item) for item in value]
    if isinstance(value, Mapping):
        return {key: plain_data(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return value.tolist()
    return value


def _model() -> Any:
    # Late: the model imports numpy, and a cached build reads only values without arrays.
    from linkwright.stages.robot.model import robot

    return robot


@functools.cache
def field_types_of(kind: type) -> dict[str, Any]:
    """Returns the types of a dataclass's fields, by name. A module that must not import numpy imports the
    model's classes for the type checker alone; their names are then looked up in the model."""
    try:
        return get_type_hints(kind)
    except NameError:
        return get_type_hints(kind, localns=vars(_model()))


def typed(kind: Any, data: Any) -> Any:
    """Returns the value of the annotated type `kind` from the plain data that JSON holds. Fields that the
    data lacks have their defaults."""
    if isinstance(kind, type) and is_dataclass(kind):
        field_types = field_types_of(kind)
        return kind(**{key: typed(field_types[key], item) for key, item in data.items()})
    origin = get_origin(kind)
    if origin is tuple:
        item_kinds = get_args(kind)
        if item_kinds[-1] is Ellipsis:
            return tuple(typed(item_kinds[0], item) for item in data)
        return tuple(typed(item_kind, item) for item_kind, item in zip(item_kinds, data, strict=True))
    if origin in (Union, types.UnionType):
        return None if data is None else typed(_option(kind, data), data)
    if origin is Literal or kind in (str, int, bool):
        return data
    if kind is float:
        return float(data)
    if _is_alias(kind):
        return typed(_unaliased(kind), data)
    if origin is not None and issubclass(origin, Mapping):
        return data
    # The type is numpy's ndarray[shape, dtype[number]]; without arguments the numbers are float64.
    dtypes = get_args(kind)[-1:]
    numbers = get_args(dtypes[0]) if dtypes else ()
    return _model().frozen(data, *numbers)


def _is_alias(kind: Any) -> bool:
    """Returns whether the type is a `type` alias, bare or with arguments, such as NDArray from numpy 2.5
    on."""
    return hasattr(get_origin(kind) or kind, "__value__")


def _unaliased(kind: Any) -> Any:
    """Returns the type behind a `type` alias; any other type unchanged."""
    while _is_alias(kind):
        arguments = get_args(kind)
        value = (get_origin(kind) or kind).__value__
        kind = value[arguments] if arguments else value
    return kind


def _option(kind: Any, data: Any) -> Any:
    """Returns the member of a union to which `data` belongs. If there are several, a mapping belongs to the
    first dataclass that has its fields, and a list to the tuple."""
    options = [_unaliased(option) for option in get_args(kind) if option is not types.NoneType]
    if len(options) == 1:
        return options[0]
    if isinstance(data, dict):
        classes = [option for option in options if isinstance(option, type) and is_dataclass(option)]
        return next(option for option in classes if data.keys() <= field_types_of(option).keys())
    return next(option for option in options if (get_origin(option) is tuple) == isinstance(data, list))


def encode_robot(robot: "Robot") -> bytes:
    """Returns a robot as JSON."""
    return dump(robot)


def decode_robot(data: bytes) -> "Robot":
    """Returns the robot that `encode_robot` wrote."""
    robot: Robot = load(_model().Robot, data)
    return robot


def encode_geometry(geometry: Geometry) -> dict[str, bytes]:
    """Returns the files of a geometry by path: `geometry.json` and a file for each entry of its `files`."""
    table = {name: getattr(geometry, name) for name in field_types_of(Geometry) if name != "files"}
    files = {ASSETS + name: data for name, data in geometry.files.items()}
    return {"geometry.json": dump(table), **files}


def decode_geometry(files: Mapping[str, bytes], meshes: bool = True) -> Geometry:
    """Returns the geometry that `encode_geometry` wrote; without `meshes` it has no files, and they are not
    read."""
    table = orjson.loads(files["geometry.json"])
    field_types = field_types_of(Geometry)
    names = [name for name in files if meshes and name.startswith(ASSETS)]
    return Geometry(
        files={name.removeprefix(ASSETS): files[name] for name in names},
        **{name: typed(field_types[name], value) for name, value in table.items()},
    )


def encode_bundle(bundle: Bundle) -> dict[str, bytes]:
    """Returns the files of a bundle by path: `manifest.json` and a file for each reply."""
    names = [field.name for field in fields(bundle) if field.name != "blobs"]
    manifest = {name: getattr(bundle, name) for name in names}
    return {
        "manifest.json": dump(manifest),
        **{REPLIES + digest: body for digest, body in bundle.blobs.items()},
    }


def decode_bundle(files: Mapping[str, bytes]) -> Bundle:
    """Returns the bundle that `encode_bundle` wrote. A reply is taken from `files` only when it is used."""
    manifest = orjson.loads(files["manifest.json"])
    kind = OnshapeBundle if "studios" in manifest else FileBundle
    field_types = field_types_of(kind)
    values = {key: typed(field_types[key], item) for key, item in manifest.items()}
    return kind(**values, blobs=Blobs(files))


class Blobs(Mapping[str, bytes]):
    """The replies of a bundle by digest, as a view of its files by path."""

    def __init__(self, files: Mapping[str, bytes]) -> None:
        self._files = files

    def __getitem__(self, digest: str) -> bytes:
        return self._files[REPLIES + digest]

    def __iter__(self) -> Any:
        return (name.removeprefix(REPLIES) for name in self._files if name.startswith(REPLIES))

    def __len__(self) -> int:
        return sum(1 for _ in self)


def encode_checks(checks: tuple[Check, ...]) -> bytes:
    """Returns checks as JSON."""
    return dump(checks)


def decode_checks(data: bytes) -> tuple[Check, ...]:
    """Returns the checks that `encode_checks` wrote."""
    checks: tuple[Check, ...] = typed(tuple[Check, ...], orjson.loads(data))
    return checks


def decode_diagnostics(data: Any) -> tuple[Diagnostic, ...]:
    """Returns diagnostics from plain data (a list of mappings)."""
    diagnostics: tuple[Diagnostic, ...] = typed(tuple[Diagnostic, ...], data)
    return diagnostics
