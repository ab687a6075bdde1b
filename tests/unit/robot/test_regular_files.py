"""Regular files alone are read, wherever a source names one: nothing blocks, nothing is read for ever."""

import contextlib
import os
import socket
from pathlib import Path

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.fetch import pinned, preflight
from linkwright.stages.fetch.bundle.section import BundleSourceSection
from linkwright.stages.fetch.mjcf import files
from linkwright.stages.fetch.mjcf.gather import gather as gather_mjcf
from linkwright.stages.fetch.mjcf.section import MjcfSourceSection
from linkwright.stages.fetch.urdf import survey
from linkwright.stages.fetch.urdf.gather import gather as gather_urdf
from linkwright.stages.fetch.urdf.meshes.companions import Companions, companions
from linkwright.stages.fetch.urdf.ros_packages import Packages
from linkwright.stages.fetch.urdf.section import UrdfSourceSection
from linkwright.stages.robot.errors import ConfigError, SourceError
from linkwright.stages.robot.system import guest, regular_files
from tests.support.mjcfs import model, written

HUGE = 1 << 42
"""More [bytes] than is read in any time; a file of that size takes no room."""


@pytest.fixture(autouse=True)
def _no_guest(monkeypatch):
    def never(*_):
        raise AssertionError("a guest was started")

    monkeypatch.setattr(guest, "ask", never)


def made(kind, folder, suffix=".stl"):
    """Something of a kind that is not to be read."""
    path = folder / f"x{suffix}"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as listener, contextlib.chdir(folder):
            listener.bind(path.name)  # its whole path may be longer than a socket's can be
    elif kind in ("device", "kernel"):
        path.symlink_to({"device": "/dev/zero", "kernel": "/proc/self/mountinfo"}[kind])
    elif kind == "huge":
        with path.open("wb") as file:
            file.truncate(HUGE)
    return path


KINDS = ["pipe", "socket", "device"]
SECTIONS = [UrdfSourceSection, MjcfSourceSection, BundleSourceSection]


def plan_of(source):
    return Plan.model_validate({"name": "r", "source": source})


def urdf(*meshes):
    shapes = (f'<visual><geometry><mesh filename="{n}.stl"/></geometry></visual>' for n in meshes)
    return f'<robot name="r"><link name="a">{"".join(shapes)}</link></robot>'


@pytest.mark.parametrize("kind", KINDS)
def test_special_file_is_neither_opened_nor_read(tmp_path, kind):
    path = made(kind, tmp_path)
    looks = (regular_files.is_file, regular_files.is_special, regular_files.is_endless)
    assert [look(path) for look in looks] == [False, True, True]
    for read in (regular_files.content, regular_files.digest):
        with pytest.raises(OSError, match="regular"):
            read(path, 100)


def test_file_is_read_as_long_as_the_system_says_it_is(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"abc")
    assert regular_files.content(path, 3) == b"abc"
    with pytest.raises(regular_files.FileTooLarge) as caught:
        regular_files.content(path, 2)
    assert caught.value.size == 3
    assert regular_files.digest(path, 3).startswith("ba7816bf")
    assert not regular_files.is_endless(path)
    with pytest.raises(OSError, match="directory"):
        regular_files.content(tmp_path, 3)
    assert not regular_files.is_file(Path("x" * 5000))
    assert not regular_files.is_file(Path("a\0"))


@pytest.mark.skipif(not Path("/proc/self/mountinfo").exists(), reason="there is no /proc")
def test_file_of_the_kernel_is_empty(tmp_path):
    path = made("kernel", tmp_path)
    assert (regular_files.is_file(path), regular_files.is_endless(path)) == (True, True)
    assert regular_files.content(path, 100) == b""


@pytest.mark.parametrize("kind", [*KINDS, "kernel", "huge"])
def test_mesh_of_a_urdf(tmp_path, kind):
    made(kind, tmp_path)
    source = UrdfSourceSection(path=str(written(tmp_path, urdf("x"), "r.urdf")))
    pinned(plan_of(source), {})
    with pytest.raises(SourceError) as caught:
        gather_urdf(source, {})
    (problem,) = caught.value.problems
    words = {"kernel": "it is empty", "huge": "it is larger than"}.get(kind, regular_files.NOT_REGULAR)
    assert words in problem.message


@pytest.mark.parametrize("kind", [*KINDS, "kernel", "huge"])
@pytest.mark.parametrize("text", [
    model("", '<asset><mesh file="x.stl"/></asset>'),
    model("", '<asset><texture file="sub/x.stl"/></asset>'),
    '<mujoco><include file="x.stl"/></mujoco>',
])  # fmt: skip
def test_file_of_an_mjcf(tmp_path, kind, text):
    made(kind, tmp_path)
    source = MjcfSourceSection(path=str(written(tmp_path, text)))
    for call in (lambda: pinned(plan_of(source), {}), lambda: gather_mjcf(source)):
        with pytest.raises(SourceError, match=r"it names (sub/)?x\.stl"):
            call()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("keys", SECTIONS)
def test_source_itself(tmp_path, kind, keys):
    plan = plan_of(keys(path=str(made(kind, tmp_path))))
    with pytest.raises(ConfigError, match="a device, a pipe or a socket"):
        preflight(plan, {})
    with pytest.raises(SourceError, match="it cannot be read: it is a device, a pipe or a socket"):
        pinned(plan, {})


@pytest.mark.parametrize("keys", SECTIONS)
def test_source_larger_than_is_read(tmp_path, keys):
    with pytest.raises(SourceError, match=r"4398046511104 bytes|longer than 32 MB"):
        pinned(plan_of(keys(path=str(made("huge", tmp_path)))), {})


def test_files_of_a_robot_are_bounded_together(tmp_path, monkeypatch):
    for name in ("a.stl", "b.stl"):
        (tmp_path / name).write_bytes(bytes(600))
    mjcf = written(tmp_path, model("", '<asset><mesh file="a.stl"/><mesh file="b.stl"/></asset>'))
    monkeypatch.setattr(survey, "LARGEST_ROBOT", 1000)
    monkeypatch.setattr(files, "LARGEST_MODEL", 1000)
    text = written(tmp_path, urdf("a", "b"), "r.urdf")
    for source in (UrdfSourceSection(path=str(text)), MjcfSourceSection(path=str(mjcf))):
        with pytest.raises(SourceError, match="have more than 1e-06 GB"):
            pinned(plan_of(source), {})


def test_package_whose_description_is_a_pipe_is_passed_by(tmp_path):
    (tmp_path / "p").mkdir()
    os.mkfifo(tmp_path / "p" / "package.xml")
    packages = Packages(tmp_path, {}, {"ROS_PACKAGE_PATH": str(tmp_path)})
    assert packages.find("no_such_package") is None
    assert packages.find("p") == tmp_path / "p"


def test_material_of_an_obj_that_is_a_pipe_is_none(tmp_path):
    os.mkfifo(tmp_path / "m.mtl")
    assert companions(tmp_path / "a.obj", b"mtllib m.mtl\n", []) == Companions()
