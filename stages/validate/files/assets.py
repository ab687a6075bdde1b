"""Checks that every file that a model refers to exists and is complete."""

from collections.abc import Iterator
from pathlib import Path

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.system.regular_files import is_file
from linkwright.stages.validate.files.damage import damage
from linkwright.stages.validate.reading.asset_files import referenced_files
from linkwright.stages.validate.reading.documents import ModelDocument


def findings(document: ModelDocument) -> Iterator[Finding]:
    """Yields a finding for each missing, empty or truncated file."""
    damage_by_path: dict[Path, str] = {}
    for file in referenced_files(document):
        if file.element in document.included or file.path is None:
            continue
        if not is_file(file.path):
            yield document.finding(file.element, file.attribute, f'"{file.text}" does not exist')
            continue
        if file.path not in damage_by_path:
            damage_by_path[file.path] = damage(file.path)
        if damage_by_path[file.path]:
            yield document.finding(file.element, file.attribute, f'"{file.text}" {damage_by_path[file.path]}')
