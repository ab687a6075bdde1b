"""Several builds of one robot at the same time, and one that is killed: no call is made twice."""

import json
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import SourceError
from linkwright.pipeline.run.build import build
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.places import PROJECT
from tests.support.traffic import at_call, at_path

COLD = 1 + 2 * 3

WORKER = """
import json, sys
from pathlib import Path
from linkwright.pipeline.run.build import build
from linkwright.pipeline.config.plan import Plan

print("ready", flush=True)
sys.stdin.readline()
report = build(Plan.parse(json.loads(sys.argv[1])))
print(json.dumps(report.calls), flush=True)
"""


def shelf():
    document = Document("Shelf")
    root = document.assembly("Shelf")
    for index, name in enumerate("ABC"):
        studio = document.studio(name)
        root.add(studio.part(name, solids.box(0.1, 0.1, 0.1 + index), density=1000), fixed=index == 0)
    return document


def plan(folder, server, name="one", until="fetch", **keys):
    source = {"kind": "onshape", "url": server.document_url(), **keys}
    return {"name": "shelf", "source": source, "output": str(folder / name), "until": until}


def start(folder, server, name):
    """A process that waits for a line before it builds."""
    environ = {"PATH": "/usr/bin", "HOME": str(folder), "LINKWRIGHT_CACHE": str(folder / "cache")}
    command = [sys.executable, "-c", WORKER, json.dumps(plan(folder, server, name))]
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    environ |= server.environ
    process = subprocess.Popen(command, cwd=PROJECT, env=environ, text=True, **pipes)
    assert process.stdout.readline() == "ready\n"
    return process


def begin(process):
    process.stdin.write("\n")
    process.stdin.flush()
    return process


def finish(process):
    out, errors = process.communicate(timeout=60)
    assert process.returncode == 0, errors
    return json.loads(out.splitlines()[-1])


def together(folder, server, number):
    """What each of `number` processes spent that began at the same moment."""
    processes = [start(folder, server, f"at-once-{index}") for index in range(number)]
    return [finish(process) for process in [begin(process) for process in processes]]


@pytest.mark.slow
def test_three_processes_at_once_make_each_call_once(tmp_path):
    # Slow enough that all are up before the first reply.
    with OnshapeServer(shelf(), latency_s=0.5) as server:
        spent = together(tmp_path, server, 3)
        assert server.count == sum(calls["made"] for calls in spent) == COLD
        server.reset()
        after = server.document.edited("B")
        after.part("B").solid = solids.box(0.3, 0.3, 0.3)
        server.edit(after)
        spent = together(tmp_path, server, 2)
        assert server.count == sum(calls["made"] for calls in spent) == 7
        paths = [path for _, path, _ in server.calls]
        assert len(set(paths)) == len(paths)
    folders = [tmp_path / f"at-once-{index}.fetch" for index in range(2)]
    assert all(json.loads((folder / "report.json").read_text())["status"] == "built" for folder in folders)


def test_a_build_takes_the_replies_that_a_killed_build_left(tmp_path):
    held, go = threading.Event(), threading.Event()

    def hold(method, path, number):
        if number == 3:
            held.set()
            go.wait(30)

    with OnshapeServer(shelf(), fault=hold) as server:
        process = start(tmp_path, server, "killed")
        begin(process)
        assert held.wait(30)
        process.kill()
        process.communicate()
        go.set()
        server.fault = None
        spent = finish(begin(start(tmp_path, server, "next")))
    assert 5 <= spent["made"] <= COLD
    assert spent["saved"] >= 1
    assert sum("/assemblies/" in path for _, path, _ in server.calls) == 1


class TestReport:
    @pytest.fixture
    def server(self):
        with OnshapeServer(shelf()) as server:
            yield server

    def build(self, folder, server, **keys):
        environ = {**server.environ, "LINKWRIGHT_CACHE": str(folder / "cache")}
        server.reset()
        try:
            build(Plan.parse(plan(folder, server, **keys)), environ=environ)
        finally:
            reports = [folder / f"one.{end}" / "report.json" for end in ("fetch", "failed")]
            newest = max(filter(Path.exists, reports), key=lambda path: path.stat().st_mtime_ns)
            calls = json.loads(newest.read_text())["calls"]
            assert calls["made"] == server.count
        return calls

    def test_it_tells_what_was_made_saved_counted_and_left(self, server, tmp_path):
        calls = self.build(tmp_path, server)
        assert calls["remaining"].pop("massproperties") > 0
        assert (calls["saved"], calls["counted_this_year"]) == (0, COLD)
        calls = self.build(tmp_path, server)
        assert (calls["made"], calls["saved"], calls["counted_this_year"]) == (1, COLD, COLD + 1)
        assert self.build(tmp_path, server, offline=True) == {"made": 0, "saved": COLD}
        calls = self.build(tmp_path, server, refresh=True)
        assert (calls["made"], calls["saved"], calls["counted_this_year"]) == (COLD, 0, 2 * COLD + 1)

    @pytest.mark.parametrize(("broken", "keys"), [(1, {}), (6, {}), (99, {"max_calls": 3})])
    def test_it_tells_what_a_failed_build_spent(self, server, tmp_path, broken, keys):
        server.fault = at_call(Fault(403), broken)
        with pytest.raises(SourceError):
            self.build(tmp_path, server, **keys)
        report = json.loads((tmp_path / "one.failed" / "report.json").read_text())
        assert report["calls"]["made"] == report["calls"]["counted_this_year"] == server.count > 0
        assert not keys or (report["exit_status"], server.count) == (1, 1)

    def test_refresh_replaces_what_a_pinned_build_finds(self, server, tmp_path):
        environ = {**server.environ, "LINKWRIGHT_CACHE": str(tmp_path / "cache")}

        def pinned(**keys):
            tree = plan(tmp_path, server, **keys)
            tree["source"]["url"] = server.document_url("v")
            return build(Plan.parse(tree), environ=environ)

        first = pinned()
        server.document.part("A").density = 2000
        server.replies = type(server.replies)(server.document)
        again, fresh, last = pinned(), pinned(refresh=True), pinned()
        assert [made.calls["made"] for made in (again, fresh, last)] == [0, COLD, 0]
        assert last.stages[0].cached
        assert last.bundle == fresh.bundle != first.bundle

    def test_a_mass_that_differs_is_in_the_report_of_a_build_that_is_good(self, server, tmp_path):
        self.build(tmp_path, server)
        server.edit(server.document.edited("Shelf"))
        server.fault = at_path(Fault(200, b'{"mass": [77.0]}'), "/assemblies/", "/massproperties")
        self.build(tmp_path, server)
        report = json.loads((tmp_path / "one.fetch" / "report.json").read_text())
        assert report["status"] == "built"
        assert [problem["code"] for problem in report["diagnostics"]] == ["W-VERIFY"]
