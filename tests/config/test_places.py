"""Folders that a robot's file names for results lie below the working folder; others may be anywhere."""

from itertools import product
from pathlib import Path

import pytest

from linkwright.pipeline.api.arguments import plan_of
from linkwright.pipeline.cli import run
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.report import Report
from tests.support.users import write

SAMPLE = "# @package _global_\ndefaults:\n  - override /source: sample\n"
KINDS = ["robot", "experiment", "config dir"]


@pytest.fixture(autouse=True)
def work(tmp_path, monkeypatch):
    """The working folder, in a home folder, with a link to a folder elsewhere."""
    folder = tmp_path / "home" / "work"
    folder.mkdir(parents=True)
    (tmp_path / "scratch").mkdir()
    (folder / "outputs").symlink_to(tmp_path / "scratch")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("PWD", str(folder))
    monkeypatch.delenv("LINKWRIGHT_TRUST", raising=False)
    monkeypatch.chdir(folder)
    return folder


def output_of(*arguments, **more):
    plan = compose_plan(arguments, **more).plan
    return plan.output


def refused(*arguments, **more):
    with pytest.raises(ConfigError, match="E-TRUST output: a file must name a folder below") as caught:
        compose_plan(arguments, **more)
    return str(caught.value)


@pytest.mark.parametrize(
    "place",
    [
        "out",
        "./out",
        "a/b/../c",
        "outputs/arm",
        "~/work/arm",
        "a/../../work/arm",
        "${vars.at}/arm",
        "{here}/arm",
    ],
)
def test_a_place_below_the_working_folder_as_it_is_written_is_allowed(work, place):
    place = place.replace("{here}", str(work))
    write(work, mine=f"{SAMPLE}output: '{place}'\nvars: {{at: below}}\n")
    assert output_of("robot=mine") == place.replace("${vars.at}", "below")


OUTSIDE = [
    "/etc",
    "/tmp/out",
    "~",
    "~/out",
    "~/.ssh",
    "..",
    ".",
    "../out",
    "a/../../out",
    "../workings/arm",
    "outputs/../../out",
    "${vars.at}/arm",
    "${oc.env:HOME}/.ssh",
    "${oc.env:NONE,/etc}",
    "${vars.home}",
]


# One judge looks at all files, so the robot's has every place, and the others have a few.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "place"),
    [*(("robot", place) for place in OUTSIDE), *product(KINDS[1:], ("/etc", "../out", "${vars.at}/arm"))],
)
def test_a_place_elsewhere_is_refused_in_each_kind_of_file_and_the_hint_types_it(work, tmp_path, kind, place):
    text = f"output: '{place}'\nvars: {{at: /abs, home: '${{oc.env:HOME}}'}}\n"
    folders, arguments = [], ["robot=mine"]
    if kind == "experiment":
        write(work, mine=SAMPLE)
        (work / "experiment").mkdir()
        (work / "experiment" / "far.yaml").write_text(f"# @package _global_\n{text}")
        arguments = ["robot=mine", "+experiment=far"]
    elif kind == "config dir":
        folders = [write(tmp_path / "robots", mine=SAMPLE + text)]
    else:
        write(work, mine=SAMPLE + text)
    assert "if you want it there: linkwright " in (shown := refused(*arguments, config_dirs=folders))
    assert "output=" in shown
    assert output_of(*arguments, "output=/abs/arm", config_dirs=folders) == "/abs/arm"


def test_the_command_line_the_environment_and_python_may_name_any_place(work, monkeypatch):
    write(work, mine=f"{SAMPLE}output: /abs/arm\n", env=f"{SAMPLE}output: ${{oc.env:OUT}}\n")
    assert output_of("robot=mine", "output=/abs/leg") == "/abs/leg"
    assert output_of("robot=mine", environ={"LINKWRIGHT_TRUST": "robot/mine.yaml"}) == "/abs/arm"
    monkeypatch.setenv("OUT", "/abs/of/the/environment")
    assert output_of("robot=env") == "/abs/of/the/environment"
    assert plan_of(["robot=mine"], False, (), "/abs/leg", ()).output == "/abs/leg"
    data = {"source": {"kind": "sample"}, "output": "/abs/data"}
    assert plan_of([data], False, (), None, ()).output == "/abs/data"
    assert plan_of([data, "output=/abs/typed"], False, (), None, ()).output == "/abs/typed"
    assert plan_of([data], False, (), Path("/abs/given"), ()).output == "/abs/given"


def test_python_refuses_the_place_of_a_file_and_shows_its_argument(work):
    write(work, mine=f"{SAMPLE}output: /abs/arm\n")
    for robot in ("robot=mine", "robot/mine.yaml"):
        with pytest.raises(ConfigError, match=r"linkwright\.build\(\.\.\., output=\.\.\.\)"):
            plan_of([robot], False, (), None, ())


def test_the_working_folder_may_be_reached_by_a_link(work, tmp_path, monkeypatch):
    (tmp_path / "by").symlink_to(work)
    write(work, mine=f"{SAMPLE}output: {tmp_path / 'by' / 'arm'}\n")
    refused("robot=mine")
    monkeypatch.setenv("PWD", str(tmp_path / "by"))
    assert output_of("robot=mine") == str(tmp_path / "by" / "arm")
    monkeypatch.setenv("PWD", str(tmp_path))
    refused("robot=mine")


@pytest.mark.parametrize(
    ("keys", "shown"),
    [
        ("output: /abs/arm", "output: a file must name a folder below"),
        ("hydra: {sweep: {dir: /abs/arm}}", "hydra.sweep.dir: a file must name a folder below"),
        ("hydra: {sweep: {dir: '~/${name}'}}", "hydra.sweep.dir: a file must name a folder below"),
        ("hydra: {sweep: {dir: '${oc.env:HOME}'}}", "hydra.sweep.dir: a file must name a folder below"),
        ("hydra: {sweeper: {params: {output: /abs/arm}}}", "hydra.sweeper.params.output: a file must not"),
    ],
)
def test_so_is_the_folder_of_a_sweep(work, capsys, keys, shown):
    write(work, mine=f"{SAMPLE}{keys}\n")
    plans = []

    def build(plan):
        plans.append(plan)
        return Report("built", plan.name, str(plan.folder), plan.until, 0)

    before = sorted(work.parent.parent.rglob("*"))
    assert run(["-m", "robot=mine", "root=auto,free"], build) == 2
    assert shown in capsys.readouterr().err
    assert plans == []
    assert sorted(work.parent.parent.rglob("*")) == before


def test_a_link_below_the_working_folder_is_followed(work, tmp_path):
    write(work, mine=f"{SAMPLE}output: outputs/arm\n")
    assert run(["robot=mine", "until=fetch"]) == 0
    assert (tmp_path / "scratch" / "arm.fetch" / "report.json").is_file()
    assert (work / "outputs").is_symlink()
