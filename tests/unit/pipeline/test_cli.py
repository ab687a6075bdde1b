"""The command: options, exit status, error border."""

import re
from importlib import import_module

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.presets import GROUPS, Presets
from linkwright.pipeline.help_text import SHORT, whole
from linkwright.pipeline.options import Command, UsageError, parse
from linkwright.pipeline.report import Report
from linkwright.pipeline.verbs import VERBS
from linkwright.stages.robot.errors import AssemblyError, ConfigError, Diagnostic

HEAVY = {
    "hydra", "jinja2", "lxml", "mujoco", "networkx", "numpy", "omegaconf", "pydantic", "rich", "scipy",
    "trimesh", "yaml",
}  # fmt: skip


@pytest.fixture
def empty(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
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


def test_the_command_line_is_taken_apart():
    arguments = ["-m", "a=1", "--config-dir", "x", "--config-dir=y", "~b", "c=-1"]
    assert parse(arguments) == Command(("a=1", "~b", "c=-1"), ("x", "y"), multirun=True)
    for options, detail in (([], "usual"), (["-v"], "all"), (["--verbose"], "all"), (["-q"], "errors")):
        assert parse([*options, "robot=sample"]).detail == detail
    with pytest.raises(UsageError, match="--plan needs a file"):
        parse(["-m", "--plan", "root=fixed,free"])


@pytest.mark.parametrize(("arguments", "shown"), [
    (["--nope", "job"], "there is no option --nope"), (["--config-dir"], "--config-dir needs a folder"),
    (["-q", "-v"], "-q and -v exclude each other"),
])  # fmt: skip
def test_wrong_options_are_one_message(arguments, shown, capsys):
    assert run(arguments) == 2
    assert capsys.readouterr().err.startswith(f"error: {shown}\n  → ")


def test_an_error_of_a_stage_shows_the_worst_of_each_code(empty, capsys):
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


@pytest.mark.parametrize("status", [0, 3])
def test_the_exit_status_is_the_reports(empty, status):
    assert run(["source=sample"], lambda plan: Report("built", plan.name, "x", plan.until, status)) == status


BUG = (
    "error: a bug in linkwright: ZeroDivisionError: by zero\n"
    "  → LINKWRIGHT_TRACEBACK=1 shows where; so does build.log in the <output>.failed folder\n"
)


@pytest.mark.parametrize(("error", "status", "shown"), [
    (ConfigError("is wrong", "source.url", "change it"), 2, "error: source.url: is wrong\n  → change it\n"),
    (AssemblyError("has no mates"), 1, "error: has no mates\n"),
    (KeyboardInterrupt(), 130, "error: interrupted\n"),
    (PermissionError(13, "Permission denied", "outputs"), 1, "error: outputs: Permission denied\n"),
    (ZeroDivisionError("by zero"), 1, BUG),
])  # fmt: skip
def test_an_error_is_one_message_and_an_exit_status(empty, capsys, monkeypatch, error, status, shown):
    assert ended(error) == status
    assert capsys.readouterr().err == shown
    monkeypatch.setenv("LINKWRIGHT_TRACEBACK", "1")
    ended(error)
    shows = not isinstance(error, KeyboardInterrupt)
    assert ("Traceback (most recent call last)" in capsys.readouterr().err) == shows


def test_a_wrong_configuration_ends_the_command_with_2_and_leaves_nothing(empty, capsys):
    assert run(["source=sample", "mesh.tolerence=1", "name=../x"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: the configuration has 2 problems\n")
    assert list(empty.iterdir()) == []
