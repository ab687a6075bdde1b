"""`linkwright view NAME`: opens the robot of a build in MuJoCo's own viewer."""

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from linkwright.pipeline.doctor.places import has_display
from linkwright.pipeline.errors import ConfigError, OutputError
from linkwright.pipeline.output.builds import find
from linkwright.stages.robot.system.programs import program

HELP = """\
linkwright view: open the robot of a build in MuJoCo's own viewer, simulating,
from its keyframe `home`.

usage: linkwright view NAME

  linkwright view sample            the build in outputs/sample
  linkwright view builds/arm        the build in that folder

NAME is the robot's name, or the output folder of its build. A double click
chooses a link, Ctrl and the mouse pull at it, the space key pauses. On a Mac
the viewer runs in MuJoCo's `mjpython`.
"""

SCENE = "scene.xml"
_USAGE = "linkwright view NAME; linkwright view --help shows more"
_MJPYTHON_CODE = "import sys; from linkwright.stages.mujoco.viewer import show; show(sys.argv[1])"
"""The code that `mjpython` runs; its argument is the path of the scene."""


def run(arguments: Sequence[str], environ: Mapping[str, str] = os.environ, system: str = sys.platform) -> int:
    """Opens the viewer; returns the exit status once the user closes it.

    Raises ConfigError for wrong usage or an unknown build; raises OutputError if there is no scene or no
    display.
    """
    if len(arguments) != 1 or arguments[0].startswith("-"):
        msg = f"expected one build, got {' '.join(arguments) or 'nothing'}"
        raise ConfigError(msg, "view", _USAGE)
    scene = _scene(arguments[0])
    report_hint = f"open {scene.with_name('report.html')} in a browser: it has the robot's figures"
    if not has_display(environ, system):
        raise OutputError(
            "there is no display (DISPLAY and WAYLAND_DISPLAY are not set)", "view", report_hint
        )
    if system == "darwin":
        return _run_mjpython(scene, report_hint)
    # Imported late, since it loads MuJoCo, and wrong usage is reported at once.
    from linkwright.stages.mujoco.viewer import NoViewer, NoWindow, show

    try:
        show(str(scene))
    except NoViewer as error:
        msg = f"MuJoCo's viewer is not installed ({error})"
        raise OutputError(msg, "view", f"pip install mujoco; or {report_hint}") from None
    except NoWindow as error:
        raise OutputError(f"MuJoCo's viewer cannot open a window: {error}", "view", report_hint) from None
    return 0


def _scene(name: str) -> Path:
    """Returns the path of the scene of a build; raises OutputError if the build has none."""
    folder = find(name, "view")
    scene = folder / SCENE
    if not scene.is_file():
        raise OutputError(
            f"the build has no {SCENE}", str(folder), "build it with export=mjcf or [urdf,mjcf]"
        )
    return scene


def _run_mjpython(scene: Path, report_hint: str) -> int:
    """Shows the scene on a Mac, where windows must be drawn in the main thread, as `mjpython` does.
    `report_hint`: a hint at what to do without it."""
    mjpython = Path(sys.executable).with_name("mjpython")
    interpreter = str(mjpython) if mjpython.exists() else program("mjpython")
    if interpreter is None:
        msg = "mjpython is missing, which MuJoCo's viewer needs on a Mac"
        raise OutputError(msg, "view", f"pip install mujoco; or {report_hint}")
    completed = subprocess.run([interpreter, "-c", _MJPYTHON_CODE, str(scene)], check=False)
    return 1 if completed.returncode else 0
