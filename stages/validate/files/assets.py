"""Every file that the model names is there, and whole."""

from collections.abc import Iterator
from pathlib import Path

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.system.regular_files import is_file
from linkwright.stages.validate.files.whole import damage
from linkwright.stages.validate.reading.asset_files import named_files
from linkwright.stages.validate.reading.documents import ModelDocument


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Missing files, and files that are empty or cut short."""
    damaged: dict[Path, str] = {}
    for one in named_files(document):
        if one.element in document.included or one.path is None:
            continue
        if not is_file(one.path):
            yield document.finding(one.element, one.attribute, f'"{one.text}" does not exist')
            continue
        if one.path not in damaged:
            damaged[one.path] = damage(one.path)
        if damaged[one.path]:
            yield document.finding(one.element, one.attribute, f'"{one.text}" {damaged[one.path]}')
