"""The files of motors: ours, and the user's own, as the command line finds them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.config.presets import OURS, Presets
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.motor_files import library
from linkwright.pipeline.verbs.explain import explained

MINE = """
title: My servo
values:
  effort: {value: 3, source: my bench, kind: measured}
"""

ARGUMENTS = ["source=sample", "actuators.elbow.motor=mine"]


def write(folder: Path, text: str = MINE, name: str = "mine") -> Path:
    (folder / "motors").mkdir(parents=True, exist_ok=True)
    file = folder / "motors" / f"{name}.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def told(cwd: Path, *arguments: str) -> str:
    with pytest.raises(ConfigError) as error:
        compose_plan(arguments or ARGUMENTS, cwd=cwd)
    return str(error.value)


def test_a_motor_of_ones_own_is_found_where_one_works_and_beside_robot(tmp_path: Path) -> None:
    write(tmp_path / "here")
    assert compose_plan(ARGUMENTS, cwd=tmp_path / "here").plan.motors["mine"].title == "My servo"
    write(tmp_path / "there", MINE.replace("My", "Their"))
    (tmp_path / "there" / "robot").mkdir()
    (tmp_path / "there" / "robot" / "arm.yaml").write_text("# @package _global_\nsource: {kind: sample}\n")
    (tmp_path / "empty").mkdir()
    arguments = ["robot=arm", "actuators.elbow.motor=mine"]
    plan = compose_plan(arguments, [tmp_path / "there"], tmp_path / "empty").plan
    assert plan.motors["mine"].title == "Their servo"


def test_ones_own_stands_in_place_of_ours_and_the_robots_in_place_of_any_file(tmp_path: Path) -> None:
    write(tmp_path, name="sts3215")
    arguments = ["source=sample", "actuators.elbow.motor=sts3215"]
    assert compose_plan(arguments, cwd=tmp_path).plan.motors["sts3215"].title == "My servo"
    value = "{effort: {value: 1, source: a guess of mine, kind: measured}}"
    arguments += ["motors.sts3215.title=Inline", f"motors.sts3215.values={value}"]
    assert compose_plan(arguments, cwd=tmp_path).plan.motors["sts3215"].title == "Inline"


def test_without_a_motor_nothing_is_read(tmp_path: Path) -> None:
    write(tmp_path, "title: [")
    assert compose_plan(["source=sample"], cwd=tmp_path).plan.motors == {}


def test_an_unknown_motor_is_told_with_near_names_and_all_that_there_are(tmp_path: Path) -> None:
    write(tmp_path)
    text = told(tmp_path, "source=sample", "actuators.elbow.motor=sts3251")
    assert "E-MOTOR actuators.elbow.motor: there is no motor sts3251" in text
    assert "did you mean sts3215? motors: erob80_100, erob80_50, mine, mx106" in text
    assert str(tmp_path / "motors") in text
    assert "there is no motor ../x" in told(tmp_path, "source=sample", "actuators.elbow.motor='../x'")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("title: [", "line 1, column 9: not valid YAML"),
        ("- a", "must be a mapping"),
        ("title: x\n", "values: missing"),
        (MINE.replace("source: my bench, ", ""), "values.effort.source: missing"),
        (MINE + "  friktion: {value: 1, source: me, kind: measured}\n", "did you mean friction?"),
    ],
)
def test_a_wrong_file_is_named(tmp_path: Path, text: str, message: str) -> None:
    file = write(tmp_path, text)
    found = told(tmp_path)
    assert f"E-MOTOR {file}" in found
    assert message in found


def test_motors_are_no_options_and_no_group(tmp_path: Path) -> None:
    write(tmp_path)
    (tmp_path / "robot").mkdir()
    presets = Presets(cwd=tmp_path)
    assert [one for one in presets.options("actuators") if "/" in one] == []
    assert presets.own_groups() == []
    assert "there is no such option" in told(tmp_path, "source=sample", "actuators=motors/sts3215")


def test_explain_tells_the_values_of_a_motor_and_their_sources(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert "effort          3 N m (measured)\n      my bench" in explained("mine")
    assert "Feetech STS3215" in explained("sts3215")
    with pytest.raises(ConfigError, match="no such code, key, motor or variable"):
        explained("sts32")


def test_every_motor_of_ours_lies_where_the_package_of_the_presets_is() -> None:
    assert {file.parent for file in library().values()} == {OURS / "actuators" / "motors"}
    for file in library().values():
        assert yaml.safe_load(file.read_text(encoding="utf-8"))["title"]


def test_the_names_of_motors_are_listed_without_heavy_imports() -> None:
    code = (
        "import sys; from linkwright.pipeline import motor_files; motor_files.library(); "
        "print({'yaml', 'pydantic'} & {*sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=dict(os.environ))
    assert done.stdout.strip() == "set()"


def test_a_motor_that_is_not_there_is_compared_with_those_of_the_robots_file(tmp_path: Path) -> None:
    motors = "motors={my_servo:{title:x,values:{kp:{value:1,source:a,kind:measured}}}}"
    text = told(tmp_path, "source=sample", motors, "actuators.elbow.motor=my_serwo")
    assert "did you mean my_servo?" in text


def test_the_hint_of_a_missing_key_is_one_line(tmp_path: Path) -> None:
    text = told(tmp_path, "source=sample", "motors={my_servo:{title:x}}")
    assert "gear [-]; rotor_inertia [kg m²], before the gear; armature [kg m²]; damping [N m s/rad]" in text
