"""Values of robot.json: whether two are alike, and what is said of two that are not."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

ALIKE = 1e-9
"""Numbers are alike up to this share of the largest of their vector, lengths and angles of poses up to this
many metres and radians: two formats of one robot differ by as much."""

ROUGH: Mapping[str, tuple[float, float]] = {
    "area": (1e-5, 0.0),
    "volume": (1e-5, 0.0),
    "depth": (1e-4, 1e-6),
    "bounds": (1e-5, 1e-6),
}
"""Fields that are worked out of meshes, which are in single precision: they are alike up to this share, and
up to this much."""

UNITS = {
    "mass": "kg",
    "com": "m",
    "inertia": "kg m²",
    "damping": ("N m s/rad", "N s/m"),
    "friction": ("N m", "N"),
    "armature": ("kg m²", "kg"),
    "effort": ("N m", "N"),
    "velocity": ("rad/s", "m/s"),
    "limits": ("rad", "m"),
    "saved": ("rad", "m"),
    "qpos0": ("rad", "m"),
    "size": "m",
    "area": "m²",
    "bounds": "m",
    "volume": "m³",
    "depth": "m",
    "lever": "m",
}
"""Field → its unit, or that of a turn and that of a slide."""


def is_pose(value: Any) -> bool:
    """Whether a value is a pose {xyz, quat}."""
    return isinstance(value, Mapping) and set(value) == {"xyz", "quat"}


def is_numeric(value: Any) -> bool:
    """Whether a value is a number, or a list of numbers and such lists."""
    if isinstance(value, list):
        return bool(value) and all(map(is_numeric, value))
    return isinstance(value, int | float) and not isinstance(value, bool)


def alike(before: Any, after: Any, field: str = "") -> bool:
    """Whether two values of a field are the same up to rounding."""
    if field in ROUGH and is_numeric(before) and is_numeric(after):
        share, least = ROUGH[field]
        one, other = list(_flat(before)), list(_flat(after))
        most = max(map(abs, (*one, *other)))
        off = max(abs(a - b) for a, b in zip(one, other, strict=False))
        return len(one) == len(other) and bool(off <= max(least, share * most))
    if is_pose(before) and is_pose(after):
        return max(moved(before, after)) <= ALIKE
    if is_numeric(before) and is_numeric(after):
        one, other = list(_flat(before)), list(_flat(after))
        scale = max(map(abs, (*one, *other)), default=0.0)
        return len(one) == len(other) and all(
            abs(a - b) <= ALIKE * scale for a, b in zip(one, other, strict=True)
        )
    if isinstance(before, list) and isinstance(after, list):
        return len(before) == len(after) and all(map(alike, before, after))
    if isinstance(before, Mapping) and isinstance(after, Mapping):
        return before.keys() == after.keys() and all(alike(before[key], after[key]) for key in before)
    return bool(before == after)


def moved(before: Mapping[str, Any], after: Mapping[str, Any]) -> tuple[float, float]:
    """By how much a pose differs from another: the distance [m] and the angle [rad]."""
    return math.dist(before["xyz"], after["xyz"]), _angle(before["quat"], after["quat"])


def described(field: str, before: Any, after: Any, kind: str = "turn") -> str:
    """What is said of a field that changed; `kind`: of the dof that has it."""
    name = _WORDS.get(field, field.replace("_", " "))
    above, dot, dof = field.partition(".")
    if dot and above in _VALUES:
        name = f"{_VALUES[above]} of {dof}"
    if is_pose(before) and is_pose(after):
        return f"{name} {_motion(*moved(before, after))}"
    if field == "files" and isinstance(before, list) and isinstance(after, list):
        return _files(before, after)
    last = field.rpartition(".")[2]
    unit = UNITS.get(last, "")
    shown = f" {unit[kind == 'slide'] if isinstance(unit, tuple) else unit}".rstrip()
    if field == "com" and is_numeric(before) and is_numeric(after):
        return f"{name} moved by {_length(math.dist(before, after))}"
    if last == "axis" and is_numeric(before) and is_numeric(after):
        return f"{name} turned by {_degrees(_between(before, after))}"
    if last == "inertia" and is_numeric(before) and is_numeric(after):
        one, other = list(_flat(before)), list(_flat(after))
        share = math.dist(one, other) / max(math.hypot(*one), math.hypot(*other))
        one, other = ([row[i] for i, row in enumerate(tensor)] for tensor in (before, after))
        moments = f"{_text(one)} → {_text(other)}"
        return f"{name} differs by {_percent(share)} (ixx, iyy, izz: {moments}{shown})"
    if last == "limits" and isinstance(before, list) and isinstance(after, list):
        ends = zip(("lower", "upper"), before, after, strict=False)
        told = [
            f"{end} limit {_text(one)} → {_text(other)}{shown}"
            for end, one, other in ends
            if not alike(one, other)
        ]
        return ", ".join(told)
    text = f"{name} {_text(before)} → {_text(after)}{shown}"
    if last == "mass" and before:
        text += f" ({100 * (after - before) / before:+.3g} %)"
    return text


_VALUES = {"values": "value", "given": "given value"}
"""Mapping of a keyframe, by dof → what people call its entries."""

_WORDS = {
    "com": "center of mass",
    "saved": "saved pose",
    "qpos0": "value at the start",
    "dof": "degrees of freedom",
}
"""Field → what people call it."""


def _files(before: Sequence[str], after: Sequence[str]) -> str:
    """Which files came and went."""
    told = [("removed ", [one for one in before if one not in after])]
    told.append(("added ", [one for one in after if one not in before]))
    return "files: " + "; ".join(word + ", ".join(names) for word, names in told if names)


def _motion(distance: float, angle: float) -> str:
    parts = [f"moved by {_length(distance)}"] * (distance > ALIKE) + [f"turned by {_degrees(angle)}"] * (
        angle > ALIKE
    )
    return ", ".join(parts)


def _length(metres: float) -> str:
    return f"{1000 * metres:.3g} mm"


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.3g} deg"


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _angle(before: Sequence[float], after: Sequence[float]) -> float:
    """The angle [rad] between two orientations (w, x, y, z)."""
    w, x, y, z = before
    W, X, Y, Z = after
    cosine = w * W + x * X + y * Y + z * Z
    sine = math.hypot(
        w * X - x * W - y * Z + z * Y, w * Y + x * Z - y * W - z * X, w * Z - x * Y + y * X - z * W
    )
    return 2.0 * math.atan2(sine, abs(cosine))


def _between(one: Sequence[float], other: Sequence[float]) -> float:
    """The angle [rad] between two directions."""
    (a, b, c), (d, e, f) = one, other
    return math.atan2(math.hypot(b * f - c * e, c * d - a * f, a * e - b * d), a * d + b * e + c * f)


def _flat(value: Any) -> Iterator[float]:
    if isinstance(value, list):
        for one in value:
            yield from _flat(one)
    else:
        yield value


def _text(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_text(one)}" for key, one in value.items()) + "}"
    return str(value)
