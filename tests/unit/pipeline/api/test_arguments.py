"""The arguments of `linkwright.build`: what is a robot, what is trusted, what is wrong."""

from pathlib import Path

import numpy as np
import pytest

from linkwright.pipeline.api.arguments import plan_of
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.errors import ConfigError, render
from tests.support.users import write

ARM = """\
# @package _global_
defaults: [{override /source: sample}]
joints: {"*": {damping: 0.5}}
"""
DATA = {"defaults": [{"override /source": "sample"}], "joints": {"*": {"damping": 0.5}}}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(write(tmp_path, arm=ARM))
    return Path.cwd()


def plan(*what, trust=False, plugins=(), output=None, config_dirs=()):
    return plan_of(what, trust, plugins, output, config_dirs)


def refused(*what, **more):
    with pytest.raises(ConfigError) as caught:
        plan(*what, **more)
    return caught.value


@pytest.mark.parametrize("what", ["robot/arm.yaml", Path("robot/arm.yaml"), "robot=arm"])
def test_a_robot_is_the_same_by_its_name_or_its_path(what):
    expected = compose_plan(["robot=arm", "root=free"]).plan
    assert plan(what, "root=free") == expected
    assert expected.root.base == "free"


def test_a_robot_as_data_is_the_same_as_its_file():
    assert plan({**DATA, "name": "arm"}, "root=free") == plan("robot/arm.yaml", "root=free")


def test_nothing_is_the_sample():
    assert plan() == compose_plan([]).plan


@pytest.mark.parametrize(
    ("data", "name"),
    [
        ({"defaults": DATA["defaults"]}, "robot"),
        ({"source": {"kind": "sample"}}, "sample"),
        ({"source": {"kind": "sample"}, "name": "my_arm"}, "my_arm"),
        ({"source": {"kind": "mjcf", "path": Path("robots/so101.xml")}}, "so101"),
    ],
)
def test_a_robot_as_data_is_named_by_itself_or_by_its_source(folder, data, name):
    (folder / "robots").mkdir()
    (folder / "robots" / "so101.xml").write_text("<mujoco/>")
    assert plan(data).name == name


def test_data_keeps_its_types():
    """YAML would read some of these texts as numbers or truth values, and numpy's numbers not at all."""
    values = {
        "a": "1e5",
        "b": "on",
        "c": 1e-7,
        "d": None,
        "e": True,
        "f": (1, 2),
        "g": np.array([1.5]),
        "h": "é",
    }
    found = plan({**DATA, "vars": {**values, "i": np.float64(2.5), "j": Path("x")}}).vars
    assert found == {**values, "f": [1, 2], "g": [1.5], "i": 2.5, "j": "x"}
    assert type(found["a"]) is str


def test_data_may_interpolate():
    robot = {**DATA, "vars": {"d": 0.25}, "joints": {"*": {"damping": "${vars.d}"}}}
    assert plan(robot).joints["*"].damping == 0.25


def test_values_that_are_no_data_is_refused_with_its_key():
    error = refused({"joints": {"elbow": {"limits": [0, object()]}}})
    assert [problem.where for problem in error.problems] == ["joints.elbow.limits[1]"]
    assert "got object" in error.problems[0].message


@pytest.mark.parametrize(
    "defaults", ["x", [{"override /nope": "x"}], [{"override /root": "free"}, {"override /root": "fixed"}]]
)
def test_what_is_wrong_with_data_names_no_file(defaults):
    text = render(refused({"defaults": defaults}))
    assert "the robot's data" in text
    assert "tmp" not in text
    assert ".yaml" not in text


def test_one_robot_is_built_at_a_time():
    assert "got robot/arm.yaml and a mapping" in refused("robot/arm.yaml", DATA).message


@pytest.mark.parametrize("robot", [{"source": {"kind": "sample"}}, "robot/mine.yaml"])
def test_a_robot_and_the_choice_of_another_are_refused(robot):
    with pytest.raises(ConfigError, match=r"got (a mapping|robot/mine.yaml) and robot=sample") as caught:
        plan(robot, "robot=sample")
    assert "defaults: [/robot/sample]" in caught.value.hint


@pytest.mark.parametrize("how", ["file", "data"])
@pytest.mark.parametrize(("key", "way"), [("source.trust", "trust=True"), ("plugins", "plugins=[...]")])
def test_a_robot_cannot_make_itself_trusted(folder, how, key, way):
    source = {"kind": "urdf", "path": "arm.urdf"}
    robot = {"source": {**source, "trust": True}} if key == "source.trust" else {"source": source}
    robot |= {"plugins": ["os"]} if key == "plugins" else {}
    (folder / "arm.urdf").write_text("<robot/>")
    if how == "file":
        (folder / "robot" / "own.yaml").write_text(f"# @package _global_\n{robot}")
    found = {one.where: one for one in refused("robot/own.yaml" if how == "file" else robot).problems}
    assert found[key].code == "E-TRUST"
    assert found[key].hint == f"if you trust it: linkwright.build(..., {way})"


def test_the_caller_can_trust_it(folder):
    (folder / "arm.urdf").write_text("<robot/>")
    robot = {"source": {"kind": "urdf", "path": "arm.urdf", "trust": True}}
    assert plan(robot, trust=True).source.trust
    assert plan({"source": {"kind": "urdf", "path": "arm.urdf"}}, trust=True).source.trust


def test_plugins_count_as_on_the_command_line():
    assert plan("robot=sample", plugins=["os.path", "json"]).plugins == ("os.path", "json")


def test_an_error_is_what_the_command_line_prints():
    with pytest.raises(ConfigError) as typed:
        compose_plan(["robot=arm", "mesh.tolerence=1", "root=fere"])
    assert str(refused("robot=arm", "mesh.tolerence=1", "root=fere")) == str(typed.value)


def test_the_output_is_an_argument_or_a_key(folder):
    assert plan("robot=arm").output is None
    assert plan("robot=arm", "output=x").output == "x"
    assert plan("robot=arm", output=Path("it's ${here}")).output == "it's ${here}"


def test_folders_with_robots_can_be_named(tmp_path):
    elsewhere = write(tmp_path / "elsewhere", leg=ARM)
    assert plan("robot=leg", config_dirs=[elsewhere]).name == "leg"


def test_it_works_inside_a_program_that_runs_under_hydra(folder):
    from hydra import compose, initialize_config_dir

    (folder / "theirs.yaml").write_text("lr: 0.5")
    with initialize_config_dir(str(folder), version_base=None):
        assert plan("robot=arm").name == "arm"
        assert compose("theirs").lr == 0.5
