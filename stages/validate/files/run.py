"""The run of the checks of files: of each model in a folder, and of what lies beside them."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.validate.files import TEXT_CHECKS
from linkwright.stages.validate.files.unused import unused_assets
from linkwright.stages.validate.reading.documents import ModelDocument, broken_text, read, sentence

XML = "C-XML"


_XML = (".srdf",)
"""Endings of files that are XML, and that nothing else reads back."""


def check_folder(
    folder: Path,
    models: Iterable[str],
    others: Iterable[str] = (),
    packages: tuple[str, ...] | None = None,
) -> Iterator[Check]:
    """The checks of the model files of these names in a build's folder; that its other files are XML, where
    they shall be; and that every asset is used. `packages`: those that the folder is, None where nothing is
    known of that."""
    documents = []
    for name in models:
        if (folder / name).exists():
            document, check = opened(folder / name)
            yield check
            if document is not None:
                document = replace(document, packages=packages)
                documents.append(document)
                yield from check_document(document)
    present = [name for name in others if (folder / name).exists()]
    for name in present:
        if name.endswith(_XML):
            # Nothing of it is kept: of a large robot it has a line for each pair of links.
            broken = broken_text(folder / name)
            yield _well_formed(folder / name, [] if broken is None else [broken])
    yield from unused_assets(folder, documents, present)


def opened(path: Path) -> tuple[ModelDocument | None, Check]:
    """The document in a file, None where it is no XML, and the check that it is, whole, and of the root that
    its name promises."""
    broken = broken_text(path)
    found = [] if broken is None else [broken]
    document = None if broken else read(path)
    if document is not None:
        found += document.broken
        if path.suffix in (".urdf", ".xml") and document.language is None:
            message = f"is no model: expected {'<robot>' if path.suffix == '.urdf' else '<mujoco>'}"
            found.append(Finding(f"<{document.root.tag}>", "", message))
    return document, _well_formed(path, found)


def _well_formed(path: Path, found: Iterable[Finding]) -> Check:
    return result(path, "XML", XML, "error", found, "well formed, and all that it includes too")


def check_document(document: ModelDocument) -> Iterator[Check]:
    """The checks of one document, of a language that is known."""
    if document.language is None:
        return
    for row in TEXT_CHECKS:
        found = row.function(document)
        yield result(document.path, row.title, row.code, row.level(document), found, row.passed)


def result(
    path: Path, name: str, code: str, level: CheckLevel, found: Iterable[Finding], passed: str
) -> Check:
    """The check that passes where nothing was found."""
    findings = tuple(found)
    detail = passed if not findings else sentence(findings)
    return Check(
        f"{path.name}: {name}", not findings, detail, float(len(findings)), 0.0, code, level, findings
    )
