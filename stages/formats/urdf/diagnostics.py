"""Collects diagnostics of a URDF, by line: errors, and elements that are left out."""

from __future__ import annotations

from collections.abc import Iterable

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.errors import Diagnostic

_MAX_SHOWN = 50
"""Largest number of diagnostics of a level."""

HINTS = {
    "E-URDF-AXIS": "give the axis a direction, as in 0 0 1",
    "E-URDF-EMPTY": "check that source.path names the robot's own file, not a part of it",
    "E-URDF-JOINT": "name the two links that it joins",
    "E-URDF-LIMIT": "swap the two, or correct the wrong one",
    "E-URDF-MESH": "name the mesh's file, or remove the shape",
    "E-URDF-MIMIC": "name the joint that it follows, or remove the <mimic>",
    "E-URDF-MORE": "correct these first",
    "E-URDF-NAME": "give it a unique name",
    "E-URDF-NUMBER": "correct the number in the file",
    "E-URDF-SHAPE": "give the shape its size in metres, or remove it",
    "W-URDF-COLOUR": "give red, green, blue and alpha from 0 to 1",
    "W-URDF-INERTIAL": "complete the <inertial>, or remove it",
    "W-URDF-MATERIAL": "define each material once, with a unique name",
    "W-URDF-MORE": "correct these first",
    "W-URDF-SHAPE": "give it a box, cylinder, sphere, capsule or mesh with an extent, or remove it",
    "W-URDF-TWICE": "remove the others",
}
"""Code → the default hint of its diagnostics."""

_ELEMENTS_LEFT_OUT = frozenset(
    ("gazebo", "contact", "sensor", "safety_controller", "calibration", "self_collision_checking", "verbose")
)
"""Elements that a URDF may have in many places, and that do not describe links or joints."""

_ATTRIBUTES_LEFT_OUT = frozenset(
    (
        *(("visual", "name"), ("visual", "group"), ("collision", "name"), ("collision", "group")),
        *(("limit", "acceleration"), ("limit", "deceleration"), ("limit", "jerk")),
        *(("link", "type"), ("joint", "dont_collapse")),
    )
)
"""Attributes that a URDF may have, by their elements, and that the robot model does not hold."""


class FileDiagnostics:
    """Diagnostics of a file, which `where` names, collected by line."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._errors: list[tuple[int, Diagnostic]] = []
        self._remarks: list[tuple[int, Diagnostic]] = []
        self._omitted_errors = 0
        self._omitted_warnings = 0
        self._left_out_counts: dict[str, int] = {}
        self._lines_of_unknown: dict[str, list[int]] = {}

    def report(self, code: str, element: Element | int, message: str, hint: str = "") -> None:
        """Adds a diagnostic about an element, or about a line."""
        line = element if isinstance(element, int) else element.sourceline
        entries = self._errors if code.startswith("E-") else self._remarks
        if len(entries) < _MAX_SHOWN:
            entries.append((line, Diagnostic(code, message, self._place(line), hint or HINTS.get(code, ""))))
        elif entries is self._errors:
            self._omitted_errors += 1
        else:
            self._omitted_warnings += 1

    def _place(self, line: int) -> str:
        return f"{self._where}, line {line}"

    def leave_out(self, name: str) -> None:
        """Counts a valid element or attribute of URDF that is left out."""
        self._left_out_counts[name] = self._left_out_counts.get(name, 0) + 1

    def leave_out_unknown(self, name: str, element: Element) -> None:
        """Counts an unknown element or attribute that is left out."""
        self._lines_of_unknown.setdefault(name, []).append(element.sourceline)

    def count_left_out(
        self, element: Element, children: Iterable[str], attributes: Iterable[str] = ()
    ) -> None:
        """Counts the children and attributes of an element that are left out: those that do not describe
        links or joints, and all others that are not among `children` and `attributes`."""
        for child in element:
            name = tag(child)
            if name in _ELEMENTS_LEFT_OUT:
                self.leave_out(f"<{name}>")
            elif name not in children:
                self.leave_out_unknown(f"<{name}> in <{tag(element)}>", child)
        for name in element.attrib:
            if (tag(element), name) in _ATTRIBUTES_LEFT_OUT or name.startswith("{") or ":" in name:
                self.leave_out(f"{name.rpartition('}')[2]} of <{tag(element)}>")
            elif name not in attributes:
                self.leave_out_unknown(f'{name}="" of <{tag(element)}>', element)

    def collected(self) -> tuple[Diagnostic, ...]:
        """Returns the first fifty errors, then the first fifty warnings, each by line, then the elements left
        out. What is beyond fifty is counted."""
        errors, remarks = (_by_line(entries) for entries in (self._errors, self._remarks))
        if self._omitted_errors:
            text = f"and {self._omitted_errors} more errors"
            errors.append(Diagnostic("E-URDF-MORE", text, self._where, HINTS["E-URDF-MORE"]))
        omitted_warnings = self._omitted_warnings + max(0, len(self._lines_of_unknown) - _MAX_SHOWN)
        if omitted_warnings:
            text = f"and {omitted_warnings} more warnings"
            remarks.append(Diagnostic("W-URDF-MORE", text, self._where, HINTS["W-URDF-MORE"]))
        return (*errors, *remarks, *self._left_out())

    def _left_out(self) -> list[Diagnostic]:
        diagnostics = []
        for name, lines in list(self._lines_of_unknown.items())[:_MAX_SHOWN]:
            times = f", and {len(lines) - 1} more" if len(lines) > 1 else ""
            msg = f"unknown {name}: left out{times}"
            hint = "check its spelling against the URDF reference"
            diagnostics.append(Diagnostic("W-URDF-UNKNOWN", msg, self._place(lines[0]), hint))
        if self._left_out_counts:
            names = ", ".join(f"{name} ({count})" for name, count in sorted(self._left_out_counts.items()))
            msg = f"left out, since they do not describe links or joints: {names}"
            diagnostics.append(Diagnostic("I-URDF-LEFT", msg, self._where))
        return diagnostics


def _by_line(entries: list[tuple[int, Diagnostic]]) -> list[Diagnostic]:
    return [diagnostic for _, diagnostic in sorted(entries, key=lambda pair: pair[0])]
