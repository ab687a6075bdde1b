"""MuJoCo as an `Engine`: the compiled model of an MJCF or URDF, and every warning on the way."""

from contextlib import AbstractContextManager
from pathlib import Path

from linkwright.stages.mujoco.compile import NotCompiled, compiled_heard, spec_of
from linkwright.stages.mujoco.warnings import listening
from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import Loaded, without_warnings
from linkwright.stages.validate.reading.located import located

CODE = "C-COMPILE"


def files(robot: str) -> tuple[str, ...]:
    """The names of the files that it reads, for a robot of this name."""
    return f"{robot}.xml", "scene.xml", f"{robot}.urdf"


def warnings() -> AbstractContextManager[list[str]]:
    """Collects what MuJoCo warns of while models are used."""
    return listening()


def load(path: Path) -> Loaded:
    """Compiles one MJCF or URDF file from where it lies."""
    try:
        model, found = compiled_heard(lambda: spec_of(path), path.parent)
    except NotCompiled as error:
        message = str(error)
        where = located(path, message)
        return Loaded(None, Check(f"{path.name}: compiles", False, message, code=CODE, findings=where))
    return Loaded(model, without_warnings(f"{path.name}: compiles", found, CODE))
