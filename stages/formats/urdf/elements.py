"""What is said in a URDF's elements: names, numbers, poses; and what is told of them."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from stages.formats.xml import Element
from stages.robot.errors import Diagnostic
from stages.robot.model import Array, frozen
from stages.robot.poses import from_parts, rotation_from_quat, rotation_from_rpy

_MOST_TOLD = 50

HINTS = {
    "E-URDF-AXIS": "give the axis a direction, as in 0 0 1",
    "E-URDF-EMPTY": "check that source.path names the robot's own file, and not a piece of it",
    "E-URDF-JOINT": "name the two links that it joins",
    "E-URDF-LIMIT": "swap the two, or mend the one that is wrong",
    "E-URDF-MESH": "name the mesh's file, or take the shape out",
    "E-URDF-MIMIC": "name the joint that it follows, or take the <mimic> out",
    "E-URDF-MORE": "mend these first",
    "E-URDF-NAME": "give it a name of its own",
    "E-URDF-NUMBER": "mend the number in the file",
    "E-URDF-SHAPE": "give the shape its size in metres, or take it out",
    "W-URDF-COLOUR": "give red, green, blue and alpha from 0 to 1",
    "W-URDF-INERTIAL": "complete it, or take the <inertial> out",
    "W-URDF-MATERIAL": "define each material once, with a name of its own",
    "W-URDF-SHAPE": "give it a box, cylinder, sphere, capsule or mesh with an extent, or take it out",
    "W-URDF-TWICE": "take out the ones that shall not count",
}
"""What to do about a finding, by code, unless the finding says it itself."""


class Told:
    """Gathers what is to be told of a file, which `where` names."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._errors: list[tuple[int, Diagnostic]] = []
        self._others: list[tuple[int, Diagnostic]] = []
        self._more = 0
        self._left: dict[str, int] = {}
        self._unknown: dict[str, list[int]] = {}

    def tell(self, code: str, element: Element | int, message: str, hint: str = "") -> None:
        """One finding about an element, or about a line."""
        line = element if isinstance(element, int) else element.sourceline
        found = self._errors if code.startswith("E-") else self._others
        if len(found) < _MOST_TOLD:
            found.append((line, Diagnostic(code, message, self._place(line), hint or HINTS.get(code, ""))))
        elif found is self._errors:
            self._more += 1

    def _place(self, line: int) -> str:
        return f"{self._where}, line {line}"

    def leave(self, what: str) -> None:
        """Something that is known and left out."""
        self._left[what] = self._left.get(what, 0) + 1

    def unknown(self, what: str, element: Element) -> None:
        self._unknown.setdefault(what, []).append(element.sourceline)

    def check(self, element: Element, children: Iterable[str], attributes: Iterable[str] = ()) -> None:
        """Takes down what an element has besides these children and attributes."""
        for child in element:
            name = tag(child)
            if name in _LEFT:
                self.leave(f"<{name}>")
            elif name not in children:
                self.unknown(f"<{name}> in <{tag(element)}>", child)
        for name in element.attrib:
            if (tag(element), name) in _LEFT_ATTRIBUTES or name.startswith("{") or ":" in name:
                self.leave(f"{name.rpartition('}')[2]} of <{tag(element)}>")
            elif name not in attributes:
                self.unknown(f'{name}="" of <{tag(element)}>', element)

    def everything(self) -> tuple[Diagnostic, ...]:
        """All findings, at most fifty of each level: errors first, then the others, each by their lines;
        what was left out last."""
        errors, others = (_by_line(found) for found in (self._errors, self._others))
        if self._more:
            text = f"and {self._more} more errors"
            errors.append(Diagnostic("E-URDF-MORE", text, self._where, HINTS["E-URDF-MORE"]))
        return (*errors, *others, *self._passed_over())

    def _passed_over(self) -> list[Diagnostic]:
        found = []
        for what, lines in list(self._unknown.items())[:_MOST_TOLD]:
            times = f", and {len(lines) - 1} more" if len(lines) > 1 else ""
            msg = f"{what} is not known, and is left out{times}"
            hint = "check its spelling against the URDF reference"
            found.append(Diagnostic("W-URDF-UNKNOWN", msg, self._place(lines[0]), hint))
        if self._left:
            names = ", ".join(f"{name} ({count})" for name, count in sorted(self._left.items()))
            msg = f"left out, as they say nothing of how the robot is made: {names}"
            found.append(Diagnostic("I-URDF-LEFT", msg, self._where))
        return found


def _by_line(found: list[tuple[int, Diagnostic]]) -> list[Diagnostic]:
    return [one for _, one in sorted(found, key=lambda pair: pair[0])]


_LEFT = frozenset(
    ("gazebo", "contact", "sensor", "safety_controller", "calibration", "self_collision_checking", "verbose")
)
"""Elements that a URDF may have in many places, and that say nothing of links and joints."""


_LEFT_ATTRIBUTES = frozenset(
    (
        *(("visual", "name"), ("visual", "group"), ("collision", "name"), ("collision", "group")),
        *(("limit", "acceleration"), ("limit", "deceleration"), ("limit", "jerk")),
        *(("link", "type"), ("joint", "dont_collapse")),
    )
)
"""Attributes that a URDF may have, by their elements, and that a robot of ours does not hold."""


def tag(element: Element) -> str:
    """An element's name, with its prefix where it has one."""
    name = str(element.tag).rpartition("}")[2]
    return f"{element.prefix}:{name}" if element.prefix else name


def child(element: Element, name: str, told: Told) -> Element | None:
    """The child of that name, None without one; of several the first counts, which is told."""
    found = [one for one in element if tag(one) == name]
    if len(found) > 1:
        told.tell("W-URDF-TWICE", found[1], f"<{tag(element)}> has several <{name}>; the first counts")
    return found[0] if found else None


def number(
    element: Element, name: str, told: Told, default: float | None = None, *, infinite: bool = False
) -> float | None:
    """A number in an attribute; `default` where there is none or a wrong one, which is told.

    `infinite`: whether it may be infinite.
    """
    found = numbers(element, name, 1, told, infinite=infinite)
    return default if found is None else found[0]


def numbers(
    element: Element, name: str, count: int, told: Told, *, infinite: bool = False
) -> tuple[float, ...] | None:
    """`count` numbers in an attribute, with spaces or commas between them; None where the attribute is
    not there or empty, or is wrong, which is told."""
    text = element.get(name)
    pieces = text.replace(",", " ").split() if text else []
    if not pieces:
        return None
    values = [_value(piece) for piece in pieces]
    good = [one for one in values if one is not None and (math.isfinite(one) or (infinite and one == one))]
    if len(good) == count == len(values):
        return tuple(good)
    wanted = "a finite number is" if count == 1 else f"{count} finite numbers are"
    if infinite:
        wanted = wanted.replace("finite ", "")
    shown = " ".join(pieces)
    shown = shown if len(shown) <= 60 else f"{shown[:60]}…"
    told.tell("E-URDF-NUMBER", element, f'<{tag(element)} {name}="{shown}">: {wanted} expected')
    return None


def _value(text: str) -> float | None:
    if "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None


def pose(element: Element, told: Told) -> Array:
    """The (4, 4) transform of an element's <origin>, the identity without one."""
    origin = child(element, "origin", told)
    if origin is None:
        return frozen(np.eye(4))
    told.check(origin, (), ("xyz", "rpy", "quat_xyzw"))
    x, y, z = numbers(origin, "xyz", 3, told) or (0.0, 0.0, 0.0)
    quat = numbers(origin, "quat_xyzw", 4, told)
    if quat is not None and any(quat):
        rotation = rotation_from_quat(np.array([quat[3], *quat[:3]]))
    else:
        roll, pitch, yaw = numbers(origin, "rpy", 3, told) or (0.0, 0.0, 0.0)
        rotation = rotation_from_rpy((roll, pitch, yaw))
    return frozen(from_parts(rotation, np.array([x, y, z])))
