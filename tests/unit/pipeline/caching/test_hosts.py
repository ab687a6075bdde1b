"""Many processes on one cache: killed ones, and hosts with other clocks, no locks, or a lost file system."""

import errno
import fcntl
import json
import os
import random
import re
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from linkwright.pipeline.caching import maintenance, shared
from linkwright.pipeline.caching.actions import Action, Cache
from linkwright.pipeline.caching.store import MAX_TEMPORARY_AGE, Store
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import CacheError
from linkwright.pipeline.output import manifest
from linkwright.pipeline.output.folder import Output
from linkwright.pipeline.sweep import folder as sweep_folder
from linkwright.pipeline.sweep.outcome_files import outcomes_of
from tests.fake_onshape.server import OnshapeServer
from tests.fake_onshape.settable import configured_stand
from tests.support.command import environment, linkwright
from tests.support.hosts import COMMAND, Host
from tests.support.kill import killed_at
from tests.support.places import PROJECT

DAY = 24 * 3600.0
HOSTS = (
    Host("behind", -3600.0, "ENOLCK"),
    Host("ahead", 3600.0, "ENOSYS"),
    Host("far_ahead", 3 * DAY, "EOPNOTSUPP"),
    Host("alone", 0.0, "shared"),
    Host("alone", 0.0, "shared"),
    Host("sound"),
)

WORKER = """
from pathlib import Path
import random
from linkwright.pipeline.caching.actions import Action, Cache
from linkwright.pipeline.caching.store import Store

order = list(range(60))
random.Random(sys.argv[2]).shuffle(order)
for number in order:
    cache = Cache(Store(Path(sys.argv[1])))
    make = lambda: {"own": b"%d," % number * 50_000, "shared": b"shared" * 100_000}
    files, _ = cache.run(Action("test", 1, number), make)
    assert dict(files) == make()
"""

COLLECTOR = """
from pathlib import Path
from linkwright.pipeline.caching import maintenance
while True:
    maintenance.collect(Path(sys.argv[1]), 0)
"""


@pytest.fixture
def _hurried(monkeypatch):
    monkeypatch.setattr(shared, "PAUSES", (0.0, 0.0))


def lose(monkeypatch, number, times, name="open"):
    """Takes the file system away for so many attempts to open (or so) a file."""
    real, left = getattr(Path, name), [times]

    def failing(self, *arguments, **more):
        if left[0]:
            left[0] -= 1
            raise OSError(number, os.strerror(number))
        return real(self, *arguments, **more)

    monkeypatch.setattr(Path, name, failing)


@pytest.mark.usefixtures("_hurried")
@pytest.mark.parametrize("number", [errno.EIO, errno.ESTALE, errno.ETIMEDOUT])
def test_a_paid_reply_that_cannot_be_read_now_is_never_a_miss(tmp_path, monkeypatch, number):
    replies = Cache(Store(tmp_path)).replies()
    replies.put("request", b"body")
    with monkeypatch.context() as patched:
        lose(patched, number, 2)
        assert replies.get("request") == b"body"
    for name, times in (("open", 3), ("open", 1_000), ("stat", 1_000)):
        with monkeypatch.context() as patched:
            lose(patched, number, times, name)
            fresh = Cache(replies._cache.store).replies()
            fresh._cache.store._intact.clear()
            with pytest.raises(CacheError, match="cannot be read") as caught:
                fresh.get("request")
            assert "run it again when it is back" in caught.value.hint
    assert replies.get("request") == b"body"
    assert replies.get("another") is None


@pytest.mark.usefixtures("_hurried")
def test_reply_is_kept_when_the_file_system_comes_back(tmp_path, monkeypatch):
    replies = Cache(Store(tmp_path)).replies()
    real, left = os.replace, [2]

    def failing(*arguments):
        if left[0]:
            left[0] -= 1
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        real(*arguments)

    monkeypatch.setattr(os, "replace", failing)
    replies.put("request", b"body")
    assert replies.get("request") == b"body"
    assert list((tmp_path / "tmp").iterdir()) == []


def test_a_rename_whose_answer_was_lost_is_done(tmp_path, monkeypatch):
    store, real, lost = Store(tmp_path), os.replace, []

    def answered_late(*names):
        real(*names)
        if not lost:
            lost.append(names)
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))

    monkeypatch.setattr(os, "replace", answered_late)
    assert store.get(store.put(b"blob")) == b"blob"
    assert lost


@pytest.mark.usefixtures("_hurried")
def test_collection_stops_at_an_unreadable_record(tmp_path, monkeypatch):
    replies = Cache(Store(tmp_path)).replies()
    replies.put("request", b"body")
    for path in tmp_path.glob("cas/*/*"):
        os.utime(path, (1, 1))
    with monkeypatch.context() as patched:
        lose(patched, errno.EIO, 1_000)
        with pytest.raises(CacheError, match="cannot be read"):
            maintenance.collect(tmp_path, 1_000_000)
    assert replies.get("request") == b"body"


def test_files_are_old_by_the_time_of_their_file_system(tmp_path, monkeypatch):
    cache = Cache(Store(tmp_path))
    cache.run(Action("test", 1), lambda: {"a": b"alpha"})
    (tmp_path / "tmp" / "being_written").touch()
    now = time.time
    monkeypatch.setattr(time, "time", lambda: now() + 2 * MAX_TEMPORARY_AGE)
    Store(tmp_path)
    assert maintenance.collect(tmp_path, 0).blobs == 0
    assert [path.name for path in (tmp_path / "tmp").iterdir()] == ["being_written"]
    assert cache.find(Action("test", 1).key) is not None


@pytest.mark.parametrize("name", ["ENOLCK", "ENOSYS", "EOPNOTSUPP"])
def test_a_file_system_without_locks_fails_no_build(tmp_path, monkeypatch, name):
    real, number = fcntl.flock, getattr(errno, name)

    def failing(*_):
        raise OSError(number, os.strerror(number))

    def not_released(handle, operation):
        if operation == fcntl.LOCK_UN and len(seen) == 1:
            failing()
        seen.append(operation)
        real(handle, operation)

    for flock in (failing, not_released):
        seen = [fcntl.LOCK_UN] if flock is not_released else []
        monkeypatch.setattr(fcntl, "flock", flock)
        cache, output = Cache(Store(tmp_path / "cache")), Output(tmp_path / "arm")
        assert cache.run(Action(flock.__name__, 1), lambda: {"a": b"alpha"})[0]["a"] == b"alpha"
        output.prepare()
        output.publish({"report.json": b'{"linkwright-report": 1}', "a": b"1"})
        assert (output.target / "a").read_bytes() == b"1"


def test_two_hosts_that_mark_a_sweep_at_once_both_do(tmp_path, monkeypatch):
    real, other = Path.replace, []

    def late(self, target):
        if not other:
            other.append(self)
            manifest.write_shared(tmp_path, {"of another host": None})
        return real(self, target)

    monkeypatch.setattr(Path, "replace", late)
    manifest.write_shared(tmp_path, dict.fromkeys(sweep_folder.SWEEP_FILES))
    assert other
    assert manifest.written_files(tmp_path) == dict.fromkeys(sweep_folder.SWEEP_FILES)
    left = tmp_path / f"{manifest.NAME}.0123abcd.tmp"
    left.write_text("{")  # by a kill
    assert not list(manifest.foreign_or_changed(tmp_path, {}))
    manifest.clear(tmp_path, ())
    assert not tmp_path.exists()


@pytest.mark.slow
def test_hosts_that_die_at_random_share_a_cache(tmp_path, request):
    root, chance = tmp_path / "cache", random.Random(11)
    Store(root)
    collector = Host("cleaning", 2 * DAY, "ENOLCK").start(COLLECTOR, str(root), cwd=tmp_path)
    request.addfinalizer(collector.communicate)
    request.addfinalizer(collector.kill)
    for attempt in range(2):
        hosts = [
            replace(host, root=str(root), dies_at=chance.randrange(50, 900) * (number % 2))
            for number, host in enumerate(HOSTS)
        ]
        running = [
            host.start(WORKER, str(root), f"{attempt}{number}", cwd=tmp_path)
            for number, host in enumerate(hosts)
        ]
        for host, process in zip(hosts, running, strict=True):
            _, errors = process.communicate(timeout=120)
            assert process.returncode == (-9 if host.dies_at else 0), (host, errors)
        summary = maintenance.verify(root)
        assert (summary.blobs, summary.broken, summary.records) == (61, (), 0)
    assert collector.poll() is None, collector.communicate()


@pytest.mark.slow
def test_jobs_on_failing_hosts_complete_in_the_next_run(tmp_path):
    legs = "'200 mm','0.3 m'"
    with OnshapeServer(configured_stand()) as server:
        line = ["-m", "name=stand", "until=graph", "page.preview=none", "source=onshape"]
        line += [f"source.url='{server.document_url()}'", f"source.configuration.leg_length={legs}"]
        line += ["joints.*.damping=1,2,3", "output=sweep"]

        def build(here, *arguments, **more):
            return linkwright(here, *arguments, environ=environment(here, seeded=False, **more))

        here, single = tmp_path / "hosts", tmp_path / "single"
        here.mkdir()
        single.mkdir()
        assert build(single, *line, **server.environ).returncode == 0
        build(here, *line, "--plan", "jobs.json", **server.environ)
        build(here, "jobs", "jobs.json", "--fetch", **server.environ)
        server.reset()

        def job(number, host):
            environ = environment(here, seeded=False, LINKWRIGHT_HOST=server.url)
            return host.start(COMMAND, "job", "jobs.json", str(number), cwd=here, environ=environ)

        hurt = [
            replace(HOSTS[0], root=str(here), dies_at=60),
            replace(HOSTS[1], root=str(here / "cache"), loses_at=20, away=60.0),
            replace(HOSTS[3], root=str(here / "cache"), loses_at=20, lost="ESTALE", away=1.0),
            replace(HOSTS[2], root=str(here), dies_at=110),
            replace(HOSTS[0], root=str(here / "cache"), loses_at=1, away=60.0),
        ]
        running = [job(number, host) for number, host in enumerate(hurt)]
        ended = [(process.communicate(timeout=120), process.returncode) for process in running]
        assert [status for _, status in ended] == [-9, 1, 0, -9, 1], ended
        assert "Traceback" not in ended[1][0][1] + ended[4][0][1]
        build(here, "jobs", "jobs.json")
        states = [(outcome.state, outcome.message) for outcome in outcomes_of(here / "sweep")]
        assert [states[number][0] for number in (1, 2, 4)] == ["failed", "built", "failed"]
        for _, message in (states[1], states[4]):
            assert re.search("the cache folder cannot be (read|written): Input/output error", message)
            assert message in json.dumps(json.loads((here / "sweep" / "summary.json").read_text()))
        for process in [job(number, HOSTS[number % 4]) for number in (0, 1, 3, 4, 5)]:
            assert process.wait(timeout=120) == 0, process.communicate()
            process.communicate()
        assert build(here, "jobs", "jobs.json").stdout.endswith("\n6 done\n")
        build(here, "jobs", "jobs.json", "--fetch", **server.environ)
        assert server.calls == [], "nothing is paid twice"
    summary = maintenance.verify(here / "cache")
    assert (summary.broken, summary.records) == ((), 0)
    robots = [
        {path.parent.name: path.read_bytes() for path in place.glob("sweep/*/robot.json")}
        for place in (single, here)
    ]
    assert robots[0] == robots[1]
    assert len(robots[0]) == 6


COUNTING_WORKER = """
import random, sys
from pathlib import Path
from linkwright.pipeline.caching.actions import Action, Cache
from linkwright.pipeline.caching.store import Store

root, ledger, seed, actions = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
cache = Cache(Store(root))
order = list(range(actions))
random.Random(seed).shuffle(order)
print("ready", flush=True)
for number in order:
    def make():
        with ledger.open("a") as file:
            file.write(f"{number}\\n")
        inner = cache.memo("part", 1, {})("double", {"n": number // 2}, lambda: b"%d" % (number // 2))
        return {"big": b"%d," % number * 200_000, "inner": inner}
    files, _ = cache.run(Action("test", 1, number), make)
    assert files["big"] == b"%d," % number * 200_000
"""


def worker(folder, seed, actions):
    words = [folder / "cache", folder / "ledger", seed, actions]
    return subprocess.Popen(
        [sys.executable, "-c", COUNTING_WORKER, *map(str, words)], cwd=PROJECT, text=True,
        env={**os.environ, "PYTHONPATH": str(PROJECT)}, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def assert_whole(root):
    """Every blob has its digest's bytes, and every record's blobs are there."""
    for blob in (root / "cas").glob("*/*"):
        assert sha256(blob.read_bytes()) == blob.name
    cache = Cache(Store(root))
    for record in (root / "ac").glob("*/*.json"):
        json.loads(record.read_bytes())
        assert cache.find(record.stem) is not None


def test_six_processes_make_each_action_once(tmp_path):
    for process in [worker(tmp_path, seed, 12) for seed in range(6)]:
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 0, errors
    assert sorted(map(int, (tmp_path / "ledger").read_text().split())) == list(range(12))
    assert_whole(tmp_path / "cache")


@pytest.mark.slow
def test_writers_killed_at_random_leave_whole_files(tmp_path):
    chance = random.Random(7)
    for attempt in range(8):
        process = worker(tmp_path, attempt, 200)
        assert process.stdout.readline() == "ready\n"
        time.sleep(chance.uniform(0, 0.15))
        process.kill()
        process.communicate()
        assert_whole(tmp_path / "cache")
    process = worker(tmp_path, 99, 20)
    assert process.wait(timeout=60) == 0
    process.communicate()


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_action_killed_at_any_step_is_a_miss_or_a_whole_hit(tmp_path):
    action, outputs = Action("test", 1), {"a": b"alpha" * 100_000, "b": b"beta"}

    def work(root):
        cache = Cache(Store(root))
        cache.run(action, lambda: outputs)
        cache.run(Action("next", 1), lambda: outputs)

    work(tmp_path / "warm")  # so that what is imported late is not counted as a step
    step, outcomes = 1, set()
    while killed_at(step, lambda: work(tmp_path / str(step))):  # noqa: B023
        root = tmp_path / str(step)
        assert_whole(root)
        files = Cache(Store(root)).find(action.key)
        outcomes.add(files is not None)
        assert files is None or dict(files) == outputs
        work(root)
        assert dict(Cache(Store(root)).find(action.key)) == outputs
        step += 1
    assert step > 10
    assert outcomes == {True, False}, "the kills must fall before and after the publication"
