"""The validate stage: MuJoCo reads what was written, and it must be the robot that CAD drew."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stages.robot.check import Check
    from stages.robot.model import Robot
    from stages.validate.keys import ValidateKeys

VERSION = 3


def validate(folder: Path, robot: "Robot", keys: "ValidateKeys") -> "tuple[Check, ...]":
    """Checks of every model file in `folder`; a check that fails does not stop the others."""
    from stages.robot.listening import listening
    from stages.validate.checks import check_model
    from stages.validate.engine import load, quiet

    thorough = keys.validate.level != "quick"
    checks: list[Check] = []
    for file in (f"{robot.name}.xml", "scene.xml", f"{robot.name}.urdf"):
        if (folder / file).exists():
            loaded = load(folder / file)
            checks.append(loaded.check)
            if thorough and loaded.model is not None:
                with listening() as heard:
                    checks.extend(check_model(file, loaded.model, robot))
                checks.append(quiet(f"{file}: runs", heard))
    return tuple(checks)
