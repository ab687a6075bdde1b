"""What a build asks before its first stage is kept with the answers, and it asks nothing else."""

import builtins
import io
import os
from contextlib import contextmanager
from pathlib import Path

import pytest

from linkwright.pipeline import observed
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.preflight import plan_problems

ROBOT = """# @package _global_
defaults:
  - optional extra: none
  - override /source: sample
  - override /mesh: hull
  - override /actuators: position

actuators: {"*": {motor: strong}}
elements: {mount: {into: {tag: worldbody}, formats: [mjcf], file: mount.xml}}
output: ${oc.env:PLACE,outputs/here}
vars: {reach: '${oc.env:REACH,0.3}'}
"""
MOTOR = "title: Strong\nvalues: {effort: {value: 3, source: own, kind: measured}}\n"

STANDS_FOR_NOTHING = {"HYDRA_FULL_ERROR", "HYDRA_DEPRECATION_WARNINGS_AS_ERRORS", "PYTHONPATH"}
"""What Hydra reads, and what decides no value of a configuration."""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A working folder with a robot, a motor, an element's file, and a folder of options beside it."""
    home = tmp_path / "home"
    files = {
        "home/robot/arm.yaml": ROBOT,
        "home/motors/strong.yaml": MOTOR,
        "home/mount.xml": "<site name='cam'/>",
        "home/.env": "ONSHAPE_ACCESS_KEY=from-the-file\n",
        "more/mesh/fine.yaml": "collider: hull\n",
        "more/robot/other.yaml": "# @package _global_\nname: other\n",
        "elsewhere/robot/far.yaml": "# @package _global_\ndefaults: [override /source: sample]\n",
    }
    for path, text in files.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)
    monkeypatch.chdir(home)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("PWD", str(home))
    return tmp_path


@contextmanager
def watched(monkeypatch, folder):
    """The paths below `folder` that Python asks the system for, and the variables that are read."""
    paths, names = set[str](), set[str]()

    def watch(module, name):
        asked = getattr(module, name)

        def tell(*args, **more):
            path = args[0] if args else more.get("path", ".")
            if isinstance(path, str | os.PathLike):
                paths.add(os.path.normpath(Path.cwd() / path))
            return asked(*args, **more)

        monkeypatch.setattr(module, name, tell)

    with monkeypatch.context() as monkeypatch:
        for name in ("stat", "lstat", "scandir", "listdir", "open", "readlink", "access"):
            watch(os, name)
        watch(io, "open")
        watch(builtins, "open")
        kind = type(os.environ)
        read = kind.__getitem__
        monkeypatch.setattr(kind, "__getitem__", lambda self, name: names.add(name) or read(self, name))
        yield paths, names
    paths.intersection_update([path for path in paths if Path(path).is_relative_to(folder)])


@pytest.mark.parametrize("overrides", [
    ["robot=arm"], ["robot=arm", "mesh=fine"], ["robot=../elsewhere/robot/far.yaml"], ["robot=glob(ar*)"],
], ids=" ".join)  # fmt: skip
def test_all_that_composing_asks_is_kept(here, monkeypatch, overrides):
    with observed.recording("salt") as seen, watched(monkeypatch, here) as (paths, names):
        plan = compose_plan(overrides, ["../more"], judge=plan_problems).plan
        assert plan_problems(plan) == []
    about = {os.path.normpath(Path.cwd() / place) for _, place, _ in seen.answers}
    # A path without links is that of all folders above it.
    about |= {str(parent) for place in about for parent in Path(place).parents}
    # The names in a folder are asked with those in the folders in it.
    listed = {place for question, place, _ in seen.answers if question in ("folders with YAML", "holds YAML")}
    assert {path for path in paths - about if str(Path(path).parent) not in listed} == set()
    assert {str(here / "home" / "robot" / "arm.yaml"), *overrides} & (paths | {*overrides})
    kept = {name for question, name, _ in seen.answers if question == "variable"}
    free = {name for name in names if name.startswith(observed.VARIABLE_PREFIXES)} | STANDS_FOR_NOTHING
    assert names - kept - free == set()
    assert seen.is_repeatable


def test_what_is_kept_is_true_until_anything_of_it_changes(here):
    with observed.recording("salt") as seen:
        plan_problems(compose_plan(["robot=arm"], ["../more"]).plan)
    assert observed.have_same_answers(seen.answers, "salt")
    for path in ("robot/arm.yaml", "motors/strong.yaml", "mount.xml", ".env"):
        file = here / "home" / path
        text = file.read_text()
        for change in (f"{text} ", None):
            file.unlink() if change is None else file.write_text(change)
            assert not observed.have_same_answers(seen.answers, "salt"), path
            file.write_text(text)
        assert observed.have_same_answers(seen.answers, "salt"), path
    for path in (
        "home/extra/none.yaml", "home/mesh/hull.yaml", "home/motors/weak.yaml", "more/robot/arm.yaml",
        "home/group/new.yaml",
    ):  # fmt: skip
        (here / path).parent.mkdir(exist_ok=True)
        (here / path).write_text("")
        assert not observed.have_same_answers(seen.answers, "salt"), path
        (here / path).unlink()


@pytest.mark.parametrize(
    "name",
    [
        "PLACE",
        "REACH",
        "HOME",
        "LINKWRIGHT_TRUST",
        "LINKWRIGHT_NEW",
        "ONSHAPE_SECRET_KEY",
        "SOURCE_DATE_EPOCH",
    ],
)
def test_a_variable_that_a_value_names_is_kept_as_a_digest(here, monkeypatch, name):
    with observed.recording("salt") as seen:
        compose_plan(["robot=arm"])
    monkeypatch.setenv(name, "0.125")
    assert not observed.have_same_answers(seen.answers, "salt")
    with observed.recording("salt") as seen:
        compose_plan(["robot=arm"])
    assert observed.have_same_answers(seen.answers, "salt")
    assert not observed.have_same_answers(seen.answers, "another salt")
    assert "0.125" not in str([answer for question, *answer in seen.answers if "variable" in question])


@pytest.mark.parametrize(
    ("overrides", "lasts"),
    [(["name=a"], True), (["name=a_${now:%H}"], False),
     (["vars={hour: '${now:%H}'}", "name=a_${vars.hour}"], False)],
    ids=str,
)  # fmt: skip
def test_a_value_of_the_moment_lets_nothing_last(here, overrides, lasts):
    with observed.recording("salt") as seen:
        compose_plan(["robot=arm", *overrides], ["../more"])
    assert seen.is_repeatable == lasts


def test_a_file_that_changes_while_it_is_read_lets_nothing_last(here):
    file = here / "home" / "mount.xml"
    with observed.recording("salt") as seen:
        plan = compose_plan(["robot=arm"]).plan
        plan_problems(plan)
        assert seen.is_repeatable
        file.write_text("<site name='other'/>")
        plan_problems(plan)
    assert not seen.is_repeatable
