"""The command: options, exit status, error border."""

import os
import re
import subprocess
import sys
from importlib import import_module

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.presets import GROUPS, Presets
from linkwright.pipeline.help_text import SHORT, whole
from linkwright.pipeline.options import Command, UsageError, parse
from linkwright.pipeline.report import Report
from linkwright.pipeline.verbs import VERBS
from linkwright.stages.robot.errors import AssemblyError, ConfigError, Diagnostic
from tests.support.places import PROJECT

HEAVY = (
    "hydra",
    "omegaconf",
    "pydantic",
    "numpy",
    "trimesh",
    "scipy",
    "mujoco",
    "lxml",
    "jinja2",
    "networkx",
    "rich",
    "yaml",
)


ENVIRONMENT = {**os.environ, "PYTHONPATH": str(PROJECT)}


def command(*arguments, cwd=PROJECT, **environ):
    """Runs `python -m pipeline` in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "linkwright", *arguments],
        cwd=cwd,
        env={**ENVIRONMENT, **environ},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.fixture
def empty(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("option", "more"),
    # Of the standard library's, those that would take a third of the time of `--help`.
    [("--help", ("dataclasses", "inspect", "json", "difflib")), ("-h", ()), ("--version", ())],
)
def test_help_and_version_import_nothing_heavy(option, more):
    code = (
        "import sys; from linkwright.pipeline.cli import main; status = main(sys.argv[1:]); "
        f"print(sorted(set({(*HEAVY, *more)!r}) & set(sys.modules)), status)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, option],
        cwd=PROJECT, env=ENVIRONMENT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.splitlines()[-1] == "[] 0"


def test_help_names_every_group_and_option(tmp_path):
    presets = Presets(cwd=tmp_path)
    # Each with the lines below it that are further in.
    entries = re.findall(r"^  ([a-z]+) (.*(?:\n {14}.*)*)", whole(), re.MULTILINE)
    lines = dict(entries)
    assert set(GROUPS) <= lines.keys()
    missing = [
        (group, option)
        for group in GROUPS
        for option in presets.options(group)
        if option not in re.findall(r"[a-z][a-z0-9]*", lines[group])
    ]
    assert missing == []


def test_the_help_is_a_screen_and_all_of_it_within_80_columns():
    assert len(SHORT.splitlines()) <= 24
    for text in (SHORT, whole(), *(import_module(module).HELP for module in VERBS.values())):
        assert [line for line in text.splitlines() if len(line) > 80] == []
    assert set(GROUPS) | set(VERBS) <= {*re.findall(r"[a-z]+", SHORT)}


@pytest.mark.parametrize(("option", "first"), [("--help", SHORT), ("--help-all", whole()), ("-h", SHORT)])
def test_there_are_a_short_help_and_a_whole_one(option, first, capsys):
    assert run([option]) == 0
    assert capsys.readouterr().out == first.rstrip() + "\n"


@pytest.mark.parametrize(
    ("options", "detail"), [([], "usual"), (["-v"], "all"), (["--verbose"], "all"), (["-q"], "errors")]
)
def test_how_much_is_told_is_an_option(options, detail):
    assert parse([*options, "robot=sample"]).detail == detail


def test_quiet_and_verbose_exclude_each_other(capsys):
    assert run(["-q", "-v"]) == 2
    assert "-q and -v exclude each other" in capsys.readouterr().err


def test_an_error_of_a_stage_shows_the_worst_of_each_code(empty, capsys):
    problems = [
        Diagnostic("E-MASS", f"part {number} has no mass", f"Part {number}", "give it") for number in range(9)
    ]

    def failing(plan):
        raise AssemblyError("the assembly cannot be built: 9 problems", problems=problems)

    assert run(["source=sample"], failing) == 1
    assert capsys.readouterr().err.splitlines() == [
        "error: the assembly cannot be built: 9 problems",
        "  E-MASS ×9 Part 0: part 0 has no mass",
        "      also: Part 1, Part 2 and 6 more (-v shows all)",
        "      give it",
    ]
    assert run(["-v", "source=sample"], failing) == 1
    assert capsys.readouterr().err.count("has no mass") == 9


def test_help_names_every_verb():
    assert [verb for verb in VERBS if f"\n  linkwright {verb} " not in whole()] == []


def test_the_command_line_is_taken_apart():
    arguments = ["-m", "a=1", "--config-dir", "x", "--config-dir=y", "~b", "c=-1"]
    assert parse(arguments) == Command(("a=1", "~b", "c=-1"), ("x", "y"), multirun=True)


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [(["--nope", "job"], "there is no option --nope"), (["--config-dir"], "--config-dir needs a folder")],
)
def test_an_option_that_is_not_there_is_reported(arguments, shown, capsys):
    with pytest.raises(UsageError):
        parse(arguments)
    assert run(arguments) == 2
    assert capsys.readouterr().err.startswith(f"error: {shown}\n  → ")


@pytest.mark.parametrize("status", [0, 3])
def test_the_exit_status_is_the_reports(empty, status):
    assert run(["source=sample"], lambda plan: Report("built", plan.name, "x", plan.until, status)) == status


@pytest.mark.parametrize(
    ("error", "status", "shown"),
    [
        (
            ConfigError("is wrong", "source.url", "change it"),
            2,
            "error: source.url: is wrong\n  → change it\n",
        ),
        (AssemblyError("has no mates"), 1, "error: has no mates\n"),
        (KeyboardInterrupt(), 130, "error: interrupted\n"),
        (PermissionError(13, "Permission denied", "outputs"), 1, "error: outputs: Permission denied\n"),
        (
            ZeroDivisionError("by zero"),
            1,
            "error: a bug in linkwright: ZeroDivisionError: by zero\n"
            "  → LINKWRIGHT_TRACEBACK=1 shows where; so does build.log in the <output>.failed folder\n",
        ),
    ],
)
def test_an_error_is_one_message_and_an_exit_status(empty, capsys, error, status, shown):
    def failing(plan):
        raise error

    assert run(["source=sample"], failing) == status
    assert capsys.readouterr().err == shown


def test_a_traceback_is_shown_when_asked_for(empty, capsys, monkeypatch):
    monkeypatch.setenv("LINKWRIGHT_TRACEBACK", "1")

    def failing(plan):
        raise ZeroDivisionError

    run(["source=sample"], failing)
    assert "Traceback (most recent call last)" in capsys.readouterr().err


def test_a_wrong_configuration_ends_the_command_with_2_and_leaves_nothing(tmp_path):
    done = command("source=sample", "mesh.tolerence=1", "name=../x", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("error: the configuration has 2 problems\n")
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
