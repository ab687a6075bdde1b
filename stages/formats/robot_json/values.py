"""Converts numbers, values and poses in robot.json."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any

import numpy as np

from linkwright.stages.formats.numbers import FORCE, LENGTH, TURN, number, numbers
from linkwright.stages.formats.robot_json.codec import (
    Form,
    JsonRecord,
    Key,
    Names,
    form_of,
    refers_to,
    refusal,
    table_of,
)
from linkwright.stages.robot.model.poses import from_parts, quat_from_rotation, rotation_from_quat
from linkwright.stages.robot.model.robot import Array, Value, frozen
from linkwright.stages.robot.model.scene import Setting


def as_float(value: float, least: float = 0.0) -> float:
    """Rounds a number to the shortest decimal within 1e-12 of its scale. `least`: the smallest scale (see
    `formats.numbers`)."""
    return float(number(value, least=least))


def as_floats(values: Iterable[float], least: float = 0.0) -> Any:
    """Returns an array as nested lists, each number the shortest decimal within 1e-12 of the scale of the
    array: its largest entry, or `least` if that is larger."""
    array = np.asarray(values, dtype=float)
    return np.array([float(text) for text in numbers(array, least=least)]).reshape(array.shape).tolist()


def as_value(value: Value) -> Any:
    """Returns a dof's value: a number, or a list of numbers."""
    return as_floats(np.array(value), TURN)


def six_digits(value: float) -> float:
    """Rounds a value to six digits: results from many poses differ in later digits between machines. Values
    up to 1e-9 are noise and become 0."""
    return float(f"{value:.6g}") if abs(value) > 1e-9 else 0.0


_read_finite = form_of(float).read


def _unchanged(value: Any) -> Any:
    return value


def _number_form(write: Callable[[float], float]) -> Form:
    return replace(form_of(float), write=write)


def _read_list(data: Any, *counts: int) -> tuple[float, ...]:
    """Returns a list of numbers as a tuple. Raises RobotJsonError for other data, and if its length is not
    one of `counts`, if there are any."""
    if not isinstance(data, list) or (counts and len(data) not in counts):
        raise refusal(f"{' or '.join(map(str, counts))} numbers".lstrip(), data)
    return tuple(_read_finite(item, {}) for item in data)


def _numbers_form(write: Callable[[Any], Any], *counts: int) -> Form:
    size = {"minItems": min(counts), "maxItems": max(counts)} if counts else {}
    schema = {"type": "array", "items": {"type": "number"}, **size}
    return Form(write, lambda data, names: _read_list(data, *counts), schema)


def _vector_form(least: float = 0.0) -> Form:
    form = _numbers_form(partial(as_floats, least=least), 3)
    return Form(form.write, lambda data, names: frozen(form.read(data, names)), form.schema)


def _write_each(write: Callable[[float], float]) -> Callable[[Iterable[float]], list[float]]:
    """Returns a function that writes each number of a list by `write`."""
    return lambda values: [write(value) for value in values]


def _tensor_form(write: Callable[[Array], Any]) -> Form:
    def read(data: Any, names: Names) -> Array:
        if not isinstance(data, list) or [len(row) for row in data if isinstance(row, list)] != [3, 3, 3]:
            raise refusal("a 3x3 tensor", data)
        return frozen([_read_list(row) for row in data])

    row = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
    return Form(write, read, {**row, "items": row})


def _read_quat(data: Any, names: Names) -> Array:
    quat = frozen(_read_list(data, 4))
    if not np.linalg.norm(quat) > 0.0:
        raise refusal("a quaternion", data)
    return quat


def _read_ends(data: Any, names: Names) -> tuple[float | None, ...]:
    if not isinstance(data, list) or len(data) != 2:
        raise refusal("two ends", data)
    return tuple(None if end is None else _read_finite(end, names) for end in data)


def _read_value(data: Any, names: Names) -> Value:
    return _read_list(data, 4, 7) if isinstance(data, list) else _read_finite(data, names)


def _read_setting(data: Any, names: Names) -> Setting:
    if isinstance(data, str):
        return data
    return _read_list(data) if isinstance(data, list) else _read_finite(data, names)


def _setting_form(write: Callable[[float], float]) -> Form:
    def write_setting(value: Setting) -> Any:
        if isinstance(value, str):
            return value
        return as_floats(value) if isinstance(value, tuple) else write(value)

    kinds = [{"type": "string"}, {"type": "number"}, {"type": "array", "items": {"type": "number"}}]
    return Form(write_setting, _read_setting, {"anyOf": kinds})


def pairs_of(form: Form) -> Form:
    """Returns the form of a JSON table that the model has as (name, value) pairs."""
    return table_of(form, lambda pairs: tuple(pairs.items()))


_DOF_VALUE = Form(
    as_value, _read_value, {"anyOf": [{"type": "number"}, _numbers_form(_unchanged, 4, 7).schema]}
)
_PAIRS = form_of(Mapping[str, tuple[str, str]])

Number = Annotated[float, _number_form(as_float)]
Coordinate = Annotated[float, _number_form(partial(as_float, least=TURN))]
"""A value of a dof, or a difference of such values [rad or m], with a scale of at least 1: up to 1e-12 it
counts as 0."""

SixDigits = Annotated[float, _number_form(six_digits)]
"""A number in six digits."""

Vector = Annotated[Array, _vector_form()]
Position = Annotated[Array, _vector_form(LENGTH)]
"""A position (3,) [m], with a scale of at least 0.1 m: entries up to 1e-13 m count as 0."""

Tensor = Annotated[Array, _tensor_form(as_floats)]
ExactTensor = Annotated[Array, _tensor_form(lambda axes: np.asarray(axes, dtype=float).tolist())]
"""A 3x3 tensor with all digits."""

Quat = Annotated[Array, Form(as_floats, _read_quat, _numbers_form(_unchanged, 4).schema)]
DofValue = Annotated[Value, _DOF_VALUE]

Ends = Annotated[
    tuple[float | None, float | None],
    Form(list, _read_ends, {**_numbers_form(list, 2).schema, "items": {"type": ["number", "null"]}}),
]
"""Two numbers, each of which may be null."""

Range = Annotated[tuple[float, float], _numbers_form(as_floats, 2)]
SixDigitRange = Annotated[tuple[float, float], _numbers_form(_write_each(six_digits), 2)]
"""Two numbers in six digits each."""

Friction = Annotated[tuple[float, float, float], _numbers_form(as_floats, 3)]
Colour = Annotated[tuple[float, float, float, float], _numbers_form(_write_each(as_float), 4)]
Lengths = Annotated[tuple[float, ...], _numbers_form(_write_each(as_float))]
"""Lengths [m], each rounded by its own scale."""

Sizes = Annotated[tuple[float, ...], _numbers_form(as_floats)]
"""Sizes, all rounded by the largest of them."""

Bounds = Annotated[tuple[float, ...], _numbers_form(_write_each(six_digits), 6)]
"""The smallest x, y and z, and the largest, in six digits each."""

ExactNumbers = Annotated[tuple[float, ...], _numbers_form(list)]
"""Numbers with all digits."""

RootValue = Annotated[tuple[float, ...], _numbers_form(list, 0, 7)]
"""Position and quaternion of a floating root; empty for a fixed root."""


def numbers_by_own_scale(count: int) -> Form:
    """Returns the form of `count` numbers, each rounded by its own scale."""
    return _numbers_form(_write_each(as_float), count)


TextPairs = Annotated[tuple[tuple[str, str], ...], pairs_of(form_of(str))]
NamePairs = Annotated[
    tuple[tuple[str, str, str], ...],
    Form(
        lambda names: {attribute: [kind, name] for attribute, kind, name in names},
        lambda data, names: tuple((key, *pair) for key, pair in _PAIRS.read(data, names).items()),
        _PAIRS.schema,
    ),
]
"""(attribute, kind of the element that it names, name of that element) for each attribute."""

TextListPairs = Annotated[tuple[tuple[str, tuple[str, ...]], ...], pairs_of(form_of(tuple[str, ...]))]
ExactValue = Annotated[float | tuple[float, ...], replace(_DOF_VALUE, write=_unchanged)]
"""A dof's value with all digits."""

SettingValue = Annotated[Setting, _setting_form(as_float)]
SettingPairs = Annotated[tuple[tuple[str, Setting], ...], pairs_of(_setting_form(_unchanged))]
Forces = Annotated[tuple[tuple[str, float], ...], pairs_of(_number_form(partial(as_float, least=FORCE)))]
Values = Annotated[
    tuple[tuple[str, float], ...], pairs_of(Form(as_value, _read_finite, form_of(float).schema))
]

LinkName = Annotated[str, refers_to("link")]
DofName = Annotated[str, refers_to("joint")]


@dataclass(frozen=True)
class PoseRecord(JsonRecord[Array]):
    """The pose of a frame in another frame.

    xyz: its origin [m].
    quat: its orientation, a quaternion (w, x, y, z).
    """

    xyz: Position
    quat: Quat

    @classmethod
    def from_model(cls, value: Array, **more: Any) -> "PoseRecord":
        return cls(value[:3, 3], quat_from_rotation(value[:3, :3]))

    def to_model(self, **more: Any) -> Array:
        return frozen(from_parts(rotation_from_quat(self.quat), self.xyz))


Pose = Annotated[PoseRecord, Key("pose")]
"""A pose with the key `pose` in robot.json; the model's field names both frames, such as
`link_from_frame`."""

PosePairs = Annotated[tuple[tuple[str, Array], ...], pairs_of(form_of(PoseRecord))]
"""(name, pose) pairs."""
