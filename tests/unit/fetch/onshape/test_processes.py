"""Builds of one robot: several at the same time make no call twice, and each reports what it spent."""

import json
import subprocess
import sys

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.run.build import build
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.server import OnshapeServer
from tests.support.places import PROJECT

pytestmark = pytest.mark.e2e

COLD = 1 + 2 * 3

WORKER = """
import json, sys
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


def plan(folder, server, name="one", pin="w", **keys):
    source = {"kind": "onshape", "url": server.document_url(pin), **keys}
    return {"name": "shelf", "source": source, "output": str(folder / name), "until": "fetch"}


def start(folder, server, name):
    """A process that waits for a line before it builds."""
    environ = {"PATH": "/usr/bin", "HOME": str(folder), "LINKWRIGHT_CACHE": str(folder / "cache")}
    command = [sys.executable, "-c", WORKER, json.dumps(plan(folder, server, name))]
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    process = subprocess.Popen(command, cwd=PROJECT, env=environ | server.environ, text=True, **pipes)
    assert process.stdout.readline() == "ready\n"
    return process


def together(folder, server, number):
    """What each of `number` processes spent that began at the same moment."""
    processes = [start(folder, server, f"at-once-{index}") for index in range(number)]
    for process in processes:
        process.stdin.write("\n")
        process.stdin.flush()
    ends = [process.communicate(timeout=60) for process in processes]
    assert [process.returncode for process in processes] == [0] * number, ends
    return [json.loads(out.splitlines()[-1]) for out, _ in ends]


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


@pytest.fixture
def server():
    with OnshapeServer(shelf()) as server:
        yield server


def built(folder, server, **keys):
    environ = {**server.environ, "LINKWRIGHT_CACHE": str(folder / "cache")}
    server.reset()
    report = build(Plan.parse(plan(folder, server, **keys)), environ=environ)
    calls = json.loads((folder / "one.fetch" / "report.json").read_text())["calls"]
    assert calls["made"] == report.calls["made"] == server.count
    return report, calls


def test_a_report_tells_what_was_made_saved_counted_and_left(server, tmp_path):
    _, calls = built(tmp_path, server)
    assert calls["remaining"].pop("massproperties") > 0
    assert (calls["saved"], calls["counted_this_year"]) == (0, COLD)
    _, calls = built(tmp_path, server)
    assert (calls["made"], calls["saved"], calls["counted_this_year"]) == (1, COLD, COLD + 1)
    assert built(tmp_path, server, offline=True)[1] == {"made": 0, "saved": COLD}
    _, calls = built(tmp_path, server, refresh=True)
    assert (calls["made"], calls["saved"], calls["counted_this_year"]) == (COLD, 0, 2 * COLD + 1)


def test_refresh_replaces_what_a_pinned_build_finds(server, tmp_path):
    first, _ = built(tmp_path, server, pin="v")
    server.document.part("A").density = 2000
    server.replies = type(server.replies)(server.document)
    keys = ({}, {"refresh": True}, {})
    again, fresh, last = (built(tmp_path, server, pin="v", **more)[0] for more in keys)
    assert [made.calls["made"] for made in (again, fresh, last)] == [0, COLD, 0]
    assert last.stages[0].cached
    assert last.bundle == fresh.bundle != first.bundle
