"""What pyproject.toml requires: of everything a floor and the next major version, and hints that agree."""

import re
import runpy

import pytest

from linkwright.stages.robot.system.install import OPTIONAL, install
from tests.support.long_tests import all_tests, long_tests
from tests.support.places import PROJECT, ROOMS

FLOORS = runpy.run_path(str(PROJECT / ".ci" / "floors.py"))
REQUIREMENTS = sorted(set(FLOORS["requirements"]()))
BOUNDED = re.compile(r"[\w.-]+>=(\d+)\.([\d.]+),<(\d+)(?:\.(\d+))?(?:; sys_platform [!=]= 'win32')?")
PAIRED = ("hydra-core", "omegaconf")
"""Two of their minor versions belong together, so that each next one is a step of its own."""


def name_of(requirement):
    return re.split(r"[^\w.-]", requirement)[0]


@pytest.mark.parametrize("requirement", REQUIREMENTS)
def test_each_has_a_floor_and_ends_before_a_major_version(requirement):
    bounds = BOUNDED.fullmatch(requirement)
    assert bounds
    floor, _, major, minor = bounds.groups()
    assert int(major) > int(floor) or minor
    assert (minor is not None) == (name_of(requirement) in PAIRED)
    assert f"{name_of(requirement)}>={FLOORS['floors']()[name_of(requirement)]}," in requirement, "CI's floor"


def test_hints_and_shown_commands_install_what_the_extras_do():
    wanted = {
        name_of(requirement): requirement for requirement in REQUIREMENTS if name_of(requirement) in OPTIONAL
    }
    assert {name: name + bound for name, bound in OPTIONAL.items()} == wanted
    assert install("xacro") == "pip install 'xacro>=2.1,<3'"
    shown = re.findall(r"pip install (?:'[^']+'\s?)+", "".join(text.read_text() for text in texts("conf")))
    plug_ins = [("hydra-joblib-launcher", "joblib"), ("hydra-submitit-launcher", "submitit")]
    plug_ins.append(("hydra-ray-launcher", "ray"))
    assert {text.strip() for text in shown} == {install(*packages) for packages in plug_ins}


def test_texts_ask_for_no_extra_by_our_name():
    """pip finds `linkwright[urdf]` on an index alone; a wheel or a checkout in hand is none."""
    ours = [PROJECT / "README.md", *(text for room in ROOMS for text in texts(room))]
    assert [our for our in ours if "linkwright[" in our.read_text()] == []


def texts(room):
    return [path for path in (PROJECT / room).rglob("*") if path.suffix in (".py", ".yaml", ".md")]


def test_no_test_fails_where_pinocchio_is_not_installed():
    """Not every Python has a wheel of it: `tests.support.pinocchio` skips tests there."""
    apart = {"benchmarks", "engines"}
    files = [path for path in (PROJECT / "tests").rglob("*.py") if not apart & {*path.parts}]
    imports = re.compile(r"^\s*(import|from) pinocchio\b", re.MULTILINE)
    assert [file.name for file in files if imports.search(file.read_text())] == []


@pytest.mark.parametrize("script", ["run", "engines"])
def test_every_test_that_a_script_of_ci_names_exists(script):
    """A folder or module that was renamed ends the script an hour later, with no test run."""
    named = set(re.findall(r"\btests/[\w/]+(?:\.py)?(?![\w$*])", (PROJECT / ".ci" / script).read_text()))
    assert [path for path in sorted(named) if not (PROJECT / path).exists()] == []


def test_every_long_test_that_is_named_exists():
    """A test that was renamed is no longer kept out of the quick loop."""
    assert long_tests() - all_tests() == set()
