"""Finds programs of the system, ignoring the working folder."""

import os
import shutil
from collections.abc import Mapping
from pathlib import Path


def program(name: str, environ: Mapping[str, str] = os.environ) -> str | None:
    """Returns the absolute path of a program in the folders of PATH; None if it is in none of them.

    Relative folders are ignored, since they start from the working folder, and so is the working folder
    itself, where Windows looks first.
    """
    folders = [folder for folder in environ.get("PATH", "").split(os.pathsep) if Path(folder).is_absolute()]
    path = shutil.which(name, path=os.pathsep.join(folders)) if folders else None
    is_in_folder = path is not None and any(Path(path).parent == Path(folder) for folder in folders)
    return path if is_in_folder else None
