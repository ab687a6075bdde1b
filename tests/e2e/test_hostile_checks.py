"""`linkwright check` of files that were written to hang it, to use up memory, or to crash what reads them:
each is one message within 5 s of the processor and 1 GB."""

import os
import shutil

import pytest

from tests.support.building import plan_of, write
from tests.support.command import COMMAND, environment
from tests.support.hostile_checks import ANSWERED, BESIDE, BUILDS, ONE
from tests.support.measured import measured
from tests.support.robots import joint, robot_with

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name == "nt", reason="it has no pipes")]

SECONDS, MEMORY = 5.0, 1 << 30
WAITS = 120
"""By the clock [s], whatever else the machine does."""


def held(here, *arguments):
    done = measured([str(COMMAND), "check", *arguments], here, environment(here), WAITS)
    assert not [word for word in ("Traceback", "a bug in linkwright", "root:") if word in done.shown], (
        done.shown[-2000:]
    )
    assert done.seconds < SECONDS, (done.seconds, done.shown[-500:])
    assert done.memory < MEMORY, (done.memory, done.shown[-500:])
    return done


def refused(here, *arguments):
    """One message: the file is not read, or a check that fails says what stops it."""
    done = held(here, *arguments)
    lines = done.shown.splitlines()
    if done.status == 3:
        failed = [line for line in lines if line.startswith("FAILED")]
        assert {line.split()[1] for line in failed} <= {"C-COMPILE", "C-XML"}, done.shown[-2000:]
    else:
        assert done.status == 1, done.shown[-2000:]
        assert len([line for line in lines if line.startswith("error:")]) == 1, done.shown


def put(folder, files):
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if callable(content):
            content(path)
        else:
            path.write_bytes(content.encode() if isinstance(content, str) else content)


@pytest.mark.parametrize("name", ONE)
def test_a_hostile_model_is_refused(tmp_path, name):
    put(tmp_path / "r", ONE[name])
    refused(tmp_path, f"r/{next(iter(ONE[name]))}")


@pytest.mark.parametrize("name", ["replicates", "a pipe", "mesh from a device", "URDF: mesh from a pipe"])
def test_so_is_a_folder_with_it(tmp_path, name):
    put(tmp_path / "r", ONE[name])
    if name == "a pipe":
        put(tmp_path / "r", {"other.xml": "<mujoco/>"})
    refused(tmp_path, "r")


@pytest.mark.parametrize("name", BUILDS)
def test_a_folder_with_a_hostile_robot_json_is_refused(tmp_path, name):
    put(tmp_path / "r", BUILDS[name])
    refused(tmp_path, "r")


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("build") / "r"
    formats = {"urdf": {}, "mjcf": {}, "sdf": {}, "usd": {}}
    write(robot_with([joint("revolute", "base", "arm", [0.1])]), folder, plan_of(export=formats))
    return folder


@pytest.mark.parametrize("name", BESIDE)
def test_a_build_with_what_is_no_file_is_refused(tmp_path, built, name):
    shutil.copytree(built, tmp_path / "r")
    path = name.format("robot")
    (tmp_path / "r" / path).unlink(missing_ok=True)
    put(tmp_path / "r", {path: BESIDE[name]})
    refused(tmp_path, "r")


@pytest.mark.parametrize("name", ANSWERED)
@pytest.mark.parametrize("form", [(), ("--json",)], ids=["text", "json"])
def test_a_broken_model_is_answered(tmp_path, name, form):
    put(tmp_path / "r", ANSWERED[name])
    assert held(tmp_path, *form, f"r/{next(iter(ANSWERED[name]))}").status in (1, 3)
