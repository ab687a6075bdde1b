"""The package `linkwright` as the wheel ships it, whatever is installed here."""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

from tests.support.places import PROJECT

WHEEL = tomllib.loads((PROJECT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]


def shipped(folder: Path) -> Path:
    """Puts the folder of `linkwright` below `folder`, as the build backend does; the folder."""
    for source, place in WHEEL["force-include"].items():
        shutil.copytree(PROJECT / source, folder / place)
    return folder


def python(
    package: Path, *arguments: str, cwd: Path, before: tuple[Path, ...] = ()
) -> subprocess.CompletedProcess[str]:
    """Runs Python in `cwd` with the package that is below `package`, and folders `before` it on the path."""
    places = os.pathsep.join(map(str, (*before, package, PROJECT)))
    environ = {"PYTHONPATH": places, "LINKWRIGHT_CACHE": str(package / "cache")}
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=cwd, env={**os.environ, **environ}, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
