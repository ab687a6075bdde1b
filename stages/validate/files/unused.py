"""Checks that every file in the folder of assets is named by a model."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.reading.asset_files import referenced_files
from linkwright.stages.validate.reading.documents import ModelDocument

CODE = "C-ASSET-UNUSED"

ASSETS_FOLDER = "assets"
"""The folder of assets of a build."""


def unused_assets(folder: Path, documents: Iterable[ModelDocument], extras: Iterable[str]) -> Iterator[Check]:
    """Checks that every file under `assets/` is named in a model, or in another file of the folder. Skips
    folders without assets, and folders without a file that names any, since a package may have other
    assets."""
    assets = folder / ASSETS_FOLDER
    if not assets.is_dir():
        return
    used = {
        file.path.resolve()
        for document in documents
        for file in referenced_files(document)
        if file.path is not None
    }
    paths_in_extras = [text for name in extras for text in _asset_paths(folder / name)]
    if not used and not paths_in_extras:
        return
    findings = []
    for path in sorted(file for file in assets.rglob("*") if file.is_file()):
        name = path.relative_to(folder).as_posix()
        if path.resolve() not in used and not any(text.endswith(name) for text in paths_in_extras):
            findings.append(Finding(name, "", "no model of this folder names it"))
    detail = "every file in assets is named by a model"
    if findings:
        names = ", ".join(finding.element for finding in findings[:3]) + (
            ", ..." if len(findings) > 3 else ""
        )
        detail = f"{len(findings)} that no model names: {names}"
    name = f"{ASSETS_FOLDER}: used"
    yield Check(name, not findings, detail, float(len(findings)), 0.0, CODE, "warning", tuple(findings))


def _asset_paths(path: Path) -> set[str]:
    """Returns the paths of assets in a text of any format."""
    return {path.decode("utf-8", "replace") for path in _PATH.findall(path.read_bytes())}


_PATH = re.compile(rb"assets/[^\"'<>@\s]+")
