"""Makes the checks of a folder or a file, against its robot.json or, without one, by themselves."""

from pathlib import Path
from typing import TYPE_CHECKING

from linkwright.pipeline.checking.packages import check_packages
from linkwright.pipeline.checking.verdict import Verdict, file_of
from linkwright.pipeline.errors import OutputError, reason
from linkwright.stages.formats.described import described
from linkwright.stages.formats.robot_json.codec import RobotJsonError
from linkwright.stages.robot.check import Check
from linkwright.stages.validate import validate
from linkwright.stages.validate.bare.run import check_bare
from linkwright.stages.validate.reading.present import present
from linkwright.stages.validate.section import ValidateSections

if TYPE_CHECKING:
    from linkwright.stages.formats.described import Truth

TRUTH = "robot.json"
ENDINGS = (".urdf", ".xml", ".srdf", ".sdf", ".usda")
ALONE = (".urdf", ".xml", ".mjcf")
"""Endings of the files of a build, and of those that are checked without a robot.json, too."""

_HINT = "give the output folder of a build, or a URDF or MJCF file"


def checked(asked: str, level: str) -> Verdict:
    """The verdict for a folder or file. OutputError where it cannot be read."""
    path = Path(asked)
    if not path.exists():
        raise OutputError("there is no such file or folder", asked, _HINT)
    if path.is_file() and path.name == TRUTH:
        path = path.parent
    if path.is_dir():
        return _folder(path, asked, level)
    if path.suffix not in (*ENDINGS, *ALONE):
        raise OutputError(f"its name ends in none of {', '.join(ENDINGS)}", asked, _HINT)
    truth = _truth(path.parent)
    if truth is not None and path.name in _files_of(truth.written.robot.name):
        every = _against(truth, path.parent, level)
        own = tuple(one for one in every if file_of(one)[0] == path.name)
        return Verdict(asked, str(path.parent), truth.written.robot.name, level, own)
    if path.suffix not in ALONE:
        raise OutputError(f"without {TRUTH} only URDF and MJCF are checked", asked, _HINT)
    return _bare(path, asked, level)


def _folder(folder: Path, asked: str, level: str) -> Verdict:
    truth = _truth(folder)
    if truth is not None:
        found = _against(truth, folder, level)
        if not found:
            msg = f"its {TRUTH} lists no files: that build ended before the export"
            raise OutputError(
                msg, asked, "build the robot without `until`, and check the folder of that build"
            )
        return Verdict(asked, str(folder), truth.written.robot.name, level, found)
    if not _models(folder):
        raise OutputError(f"the folder has no {TRUTH}, and no URDF or MJCF", asked, _HINT)
    return _bare(folder, asked, level)


def _files_of(robot: str) -> tuple[str, ...]:
    return (*(f"{robot}{ending}" for ending in ENDINGS), "scene.xml")


def _truth(folder: Path) -> "Truth | None":
    """What the robot.json of a folder says; None where it has none."""
    file = folder / TRUTH
    if not file.is_file():
        return None
    try:
        return described(file.read_bytes())
    except OSError as error:
        raise OutputError(f"it cannot be read: {reason(error)}", str(file)) from None
    except RobotJsonError as error:
        hint = "build again: it was changed, or an older Linkwright wrote it"
        raise OutputError(f"it cannot be compared with: {error}", str(file), hint) from None


def _against(truth: "Truth", folder: Path, level: str) -> tuple[Check, ...]:
    """The checks of a build, of its files as they are."""
    keys = ValidateSections.model_validate({"validate": {"level": level}})
    checks = validate(folder, truth.written, keys)
    return (*present(folder, truth.files), *checks, *check_packages(folder, truth))


def _bare(path: Path, asked: str, level: str) -> Verdict:
    """The checks of a file, or of all in a folder, that nothing is known of but what they say."""
    folder = path if path.is_dir() else path.parent
    note = f"there is no {TRUTH} of this robot beside it: nothing is compared with CAD"
    return Verdict(asked, str(folder), "", level, check_bare(path), (note,))


def _models(folder: Path) -> list[Path]:
    """The URDF and MJCF files of a folder."""
    return sorted(one for one in folder.iterdir() if one.suffix in ALONE and one.is_file())
