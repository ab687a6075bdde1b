# ruff: noqa: E501
"""Hints are commands that work when they are pasted; messages are in our words and fit what was typed."""

import re
import shlex
from pathlib import Path

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.options import UsageError, parse
from linkwright.stages.robot.errors import ConfigError
from tests.support.cases import mostly_slow
from tests.support.stand_in_builds import Recorder
from tests.support.users import GLOBAL, SAMPLE, URL, composed, put, refused, write

THEIRS = re.compile(
    r"ConfigKeyError|ConfigAttributeError|full_key|object_type|no viable|mismatched|token recog"
)
FREE = f"{SAMPLE}root: {{base: free}}\n"


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("arm.urdf", "arm.xml", "arm.zip"):
        (tmp_path / name).touch()
    return write(tmp_path, my_arm=SAMPLE)


def problems(folder, *arguments):
    """The problems of a command line; none where it is right."""
    try:
        command = parse(arguments)
        composed(folder, *command.overrides, dirs=command.config_dirs)
    except ConfigError as error:
        return list(error.problems)
    except UsageError as error:
        pytest.fail(str(error))
    return []


def commands(hint, typed):
    """The command lines that a hint shows, whole; a single argument takes the place of what was typed."""
    lines = [
        shlex.split(re.split(r"\s{3}| shows | lists | tells ", text)[0])[1:]
        for text in re.findall(r"linkwright (?:[^'\";(]|'[^']*'|\"[^\"]*\")+", hint)
    ]
    single = r"(?:quote the value: |for one text |for a list |example of a mapping: )(\S.*?)(?:;|$)"
    lines += [[*typed[:-1], *shlex.split(text)] for text in re.findall(single, hint)]
    return lines + [[*typed, *shlex.split(text)] for text in re.findall(r"command line[:,] (.*)$", hint)]


@pytest.mark.parametrize(
    "typed",
    mostly_slow([
        ["my_arm"], ["robot/my_arm.yaml"], ["arm.urdf"], ["arm.xml"], ["arm.zip"], [URL],
        [f"{URL}?configuration=a%3Db&x=1"],
        ["source=onshape", f"source.url={URL}?configuration=a%3Db"],
        ["source=sample", "name=a,b"],
        ["source=sample", "depth.rigid=a,b"],
        ["source=urdf", "source.path=~/arm.urdf"],
        ["source=urdf", "source.path=a:b (1).urdf"],
        ["source=sample", "name=it's"],
        ["source=sample", "joints={a: {damping: 1}"],
        ["source=sample", "~nope"],
        ["source=sample", "foo=1"],
        ["source=urdf"], ["source=mjcf"], ["source=bundle"], ["source=onshape"],
        ["source=sample", "vars.x=a b (c) ~"],
    ], keep=12),
    ids=" ".join,
)  # fmt: skip
def test_a_hint_can_be_pasted(here, typed):
    shown = problems(here, *typed)
    assert shown
    lines = [line for problem in shown for line in commands(problem.hint, typed)]
    for line in lines:
        # The address of a hint is an address that nobody has.
        after = [
            item for item in problems(here, *line) if item.code in ("E-OVERRIDE", "E-MISSING", "E-OPTION")
        ]
        assert after == [], (line, after)
    assert lines or typed[-1] in ("foo=1", "source=onshape"), shown


def test_a_pasted_hint_does_what_was_meant(here):
    typed = ["source=urdf", "source.path=~/my (1) arm.urdf"]
    (line,) = commands(problems(here, *typed)[0].hint, typed)
    assert composed(here, *line).plan.source.path == f"{Path.home()}/my (1) arm.urdf"


@pytest.mark.parametrize(
    ("kind", "file"), [("urdf", "arm.urdf"), ("mjcf", "arm.xml"), ("bundle", "arm.zip"), ("onshape", "https:")]
)  # fmt: skip
def test_the_example_of_a_hint_fits_the_source(here, kind, file):
    (problem,) = problems(here, f"source={kind}")
    assert problem.code == "E-MISSING"
    assert file in problem.hint


ROBOTS = {
    "no folder": ("  - /extra: x\n", "E-OPTION extra=x", "groups: actuators"),
    "order": ("  - override /mesh: hull\n  - bare\n", "E-OVERRIDE robot/bad.yaml", "at the end of the list"),
    "order of a list": ("  - override /export: [urdf, mjcf]\n  - bare\n", "E-OVERRIDE robot/bad.yaml", "at the end of the list"),
    "twice": ("  - /mesh: ladder\n", "E-OVERRIDE mesh", "- override /mesh: ..."),
    "computed": ("  - /${mesh}/x\n", "E-OVERRIDE ${mesh}/x", "the name of the option itself"),
    "logging": ("  - override /hydra/job_logging: nope\n", "E-TRUST hydra.job_logging", "remove it"),
    "launcher": ("  - override /hydra/launcher: nope\n", "E-OPTION hydra/launcher=nope", "basic"),
    "a list": ("source: [1]\n", "E-OVERRIDE robot/bad.yaml", "check the file there"),
    "text for a number": ("  - override /hydra/launcher: joblib\nhydra: {launcher: {n_jobs: many}}\n", "E-OVERRIDE robot/bad.yaml", ""),
    "a key": ("name: ${nope.x}\n", "E-VALUE name", "${vars.reach}"),
    "a variable": ("name: ${oc.env:NOT_THERE}\n", "E-VALUE name", "${oc.env:NOT_THERE,0}"),
    "a resolver": ("name: ${eval:1+1}\n", "E-VALUE name", "resolvers: oc.env"),
    "a circle": ("vars: {a: '${vars.b}', b: '${vars.a}'}\n", "E-VALUE vars.a", "break the cycle"),
    "nothing given": ("source: {path: '???'}\nname: ${source.path}\n", "E-VALUE name", "give that value"),
}  # fmt: skip


@pytest.mark.parametrize("name", ROBOTS)
def test_an_error_of_hydra_about_a_file_is_translated(here, name):
    if name == "text for a number":
        pytest.importorskip("hydra_plugins.hydra_joblib_launcher")
    text, where, hint = ROBOTS[name]
    source = "  - override /source: sample\n"
    # Overrides end a defaults list.
    text = f"{text}{source}" if text.startswith("  - /") else f"{source}{text}"
    write(here, bad=f"{GLOBAL}defaults:\n{text}")
    shown = problems(here, "robot=bad")
    assert any(f"{problem.code} {problem.where}".startswith(where) for problem in shown), shown
    assert any(hint in problem.hint for problem in shown), shown
    assert not [problem for problem in shown if THEIRS.search(problem.message + problem.hint)]
    assert not [item for item in shown if item.code == "E-OPTION" and item.hint.rstrip().endswith(":")]


@pytest.mark.parametrize(("typed", "where", "text"), [
    (["~nope"], "~nope", "does not exist, so it cannot be deleted"),
    (["~ground=none"], "~ground", "does not exist, so it cannot be deleted"),
    (["+name=a", "+name=b"], "+name", "exists already"),
    (["++mesh=hull"], "++mesh=hull", "++ is for keys, and this is a group"),
    (["mesh.visual=1"], "mesh.visual", "must be a mapping (given 1)"),
    (["name=(a"], "name=(a", "cannot be read"),
    (["name=a:b:"], "name", ""),
])  # fmt: skip
def test_an_error_of_hydra_about_an_override_is_translated(here, typed, where, text):
    shown = problems(here, "source=sample", *typed)
    reported = [problem for problem in shown if problem.where.startswith(where)]
    assert reported, shown
    assert any(text in problem.message for problem in reported), shown
    assert not [problem for problem in shown if THEIRS.search(problem.message + problem.hint)]


@pytest.mark.parametrize(("make", "named", "shown"), [
    ([], "nope", ["--config-dir: nope is not a folder", "name the folder that holds robot/"]),
    (["file"], "file", ["file is a file"]),
    (["robots/robot/a.yaml"], "robots/robot", ["but no folder robot/", "--config-dir {here}/robots"]),
    (["robots/a.yaml"], "robots", ["contains YAML files", "DIR of DIR/robot/my_arm.yaml"]),
    (["empty/x.txt"], "empty", ["has no folder robot/ with a robot in it"]),
])  # fmt: skip
def test_a_wrong_folder_for_config_dir_comes_with_the_right_one(tmp_path, make, named, shown):
    message = refused(put(tmp_path, dict.fromkeys(make, SAMPLE)), dirs=[named])
    assert [words for words in shown if words.format(here=tmp_path) not in message] == []


@pytest.mark.parametrize("folder", ["robot", "plain", "some where"])
def test_a_robot_is_a_path_from_anywhere(tmp_path, monkeypatch, folder):
    put(tmp_path, {f"there/{folder}/my_arm.yaml": FREE})
    monkeypatch.setenv("HOME", str(tmp_path))
    (here := tmp_path / "here").mkdir()
    place = f"there/{folder}/my_arm"
    for typed in (
        f"{tmp_path}/{place}.yaml",
        f"../{place}.yaml",
        f"../{place}",
        f"~/{place}.yaml",
        f"'../{place}.yaml'",
    ):
        made = composed(here, f"robot={typed}")
        assert (made.plan.name, made.plan.root.base) == ("my_arm", "free"), typed


def test_a_path_means_that_file_and_a_name_an_option(here):
    write(here, sample=f"{SAMPLE}name: mine\n")
    assert composed(here, "robot=robot/sample.yaml").plan.name == "mine"
    assert "ambiguous" in problems(here, "robot=sample")[0].message


def test_robot_by_its_path_has_the_files_beside_it(tmp_path):
    evil = f"{SAMPLE}hydra: {{callbacks: {{x: {{_target_: os.system}}}}}}\n"
    there = write(tmp_path / "there", my_arm=f"{GLOBAL}defaults:\n  - base\n", base=FREE, evil=evil)
    (here := tmp_path / "here").mkdir()
    assert composed(here, f"robot={there}/robot/my_arm.yaml").plan.root.base == "free"
    (problem,) = problems(here, f"robot={there}/robot/evil.yaml")
    assert (problem.code, problem.where) == ("E-TRUST", "hydra.callbacks")


def test_robots_by_their_paths_are_swept_over(here):
    write(here / "there", other=SAMPLE)
    build = Recorder()
    assert run(["-m", "robot=my_arm,there/robot/other.yaml"], build) == 0
    folders = [(plan.name, Path(plan.output).name.rpartition("-")[0]) for plan in build.plans]
    assert folders == [("my_arm", "robot=my_arm"), ("other", "robot=other")]
