"""Defaults lists and options reach only files in the folders of the configuration."""

import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.stages.robot.errors import ConfigError

SAMPLE = "# @package _global_\ndefaults:\n  - override /source: sample\n"
SECRET = "swordfish"


@pytest.fixture
def here(tmp_path):
    """A working folder beside a file that is not of the configuration; `out` names it from `robot/`."""
    for path, text in {
        "work/robot/mine.yaml": SAMPLE,
        "work/mesh/fine.yaml": "tolerance: 0.001\n",
        "work/experiment/e.yaml": "# @package _global_\nroot: {base: fixed}\n",
        "outside/x.yaml": f"# @package _global_\nname: {SECRET}\n",
        "outside/mesh/x.yaml": "tolerance: 0.005\n",
    }.items():
        file = tmp_path / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return tmp_path / "work"


def write(here, path, text):
    file = here / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)


def refused(here, *arguments):
    with pytest.raises(ConfigError) as caught:
        compose_plan(arguments, (), here, environ={})
    message = str(caught.value)
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
@pytest.mark.parametrize(
    ("file", "entry"),
    [
        *(("robot/mine.yaml", entry) for entry in ENTRIES),
        *(("experiment/e.yaml", entry) for entry in ENTRIES[::3]),
        *(("robot/deep/mine.yaml", entry) for entry in ENTRIES[1::3]),
    ],
)
def test_a_defaults_list_does_not_leave_the_folders(here, file, entry):
    text = entry.format(outside=here.parent / "outside")
    if text.startswith("override"):
        lines = f"defaults:\n  - override /source: sample\n  - {text}\n"
    else:
        lines = f"defaults:\n  - {text}\n  - override /source: sample\n"
    write(here, file, f"# @package _global_\n{lines}")
    group, _, option = file.removesuffix(".yaml").partition("/")
    robot = [] if group == "robot" else ["robot=mine"]
    message = refused(here, *robot, f"{group}={option}")
    assert "outside the folders of the configuration" in message
    assert "--config-dir" in message


@pytest.mark.parametrize(
    "argument",
    [
        "mesh=../../outside/mesh/x", "experiment=../../outside/x", "mesh=../../../outside/mesh/x",
        "root=../outside/x", "mesh=a/../../../outside/mesh/x", "+experiment=../../outside/x",
        "export=[urdf,../../outside/x]",
    ],
)  # fmt: skip
def test_an_option_on_the_command_line_does_not_leave_the_folders(here, argument):
    message = refused(here, "robot=mine", argument)
    assert "outside the folders of the configuration" in message
    assert "--config-dir" in message


def test_a_robot_is_no_option_outside_but_a_path_that_the_user_types(here):
    assert "no such file" in refused(here, "robot=../../outside/x")
    assert compose_plan(["robot=../outside/x", "source=sample"], (), here, environ={}).plan.name == SECRET


def test_what_stays_inside_is_composed(here):
    write(here, "robot/a/deep.yaml", SAMPLE)
    inside = "# @package _global_\ndefaults:\n  - {}\n  - override /mesh: ../robot/../mesh/fine\n"
    for entry in (
        "a/deep",
        "a/../a/deep",
        "/robot/a/deep",
        "/robot/../robot/a/deep",
        "../mesh/../robot/a/deep",
    ):
        write(here, "robot/all.yaml", inside.format(entry))
        plan = compose_plan(["robot=all", "source=sample"], (), here, environ={}).plan
        assert plan.mesh.tolerance == 0.001


def test_a_link_in_a_folder_is_followed_but_not_what_is_above_its_target(here):
    (here / "robot" / "linked.yaml").symlink_to(here.parent / "outside" / "x.yaml")
    assert compose_plan(["robot=linked", "source=sample"], (), here, environ={}).plan.name == SECRET
    (here / "robot" / "sub").symlink_to(here.parent / "outside" / "mesh")
    write(
        here,
        "robot/mine.yaml",
        "# @package _global_\ndefaults:\n  - sub/../x\n  - override /source: sample\n",
    )
    # Below `mesh`, where the link leads, `..` would be the folder outside.
    assert "E-OPTION" in refused(here, "robot=mine")


def test_a_folder_named_on_the_command_line_is_a_folder_of_the_configuration(here):
    write(here, "robot/mine.yaml", SAMPLE + "  - override /mesh: x\n")
    plan = compose_plan(["robot=mine"], [here.parent / "outside"], here, environ={}).plan
    assert plan.mesh.tolerance == 0.005
