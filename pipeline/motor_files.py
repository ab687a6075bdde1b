"""Where the files of the motor library are. No heavy imports: tab completion reads their names too.

Ours are in `conf/actuators/motors`, the user's own in `motors/` beside `robot/`. They are data, and no
options of a group.
"""

import re
from collections.abc import Iterable
from pathlib import Path

from linkwright.pipeline import observed

FOLDER = "motors"

OURS = Path(__file__).resolve().parents[1] / "conf" / "actuators" / FOLDER

_NAME = re.compile(r"\w[\w.+-]*")


def library(own: Iterable[Path] = ()) -> dict[str, Path]:
    """Name → file of every motor, sorted; one of the user's own stands in place of ours. `own`: the folders
    that hold `robot/`."""
    found: dict[str, Path] = {}
    for folder in (OURS, *(one / FOLDER for one in own)):
        files = (folder / name for name in observed.yaml_files(folder))
        found |= {file.stem: file for file in files if _NAME.fullmatch(file.stem)}
    return dict(sorted(found.items()))


def is_motor(file: Path, group: Path) -> bool:
    """Whether a file below the folder of a group is one of a motor."""
    return group.name == "actuators" and file.relative_to(group).parts[0] == FOLDER
