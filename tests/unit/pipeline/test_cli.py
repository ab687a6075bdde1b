"""The command: options, exit status, error border."""

import re
from importlib import import_module

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.presets import GROUPS, Presets
from linkwright.pipeline.errors import exit_status
from linkwright.pipeline.help_text import SHORT, whole
from linkwright.pipeline.reference.exit_status import INTERRUPTED, MEANINGS, line, table
from linkwright.pipeline.verbs import VERBS
from linkwright.stages.robot.errors import AssemblyError, ConfigError, Diagnostic, ValidationFailed

HEAVY = {
    "hydra", "jinja2", "lxml", "mujoco", "networkx", "numpy", "omegaconf", "pydantic", "rich", "scipy",
    "trimesh", "yaml",
}  # fmt: skip


ARM = """<robot name="arm"><link name="base"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""
BROKEN = ARM.replace('value="1"', 'value="-1"')


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LINKWRIGHT_CACHE", str(tmp_path / "cache"))
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "broken.urdf").write_text(BROKEN)
    return tmp_path


def ended(error, *options):
    """The exit status of a command whose build ends with this error."""

    def failing(plan):
        raise error

    return run([*options, "source=sample"], failing)


def test_the_help_names_every_group_option_and_verb(tmp_path):
    # Each with the lines below it that are further in.
    lines = dict(re.findall(r"^  ([a-z]+) (.*(?:\n {14}.*)*)", whole(), re.MULTILINE))
    assert set(GROUPS) <= lines.keys()
    for group in GROUPS:
        options = set(Presets(cwd=tmp_path).options(group))
        assert options - {*re.findall(r"[a-z][a-z0-9]*", lines[group])} == set(), group
    assert [verb for verb in VERBS if f"\n  linkwright {verb} " not in whole()] == []


def test_the_help_is_a_screen_and_all_of_it_within_80_columns():
    assert len(SHORT.splitlines()) <= 24
    for text in (SHORT, whole(), *(import_module(module).HELP for module in VERBS.values())):
        assert [line for line in text.splitlines() if len(line) > 80] == []
    assert set(GROUPS) | set(VERBS) <= {*re.findall(r"[a-z]+", SHORT)}


@pytest.mark.parametrize(("option", "first"), [("--help", SHORT), ("--help-all", whole()), ("-h", SHORT)])
def test_there_are_a_short_help_and_a_whole_one(option, first, capsys):
    assert run([option]) == 0
    assert capsys.readouterr().out == first.rstrip() + "\n"


def test_an_error_of_a_stage_shows_the_worst_of_each_code(folder, capsys):
    problems = [Diagnostic("E-MASS", f"part {n} has no mass", f"Part {n}", "give it") for n in range(9)]
    error = AssemblyError("the assembly cannot be built: 9 problems", problems=problems)
    assert ended(error) == 1
    assert capsys.readouterr().err.splitlines() == [
        "error: the assembly cannot be built: 9 problems",
        "  E-MASS ×9 Part 0: part 0 has no mass",
        "      also: Part 1, Part 2 and 6 more (-v shows all)",
        "      give it",
    ]
    assert ended(error, "-v") == 1
    assert capsys.readouterr().err.count("has no mass") == 9


BUG = (
    "error: a bug in linkwright: ZeroDivisionError: by zero\n"
    "  → LINKWRIGHT_TRACEBACK=1 shows where; so does build.log in the <output>.failed folder\n"
)


@pytest.mark.parametrize(("error", "status", "shown"), [
    (ConfigError("is wrong", "source.url", "change it"), 2, "error: source.url: is wrong\n  → change it\n"),
    (AssemblyError("has no mates"), 1, "error: has no mates\n"),
    (ValidationFailed("is off"), 3, "error: is off\n"),
    (KeyboardInterrupt(), 130, "error: interrupted\n"),
    (PermissionError(13, "Permission denied", "outputs"), 1, "error: outputs: Permission denied\n"),
    (ZeroDivisionError("by zero"), 1, BUG),
])  # fmt: skip
def test_an_error_is_one_message_and_an_exit_status(folder, capsys, monkeypatch, error, status, shown):
    assert ended(error) == exit_status(error) == status
    assert status in {*MEANINGS["build"], INTERRUPTED}
    assert capsys.readouterr().err == shown
    monkeypatch.setenv("LINKWRIGHT_TRACEBACK", "1")
    ended(error)
    shows = not isinstance(error, KeyboardInterrupt)
    assert ("Traceback (most recent call last)" in capsys.readouterr().err) == shows


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


def test_each_verb_has_a_row_and_its_help_ends_with_it(capsys):
    assert MEANINGS.keys() == {"build", "sweep", *VERBS}
    for verb, module in VERBS.items():
        assert "exit status:" not in import_module(module).HELP, verb
        assert run([verb, "--help"]) == 0
        out = capsys.readouterr().out
        assert all(len(text) <= 80 for text in out.splitlines())
        assert re.sub(r"\s+", " ", out).strip().endswith(line(verb))
    assert run(["explain", "exit"]) == 0
    explained = re.sub(r"\s+", " ", capsys.readouterr().out)
    assert all(re.sub(r"\s+", " ", row) in explained for row in table().splitlines())
    assert line("build") in re.sub(r"\s+", " ", whole())
