"""`--cfg` and `--info`: a configuration before it is built, and how it came to be."""

import logging

import pytest
import yaml

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.options import Command, UsageError, parse
from tests.support.stand_in_builds import ended
from tests.support.users import URL, write

MY_ARM = """\
# @package _global_
defaults:
  - override /source: sample
vars: {reach: 0.3}
mass: {density: "${oc.env:DENSITY,900}"}
joints: {"*": {limits: [-1, "${vars.reach}"]}}
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("DENSITY", "ONSHAPE_ACCESS_KEY", "ONSHAPE_SECRET_KEY"):
        monkeypatch.delenv(name, raising=False)
    return write(tmp_path, my_arm=MY_ARM)


def printed(capsys, *arguments, status=0):
    assert run(list(arguments)) == status
    return capsys.readouterr().out


def test_cfg_job_prints_the_plan_written_or_resolved(here, capsys):
    tree = yaml.safe_load(printed(capsys, "--cfg", "job", "robot=my_arm", "root=free", "--resolve"))
    assert tree == compose_plan(["robot=my_arm", "root=free"], cwd=here).plan.tree()
    assert tree["mass"]["density"] == 900
    tree = yaml.safe_load(printed(capsys, "--cfg", "job", "robot=my_arm"))
    assert tree["mass"]["density"] == "${oc.env:DENSITY,900}"
    assert tree["joints"]["*"]["limits"] == [-1, "${vars.reach}"]
    tree = yaml.safe_load(printed(capsys, "--cfg", "hydra", "robot=my_arm"))
    assert list(tree) == ["hydra"]
    assert tree["hydra"]["runtime"]["choices"]["robot"] == "my_arm"
    assert {"hydra", "mass"} <= set(yaml.safe_load(printed(capsys, "-c", "all", "robot=my_arm")))
    assert sorted(path.name for path in here.iterdir()) == ["robot"]


def test_cfg_needs_no_credentials_but_a_right_plan(here, capsys):
    assert "kind: onshape" in printed(capsys, "--cfg", "job", "source=onshape", f"source.url='{URL}'")
    assert run(["--cfg", "job", "robot=my_arm", "foo=1", "root=fred"]) == 2
    shown = capsys.readouterr().err
    assert "E-KEY foo: unknown key" in shown
    assert "E-OPTION root=fred" in shown


@pytest.mark.parametrize(("package", "text"), [
    ("mass.density", "${oc.env:DENSITY,900}\n"),
    ("ground.size", "# @package ground.size\n- 4.0\n- 4.0\n"),
    ("ground.size.1", "4.0\n"),
    ("joints.*", "# @package joints.*\n"),
    ("_global_", "name: my_arm\n"),
])  # fmt: skip
def test_a_part_of_it_is_printed_by_its_key(here, capsys, package, text):
    assert printed(capsys, "--cfg", "job", "--package", package, "robot=my_arm").startswith(text)
    printed(capsys, "--cfg", "job", "-p", f"{package}x", "robot=my_arm", status=2)


@pytest.mark.slow
def test_a_secret_is_not_printed(here, capsys, monkeypatch):
    monkeypatch.setenv("ONSHAPE_SECRET_KEY", "x9-secret-of-mine")
    write(here, my_arm=MY_ARM.replace("0.3}", "'${oc.env:ONSHAPE_SECRET_KEY}'}"))
    for option in (["--cfg", "job"], ["--cfg", "job", "--resolve"], ["--cfg", "all"], ["--info", "all"]):
        run([*option, "robot=my_arm", "vars.x=x9-secret-of-mine"])
        shown = capsys.readouterr()
        assert "x9-secret-of-mine" not in shown.out + shown.err


@pytest.mark.parametrize(("kind", "words"), [
    ("defaults-tree", ["Defaults Tree", "robot: my_arm"]),
    ("defaults", ["Defaults List", "robot/my_arm"]),
    ("searchpath", ["Config search path", "pkg://linkwright.conf"]),
    ("plugins", ["Installed Hydra Plugins", "BasicLauncher"]),
    ("config", ["kind: sample"]),
    ("all", ["Defaults Tree", "Config search path", "BasicLauncher", "kind: sample"]),
])  # fmt: skip
def test_info_shows_how_it_came_to_be(here, capsys, kind, words):
    text = printed(capsys, "--info", kind, "robot=my_arm")
    assert [word for word in words if word not in text] == []


def test_info_helps_where_the_configuration_is_wrong(here, capsys):
    assert "robot: my_arm" in printed(capsys, "--info", "defaults-tree", "robot=my_arm", "foo=1")
    assert "Defaults Tree" in printed(capsys, "-i", "robot=my_arm", "foo=1", status=2)


@pytest.mark.parametrize(("arguments", "command"), [
    (["--cfg", "job", "a=1"], Command(("a=1",), show="cfg", subject="job")),
    (["-c=all", "-p", "x"], Command(show="cfg", subject="all", package="x")),
    (["--info", "a=1"], Command(("a=1",), show="info", subject="all")),
    (["-i", "defaults"], Command(show="info", subject="defaults")),
    (["--run", "a=1"], Command(("a=1",))),
    (["--install-completion"], Command(show="install-completion")),
    (["--install-completion", "zsh"], Command(show="install-completion", subject="zsh")),
    (["-m", "a=1", "--config-dir", "x", "--config-dir=y", "~b", "c=-1"],
     Command(("a=1", "~b", "c=-1"), ("x", "y"), multirun=True)),
    (["-v", "a=1"], Command(("a=1",), detail="all")), (["--verbose"], Command(detail="all")),
    (["-q"], Command(detail="errors")),
])  # fmt: skip
def test_options_are_read(arguments, command):
    assert parse(arguments) == command


@pytest.mark.parametrize(("arguments", "shown"), [
    (["--cfg"], "--cfg needs a word\n  → --cfg job"),
    (["--cfg", "jobs"], "--cfg knows no jobs\n  → --cfg job, or one of: job, hydra, all"),
    (["--info=x"], "--info knows no x"),
    (["-m", "--cfg", "job"], "--cfg shows one configuration, and a sweep has many"),
    (["--resolve"], "--package and --resolve belong to --cfg\n  → linkwright --cfg job --resolve"),
    (["--config-name", "x"], "there is no option --config-name here\n  → a robot is a file"),
    (["-cp", "x"], "there is no option -cp here\n  → add a folder of your own"),
    (["--nope"], "there is no option --nope\n  → linkwright --help"),
    (["--config-dir"], "--config-dir needs a folder\n  → "),
    (["-q", "-v"], "-q and -v exclude each other\n  → "),
    (["-m", "--plan", "root=fixed,free"], "--plan needs a file"),
])  # fmt: skip
def test_an_option_that_cannot_be_is_reported(arguments, shown):
    with pytest.raises(UsageError) as caught:
        parse(arguments)
    assert str(caught.value).startswith(shown)


@pytest.mark.slow
def test_info_speaks_also_after_a_sweep_in_the_same_process(here, capsys):
    """A sweep's logging quiets Hydra, and switches off the loggers that were there before it."""
    sweep = ["-m", "robot=my_arm", "root=auto,free", "hydra/launcher=basic"]
    assert run(sweep, ended) == 0
    assert logging.getLogger("hydra").level == logging.WARNING
    for name in [name for name in logging.root.manager.loggerDict if name.startswith("hydra.")]:
        logging.getLogger(name).disabled = True
    capsys.readouterr()
    assert "robot: my_arm" in printed(capsys, "--info", "defaults-tree", "robot=my_arm")
    assert logging.getLogger("hydra").level == logging.WARNING
