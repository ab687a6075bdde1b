"""Checks a folder or a file against its robot.json or, without robot.json, against itself."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from linkwright.pipeline.checking.packages import check_packages
from linkwright.pipeline.checking.verdict import Verdict, file_of
from linkwright.pipeline.errors import OutputError, reason
from linkwright.stages.formats.described import read_robot_json
from linkwright.stages.formats.robot_json.codec import RobotJsonError
from linkwright.stages.robot.check import Check
from linkwright.stages.targets.engines import ENGINES
from linkwright.stages.validate import validate
from linkwright.stages.validate.bare.run import check_bare
from linkwright.stages.validate.reading.file_existence import check_files_exist
from linkwright.stages.validate.section import ValidateSections
from linkwright.stages.validate.targets.judge import form_of, judge_file

if TYPE_CHECKING:
    from linkwright.stages.formats.described import Truth

TRUTH = "robot.json"
ENDINGS = (".urdf", ".xml", ".srdf", ".sdf", ".usda")
"""Endings of the files of a build."""

BARE_ENDINGS = (".urdf", ".xml", ".mjcf")
"""Endings of files that can be checked without a robot.json."""

TARGET_ENDINGS = (*BARE_ENDINGS, ".sdf")
"""Endings of files that can be judged for engines."""

_HINT = "give the output folder of a build, or a URDF or MJCF file"


def checked(user_path: str, level: str, targets: Sequence[str] = ()) -> Verdict:
    """Returns the verdict on a folder or file, or with `targets` on whether these engines (`mjx`,
    `mujoco:3.11`) can load it. Raises OutputError if it cannot be read."""
    path = Path(user_path)
    if not path.exists():
        raise OutputError("there is no such file or folder", user_path, _HINT)
    if path.is_file() and path.name == TRUTH:
        path = path.parent
    if targets:
        return _target_verdict(path, user_path, level, targets)
    if path.is_dir():
        return _folder_verdict(path, user_path, level)
    if path.suffix not in (*ENDINGS, *BARE_ENDINGS):
        raise OutputError(f"its name does not end in any of {', '.join(ENDINGS)}", user_path, _HINT)
    truth = _truth(path.parent)
    if truth is not None and path.name in _file_names(truth.written.robot.name):
        checks = _build_checks(truth, path.parent, level)
        own_checks = tuple(check for check in checks if file_of(check)[0] == path.name)
        return Verdict(user_path, str(path.parent), truth.written.robot.name, level, own_checks)
    if path.suffix not in BARE_ENDINGS:
        raise OutputError(f"without {TRUTH} only URDF and MJCF are checked", user_path, _HINT)
    return _bare_verdict(path, user_path, level)


def _folder_verdict(folder: Path, user_path: str, level: str) -> Verdict:
    """Checks a build's folder against its robot.json, or else the URDF and MJCF files in the folder."""
    truth = _truth(folder)
    if truth is not None:
        checks = _build_checks(truth, folder, level)
        if not checks:
            msg = f"its {TRUTH} lists no files: that build ended before the export"
            raise OutputError(
                msg, user_path, "build the robot without `until`, and check the folder of that build"
            )
        return Verdict(user_path, str(folder), truth.written.robot.name, level, checks)
    if not _model_files(folder):
        raise OutputError(f"the folder has no {TRUTH}, and no URDF or MJCF", user_path, _HINT)
    return _bare_verdict(folder, user_path, level)


def _file_names(robot: str) -> tuple[str, ...]:
    return (*(f"{robot}{ending}" for ending in ENDINGS), "scene.xml")


def _truth(folder: Path) -> "Truth | None":
    """Reads a folder's robot.json; returns None without the file."""
    file = folder / TRUTH
    if not file.is_file():
        return None
    try:
        return read_robot_json(file.read_bytes())
    except OSError as error:
        raise OutputError(f"it cannot be read: {reason(error)}", str(file)) from None
    except RobotJsonError as error:
        hint = "build again: it was changed, or an older Linkwright wrote it"
        raise OutputError(f"it cannot be compared with: {error}", str(file), hint) from None


def _build_checks(truth: "Truth", folder: Path, level: str) -> tuple[Check, ...]:
    """Checks the files of a build as they are now."""
    keys = ValidateSections.model_validate({"validate": {"level": level}})
    checks = validate(folder, truth.written, keys)
    return (*check_files_exist(folder, truth.files), *checks, *check_packages(folder, truth))


def _bare_verdict(path: Path, user_path: str, level: str) -> Verdict:
    """Checks a file, or all files of a folder, without a robot.json to compare with."""
    folder = path if path.is_dir() else path.parent
    note = f"there is no {TRUTH} of this robot beside it: nothing is compared with CAD"
    return Verdict(user_path, str(folder), "", level, check_bare(path), (note,))


def _target_verdict(path: Path, user_path: str, level: str, targets: Sequence[str]) -> Verdict:
    """Checks whether engines can load a file, or those models of a folder whose format they read. A folder's
    `scene.xml` is checked in place of the MJCF files that it includes."""
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    files = [file for file in files if file.suffix in TARGET_ENDINGS and file.is_file()]
    scenes = [file for file in files if file.name == "scene.xml"]
    files = [file for file in files if file.suffix != ".xml" or not scenes or file in scenes]
    if not files:
        raise OutputError("it is no URDF, MJCF or SDF, which --target judges", user_path, _HINT)
    checks: list[Check] = []
    for target in targets:
        name, _, version = target.partition(":")
        readable = [file for file in files if form_of(file) in ENGINES[name].reads]
        for file in readable or files:
            checks += judge_file(name, file, version or None)
    folder = path if path.is_dir() else path.parent
    return Verdict(user_path, str(folder), "", level, tuple(checks))


def _model_files(folder: Path) -> list[Path]:
    """Returns the URDF and MJCF files of a folder."""
    return sorted(path for path in folder.iterdir() if path.suffix in BARE_ENDINGS and path.is_file())
