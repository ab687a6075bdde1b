"""`elements` and `attributes`, applied to the files of every format that they are for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from linkwright.stages.export.amend.compiled import compiled, fit, likely
from linkwright.stages.export.amend.documents import Documents, Refused
from linkwright.stages.export.amend.entries import Entry, entries
from linkwright.stages.formats.xml import Element
from linkwright.stages.mujoco.compile import NotCompiled
from linkwright.stages.robot.errors import Diagnostic, ExportError
from linkwright.stages.robot.model.amendments import UNCHANGED, Amendment, Amendments, Surplus
from linkwright.stages.robot.text.globs import listed

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

_MESSAGE = "the robot's files cannot be amended"


@dataclass(frozen=True, slots=True)
class Amended:
    """The `files` that were changed, by path, what was done to them, and remarks."""

    files: Mapping[str, bytes]
    amendments: Amendments = UNCHANGED
    diagnostics: tuple[Diagnostic, ...] = ()


def amended(
    files: Mapping[str, bytes],
    formats: Mapping[str, Sequence[str]],
    keys: "ExportSections",
    texts: Mapping[str, str],
) -> Amended:
    """`files`: all files of the robot, by path, with its meshes; `formats`: those that are written, with the
    paths of their files; `texts`: of the files that `elements` name, by entry.

    ExportError with E-ELEMENT for each entry whose target is not there, or whose names are taken, and where
    MuJoCo refuses the result. I-ELEMENT for entries of formats that are not written.
    """
    try:
        every = entries(keys, texts)
    except Refused as refused:
        raise ExportError(_MESSAGE, problems=[refused.diagnostic]) from None
    found: dict[str, bytes] = {}
    changes: list[Amendment] = []
    surplus: list[Surplus] = []
    problems: list[Diagnostic] = []
    for form, paths in formats.items():
        work = _FormatWork(form, paths, files, [one for one in every if form in one.formats])
        if work.entries and work.apply():
            found |= work.documents.written()
            changes += work.changes
            surplus += work.surplus
        problems += work.problems
    if problems:
        raise ExportError(_MESSAGE, problems=dict.fromkeys(problems))
    return Amended(found, Amendments(tuple(changes), tuple(surplus)), _left_out(every, formats))


def _left_out(every: Sequence[Entry], formats: Mapping[str, object]) -> tuple[Diagnostic, ...]:
    keys = {one.key: one.formats for one in every if not any(form in formats for form in one.formats)}
    if not keys:
        return ()
    wanted = listed(form for forms in keys.values() for form in forms)
    text = f"not applied, since they are for formats that are not written ({wanted}): {listed(keys)}"
    return (
        Diagnostic("I-ELEMENT", text, "elements", "choose the format in export, or change their `formats`"),
    )


class _FormatWork:
    """The entries of one format, and its files."""

    def __init__(
        self, form: str, paths: Sequence[str], files: Mapping[str, bytes], own: Sequence[Entry]
    ) -> None:
        self.form, self.entries, self.problems = form, own, list[Diagnostic]()
        self._paths, self._files = paths, files
        self.changes: list[Amendment] = []
        self.surplus: list[Surplus] = []
        self.documents: Documents

    def apply(self) -> bool:
        """Applies all entries; whether there was no problem."""
        self.documents = self._read()
        for entry in self.entries:
            try:
                self.changes.append(entry.apply(self.documents))
            except Refused as refused:
                self.problems.append(refused.diagnostic)
        if not self.problems:
            self.surplus = self._of_mjcf() if self.form == "mjcf" else self._of_urdf()
        return not self.problems

    def _read(self) -> Documents:
        return Documents(self.form, self._paths, self._files)

    def _of_mjcf(self) -> list[Surplus]:
        meshes = {path: data for path, data in self._files.items() if path.startswith("assets/")}
        try:
            return fit(self.documents, self._read(), self.changes, meshes)
        except Refused as refused:
            self.problems.append(refused.diagnostic)
        except NotCompiled as error:
            key = self._culprit(meshes)
            if key:
                message = " ".join(str(error).split())
                text = f"MuJoCo refuses it: {message}"
                self.problems.append(Diagnostic("E-ELEMENT", text, key, likely(message)))
        return []

    def _culprit(self, meshes: Mapping[str, bytes]) -> str:
        """The key of the last entry without which the file compiles; "" where it never did."""
        for count in reversed(range(len(self.entries))):
            documents = self._read()
            for entry in self.entries[:count]:
                entry.apply(documents)
            try:
                compiled(documents, "scene", meshes)
            except NotCompiled:
                continue
            return self.entries[count].key
        return ""

    def _of_urdf(self) -> list[Surplus]:
        root, before = self.documents.every[0].root, self._read().every[0].root
        path = self.documents.every[0].path
        return [Surplus(path, dofs=_moving(root) - _moving(before))]


_WIDTHS = {"revolute": 1, "continuous": 1, "prismatic": 1, "planar": 3, "floating": 6}
"""Degrees of freedom by the type of a URDF's joint."""


def _moving(root: Element) -> int:
    return sum(_WIDTHS.get(str(one.get("type")), 0) for one in root.iterchildren("joint"))
