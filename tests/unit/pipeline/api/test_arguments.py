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
URDF = {"kind": "urdf", "path": "arm.urdf"}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(write(tmp_path, arm=ARM))
    (tmp_path / "arm.urdf").write_text("<robot/>")
    return tmp_path


def plan(*overrides, trust=False, plugins=(), output=None, config_dirs=()):
    return plan_of(overrides, trust, plugins, output, config_dirs)


def refused(*overrides, **more):
    with pytest.raises(ConfigError) as caught:
        plan(*overrides, **more)
    return caught.value


@pytest.mark.parametrize(
    "robot", ["robot/arm.yaml", Path("robot/arm.yaml"), "robot=arm", DATA | {"name": "arm"}]
)
def test_a_robot_is_the_same_by_its_name_its_path_or_as_data(robot):
    expected = compose_plan(["robot=arm", "root=free"]).plan
    assert plan(robot, "root=free") == expected
    assert expected.root.base == "free"
    assert plan() == compose_plan([]).plan, "the sample"


@pytest.mark.parametrize(("data", "name"), [
    ({"defaults": DATA["defaults"]}, "robot"),
    ({"source": {"kind": "sample"}}, "sample"),
    ({"source": {"kind": "sample"}, "name": "my_arm"}, "my_arm"),
    ({"source": {"kind": "mjcf", "path": Path("robots/so101.xml")}}, "so101"),
])  # fmt: skip
def test_a_robot_as_data_is_named_by_itself_or_by_its_source(folder, data, name):
    (folder / "robots").mkdir()
    (folder / "robots" / "so101.xml").write_text("<mujoco/>")
    assert plan(data).name == name


def test_data_keeps_its_types_and_may_interpolate():
    """YAML would read some of these texts as numbers or truth values, and numpy's numbers not at all."""
    values = {"a": "1e5", "b": "on", "c": 1e-7, "d": None, "e": True, "f": (1, 2), "h": "é"}
    arrays = {"g": np.array([1.5]), "i": np.float64(2.5), "j": Path("x")}
    planned = plan(DATA | {"vars": values | arrays, "joints": {"*": {"damping": "${vars.c}"}}})
    assert planned.vars == {**values, "f": [1, 2], "g": [1.5], "i": 2.5, "j": "x"}
    assert type(planned.vars["a"]) is str
    assert planned.joints["*"].damping == 1e-7


def test_values_that_are_no_data_are_refused_with_their_key():
    error = refused({"joints": {"elbow": {"limits": [0, object()]}}})
    assert [problem.where for problem in error.problems] == ["joints.elbow.limits[1]"]
    assert "got object" in error.problems[0].message


@pytest.mark.parametrize(
    "defaults", ["x", [{"override /nope": "x"}], [{"override /root": "free"}, {"override /root": "fixed"}]]
)
def test_an_error_of_data_names_no_file(defaults):
    text = render(refused({"defaults": defaults}))
    assert "the robot's data" in text
    assert not [words for words in ("tmp", ".yaml") if words in text]


@pytest.mark.parametrize("robot", [{"source": {"kind": "sample"}}, "robot/mine.yaml"])
def test_two_robots_are_refused(robot):
    error = refused(robot, "robot=sample")
    assert f"got {'a mapping' if isinstance(robot, dict) else robot} and robot=sample" in error.message
    assert "defaults: [/robot/sample]" in error.hint
    assert "got robot/arm.yaml and a mapping" in refused("robot/arm.yaml", DATA).message


@pytest.mark.parametrize("how", ["file", "data"])
@pytest.mark.parametrize(("key", "way"), [("source.trust", "trust=True"), ("plugins", "plugins=[...]")])
def test_a_robot_cannot_make_itself_trusted(folder, how, key, way):
    robot = (
        {"source": URDF | {"trust": True}} if key == "source.trust" else {"source": URDF, "plugins": ["os"]}
    )
    if how == "file":
        (folder / "robot" / "own.yaml").write_text(f"# @package _global_\n{robot}")
    error = refused("robot/own.yaml" if how == "file" else robot)
    (problem,) = [problem for problem in error.problems if problem.where == key]
    assert (problem.code, problem.hint) == ("E-TRUST", f"if you trust it: linkwright.build(..., {way})")


def test_the_caller_can_trust_a_robot_and_plugins():
    for source in (URDF, URDF | {"trust": True}):
        assert plan({"source": source}, trust=True).source.trust
    assert plan("robot=sample", plugins=["os.path", "json"]).plugins == ("os.path", "json")


def test_output_and_folders_with_robots_are_arguments(tmp_path):
    assert plan("robot=arm").output is None
    assert plan("robot=arm", "output=x").output == "x"
    assert plan("robot=arm", output=Path("it's ${here}")).output == "it's ${here}"
    elsewhere = write(tmp_path / "elsewhere", leg=ARM)
    assert plan("robot=leg", config_dirs=[elsewhere]).name == "leg"


def test_it_works_inside_a_program_that_runs_under_hydra(folder):
    from hydra import compose, initialize_config_dir

    (folder / "theirs.yaml").write_text("lr: 0.5")
    with initialize_config_dir(str(folder), version_base=None):
        assert plan("robot=arm").name == "arm"
        assert compose("theirs").lr == 0.5
