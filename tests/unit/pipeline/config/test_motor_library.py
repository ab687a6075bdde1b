"""The files of motors: ours, and the user's own, as the command line finds them."""

import pytest
import yaml

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.config.presets import OURS, Presets
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.motor_files import library
from linkwright.pipeline.verbs.explain import explained
from tests.support.users import write as write_robot

MINE = """
title: My servo
values:
  effort: {value: 3, source: my bench, kind: measured}
"""

ARGUMENTS = ["source=sample", "actuators.elbow.motor=mine"]


def write(folder, text=MINE, name="mine"):
    (folder / "motors").mkdir(parents=True, exist_ok=True)
    file = folder / "motors" / f"{name}.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def refusal(cwd, *arguments):
    with pytest.raises(ConfigError) as error:
        compose_plan(arguments or ARGUMENTS, cwd=cwd)
    return str(error.value)


def test_motor_of_the_user_is_beside_robot(tmp_path):
    for folder, whose in (("here", "My"), ("there", "Their")):
        write(tmp_path / folder, MINE.replace("My", whose))
    assert compose_plan(ARGUMENTS, cwd=tmp_path / "here").plan.motors["mine"].title == "My servo"
    write_robot(tmp_path / "there", arm="# @package _global_\nsource: {kind: sample}\n")
    (tmp_path / "empty").mkdir()
    arguments = ["robot=arm", "actuators.elbow.motor=mine"]
    plan = compose_plan(arguments, [tmp_path / "there"], tmp_path / "empty").plan
    assert plan.motors["mine"].title == "Their servo"


def test_motor_of_the_robot_wins_over_any_file(tmp_path):
    write(tmp_path, name="sts3215")
    arguments = ["source=sample", "actuators.elbow.motor=sts3215"]
    assert compose_plan(arguments, cwd=tmp_path).plan.motors["sts3215"].title == "My servo"
    value = "{effort: {value: 1, source: a guess of mine, kind: measured}}"
    arguments += ["motors.sts3215.title=Inline", f"motors.sts3215.values={value}"]
    assert compose_plan(arguments, cwd=tmp_path).plan.motors["sts3215"].title == "Inline"
    write(tmp_path, "title: [")
    assert compose_plan(["source=sample"], cwd=tmp_path).plan.motors == {}, "without a motor nothing is read"


def test_unknown_motor_comes_with_near_names_and_all(tmp_path):
    write(tmp_path)
    text = refusal(tmp_path, "source=sample", "actuators.elbow.motor=sts3251")
    assert "E-MOTOR actuators.elbow.motor: there is no motor sts3251" in text
    assert "did you mean sts3215? motors: erob80_100, erob80_50, mine, mx106" in text
    assert str(tmp_path / "motors") in text
    assert "there is no motor ../x" in refusal(tmp_path, "source=sample", "actuators.elbow.motor='../x'")
    motors = "motors={my_servo:{title:x,values:{kp:{value:1,source:a,kind:measured}}}}"
    text = refusal(tmp_path, "source=sample", motors, "actuators.elbow.motor=my_serwo")
    assert "did you mean my_servo?" in text
    text = refusal(tmp_path, "source=sample", "motors={my_servo:{title:x}}")
    assert "gear [-]; rotor_inertia [kg m²], before the gear; armature [kg m²]; damping [N m s/rad]" in text


@pytest.mark.parametrize(("text", "message"), [
    ("title: [", "line 1, column 9: not valid YAML"),
    ("- a", "must be a mapping"),
    ("title: x\n", "values: missing"),
    (MINE.replace("source: my bench, ", ""), "values.effort.source: missing"),
    (MINE + "  friktion: {value: 1, source: me, kind: measured}\n", "did you mean friction?"),
])  # fmt: skip
def test_a_wrong_file_is_named(tmp_path, text, message):
    file = write(tmp_path, text)
    error = refusal(tmp_path)
    assert f"E-MOTOR {file}" in error
    assert message in error


def test_motors_are_no_options_and_no_group(tmp_path):
    write(tmp_path)
    (tmp_path / "robot").mkdir()
    presets = Presets(cwd=tmp_path)
    assert [option for option in presets.options("actuators") if "/" in option] == []
    assert presets.own_groups() == []
    assert {file.parent for file in library().values()} == {OURS / "actuators" / "motors"}
    for file in library().values():
        assert yaml.safe_load(file.read_text(encoding="utf-8"))["title"]
    assert "there is no such option" in refusal(tmp_path, "source=sample", "actuators=motors/sts3215")


def test_explain_tells_the_values_of_a_motor_and_their_sources(tmp_path, monkeypatch):
    write(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert "effort          3 N m (measured)\n      my bench" in explained("mine")
    assert "Feetech STS3215" in explained("sts3215")
    with pytest.raises(ConfigError, match="no such code, key, motor or variable"):
        explained("sts32")
