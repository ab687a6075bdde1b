"""A full disk: one clear message wherever it is met, and before a call is paid where it can be known."""

import contextlib
import errno
import json
import os
import subprocess

import pytest
from trimesh.creation import icosphere

from linkwright.pipeline.caching import actions, disk_space
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.cli import run
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import CacheError, LinkwrightError, OutputError
from linkwright.pipeline.output.folder import FAILED, Output
from linkwright.pipeline.run.build import build
from linkwright.stages.fetch.onshape.api.ledger import Ledger
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import environment, linkwright
from tests.support.faulty import desk
from tests.support.outputs import OURS
from tests.support.stand_in_builds import ended

FULL = {errno.ENOSPC: "the disk is full", errno.EDQUOT: "the disk quota is used up"}


def plan(here, source, **more):
    data = {"name": "desk", "source": source, "output": str(here / "out" / "desk"), "until": "fetch"}
    return Plan.parse({**data, "cache": {"dir": str(here / "cache")}, **more})


@pytest.fixture
def server():
    with OnshapeServer(desk()) as server:
        yield server


@pytest.fixture
def asked(tmp_path, server):
    """The plan of a fetch."""
    return plan(tmp_path, {"kind": "onshape", "url": server.document_url()})


def no_space(*_, **__):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@contextlib.contextmanager
def disk(place, kilobytes):
    """A disk of that size at `place`, or a skipped test where none can be made."""
    place.mkdir(exist_ok=True)
    options = ["-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(place)]
    if os.geteuid() != 0 or subprocess.run(["mount", *options], capture_output=True, check=False).returncode:
        pytest.skip("only root may mount a small disk")
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


def refuse(monkeypatch, number, where, name="posix_fallocate"):
    """Lets the system say that there is no room, for a file that is in `where`."""
    real = getattr(os, name)

    def refusing(handle, *arguments):
        if str(where) in os.readlink(f"/proc/self/fd/{handle}"):  # noqa: PTH115
            raise OSError(number, os.strerror(number))
        return real(handle, *arguments)

    monkeypatch.setattr(os, name, refusing)


@pytest.mark.skipif(not os.path.exists("/proc/self/fd"), reason="needs /proc")  # noqa: PTH110
@pytest.mark.parametrize("number", list(FULL))
@pytest.mark.parametrize("call", ["posix_fallocate", "fsync"])
@pytest.mark.parametrize(("full", "kind"), [("out", OutputError), ("cache", CacheError)])
def test_no_call_is_spent_where_there_is_no_room_for_its_reply(
    tmp_path, monkeypatch, server, asked, number, call, full, kind
):
    refuse(monkeypatch, number, tmp_path / full, call)
    with pytest.raises(kind, match=FULL[number]) as caught:
        build(asked, environ=server.environ)
    assert server.calls == []
    assert "free space there" in caught.value.hint
    assert str(tmp_path / full) in caught.value.where


@pytest.mark.parametrize("full", ["out", "cache"])
def test_no_call_is_spent_on_a_disk_that_is_really_full(tmp_path, server, asked, full):
    with disk(tmp_path / full, 600):
        with pytest.raises(LinkwrightError, match="the disk is full"):
            build(asked, environ=server.environ)
        assert server.calls == []
        report = json.loads((tmp_path / "out" / "desk.failed" / "report.json").read_bytes())
        assert "the disk is full" in report["error"]["message"]


def test_reserved_room_is_that_of_the_last_build(tmp_path, monkeypatch, server, asked):
    held, most = [], []
    taken = disk_space.reserved

    @contextlib.contextmanager
    def counted(folder, size):
        with taken(folder, size):
            held.append(size)
            most.append(list(held))
            yield
            held.pop()

    monkeypatch.setattr(disk_space, "reserved", counted)
    build(asked, environ=server.environ)
    assert most[-1] == [disk_space.MIN_FREE_BYTES] * 2
    Output(asked.folder).publish({"report.json": OURS, "assets/a": b"x" * 2_000_000})
    build(asked, environ=server.environ)
    assert most[-1] == [2_000_000 + len(OURS)] * 2
    shown = len(most)
    build(plan(tmp_path, {"kind": "onshape", "url": server.document_url(), "offline": True}), environ={})
    build(plan(tmp_path, {"kind": "sample"}, output=str(tmp_path / "sample")), environ={})
    assert len(most) == shown, "no call, no probe"
    assert not [path for path in tmp_path.rglob("*") if path.name.startswith("room-")]


@pytest.mark.parametrize("lacks", [None, errno.EINVAL, errno.ENOTSUP])
def test_room_is_measured_by_writing_if_need_be(tmp_path, monkeypatch, lacks):
    def refuse(*_):
        raise OSError(lacks, os.strerror(lacks))

    if lacks is None:
        monkeypatch.delattr(os, "posix_fallocate")
    else:
        monkeypatch.setattr(os, "posix_fallocate", refuse)
        monkeypatch.setattr(os, "fsync", refuse)
    with disk_space.reserved(tmp_path, 2_500_000):
        pass
    assert list(tmp_path.iterdir()) == []
    small = disk_space.reserved(tmp_path / "small", 1_000_000)
    with disk(tmp_path / "small", 600), pytest.raises(OSError, match="No space"), small:
        pass


def test_store_and_output_on_a_full_disk_lose_nothing(tmp_path):
    place = tmp_path / "small"
    with disk(place, 600):
        store, output = Store(place / "cache"), Output(place / "arm")
        output.publish({"report.json": OURS, "a": b"1"})
        digest = store.put(b"kept")
        for act in (
            lambda: output.publish({"report.json": OURS, "a": os.urandom(900_000)}),
            lambda: output.publish({"report.json": OURS, "a": os.urandom(900_000)}, FAILED),
            lambda: store.put(os.urandom(900_000)),
            lambda: store.scratch({"a": os.urandom(900_000)}).__enter__(),
        ):
            with pytest.raises((OutputError, CacheError), match="the disk is full"):
                act()
        assert (output.target / "a").read_bytes() == b"1"
        assert store.get(digest) == b"kept"
        assert sorted(path.name for path in place.iterdir()) == [".linkwright", "arm", "cache"]
        assert [path for path in (place / "cache" / "tmp").rglob("*") if path.is_file()] == []


def test_a_temporary_folder_that_cannot_be_made_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(actions.tempfile, "TemporaryDirectory", no_space)
    with pytest.raises(CacheError, match="no temporary folder can be made: the disk is full") as caught:
        build(plan(tmp_path, {"kind": "sample"}, cache={"mode": "bypass"}), environ={})
    assert "TMPDIR" in caught.value.hint


def test_ledger_that_cannot_be_written_loses_no_reply(monkeypatch, server, asked):
    lines = []

    class Ears:
        def __getattr__(self, name):
            return lambda *words: lines.append(" ".join(map(str, words)))

    monkeypatch.setattr("linkwright.stages.fetch.onshape.api.ledger._append", no_space)
    assert build(asked, Ears(), server.environ).exit_status == 0
    assert server.count > 1
    (line,) = [line for line in lines if "API calls are not counted" in line]
    assert "No space left" in line


@pytest.mark.parametrize("room_for", [0, 5])
def test_cut_line_of_the_ledger_is_not_counted(tmp_path, monkeypatch, room_for):
    ledger = Ledger(tmp_path, "0123456789abcdef", 2026)
    assert ledger.note("elements", 200) == ""
    write = os.write
    with monkeypatch.context() as patched:
        patched.setattr(os, "write", lambda handle, line: write(handle, line[:room_for]))
        assert "No space left" in ledger.note("elements", 200)
    assert ledger.note("elements", 200) == ""
    assert ledger.counted() == 2


@pytest.mark.parametrize("kilobytes", [4, 12, 40])
def test_sweep_on_a_full_disk_shows_how_its_jobs_ended(tmp_path, monkeypatch, capsys, kilobytes):
    monkeypatch.chdir(tmp_path)

    def filling(plan):
        with contextlib.suppress(OSError), open("small/filling", "wb") as file:
            file.write(b"x" * 100_000)
        return ended(plan)

    with disk(tmp_path / "small", kilobytes):
        status = run(["-m", "source=sample", "root=auto,free", "output=small/sweep"], filling)
        out, err = capsys.readouterr()
    assert status == 1
    assert err.count("error:") == 1
    assert "small/sweep: the output folder cannot be written: the disk is full" in err
    assert "Traceback" not in err
    if "job 1 ended" in err:
        assert "2 of 2 jobs built and valid" in out


TENSOR = '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
SOLID = f'<inertial><mass value="1"/>{TENSOR}</inertial>'
MESH = """<geometry><mesh filename="ball.stl"/></geometry>"""
LINK = f"<link name='{{}}'>{SOLID}<visual>{MESH}</visual><collision>{MESH}</collision></link>"
ARM = f"""<robot name="arm">{LINK.format("base")}{LINK.format("hand")}
<joint name="wrist" type="revolute"><parent link="base"/><child link="hand"/><origin xyz="0 0 0.5"/>
  <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="5" velocity="2"/></joint></robot>"""


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [["cache.mode=use"], ["cache.mode=bypass"], ["-m", "root=auto,free"]])
def test_command_on_any_disk_ends_well_or_with_one_message(tmp_path, arguments):
    # A small robot, which is quickly made: the files that fill the disk are the same.
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "ball.stl").write_bytes(icosphere(subdivisions=3, radius=0.1).export(file_type="stl"))
    arguments = [*arguments, "source=urdf", f"source.path={tmp_path / 'arm.urdf'}", "mesh=hull"]

    def environ(here):
        return environment(here, seeded=False, TMPDIR=str(here))

    with disk(tmp_path / "small", 100_000):
        here = tmp_path / "small"
        assert linkwright(here, *arguments, environ=environ(here)).returncode == 0
        used = int(subprocess.check_output(["du", "-sk", str(here)], text=True).split()[0])
    statuses = []
    for kilobytes in [4, 24, *range(60, used, used // 5), 100_000]:
        with disk(tmp_path / "small", kilobytes):
            done = linkwright(here, *arguments, environ=environ(here))
            statuses.append(done.returncode)
            assert done.returncode in (0, 1), done.stderr
            assert "Traceback" not in done.stderr
            if done.returncode:
                assert "disk is full" in done.stderr + done.stdout, (kilobytes, done.stderr)
                assert done.stderr.count("error:") <= 1
            subprocess.run(["mount", "-o", "remount,size=100000k", str(here)], check=True)
            assert linkwright(here, *arguments, environ=environ(here)).returncode == 0
    assert statuses[0] == 1
    assert statuses[-1] == 0
