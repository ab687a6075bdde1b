"""Compares a build's packages with those that `stages.export` makes from the build's files."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from linkwright.stages.export import VERSION
from linkwright.stages.export.rewrite_packages import package_again
from linkwright.stages.formats.described import Truth
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.system.regular_files import is_file
from linkwright.stages.validate.reading.guarded import guarded
from linkwright.stages.validate.rewritten.check import rewritten

CODES = {"ros2": "C-ROS2", "python": "C-PYTHON"}
"""Format of a package → the code of its check."""

TRUTH = "robot.json"


def check_packages(folder: Path, truth: Truth) -> Iterator[Check]:
    """Checks that each package is as a build would write it, and that its copies equal the build's files."""
    if truth.packages:
        files = _package_sources(folder, truth)
        for name in truth.packages:
            checks = guarded(f"{name}: package", partial(_check_package, folder, truth, name, files))
            yield from (replace(check, code=CODES[name]) for check in checks)


def _check_package(folder: Path, truth: Truth, name: str, files: dict[str, bytes]) -> Iterator[Check]:
    expected = package_again(truth, name, files)
    place = truth.packages[name].folder
    copies = {path: data for path, data in expected.items() if place and path.startswith(f"{place}/")}
    other_files = {path: data for path, data in expected.items() if path not in copies}
    current = truth.packages[name].writer == VERSION
    urdf = f"{truth.written.robot.name}.urdf"
    changes = () if urdf in files else truth.written.amendments.changes_of(urdf)
    yield from rewritten(folder, other_files, copies=False, current=current, changes=changes)
    yield from rewritten(folder, copies, copies=True, current=current)


def _package_sources(folder: Path, truth: Truth) -> dict[str, bytes]:
    """Returns the files that packages are made of, by path. Files that a build leaves only in a package are
    read there."""
    package_prefixes = tuple(f"{name}/" for name in truth.packages)
    paths = {path: folder / path for path in (TRUTH, *truth.files) if not path.startswith(package_prefixes)}
    if "python" in truth.packages:
        copies = folder / truth.packages["python"].folder
        robot = truth.written.robot.name
        for path in (f"{robot}.urdf", f"{robot}.srdf", f"{robot}.xml", "scene.xml"):
            if path not in paths and is_file(copies / path):
                paths[path] = copies / path
    return {path: place.read_bytes() for path, place in paths.items() if is_file(place)}
