# ruff: noqa: E501
"""Hints are commands that work when they are pasted; what is told is in our words and fits what was typed."""

import re
import shlex
from pathlib import Path

import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.options import UsageError, parse
from linkwright.stages.robot.errors import ConfigError
from tests.support.cases import mostly_slow
from tests.support.users import URL, write

GLOBAL = "# @package _global_\n"
SAMPLE = f"{GLOBAL}defaults:\n  - override /source: sample\n"
THEIRS = re.compile(
    r"ConfigKeyError|ConfigAttributeError|full_key|object_type|no viable|mismatched|token recog"
)


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
        compose_plan(command.overrides, command.config_dirs, folder)
    except ConfigError as error:
        return list(error.problems)
    except UsageError as error:
        pytest.fail(str(error))
    return []


def commands(hint, typed):
    """The command lines that a hint shows, whole; a single argument takes the place of what was typed."""
    found = []
    for text in re.findall(r"linkwright (?:[^'\";(]|'[^']*'|\"[^\"]*\")+", hint):
        found.append(shlex.split(re.split(r"\s{3}| shows | lists | tells ", text)[0])[1:])
    for text in re.findall(
        r"(?:quote the value: |for one text |for a list |example of a mapping: )(\S.*?)(?:;|$)", hint
    ):
        found.append([*typed[:-1], *shlex.split(text)])
    found += [[*typed, *shlex.split(text)] for text in re.findall(r"command line[:,] (.*)$", hint)]
    return found


@pytest.mark.parametrize(
    "typed",
    mostly_slow([
        ["my_arm"],
        ["robot/my_arm.yaml"],
        ["arm.urdf"],
        ["arm.xml"],
        ["arm.zip"],
        [URL],
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
        ["source=urdf"],
        ["source=mjcf"],
        ["source=bundle"],
        ["source=onshape"],
        ["source=sample", "vars.x=a b (c) ~"],
    ], keep=12),
    ids=" ".join,
)  # fmt: skip
def test_a_hint_can_be_pasted(here, typed):
    shown = problems(here, *typed)
    assert shown
    lines = [line for problem in shown for line in commands(problem.hint, typed)]
    for line in lines:
        after = [one for one in problems(here, *line) if one.code in ("E-OVERRIDE", "E-MISSING", "E-OPTION")]
        # The address of a hint is one that nobody has.
        assert after == [], (line, after)
    assert lines or typed[-1] in ("foo=1", "source=onshape"), shown


def test_a_pasted_hint_does_what_was_meant(here):
    typed = ["source=urdf", "source.path=~/my (1) arm.urdf"]
    (line,) = commands(problems(here, *typed)[0].hint, typed)
    assert compose_plan(line, cwd=here).plan.source.path == f"{Path.home()}/my (1) arm.urdf"


def test_a_mapping_is_typed_as_yaml_has_it(here):
    typed = ["source=sample", 'joints={"elbow*": {damping: 1e-3, limits: [-1, 1]}, "b": {"effort": 2}}']
    joints = compose_plan(typed, cwd=here).plan.joints
    assert (joints["elbow*"].limits, joints["elbow*"].damping, joints["b"].effort) == ((-1, 1), 1e-3, 2)


@pytest.mark.parametrize(
    ("kind", "file"),
    [("urdf", "arm.urdf"), ("mjcf", "arm.xml"), ("bundle", "arm.zip"), ("onshape", "https:")],
)
def test_the_example_of_a_hint_fits_the_source(here, kind, file):
    (problem,) = problems(here, f"source={kind}")
    assert problem.code == "E-MISSING"
    assert file in problem.hint


ROBOTS = {
    "no group": ("  - override /mehs: hull\n", "E-OVERRIDE robot/bad.yaml", "did you mean mesh?"),
    "no option": ("  - override /mesh: hul\n", "E-OPTION mesh=hul", "did you mean hull? options: coacd, hull"),
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
    first = "" if text.startswith("  - override") else "  - override /source: sample\n"
    entries = text if text.startswith("  -") else ""
    keys = "" if entries else text
    if entries.startswith("  - /"):
        text = f"{entries}  - override /source: sample\n"
    elif entries:
        text = f"  - override /source: sample\n{entries}"
    else:
        text = first + keys
    write(here, bad=f"{GLOBAL}defaults:\n{text}")
    shown = problems(here, "robot=bad")
    lines = [f"{one.code} {one.where}" for one in shown]
    assert any(line.startswith(where) for line in lines), shown
    assert any(hint in one.hint for one in shown), shown
    assert not [one for one in shown if THEIRS.search(one.message + one.hint)]
    assert not [one for one in shown if one.code == "E-OPTION" and one.hint.rstrip().endswith(":")]


@pytest.mark.parametrize(
    ("typed", "where", "text"),
    [
        (["~nope"], "~nope", "does not exist, so it cannot be deleted"),
        (["~ground=none"], "~ground", "does not exist, so it cannot be deleted"),
        (["+name=a", "+name=b"], "+name", "exists already"),
        (["++mesh=hull"], "++mesh=hull", "++ is for keys, and this is a group"),
        (["mesh.visual=1"], "mesh.visual", "must be a mapping (given 1)"),
        (["name=(a"], "name=(a", "cannot be read"),
        (["name=a:b:"], "name", ""),
    ],
)
def test_an_error_of_hydra_about_an_override_is_translated(here, typed, where, text):
    shown = problems(here, "source=sample", *typed)
    found = [one for one in shown if one.where.startswith(where)]
    assert found, shown
    assert any(text in one.message for one in found), shown
    assert not [one for one in shown if THEIRS.search(one.message + one.hint)]


@pytest.mark.parametrize(
    ("make", "named", "shown"),
    [
        ([], "nope", ["nope is not a folder", "name the folder that holds robot/"]),
        (["file"], "file", ["file is a file"]),
        (["robots/robot/a.yaml"], "robots/robot", ["but no folder robot/", "--config-dir {here}/robots"]),
        (["robots/a.yaml"], "robots", ["contains YAML files", "DIR of DIR/robot/my_arm.yaml"]),
        (["empty/x.txt"], "empty", ["has no folder robot/ with a robot in it"]),
    ],
)
def test_a_wrong_folder_for_config_dir_says_which_it_wants(tmp_path, make, named, shown):
    for file in make:
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_text(SAMPLE)
    with pytest.raises(ConfigError) as caught:
        compose_plan([], [named], tmp_path)
    assert [words for words in shown if words.format(here=tmp_path) not in str(caught.value)] == []


@pytest.mark.parametrize("folder", ["robot", "plain", "some where"])
def test_a_robot_is_a_path_from_anywhere(tmp_path, monkeypatch, folder):
    file = tmp_path / "there" / folder / "my_arm.yaml"
    file.parent.mkdir(parents=True)
    file.write_text(f"{SAMPLE}root: {{base: free}}\n")
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.setenv("HOME", str(tmp_path))
    for typed in (
        file,
        f"../there/{folder}/my_arm.yaml",
        f"../there/{folder}/my_arm",
        f"~/there/{folder}/my_arm.yaml",
    ):
        made = compose_plan([f"robot={typed}"], (), here)
        assert (made.plan.name, made.plan.root.base) == ("my_arm", "free")
    assert compose_plan(["robot='../there/" + folder + "/my_arm.yaml'"], (), here).plan.name == "my_arm"


def test_a_path_means_that_file_and_a_name_an_option(here):
    write(here, sample=f"{SAMPLE}name: mine\n")
    assert compose_plan(["robot=robot/sample.yaml"], (), here).plan.name == "mine"
    assert "ambiguous" in problems(here, "robot=sample")[0].message


def test_files_beside_a_robot_by_its_path_are_found(tmp_path):
    there = write(
        tmp_path / "there", my_arm=f"{GLOBAL}defaults:\n  - base\n", base=f"{SAMPLE}root: {{base: free}}\n"
    )
    (tmp_path / "here").mkdir()
    assert compose_plan([f"robot={there}/robot/my_arm.yaml"], (), tmp_path / "here").plan.root.base == "free"


def test_a_robot_by_its_path_is_judged_as_any(tmp_path):
    there = write(tmp_path / "there", evil=f"{SAMPLE}hydra: {{callbacks: {{x: {{_target_: os.system}}}}}}\n")
    (tmp_path / "here").mkdir()
    (problem,) = problems(tmp_path / "here", f"robot={there}/robot/evil.yaml")
    assert (problem.code, problem.where) == ("E-TRUST", "hydra.callbacks")


def test_robots_by_their_paths_are_swept_over(here, monkeypatch):
    from linkwright.pipeline.cli import run
    from linkwright.pipeline.report import Report

    write(here / "there", other=SAMPLE)
    plans = []

    def build(plan):
        plans.append(plan)
        return Report("built", plan.name, str(plan.folder), plan.until, 0)

    assert run(["-m", "robot=my_arm,there/robot/other.yaml"], build) == 0
    assert [plan.name for plan in plans] == ["my_arm", "other"]
    assert [Path(plan.output).name.rpartition("-")[0] for plan in plans] == ["robot=my_arm", "robot=other"]
