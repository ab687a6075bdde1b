"""Where things lie: the project, and the data beside it that a fresh clone does not have."""

import shutil
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
ROOMS = ("conf", "pipeline", "stages")
"""The folders of the product."""

MODELS = PROJECT / "tests" / "support" / "models"
"""Robots in files of their own."""

SHIPPED = ("pyproject.toml", "setup.py", "README.md", "LICENSE", *ROOMS)
"""What the package is made of."""

SHARED = PROJECT.parent / "shared"
"""Recorded replies and robots of others: where it is not there, the tests that read it are skipped."""


def copy_source(folder):
    """Copies into a folder what the package is made of."""
    folder.mkdir(parents=True)
    for name in SHIPPED:
        copy = shutil.copytree if (PROJECT / name).is_dir() else shutil.copy
        copy(PROJECT / name, folder / name)


def link_package(folder, tree=PROJECT):
    """Makes the package `linkwright` in a folder for Python's path, as the wheel lays it out, of links into a
    tree."""
    package = folder / "linkwright"
    package.mkdir(parents=True)
    places = [*(tree / "pipeline" / "package").glob("*.*"), *(tree / room for room in ROOMS)]
    for place in places:
        (package / place.name).symlink_to(place)
