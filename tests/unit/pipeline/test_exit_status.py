"""The exit status of every command is as its table says."""

import re
from importlib import import_module

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.errors import exit_status
from linkwright.pipeline.reference.exit_status import INTERRUPTED, MEANINGS, line, table
from linkwright.pipeline.report import Report
from linkwright.pipeline.verbs import VERBS
from linkwright.stages.robot.errors import AssemblyError, ConfigError, ValidationFailed

ARM = """<robot name="arm"><link name="base"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
BROKEN = ARM.replace('value="1"', 'value="-1"')

SWEEP = ("-m", "robot=sample", "until=fetch", "root=fixed,free", "--plan", "jobs.json")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LINKWRIGHT_CACHE", str(tmp_path / "cache"))
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "broken.urdf").write_text(BROKEN)
    return tmp_path


CASES = [
    ("bundle", ["nope", "a.zip"], 2),
    ("cache", ["info"], 0), ("cache", ["verify"], 0), ("cache", ["info", "cache.dir=arm.urdf/x"], 0),
    ("cache", ["nope"], 2),
    ("check", ["arm.urdf"], 0), ("check", ["nope.urdf"], 1), ("check", [], 2), ("check", ["broken.urdf"], 3),
    ("diff", ["a", "b"], 1), ("diff", ["a"], 2),
    ("doctor", [], 0), ("doctor", ["cache.dir=arm.urdf/x"], 1), ("doctor", ["--nope"], 2),
    ("explain", ["exit"], 0), ("explain", ["W-LIMIT"], 0), ("explain", ["nope"], 2),
    ("job", ["none.json", "0"], 2), ("jobs", ["none.json"], 2),
    ("new", ["arm.urdf"], 0), ("new", ["nope.urdf"], 2),
    ("skill", [], 0), ("skill", ["--nope"], 2),
    ("snapshot", ["--nope"], 2), ("view", ["nope"], 2),
]  # fmt: skip


@pytest.mark.parametrize(("verb", "arguments", "status"), CASES, ids=lambda value: str(value)[:30])
def test_a_verb_ends_with_a_status_of_its_table(folder, verb, arguments, status):
    assert run([verb, *arguments]) == status
    assert status in MEANINGS[verb]


@pytest.mark.parametrize(("error", "status"), [
    (None, 0), (AssemblyError("x"), 1), (ConfigError("x"), 2), (ValidationFailed("x"), 3),
    (KeyboardInterrupt(), INTERRUPTED), (ZeroDivisionError(), 1), (PermissionError(), 1),
], ids=str)  # fmt: skip
def test_a_build_ends_with_the_status_of_its_error(folder, error, status):
    def build(plan):
        if error:
            raise error
        return Report("built", plan.name, str(plan.folder), plan.until, 0)

    assert run(["source=sample"], build) == status
    assert error is None or exit_status(error) == status
    assert status in {*MEANINGS["build"], INTERRUPTED}


@pytest.mark.parametrize(("statuses", "status"), [
    ((0, 0), 0), ((0, 3), 3), ((1, 3), 1),
], ids=str)  # fmt: skip
def test_a_sweep_ends_with_the_worst_status_of_its_jobs(folder, statuses, status):
    def build(plan):
        ended = statuses[plan.root.base == "free"]
        if ended == 1:
            raise AssemblyError("x")
        return Report("built" if not ended else "invalid", plan.name, str(plan.folder), plan.until, ended)

    assert run(["-m", "source=sample", "root=fixed,free"], build) == status
    assert status in MEANINGS["sweep"]


def test_a_list_of_jobs_ends_with_the_status_of_its_jobs(folder):
    assert run(SWEEP) == 0
    assert run(["jobs", "jobs.json"]) == 1
    assert run(["job", "jobs.json", "0"]) == 0
    assert run(["job", "jobs.json", "--shard", "1/1"]) == 0
    assert run(["jobs", "jobs.json"]) == 0


def test_each_verb_has_a_row_and_its_help_ends_with_it(capsys):
    assert MEANINGS.keys() == {"build", "sweep", *VERBS}
    for verb, module in VERBS.items():
        assert "exit status:" not in import_module(module).HELP, verb
        assert run([verb, "--help"]) == 0
        out = capsys.readouterr().out
        assert all(len(text) <= 80 for text in out.splitlines())
        assert re.sub(r"\s+", " ", out).strip().endswith(line(verb))


def test_the_table_is_explained_and_in_the_help(capsys):
    assert run(["explain", "exit"]) == 0
    explained = re.sub(r"\s+", " ", capsys.readouterr().out)
    assert all(re.sub(r"\s+", " ", row) in explained for row in table().splitlines())
    assert run(["--help-all"]) == 0
    assert line("build") in re.sub(r"\s+", " ", capsys.readouterr().out)
