"""Runs the checks of files: of each model in a folder, and of the folder's other files."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.validate.files import TEXT_CHECKS
from linkwright.stages.validate.files.unused import unused_assets
from linkwright.stages.validate.reading.documents import ModelDocument, broken_text, read, sentence

XML_CODE = "C-XML"

_XML_ENDINGS = (".srdf",)
"""Extensions of XML files that no other check reads."""


def check_folder(
    folder: Path,
    models: Iterable[str],
    extras: Iterable[str] = (),
    packages: tuple[str, ...] | None = None,
) -> Iterator[Check]:
    """Checks a build's folder: its `models`, that XML files among the `extras` are well formed, and that
    every asset is used. `packages`: the names of the packages whose root is this folder; None if unknown."""
    documents = []
    for name in models:
        if (folder / name).exists():
            document, check = read_checked(folder / name)
            yield check
            if document is not None:
                document = replace(document, packages=packages)
                documents.append(document)
                yield from check_document(document)
    present = [name for name in extras if (folder / name).exists()]
    for name in present:
        if name.endswith(_XML_ENDINGS):
            # The document is not kept: for a large robot it has a line for each pair of links.
            broken = broken_text(folder / name)
            yield _well_formed(folder / name, [] if broken is None else [broken])
    yield from unused_assets(folder, documents, present)


def read_checked(path: Path) -> tuple[ModelDocument | None, Check]:
    """Returns the document in a file (None if it is not XML), and the check that the file is well-formed XML
    with the root that its extension promises."""
    broken = broken_text(path)
    findings = [] if broken is None else [broken]
    document = None if broken else read(path)
    if document is not None:
        findings += document.broken
        if path.suffix in (".urdf", ".xml") and document.language is None:
            message = f"is not a model: expected {'<robot>' if path.suffix == '.urdf' else '<mujoco>'}"
            findings.append(Finding(f"<{document.root.tag}>", "", message))
    return document, _well_formed(path, findings)


def _well_formed(path: Path, findings: Iterable[Finding]) -> Check:
    return check_of(
        path, "XML", XML_CODE, "error", findings, "well formed, as is every file that it includes"
    )


def check_document(document: ModelDocument) -> Iterator[Check]:
    """Checks a document in a known language."""
    if document.language is None:
        return
    for row in TEXT_CHECKS:
        findings = row.function(document)
        yield check_of(document.path, row.title, row.code, row.level(document), findings, row.passed)


def check_of(
    path: Path, name: str, code: str, level: CheckLevel, findings: Iterable[Finding], passed: str
) -> Check:
    """Returns a check that passes if there are no findings. `passed`: its detail if it passes."""
    all_findings = tuple(findings)
    detail = sentence(all_findings) if all_findings else passed
    return Check(
        f"{path.name}: {name}",
        not all_findings,
        detail,
        float(len(all_findings)),
        0.0,
        code,
        level,
        all_findings,
    )
