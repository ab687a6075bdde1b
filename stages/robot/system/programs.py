"""Finds programs of the system, ignoring the working folder."""

import os
import shutil
from collections.abc import Mapping
from pathlib import Path


def program(name: str, environ: Mapping[str, str] = os.environ) -> str | None:
    """Returns the absolute path of a program on PATH; None if it is not there.

    Relative entries of PATH, which start from the working folder, are left out; so is the working folder
    itself, where Windows looks first.
    """
    places = [place for place in environ.get("PATH", "").split(os.pathsep) if Path(place).is_absolute()]
    path = shutil.which(name, path=os.pathsep.join(places)) if places else None
    return path if path is not None and any(Path(path).parent == Path(place) for place in places) else None
