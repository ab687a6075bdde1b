"""`linkwright view NAME`: the robot of a build in MuJoCo's own viewer."""

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

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
chooses a link, Ctrl and the mouse pull at it, the space key pauses. A Mac runs
it by MuJoCo's `mjpython`.

exit status: 0 the viewer was closed; 1 there is no display, or no scene; 2
wrong usage
"""

SCENE = "scene.xml"
_USAGE = "linkwright view NAME; linkwright view --help shows more"
_ON_MAC = "import sys; from linkwright.stages.mujoco.viewer import show; show(sys.argv[1])"


def run(arguments: Sequence[str], environ: Mapping[str, str] = os.environ, system: str = sys.platform) -> int:
    """Opens the viewer, and returns the exit status when it is closed.

    ConfigError for wrong usage or an unknown build; OutputError where there is no scene or no display.
    """
    if len(arguments) != 1 or arguments[0].startswith("-"):
        msg = f"expected one build, got {' '.join(arguments) or 'nothing'}"
        raise ConfigError(msg, "view", _USAGE)
    folder = find(arguments[0], "view")
    scene = folder / SCENE
    if not scene.is_file():
        raise OutputError(
            f"the build has no {SCENE}", str(folder), "build it with export=mjcf or [urdf,mjcf]"
        )
    page = f"open {folder / 'report.html'} in a browser: it has the robot's figures"
    if system.startswith("linux") and not (environ.get("DISPLAY") or environ.get("WAYLAND_DISPLAY")):
        raise OutputError("there is no display (DISPLAY and WAYLAND_DISPLAY are not set)", "view", page)
    if system == "darwin":
        return _by_mjpython(scene, page)
    # Late: it imports MuJoCo, and wrong usage is told at once.
    from linkwright.stages.mujoco.viewer import NoViewer, NoWindow, show

    try:
        show(str(scene))
    except NoViewer as error:
        msg = f"MuJoCo's viewer is not installed ({error})"
        raise OutputError(msg, "view", f"pip install mujoco; or {page}") from None
    except NoWindow as error:
        raise OutputError(f"MuJoCo's viewer cannot open a window: {error}", "view", page) from None
    return 0


def _by_mjpython(scene: Path, otherwise: str) -> int:
    """A Mac draws windows from the main thread alone, which MuJoCo's own interpreter sees to."""
    mjpython = Path(sys.executable).with_name("mjpython")
    found = str(mjpython) if mjpython.exists() else program("mjpython")
    if found is None:
        msg = "there is no mjpython, by which MuJoCo's viewer runs on a Mac"
        raise OutputError(msg, "view", f"pip install mujoco; or {otherwise}")
    return subprocess.run([found, "-c", _ON_MAC, str(scene)], check=False).returncode and 1
