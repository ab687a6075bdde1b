"""The validate stage: MuJoCo reads what was written, and it must be the robot that CAD drew."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stages.robot.check import Check
    from stages.robot.model import Robot
    from stages.validate.keys import ValidateKeys

VERSION = 4


def validate(folder: Path, robot: "Robot", keys: "ValidateKeys") -> "tuple[Check, ...]":
    """Checks of every model file in `folder`; a check that fails does not stop the others."""
    names = (f"{robot.name}.xml", "scene.xml", f"{robot.name}.urdf")
    files = [folder / name for name in names if (folder / name).exists()]
    return tuple(check for file in files for check in _checks_of(file, robot, keys.validate.level != "quick"))


def _checks_of(file: Path, robot: "Robot", thorough: bool) -> "list[Check]":
    """The checks of one file; its model lives no longer, since a large one takes half a gigabyte."""
    from stages.robot.mujoco_warnings import listening
    from stages.validate.checks.parts import check_model
    from stages.validate.engines.mujoco_engine import load, quiet

    loaded = load(file)
    if not thorough or loaded.model is None:
        return [loaded.check]
    with listening() as heard:
        found = check_model(file, loaded.model, robot)
    return [loaded.check, *found, quiet(f"{file.name}: runs", heard)]
