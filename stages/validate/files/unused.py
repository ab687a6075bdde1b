"""Every file in the folder of assets is one that a model names."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.reading.asset_files import named_files
from linkwright.stages.validate.reading.documents import ModelDocument

CODE = "C-ASSET-UNUSED"

ASSETS = "assets"
"""The folder of assets of a build."""


def unused_assets(folder: Path, documents: Iterable[ModelDocument], others: Iterable[str]) -> Iterator[Check]:
    """That every file under `assets/` is named in a model, or in another file of the folder. None where there
    is no such folder, or no file that names any: the models of a package have assets of their own."""
    assets = folder / ASSETS
    if not assets.is_dir():
        return
    used = {
        one.path.resolve() for document in documents for one in named_files(document) if one.path is not None
    }
    texts = [text for name in others for text in _texts(folder / name)]
    if not used and not texts:
        return
    found = []
    for path in sorted(one for one in assets.rglob("*") if one.is_file()):
        name = path.relative_to(folder).as_posix()
        if path.resolve() not in used and not any(text.endswith(name) for text in texts):
            found.append(Finding(name, "", "no model of this folder names it"))
    detail = "every file in assets is named by a model"
    if found:
        names = ", ".join(one.element for one in found[:3]) + (", ..." if len(found) > 3 else "")
        detail = f"{len(found)} that no model names: {names}"
    name = f"{ASSETS}: used"
    yield Check(name, not found, detail, float(len(found)), 0.0, CODE, "warning", tuple(found))


def _texts(path: Path) -> set[str]:
    """The paths of assets in a text of any format."""
    return {one.decode("utf-8", "replace") for one in _PATH.findall(path.read_bytes())}


_PATH = re.compile(rb"assets/[^\"'<>@\s]+")
