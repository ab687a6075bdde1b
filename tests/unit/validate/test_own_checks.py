"""Checks of the user's own: functions and classes of trusted modules, and what goes wrong in them."""

import importlib
import json
import sys
from pathlib import Path

import pytest

from linkwright.pipeline.config.files.trust import forbidden_target_problems, is_in_modules
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.plugins.loader import sources_digest, target
from linkwright.pipeline.plugins.trusted_modules import NotTrusted, trust
from linkwright.stages.robot.check import Check
from linkwright.stages.validate import validate
from linkwright.stages.validate.user_checks import UserCheck
from tests.support.building import plan_of, write
from tests.support.command import linkwright
from tests.support.compiled import compiled_of
from tests.support.places import PROJECT
from tests.support.robots import joint, robot_with

MODEL = '<mujoco><worldbody><body name="base"><joint/><geom size=".1" mass="2"/></body></worldbody></mujoco>'


def light(compiled, most=1.0):
    mass = float(compiled.model.body_mass.sum())
    yield Check("weight", mass <= most, f"{mass:g} kg", mass, most)


class Light:
    def __init__(self, most=1.0):
        self.most = most

    def __call__(self, compiled):
        return list(light(compiled, self.most))


def broken(compiled):
    yield Check("first", True, "")
    raise ValueError("no such motor")


def results(code, name="my_checks.light", **keys):
    return list(UserCheck(name, code, keys).check(compiled_of(MODEL)))


@pytest.mark.parametrize("code", [light, Light], ids=["function", "class"])
def test_function_and_a_class_get_the_model_and_the_keys(code):
    (heavy,) = results(code)
    assert (heavy.name, heavy.passed, heavy.value, heavy.code) == ("robot.xml: weight", False, 2.0, "X-LIGHT")
    assert heavy.fails
    assert results(code, most=3.0)[0].passed


def test_single_check_and_a_code_of_its_own():
    (check,) = results(lambda compiled: Check("it", True, "", code="X-MINE"))
    assert check.code == "X-MINE"
    (other,) = results(lambda compiled: Check("it", True, "", code="C-MASS"))
    assert other.code == "X-LIGHT"


def test_error_is_one_message_with_its_place():
    (check,) = results(broken, "my_checks.broken")
    place = f"(test_own_checks.py, line {broken.__code__.co_firstlineno + 2})"
    assert (check.passed, check.code) == (False, "X-BROKEN")
    assert check.detail == f"my_checks.broken raised ValueError: no such motor {place}"
    (other,) = results(light, wrong=1)
    assert "TypeError" in other.detail


def test_error_in_a_file_called_like_ours_has_its_place(tmp_path):
    file = tmp_path / "user_checks.py"
    file.write_text("def heavy(compiled):\n    raise ValueError('too heavy')\n")
    names = {}
    exec(compile(file.read_text(), str(file), "exec"), names)
    (check,) = results(names["heavy"], "user_checks.heavy")
    assert check.detail.endswith("too heavy (user_checks.py, line 2)")


def test_check_runs_once_for_the_first_file_that_compiles(tmp_path):
    written = write(robot_with([joint("revolute", "base", "arm")]), tmp_path).written
    own = [UserCheck("my_checks.light", light)]

    def names():
        return [
            check.name for check in validate(tmp_path, written, plan_of(), own) if check.code == "X-LIGHT"
        ]

    assert names() == ["robot.xml: weight"]
    (tmp_path / "robot.xml").write_text("<mujoco><worldbody><body/></mujoco>")
    assert names() == ["robot.urdf: weight"]


@pytest.mark.parametrize("gives", [None, "text", 3, [1]])
def test_what_is_no_check_is_said(gives):
    (check,) = results(lambda compiled: gives)
    assert not check.passed
    assert "must yield checks" in check.detail


def test_target_is_covered_by_its_module_and_those_above_it():
    assert is_in_modules("mine.light", ["mine"])
    assert is_in_modules("mine.deep.light", ["mine"])
    assert is_in_modules("mine.deep.light", ["mine.deep"])
    assert not is_in_modules("mine_too.light", ["mine"])
    assert not is_in_modules("mine", ["mine"])


CHECKS = {"validate": {"checks": [{"_target_": "mine.light"}]}}


def test_code_that_is_not_trusted_is_refused_with_its_remedy():
    (problem,) = forbidden_target_problems(CHECKS, "linkwright robot=arm")
    assert (problem.code, problem.where) == ("E-TRUST", "validate.checks[0]._target_")
    assert problem.hint == "if you trust it: linkwright robot=arm 'plugins=[mine]'"
    assert list(forbidden_target_problems({**CHECKS, "plugins": ["mine"]})) == []
    assert len(list(forbidden_target_problems({**CHECKS, "plugins": ["other"]}))) == 1


def test_code_anywhere_else_is_refused_whatever_is_trusted():
    tree = {"plugins": ["os"], "vars": {"x": {"_target_": "os.system"}}}
    assert [problem.where for problem in forbidden_target_problems(tree)] == ["vars.x._target_"]
    deeper = {"plugins": ["os"], "validate": {"checks": [{"_target_": "os.x", "y": {"_target_": "os.z"}}]}}
    assert [problem.where for problem in forbidden_target_problems(deeper)] == [
        "validate.checks[0].y._target_"
    ]


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("no_such_module_here.light", "cannot be imported"),
        ("json.light", "has no function or class light"),
        ("os.path.join", "belongs to no module that plugins names"),
    ],
)
def test_target_that_cannot_be_found(path, said):
    assert target({"_target_": "json.dumps"}, ["json"], "") is json.dumps
    with pytest.raises(ConfigError) as caught:
        target({"_target_": path}, ["no_such_module_here", "json"], "validate.checks.0")
    assert said in caught.value.message
    assert caught.value.where == "validate.checks.0"


def test_text_of_a_plugin_is_part_of_what_is_kept(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    Path("my_light_checks.py").write_text("def light(compiled): return []\n")
    first = sources_digest(["my_light_checks"])
    assert first == sources_digest(["my_light_checks"])
    Path("my_light_checks.py").write_text("def light(compiled): return [1]\n")
    assert sources_digest(["my_light_checks"]) != first
    assert sources_digest(["no_such_module_here"]) is None
    assert sources_digest(["time"]) is None


def test_packages_around_a_plugin_and_places_of_files_are_kept(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    Path("lab_around").mkdir()
    Path("lab_around/checks.py").write_text("from lab_around import LIMIT\n")
    Path("lab_around/__init__.py").write_text("LIMIT = 1\n")
    first = sources_digest(["lab_around.checks"])
    assert first == sources_digest(["lab_around.checks"])
    assert first is not None
    Path("lab_around/__init__.py").write_text("LIMIT = 2\n")
    assert sources_digest(["lab_around.checks"]) != first
    for folder in ("lab_places", "lab_places/old", "lab_places/new"):
        Path(folder).mkdir()
        Path(folder, "__init__.py").write_text("")
    Path("lab_places/old/part.py").write_text("def light(compiled): return []\n")
    first = sources_digest(["lab_places"])
    Path("lab_places/old/part.py").rename("lab_places/new/part.py")
    assert sources_digest(["lab_places"]) != first


def test_modules_of_the_working_folder_are_found_if_trusted(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    package = tmp_path / "lab_of_mine"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "checks.py").write_text("def light(compiled): return []\n")
    (package / "deep.py").write_text("from lab_of_mine.checks import light\n")
    (tmp_path / "neighbour_of_mine.py").write_text("")
    (tmp_path / "asking_of_mine.py").write_text("import neighbour_of_mine\ndef light(compiled): return []\n")
    path = list(sys.path)
    assert callable(target({"_target_": "lab_of_mine.checks.light"}, ["lab_of_mine.checks"], ""))
    with pytest.raises(ConfigError) as caught:
        target({"_target_": "asking_of_mine.light"}, ["asking_of_mine"], "validate.checks[0]")
    assert "asking_of_mine imports neighbour_of_mine of the working folder" in caught.value.message
    assert caught.value.hint == "if you trust it: 'plugins=[asking_of_mine,neighbour_of_mine]'"
    assert target({"_target_": "asking_of_mine.light"}, ["asking_of_mine", "neighbour_of_mine"], "")
    trust(["lab_of_mine.checks"])
    with pytest.raises(NotTrusted, match="plugins="):
        importlib.import_module("lab_of_mine.deep")
    trust(["lab_of_mine"])
    sys.modules.pop("lab_of_mine")
    assert importlib.import_module("lab_of_mine.deep").light
    assert sys.path == path


def test_check_that_imports_a_former_name_is_told_the_new_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    monkeypatch.setattr(sys, "path", [place for place in sys.path if Path(place).resolve() != PROJECT])
    (tmp_path / "early_of_mine.py").write_text(
        "from stages.robot.check import Check\ndef light(compiled): return []\n"
    )
    with pytest.raises(ConfigError, match="No module named 'stages'") as caught:
        target({"_target_": "early_of_mine.light"}, ["early_of_mine"], "validate.checks[0]")
    assert "from linkwright import Check, Finding, CompiledModel" in caught.value.hint


OWN = """
from linkwright import Check

def light(compiled, most):
    mass = float(compiled.model.body_mass.sum())
    yield Check("weight", mass <= most, f"{mass:.3g} kg of {most:g}", mass, most)
"""


@pytest.mark.e2e
def test_build_runs_them_from_the_working_folder(tmp_path):
    (tmp_path / "my_own_checks.py").write_text(OWN)
    words = ["robot=sample", "mesh=visual", "output=out", "export=mjcf"]
    words.append("validate.checks=[{_target_: my_own_checks.light, most: 0.5}]")
    refused = linkwright(tmp_path, *words, status=2)
    assert "E-TRUST validate.checks[0]._target_" in refused.stderr
    assert "2 problems" not in refused.stderr
    assert "plugins=[my_own_checks]" in refused.stderr
    done = linkwright(tmp_path, *words, "plugins=[my_own_checks]", status=3)
    assert "FAILED X-LIGHT sample.xml: weight" in done.stdout
