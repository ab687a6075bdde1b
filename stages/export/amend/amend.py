"""Applies the keys `elements` and `attributes` to the files of the formats that they name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from linkwright.stages.export.amend.compiled import compiled, fit_keyframes, suggestion_for
from linkwright.stages.export.amend.documents import Documents, Refused
from linkwright.stages.export.amend.entries import Entry, entries
from linkwright.stages.formats.xml import Element
from linkwright.stages.mujoco.compile import NotCompiled
from linkwright.stages.robot.errors import Diagnostic, ExportError
from linkwright.stages.robot.model.amendments import UNCHANGED, Amendment, Amendments, Surplus
from linkwright.stages.robot.text.globs import name_list

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

_MESSAGE = "the robot's files cannot be amended"


@dataclass(frozen=True, slots=True)
class Amended:
    """The result of all amendments."""

    files: Mapping[str, bytes]
    """Path → content of the files that changed."""

    amendments: Amendments = UNCHANGED
    """The changes, for robot.json."""

    diagnostics: tuple[Diagnostic, ...] = ()


def amend(
    files: Mapping[str, bytes],
    formats: Mapping[str, Sequence[str]],
    keys: "ExportSections",
    texts: Mapping[str, str],
) -> Amended:
    """Returns the files that `elements` and `attributes` change.

    `files`: path → content of all files of the robot, with its meshes; `formats`: written format → the paths
    of its files; `texts`: entry of `elements` → the text of the file that it names.

    Raises ExportError with an E-ELEMENT for each entry whose target does not exist or whose names are taken,
    and if MuJoCo refuses the result. Reports entries for formats that are not written (I-ELEMENT).
    """
    try:
        all_entries = entries(keys, texts)
    except Refused as refused:
        raise ExportError(_MESSAGE, problems=[refused.diagnostic]) from None
    amended_files: dict[str, bytes] = {}
    changes: list[Amendment] = []
    surplus: list[Surplus] = []
    problems: list[Diagnostic] = []
    for form, paths in formats.items():
        format_work = _FormatWork(
            form, paths, files, [entry for entry in all_entries if form in entry.formats]
        )
        if format_work.entries and format_work.apply():
            amended_files |= format_work.documents.contents()
            changes += format_work.changes
            surplus += format_work.surplus
        problems += format_work.problems
    if problems:
        raise ExportError(_MESSAGE, problems=dict.fromkeys(problems))
    return Amended(
        amended_files, Amendments(tuple(changes), tuple(surplus)), _unused_entries(all_entries, formats)
    )


def _unused_entries(all_entries: Sequence[Entry], formats: Mapping[str, object]) -> tuple[Diagnostic, ...]:
    """Reports the entries for formats that are not written (I-ELEMENT)."""
    keys = {
        entry.key: entry.formats
        for entry in all_entries
        if not any(form in formats for form in entry.formats)
    }
    if not keys:
        return ()
    formats_named = name_list(form for forms in keys.values() for form in forms)
    text = (
        f"not applied, since they are for formats that are not written ({formats_named}): {name_list(keys)}"
    )
    return (
        Diagnostic("I-ELEMENT", text, "elements", "choose the format in export, or change their `formats`"),
    )


class _FormatWork:
    """Applies the entries for one format to its files."""

    def __init__(
        self, form: str, paths: Sequence[str], files: Mapping[str, bytes], entries: Sequence[Entry]
    ) -> None:
        self.form, self.entries, self.problems = form, entries, list[Diagnostic]()
        self._paths, self._files = paths, files
        self.changes: list[Amendment] = []
        self.surplus: list[Surplus] = []
        self.documents: Documents

    def apply(self) -> bool:
        """Applies all entries, and returns whether there was no problem."""
        self.documents = self._read()
        for entry in self.entries:
            try:
                self.changes.append(entry.apply(self.documents))
            except Refused as refused:
                self.problems.append(refused.diagnostic)
        if not self.problems:
            self.surplus = self._mjcf_surplus() if self.form == "mjcf" else self._urdf_surplus()
        return not self.problems

    def _read(self) -> Documents:
        return Documents(self.form, self._paths, self._files)

    def _mjcf_surplus(self) -> list[Surplus]:
        """Completes the keyframes, and returns the surplus of each file; [] after a problem."""
        meshes = {path: data for path, data in self._files.items() if path.startswith("assets/")}
        try:
            return fit_keyframes(self.documents, self._read(), self.changes, meshes)
        except Refused as refused:
            self.problems.append(refused.diagnostic)
        except NotCompiled as error:
            key = self._culprit(meshes)
            if key:
                message = " ".join(str(error).split())
                text = f"MuJoCo refuses it: {message}"
                self.problems.append(Diagnostic("E-ELEMENT", text, key, suggestion_for(message)))
        return []

    def _culprit(self, meshes: Mapping[str, bytes]) -> str:
        """Returns the key of the entry that breaks the file: without it and those after it, the file
        compiles. Returns "" if the file does not compile without entries either."""
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

    def _urdf_surplus(self) -> list[Surplus]:
        """Returns the degrees of freedom that the URDF has beyond the robot."""
        root, old_root = self.documents.files[0].root, self._read().files[0].root
        path = self.documents.files[0].path
        return [Surplus(path, dofs=_count_dofs(root) - _count_dofs(old_root))]


_DOFS_OF_TYPE = {"revolute": 1, "continuous": 1, "prismatic": 1, "planar": 3, "floating": 6}
"""Degrees of freedom by the type of a URDF's joint."""


def _count_dofs(root: Element) -> int:
    return sum(_DOFS_OF_TYPE.get(str(joint.get("type")), 0) for joint in root.iterchildren("joint"))
