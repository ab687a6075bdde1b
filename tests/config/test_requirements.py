"""What pyproject.toml requires: of everything a floor and the next major version, and hints that agree."""

import re
import runpy
from pathlib import Path

import pytest

from linkwright.stages.robot.system.install import OPTIONAL, install
from tests.support.places import PROJECT, ROOMS

FLOORS = runpy.run_path(str(PROJECT / ".ci" / "floors.py"))
REQUIREMENTS = sorted(set(FLOORS["requirements"]()))
BOUNDED = re.compile(r"[\w.-]+>=(\d+)\.([\d.]+),<(\d+)(?:\.(\d+))?(?:; sys_platform [!=]= 'win32')?")
PAIRED = ("hydra-core", "omegaconf")
"""Two of their minor versions belong together, so that each next one is a step of its own."""


def name_of(requirement: str) -> str:
    return re.split(r"[^\w.-]", requirement)[0]


@pytest.mark.parametrize("requirement", REQUIREMENTS)
def test_each_has_a_floor_and_ends_before_a_major_version(requirement: str) -> None:
    found = BOUNDED.fullmatch(requirement)
    assert found
    floor, _, major, minor = found.groups()
    assert int(major) > int(floor) or minor
    assert (minor is not None) == (name_of(requirement) in PAIRED)


def test_ci_installs_the_floor_of_each() -> None:
    floors = FLOORS["floors"]()
    assert set(floors) == {name_of(one) for one in REQUIREMENTS}
    assert all(f"{name}>={floor}," in " ".join(REQUIREMENTS) for name, floor in floors.items())


def test_hints_install_what_the_extras_do() -> None:
    wanted = {name_of(one): one for one in REQUIREMENTS if name_of(one) in OPTIONAL}
    assert {name: name + bound for name, bound in OPTIONAL.items()} == wanted
    assert install("xacro") == "pip install 'xacro>=2.1,<3'"


def test_nothing_that_a_user_reads_asks_for_an_extra_by_our_name() -> None:
    """pip finds `linkwright[urdf]` on an index alone; a wheel or a checkout in hand is none."""
    ours = [PROJECT / "README.md", *(one for room in ROOMS for one in texts(room))]
    assert [one for one in ours if "linkwright[" in one.read_text()] == []


def texts(room: str) -> list[Path]:
    return [one for one in (PROJECT / room).rglob("*") if one.suffix in (".py", ".yaml", ".md")]


def test_shown_commands_install_what_the_extras_do() -> None:
    shown = re.findall(r"pip install (?:'[^']+'\s?)+", "".join(one.read_text() for one in texts("conf")))
    assert [one.strip(" ") for one in shown] == [install("hydra-joblib-launcher", "joblib")]


def test_no_test_fails_where_pinocchio_is_not_installed() -> None:
    """Not every Python has a wheel of it: `tests.support.pinocchio` skips tests there."""
    files = [one for one in (PROJECT / "tests").rglob("*.py") if "benchmarks" not in one.parts]
    imports = re.compile(r"^\s*(import|from) pinocchio\b", re.MULTILINE)
    assert [one.name for one in files if imports.search(one.read_text())] == []
