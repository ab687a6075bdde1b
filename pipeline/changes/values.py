"""Compares values of robot.json, and describes their difference in words."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

TOLERANCE = 1e-9
"""Tolerance of numbers, relative to the largest number of their vector, and of poses [m, rad]. Two formats of
the same robot differ by up to this."""

MESH_TOLERANCES: Mapping[str, tuple[float, float]] = {
    "area": (1e-5, 0.0),
    "volume": (1e-5, 0.0),
    "depth": (1e-4, 1e-6),
    "bounds": (1e-5, 1e-6),
}
"""Relative and absolute tolerance of fields that are computed from meshes, which are in single precision."""

UNITS = {
    "mass": "kg",
    "total_mass": "kg",
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
"""Maps each field to its unit, or to its units for a turn and for a slide."""


def is_pose(value: Any) -> bool:
    """Tells whether a value is a pose {xyz, quat}."""
    return isinstance(value, Mapping) and set(value) == {"xyz", "quat"}


def is_numeric(value: Any) -> bool:
    """Tells whether a value is a number, or a list of numbers and such lists."""
    if isinstance(value, list):
        return bool(value) and all(map(is_numeric, value))
    return isinstance(value, int | float) and not isinstance(value, bool)


def are_equal(before: Any, after: Any, field: str = "") -> bool:
    """Tells whether two values of a field are the same up to rounding."""
    if field in MESH_TOLERANCES and is_numeric(before) and is_numeric(after):
        share, absolute = MESH_TOLERANCES[field]
        earlier, later = list(_numbers(before)), list(_numbers(after))
        largest = max(map(abs, (*earlier, *later)))
        difference = max(abs(a - b) for a, b in zip(earlier, later, strict=False))
        return len(earlier) == len(later) and bool(difference <= max(absolute, share * largest))
    if is_pose(before) and is_pose(after):
        return max(pose_difference(before, after)) <= TOLERANCE
    if is_numeric(before) and is_numeric(after):
        earlier, later = list(_numbers(before)), list(_numbers(after))
        scale = max(map(abs, (*earlier, *later)), default=0.0)
        return len(earlier) == len(later) and all(
            abs(a - b) <= TOLERANCE * scale for a, b in zip(earlier, later, strict=True)
        )
    if isinstance(before, list) and isinstance(after, list):
        return len(before) == len(after) and all(map(are_equal, before, after))
    if isinstance(before, Mapping) and isinstance(after, Mapping):
        return before.keys() == after.keys() and all(are_equal(before[key], after[key]) for key in before)
    return bool(before == after)


def pose_difference(before: Mapping[str, Any], after: Mapping[str, Any]) -> tuple[float, float]:
    """Returns the difference of two poses: the distance [m] and the angle [rad]."""
    return math.dist(before["xyz"], after["xyz"]), _rotation_angle(before["quat"], after["quat"])


def change_text(field: str, before: Any, after: Any, kind: str = "turn") -> str:
    """Describes a field's change in words. `kind` of the dof, "turn" or "slide", decides the units."""
    name = _FIELD_WORDS.get(field, field.replace("_", " "))
    table, dot, dof = field.partition(".")
    if dot and table in _ENTRY_WORDS:
        name = f"{_ENTRY_WORDS[table]} of {dof}"
    if is_pose(before) and is_pose(after):
        return f"{name} {_motion_text(*pose_difference(before, after))}"
    if field == "files" and isinstance(before, list) and isinstance(after, list):
        return _files_text(before, after)
    quantity = field.rpartition(".")[2]
    unit = UNITS.get(quantity, "")
    unit_text = f" {unit[kind == 'slide'] if isinstance(unit, tuple) else unit}".rstrip()
    if field == "com" and is_numeric(before) and is_numeric(after):
        return f"{name} moved by {_length_text(math.dist(before, after))}"
    if quantity == "axis" and is_numeric(before) and is_numeric(after):
        return f"{name} turned by {_angle_text(_axis_angle(before, after))}"
    if quantity == "inertia" and is_numeric(before) and is_numeric(after):
        earlier, later = list(_numbers(before)), list(_numbers(after))
        share = math.dist(earlier, later) / max(math.hypot(*earlier), math.hypot(*later))
        earlier, later = ([row[i] for i, row in enumerate(tensor)] for tensor in (before, after))
        moments = f"{_value_text(earlier)} → {_value_text(later)}"
        return f"{name} differs by {_share_text(share)} (ixx, iyy, izz: {moments}{unit_text})"
    if quantity == "limits" and isinstance(before, list) and isinstance(after, list):
        ends = zip(("lower", "upper"), before, after, strict=False)
        texts = [
            f"{end} limit {_value_text(earlier)} → {_value_text(later)}{unit_text}"
            for end, earlier, later in ends
            if not are_equal(earlier, later)
        ]
        return ", ".join(texts)
    text = f"{name} {_value_text(before)} → {_value_text(after)}{unit_text}"
    if quantity in ("mass", "total_mass") and before:
        text += f" ({100 * (after - before) / before:+.3g} %)"
    return text


_ENTRY_WORDS = {"values": "value", "given": "given value"}
"""Maps the fields of a keyframe that map dofs to values, to words for their entries."""

_FIELD_WORDS = {
    "com": "center of mass",
    "saved": "saved pose",
    "qpos0": "value at the start",
    "dof": "degrees of freedom",
}
"""Maps fields to words for people."""


def _files_text(before: Sequence[str], after: Sequence[str]) -> str:
    """Describes in words the files that were added and removed."""
    groups = [("removed ", [file for file in before if file not in after])]
    groups.append(("added ", [file for file in after if file not in before]))
    return "files: " + "; ".join(word + ", ".join(names) for word, names in groups if names)


def _motion_text(distance: float, angle: float) -> str:
    parts = [f"moved by {_length_text(distance)}"] * (distance > TOLERANCE) + [
        f"turned by {_angle_text(angle)}"
    ] * (angle > TOLERANCE)
    return ", ".join(parts)


def _length_text(metres: float) -> str:
    return f"{1000 * metres:.3g} mm"


def _angle_text(angle: float) -> str:
    return f"{math.degrees(angle):.3g} deg"


def _share_text(share: float) -> str:
    return f"{100 * share:.3g} %"


def _rotation_angle(before: Sequence[float], after: Sequence[float]) -> float:
    """Returns the angle [rad] between two orientations (w, x, y, z)."""
    w, x, y, z = before
    W, X, Y, Z = after
    # The sine is the length of the vector part of conj(q) Q: small angles are exact, unlike with acos. q and
    # -q are the same orientation, hence abs.
    cosine = w * W + x * X + y * Y + z * Z
    sine = math.hypot(
        w * X - x * W - y * Z + z * Y, w * Y + x * Z - y * W - z * X, w * Z - x * Y + y * X - z * W
    )
    return 2.0 * math.atan2(sine, abs(cosine))


def _axis_angle(first: Sequence[float], second: Sequence[float]) -> float:
    """Returns the angle [rad] between two directions."""
    # The cross and the dot product: exact also for small angles, unlike acos.
    (a, b, c), (d, e, f) = first, second
    return math.atan2(math.hypot(b * f - c * e, c * d - a * f, a * e - b * d), a * d + b * e + c * f)


def _numbers(value: Any) -> Iterator[float]:
    """Yields the numbers of a nested list in order."""
    if isinstance(value, list):
        for entry in value:
            yield from _numbers(entry)
    else:
        yield value


def _value_text(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return f"[{', '.join(map(_value_text, value))}]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_value_text(entry)}" for key, entry in value.items()) + "}"
    return str(value)
