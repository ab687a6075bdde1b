"""Compiles an MJCF or URDF in MuJoCo, as an `Engine`, and collects every warning on the way."""

from contextlib import AbstractContextManager
from pathlib import Path

from linkwright.stages.mujoco.compile import NotCompiled, compiled_with_warnings, spec_of
from linkwright.stages.mujoco.warnings import collected_warnings
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import Loaded, without_warnings
from linkwright.stages.validate.reading.located import located

CODE = "C-COMPILE"


def files(robot: str) -> tuple[str, ...]:
    """Returns the names of the files that the engine reads, for a robot of this name."""
    return f"{robot}.xml", "scene.xml", f"{robot}.urdf"


def warnings() -> AbstractContextManager[list[str]]:
    """Collects MuJoCo's warnings while models are used."""
    return collected_warnings()


def load(path: Path) -> Loaded:
    """Compiles an MJCF or URDF file in its folder."""
    try:
        model, texts = compiled_with_warnings(lambda: spec_of(path), path.parent)
    except NotCompiled as error:
        message = str(error)
        findings = located(path, message)
        return Loaded(None, Check(f"{path.name}: compiles", False, message, code=CODE, findings=findings))
    return Loaded(model, without_warnings(f"{path.name}: compiles", texts, CODE))
