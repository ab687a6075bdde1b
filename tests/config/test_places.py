"""Folders that a robot's file names for results are below the working folder; others may be anywhere."""

from itertools import product
from pathlib import Path

import pytest

from linkwright.pipeline.api.arguments import plan_of
from linkwright.pipeline.cli import run
from linkwright.pipeline.errors import ConfigError
from tests.support.users import GLOBAL, SAMPLE, composed, put, refused, write

BELOW = "output: a file must name a folder below"


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
    return composed(Path(), *arguments, **more).plan.output


@pytest.mark.parametrize(
    "place",
    ["./out", "a/b/../c", "outputs/arm", "~/work/arm", "a/../../work/arm", "${vars.at}/arm", "{here}/arm"],
)  # fmt: skip
def test_place_below_the_working_folder_is_allowed(work, place):
    place = place.replace("{here}", str(work))
    write(work, mine=f"{SAMPLE}output: '{place}'\nvars: {{at: below}}\n")
    assert output_of("robot=mine") == place.replace("${vars.at}", "below")


OUTSIDE = [
    "/etc", "/tmp/out", "~", "~/out", "~/.ssh", "..", ".", "../out", "a/../../out", "../workings/arm",
    "outputs/../../out", "${vars.at}/arm", "${oc.env:HOME}/.ssh", "${oc.env:NONE,/etc}", "${vars.home}",
]  # fmt: skip
FEW = ("/etc", "../out", "${vars.at}/arm")


# A single function checks all files, so the robot's has every place, and the others have a few.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "place"), [*(("robot", place) for place in OUTSIDE), *product(("experiment", "config dir"), FEW)]
)
def test_place_elsewhere_is_refused_in_each_kind_of_file(work, tmp_path, kind, place):
    text = f"output: '{place}'\nvars: {{at: /abs, home: '${{oc.env:HOME}}'}}\n"
    folders, arguments = [], ["robot=mine"]
    if kind == "experiment":
        put(write(work, mine=SAMPLE), {"experiment/far.yaml": GLOBAL + text})
        arguments.append("+experiment=far")
    elif kind == "config dir":
        folders = [write(tmp_path / "robots", mine=SAMPLE + text)]
    else:
        write(work, mine=SAMPLE + text)
    shown = refused(work, *arguments, dirs=folders)
    assert f"E-TRUST {BELOW}" in shown
    assert "if you want it there: linkwright " in shown
    assert "output=" in shown
    assert output_of(*arguments, "output=/abs/arm", dirs=folders) == "/abs/arm"


def test_command_line_environment_and_python_name_any_place(work, monkeypatch):
    write(work, mine=f"{SAMPLE}output: /abs/arm\n", env=f"{SAMPLE}output: ${{oc.env:OUT}}\n")
    assert output_of("robot=mine", "output=/abs/leg") == "/abs/leg"
    assert output_of("robot=mine", environ={"LINKWRIGHT_TRUST": "robot/mine.yaml"}) == "/abs/arm"
    monkeypatch.setenv("OUT", "/abs/of/the/environment")
    assert output_of("robot=env") == "/abs/of/the/environment"
    data = {"source": {"kind": "sample"}, "output": "/abs/data"}
    for arguments, named, expected in (
        (["robot=mine"], "/abs/leg", "/abs/leg"),
        ([data], None, "/abs/data"),
        ([data, "output=/abs/typed"], None, "/abs/typed"),
        ([data], Path("/abs/given"), "/abs/given"),
    ):
        assert plan_of(arguments, False, (), named, ()).output == expected


@pytest.mark.parametrize("robot", ["robot=mine", "robot/mine.yaml"])
def test_place_of_a_file_is_an_argument_in_python(work, robot):
    write(work, mine=f"{SAMPLE}output: /abs/arm\n")
    with pytest.raises(ConfigError, match=r"linkwright\.build\(\.\.\., output=\.\.\.\)"):
        plan_of([robot], False, (), None, ())


def test_the_working_folder_may_be_reached_by_a_link(work, tmp_path, monkeypatch):
    (tmp_path / "by").symlink_to(work)
    write(work, mine=f"{SAMPLE}output: {tmp_path / 'by' / 'arm'}\n")
    assert BELOW in refused(work, "robot=mine")
    monkeypatch.setenv("PWD", str(tmp_path / "by"))
    assert output_of("robot=mine") == str(tmp_path / "by" / "arm")
    monkeypatch.setenv("PWD", str(tmp_path))
    assert BELOW in refused(work, "robot=mine")


DIR = "hydra.sweep.dir: a file must name a folder below"


@pytest.mark.parametrize(("keys", "shown"), [
    ("output: /abs/arm", BELOW),
    ("hydra: {sweep: {dir: /abs/arm}}", DIR),
    ("hydra: {sweep: {dir: '~/${name}'}}", DIR),
    ("hydra: {sweep: {dir: '${oc.env:HOME}'}}", DIR),
    ("hydra: {sweeper: {params: {output: /abs/arm}}}", "hydra.sweeper.params.output: a file must not"),
])  # fmt: skip
def test_so_is_the_folder_of_a_sweep(work, capsys, keys, shown):
    write(work, mine=f"{SAMPLE}{keys}\n")
    before = sorted(work.parent.parent.rglob("*"))
    assert run(["-m", "robot=mine", "root=auto,free"], pytest.fail) == 2
    assert shown in capsys.readouterr().err
    assert sorted(work.parent.parent.rglob("*")) == before


def test_a_link_below_the_working_folder_is_followed(work, tmp_path):
    write(work, mine=f"{SAMPLE}output: outputs/arm\n")
    assert run(["robot=mine", "until=fetch"]) == 0
    assert (tmp_path / "scratch" / "arm.fetch" / "report.json").is_file()
    assert (work / "outputs").is_symlink()
