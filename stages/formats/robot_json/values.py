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
    refused,
    table_of,
)
from linkwright.stages.robot.model.poses import from_parts, quat_from_rotation, rotation_from_quat
from linkwright.stages.robot.model.robot import Array, Value, frozen
from linkwright.stages.robot.model.scene import Setting


def as_float(value: float, least: float = 0.0) -> float:
    """Returns a number as short as the formatter makes it."""
    return float(number(value, least=least))


def as_floats(values: Iterable[float], least: float = 0.0) -> Any:
    """Returns nested lists of the array's shape, each number as short as the formatter makes it."""
    array = np.asarray(values, dtype=float)
    return np.array([float(text) for text in numbers(array, least=least)]).reshape(array.shape).tolist()


def as_value(value: Value) -> Any:
    """Returns a dof's value: a number, or a list of numbers."""
    return as_floats(np.array(value), TURN)


def short(value: float) -> float:
    """Rounds a value to six digits: results from many poses differ in later digits between machines. Values
    below 1e-9 differ in all digits, and become 0."""
    return float(f"{value:.6g}") if abs(value) > 1e-9 else 0.0


_finite = form_of(float).read


def _kept(value: Any) -> Any:
    return value


def _number(write: Callable[[float], float]) -> Form:
    return replace(form_of(float), write=write)


def _list(data: Any, *counts: int) -> tuple[float, ...]:
    """Returns a list of numbers, whose length is one of `counts`, or any length without counts."""
    if not isinstance(data, list) or (counts and len(data) not in counts):
        raise refused(f"{' or '.join(map(str, counts))} numbers".lstrip(), data)
    return tuple(_finite(item, {}) for item in data)


def _numbers(write: Callable[[Any], Any], *counts: int) -> Form:
    size = {"minItems": min(counts), "maxItems": max(counts)} if counts else {}
    schema = {"type": "array", "items": {"type": "number"}, **size}
    return Form(write, lambda data, names: _list(data, *counts), schema)


def _vector(least: float = 0.0) -> Form:
    form = _numbers(partial(as_floats, least=least), 3)
    return Form(form.write, lambda data, names: frozen(form.read(data, names)), form.schema)


def _each(write: Callable[[float], float]) -> Callable[[Iterable[float]], list[float]]:
    return lambda values: [write(value) for value in values]


def _tensor(write: Callable[[Array], Any]) -> Form:
    def read(data: Any, names: Names) -> Array:
        if not isinstance(data, list) or [len(row) for row in data if isinstance(row, list)] != [3, 3, 3]:
            raise refused("a 3x3 tensor", data)
        return frozen([_list(row) for row in data])

    row = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
    return Form(write, read, {**row, "items": row})


def _read_quat(data: Any, names: Names) -> Array:
    quat = frozen(_list(data, 4))
    if not np.linalg.norm(quat) > 0.0:
        raise refused("a quaternion", data)
    return quat


def _read_ends(data: Any, names: Names) -> tuple[float | None, ...]:
    if not isinstance(data, list) or len(data) != 2:
        raise refused("two ends", data)
    return tuple(None if end is None else _finite(end, names) for end in data)


def _read_value(data: Any, names: Names) -> Value:
    return _list(data, 4, 7) if isinstance(data, list) else _finite(data, names)


def _read_setting(data: Any, names: Names) -> Setting:
    if isinstance(data, str):
        return data
    return _list(data) if isinstance(data, list) else _finite(data, names)


def _setting(write: Callable[[float], float]) -> Form:
    def written(value: Setting) -> Any:
        if isinstance(value, str):
            return value
        return as_floats(value) if isinstance(value, tuple) else write(value)

    kinds = [{"type": "string"}, {"type": "number"}, {"type": "array", "items": {"type": "number"}}]
    return Form(written, _read_setting, {"anyOf": kinds})


def pairs_of(form: Form) -> Form:
    """Returns the form of a table that the model has as pairs of a name and a value."""
    return table_of(form, lambda pairs: tuple(pairs.items()))


_DOF_VALUE = Form(as_value, _read_value, {"anyOf": [{"type": "number"}, _numbers(_kept, 4, 7).schema]})
_PAIRS = form_of(Mapping[str, tuple[str, str]])

Number = Annotated[float, _number(as_float)]
Turned = Annotated[float, _number(partial(as_float, least=TURN))]
"""A number in [rad], or of unit length."""

Short = Annotated[float, _number(short)]
"""A number in six digits."""

Vector = Annotated[Array, _vector()]
Place = Annotated[Array, _vector(LENGTH)]
Tensor = Annotated[Array, _tensor(as_floats)]
ExactTensor = Annotated[Array, _tensor(lambda axes: np.asarray(axes, dtype=float).tolist())]
Quat = Annotated[Array, Form(as_floats, _read_quat, _numbers(_kept, 4).schema)]
DofValue = Annotated[Value, _DOF_VALUE]

Ends = Annotated[
    tuple[float | None, float | None],
    Form(list, _read_ends, {**_numbers(list, 2).schema, "items": {"type": ["number", "null"]}}),
]
"""Two numbers, each of which may be null."""

Range = Annotated[tuple[float, float], _numbers(as_floats, 2)]
ShortRange = Annotated[tuple[float, float], _numbers(_each(short), 2)]
Friction = Annotated[tuple[float, float, float], _numbers(as_floats, 3)]
Colour = Annotated[tuple[float, float, float, float], _numbers(_each(as_float), 4)]
Lengths = Annotated[tuple[float, ...], _numbers(_each(as_float))]
Sizes = Annotated[tuple[float, ...], _numbers(as_floats)]
Bounds = Annotated[tuple[float, ...], _numbers(_each(short), 6)]
ExactNumbers = Annotated[tuple[float, ...], _numbers(list)]
RootValue = Annotated[tuple[float, ...], _numbers(list, 0, 7)]
"""Position and quaternion of a floating root; empty for a fixed root."""


def each_of(count: int) -> Form:
    """Returns the form of `count` numbers, each as short as possible."""
    return _numbers(_each(as_float), count)


TextPairs = Annotated[tuple[tuple[str, str], ...], pairs_of(form_of(str))]
NamePairs = Annotated[
    tuple[tuple[str, str, str], ...],
    Form(
        lambda names: {attribute: [kind, name] for attribute, kind, name in names},
        lambda data, names: tuple((key, *pair) for key, pair in _PAIRS.read(data, names).items()),
        _PAIRS.schema,
    ),
]
"""Attribute → the kind and the name of the thing that it names."""

TextsPairs = Annotated[tuple[tuple[str, tuple[str, ...]], ...], pairs_of(form_of(tuple[str, ...]))]
ExactValue = Annotated[float | tuple[float, ...], replace(_DOF_VALUE, write=_kept)]
SettingValue = Annotated[Setting, _setting(as_float)]
SettingPairs = Annotated[tuple[tuple[str, Setting], ...], pairs_of(_setting(_kept))]
Forces = Annotated[tuple[tuple[str, float], ...], pairs_of(_number(partial(as_float, least=FORCE)))]
Values = Annotated[tuple[tuple[str, float], ...], pairs_of(Form(as_value, _finite, form_of(float).schema))]

LinkName = Annotated[str, refers_to("link")]
DofName = Annotated[str, refers_to("joint")]


@dataclass(frozen=True)
class PoseRecord(JsonRecord[Array]):
    """The pose of a frame in another.

    xyz: its origin [m].
    quat: its orientation, a quaternion (w, x, y, z).
    """

    xyz: Place
    quat: Quat

    @classmethod
    def from_model(cls, value: Array, **more: Any) -> "PoseRecord":
        return cls(value[:3, 3], quat_from_rotation(value[:3, :3]))

    def to_model(self, **more: Any) -> Array:
        return frozen(from_parts(rotation_from_quat(self.quat), self.xyz))


Pose = Annotated[PoseRecord, Key("pose")]
"""A pose with the key `pose` in robot.json; the model's name says its frames."""

PosePairs = Annotated[tuple[tuple[str, Array], ...], pairs_of(form_of(PoseRecord))]
"""Poses by names."""
