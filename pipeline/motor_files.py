"""Finds the files of the motor library. Imports nothing heavy, since tab completion reads their names too.

Linkwright's motors are in `conf/actuators/motors`, the user's in `motors/` beside `robot/`. Their files are
data, not options of a group.
"""

import re
from collections.abc import Iterable
from pathlib import Path

from linkwright.pipeline import observed

FOLDER = "motors"

OURS = Path(__file__).resolve().parents[1] / "conf" / "actuators" / FOLDER

_NAME_PATTERN = re.compile(r"\w[\w.+-]*")


def library(own_folders: Iterable[Path] = ()) -> dict[str, Path]:
    """Maps the name of each motor to its file, sorted. A motor of the user's own replaces Linkwright's.
    `own_folders`: the user's folders, which contain `robot/`."""
    files_by_name: dict[str, Path] = {}
    for folder in (OURS, *(parent / FOLDER for parent in own_folders)):
        files = (folder / name for name in observed.yaml_files(folder))
        files_by_name |= {file.stem: file for file in files if _NAME_PATTERN.fullmatch(file.stem)}
    return dict(sorted(files_by_name.items()))


def is_motor(file: Path, group: Path) -> bool:
    """Tells whether a file below the folder of a group describes a motor."""
    return group.name == "actuators" and file.relative_to(group).parts[0] == FOLDER
