"""`pytest --linkwright`, as users run it in a repository of robots."""

import os
import re
import shlex
import sys

import pytest
import yaml

from tests.support.cases import mostly_slow
from tests.support.command import environment, run_in
from tests.support.pages import blocks, page
from tests.support.places import PROJECT
from tests.support.users import MY_ARM, write

pytestmark = pytest.mark.slow

HEAD = "# @package _global_\n"
PAIR = f"{HEAD}defaults:\n  - override /source: urdf\nsource: {{path: pair.urdf}}\n"
BODY = '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
URDF = (
    f'<robot name="pair"><link name="a">{BODY}</link><link name="b">{BODY}</link>'
    '<joint name="hinge" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>'
    "</robot>"
)
OWN = """\
import sys

def test_nothing_of_linkwright_is_loaded_but_its_plug_in():
    loaded = {name for name in sys.modules if name.partition(".")[0] == "linkwright"}
    assert loaded == {"linkwright", "linkwright.pytest_plugin"}
"""


@pytest.fixture
def here(tmp_path):
    """A repository with a robot that builds, one from Onshape, an experiment, and a test of its own."""
    (tmp_path / "pair.urdf").write_text(URDF)
    (tmp_path / "experiment").mkdir()
    (tmp_path / "experiment" / "wide.yaml").write_text(
        f"{HEAD}defaults:\n  - override /robot: pair\nground: {{size: [9, 9]}}\n"
    )
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "test_own.py").write_text(OWN)
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = -p no:cacheprovider\ntestpaths = tests\n")
    return write(tmp_path, pair=PAIR, arm=MY_ARM)


def run_pytest(folder, *arguments, **environ):
    """Runs pytest in a folder, whatever runs this test."""
    variables = environment(folder, seeded=False, **environ)
    return run_in(folder, sys.executable, "-m", "pytest", *arguments, environ=variables)


def ended(run):
    """The outcome as pytest counts it: "1 failed, 2 passed"."""
    summary = re.search(r"((?:\d+ \w+(?:, )?)+) in [\d.]+", run.stdout)
    assert summary, run.stdout + run.stderr
    return summary[1]


def test_nothing_happens_where_it_is_not_asked_for(here):
    done = run_pytest(here)
    assert (done.returncode, ended(done)) == (0, "1 passed"), done.stdout
    assert not (here / "snapshots").exists()


@pytest.mark.slow
def test_a_repository_is_tested_renewed_and_tested_again(here):
    missing = run_pytest(here, "--linkwright", "--deselect", "tests")
    assert missing.returncode == 1
    assert ended(missing) == "3 failed, 1 passed, 1 deselected"
    assert "there is no snapshot of robot=pair" in missing.stdout
    assert "pytest --linkwright-update" in missing.stdout
    made = run_pytest(here, "--linkwright-update", "--deselect", "tests")
    assert (made.returncode, ended(made)) == (0, "4 passed, 1 deselected"), made.stdout
    assert "snapshots/pair.txt: made" in made.stdout
    names = {file.name for file in (here / "snapshots").iterdir()}
    assert names == {"arm.txt", "pair.txt", "pair_wide.txt"}
    again = run_pytest(here, "--linkwright", "-n", "2", "--deselect", "tests")
    assert (again.returncode, ended(again)) == (0, "4 passed"), again.stdout


@pytest.mark.slow
def test_a_failure_shows_the_keys_and_figures_that_changed(here):
    run_pytest(here, "--linkwright-update")
    write(here, pair=f"{PAIR}joints: {{hinge: {{damping: 0.5}}}}\n")
    (here / "pair.urdf").write_text(URDF.replace('value="2"', 'value="3"', 1))
    (here / "robot" / "arm.yaml").unlink()
    write(here, broken=f"{PAIR}foo: 1\n")
    done = run_pytest(here, "--linkwright", "-k", "pair or broken or left", "-n", "2")
    assert (done.returncode, ended(done)) == (1, "3 failed"), done.stdout
    changed, mass = "joints.hinge.damping: (default) → 0.5", "\n    mass: 4.0 → 5.0\n"
    words = (changed, mass, "snapshots/arm.txt: left over", "robot=broken: error", "E-KEY foo")
    assert [word for word in words if word not in done.stdout] == []
    assert "Traceback" not in done.stdout
    (here / "robot" / "broken.yaml").unlink()
    update = run_pytest(here, "--linkwright-update", "-n", "2", "--deselect", "tests")
    assert (update.returncode, ended(update)) == (0, "3 passed"), update.stdout
    assert changed in update.stdout
    assert "snapshots/arm.txt: removed" in update.stdout
    assert ended(run_pytest(here, "--linkwright", "--deselect", "tests")) == "3 passed, 1 deselected"


def test_whatever_reaches_for_the_network_fails_and_the_next_test_may(here):
    run_pytest(here, "--linkwright-update")
    (here / "conftest.py").write_text(
        "import socket\n"
        "import linkwright.pipeline.stages.stage as stage\n"
        "def fetch(*_):\n"
        "    socket.create_connection(('127.0.0.1', 9))\n"
        "stage.fetch = fetch\n"
    )
    (here / "tests" / "test_own.py").write_text(
        "import socket\n"
        "def test_own():\n"
        "    with socket.create_server(('127.0.0.1', 0)) as server:\n"
        "        socket.create_connection(server.getsockname()).close()\n"
    )
    done = run_pytest(here, "--linkwright", LINKWRIGHT_CACHE=str(here / "another"))
    assert ended(done) == "2 failed, 3 passed"
    assert "a snapshot is made without the network, and something reached for it" in done.stdout
    assert "127.0.0.1:9" in done.stdout


def test_the_settings_name_other_folders(here):
    (here / "tests" / "test_own.py").unlink()
    inside = here / "inside"
    inside.mkdir()
    for name in ("robot", "experiment", "pair.urdf"):
        (here / name).rename(inside / name)
    write(here / "more", extra=PAIR)
    settings = "linkwright_folder = inside\nlinkwright_config_dirs =\n    more\n"
    (here / "pytest.ini").write_text((here / "pytest.ini").read_text() + settings)
    done = run_pytest(here / "tests", "--linkwright-update")
    assert (done.returncode, ended(done)) == (0, "5 passed"), done.stdout
    assert (inside / "snapshots" / "extra.txt").is_file()


@pytest.mark.parametrize("more", mostly_slow(["", "-n2"], keep=1), ids=["alone", "in parallel"])
def test_a_repository_without_robots_is_told(tmp_path, more):
    done = run_pytest(tmp_path, "--linkwright", *filter(None, [more]))
    assert done.returncode == 4
    assert "there is no robot" in done.stderr + done.stdout
    assert "Traceback" not in done.stderr + done.stdout


def test_the_commands_of_the_ci_file_run_where_they_can(here):
    steps = yaml.safe_load(blocks("docs/operate/snapshots.md")["ci"])["jobs"]["snapshots"]["steps"]
    install, test = (shlex.split(step["run"]) for step in steps if "run" in step)
    assert install == ["python", "-m", "pip", "install", "-r", "requirements.txt"]
    assert test[:3] == ["python", "-m", "pytest"]
    assert all(re.fullmatch(r"actions/[\w-]+@v\d+", step["uses"]) for step in steps if "uses" in step)
    run_pytest(here, "--linkwright-update")
    assert ended(run_pytest(here, *test[3:], "--deselect", "tests")) == "4 passed, 1 deselected"


def test_the_page_has_the_settings_and_options_that_there_are(here):
    output, text = run_pytest(here, "--help").stdout, page("docs/operate/snapshots.md")
    words = ("--linkwright", "--linkwright-update", "linkwright_folder", "linkwright_config_dirs")
    assert [word for word in words if word not in output or word not in text] == []


@pytest.mark.slow
def test_our_own_tests_are_collected_as_without_the_plug_in():
    command = [sys.executable, "-m", "pytest", "--collect-only", "-qq", "-p", "no:cacheprovider"]
    command += ["tests/unit/pipeline", "tests/config"]
    runs = [run_in(PROJECT, *command, *more, environ=os.environ) for more in ((), ("-p", "no:linkwright"))]
    assert runs[0].stdout == runs[1].stdout
    assert runs[0].returncode == runs[1].returncode == 0
