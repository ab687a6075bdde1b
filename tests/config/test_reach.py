"""Defaults lists and options reach only files in the folders of the configuration."""

import pytest

from tests.support import users
from tests.support.users import GLOBAL, SAMPLE, put

SECRET = "swordfish"


@pytest.fixture
def here(tmp_path):
    """A working folder beside a folder that is not of the configuration."""
    put(tmp_path, {
        "work/robot/mine.yaml": SAMPLE,
        "work/mesh/fine.yaml": "tolerance: 0.001\n",
        "work/experiment/e.yaml": f"{GLOBAL}root: {{base: fixed}}\n",
        "outside/x.yaml": f"{GLOBAL}name: {SECRET}\n",
        "outside/mesh/x.yaml": "tolerance: 0.005\n",
    })  # fmt: skip
    return tmp_path / "work"


def plan(here, *arguments, dirs=()):
    return users.composed(here, *arguments, dirs=dirs, environ={}).plan


def refused(here, *arguments):
    message = users.refused(here, *arguments, environ={})
    assert SECRET not in message
    assert "0.005" not in message
    return message


ENTRIES = [
    "../../outside/x", "../robot/../../outside/x", "/robot/../../outside/x", "/../outside/x", "//etc/x",
    "//{outside}/x", "file://{outside}/x", "/file://{outside}/x", "pkg://os/x", "/robot/./../../outside/x",
    "..\\outside\\x", "override /mesh: ../../outside/mesh/x", "override /mesh: /../../outside/mesh/x",
    "override /mesh: //{outside}/mesh/x", "override /root: ../../outside/x",
    "override /mesh: file://{outside}/mesh/x", "/mesh@vars: ../../outside/mesh/x", "/../outside: x",
    "/../outside@vars: x", "optional /../outside@vars: x", "/mesh@vars: [../../outside/mesh/x]",
    "override /export: [../../outside/x]", "/mesh@vars: a/../../../outside/mesh/x",
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("file", "entry"), [
    *(("robot/mine.yaml", entry) for entry in ENTRIES),
    *(("experiment/e.yaml", entry) for entry in ENTRIES[::3]),
    *(("robot/deep/mine.yaml", entry) for entry in ENTRIES[1::3]),
])  # fmt: skip
def test_a_defaults_list_does_not_leave_the_folders(here, file, entry):
    lines = ["override /source: sample", entry.format(outside=here.parent / "outside")]
    # Overrides end a defaults list.
    lines = lines if entry.startswith("override") else lines[::-1]
    put(here, {file: f"{GLOBAL}defaults:\n" + "".join(f"  - {line}\n" for line in lines)})
    group, _, option = file.removesuffix(".yaml").partition("/")
    message = refused(here, *([] if group == "robot" else ["robot=mine"]), f"{group}={option}")
    assert "outside the folders of the configuration" in message
    assert "--config-dir" in message


@pytest.mark.parametrize("argument", [
    "mesh=../../outside/mesh/x", "experiment=../../outside/x", "mesh=../../../outside/mesh/x",
    "root=../outside/x", "mesh=a/../../../outside/mesh/x", "+experiment=../../outside/x",
    "export=[urdf,../../outside/x]",
])  # fmt: skip
def test_option_on_the_command_line_stays_in_the_folders(here, argument):
    message = refused(here, "robot=mine", argument)
    assert "outside the folders of the configuration" in message
    assert "--config-dir" in message


def test_robot_outside_is_a_path_that_the_user_types(here):
    assert "no such file" in refused(here, "robot=../../outside/x")
    assert plan(here, "robot=../outside/x", "source=sample").name == SECRET


@pytest.mark.parametrize(
    "entry", ["a/deep", "a/../a/deep", "/robot/a/deep", "/robot/../robot/a/deep", "../mesh/../robot/a/deep"]
)
def test_a_path_that_stays_inside_is_composed(here, entry):
    inside = f"{GLOBAL}defaults:\n  - {entry}\n  - override /mesh: ../robot/../mesh/fine\n"
    put(here, {"robot/a/deep.yaml": SAMPLE, "robot/all.yaml": inside})
    assert plan(here, "robot=all", "source=sample").mesh.tolerance == 0.001


def test_link_is_followed_but_not_above_its_target(here):
    (here / "robot" / "linked.yaml").symlink_to(here.parent / "outside" / "x.yaml")
    assert plan(here, "robot=linked", "source=sample").name == SECRET
    (here / "robot" / "sub").symlink_to(here.parent / "outside" / "mesh")
    put(here, {"robot/mine.yaml": f"{GLOBAL}defaults:\n  - sub/../x\n  - override /source: sample\n"})
    # Below `mesh`, where the link leads, `..` would be the folder outside.
    assert "E-OPTION" in refused(here, "robot=mine")


def test_folder_on_the_command_line_is_of_the_configuration(here):
    put(here, {"robot/mine.yaml": f"{SAMPLE}  - override /mesh: x\n"})
    assert plan(here, "robot=mine", dirs=[here.parent / "outside"]).mesh.tolerance == 0.005
