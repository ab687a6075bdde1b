"""A sweep of an Onshape document: what it costs, what its jobs see, and who has the key."""

import itertools
import json
import os
import re

import pytest

from linkwright.pipeline.sweep import run
from tests.fake_onshape.faults import Fault
from tests.fake_onshape.server import ACCESS_KEY, SECRET_KEY, OnshapeServer
from tests.fake_onshape.settable import configured_stand
from tests.support.command import called, environment

pytestmark = [pytest.mark.slow, pytest.mark.e2e]

LEGS = ("200 mm", "0.3 m", "0.4 m")
STAND = ("name=stand", "until=graph", "page.preview=none")


@pytest.fixture
def server():
    with OnshapeServer(configured_stand()) as server:
        yield server


@pytest.fixture
def sweep(tmp_path, server):
    """Sweeps over lengths of the leg, and `more`, without the colliders of the sample."""

    def sweep(*more, legs=LEGS, here=tmp_path, **variables):
        here.mkdir(exist_ok=True)
        environ = environment(here, seeded=False, **{**server.environ, **variables})
        lengths = ",".join(f"'{leg}'" for leg in legs)
        line = [*STAND, "source=onshape", f"source.url='{server.document_url()}'"]
        return called(here, "-m", *line, f"source.configuration.leg_length={lengths}", *more, environ=environ)

    return sweep


def plan_of(done):
    """The line that tells what a sweep costs: jobs, configurations, calls, and whether at least so many."""
    match = re.search(r"^(\d+) jobs?, (\d+) configurations?, (at least )?(\d+) calls?$", done.stderr, re.M)
    assert match, done.stderr
    return int(match[1]), int(match[2]), int(match[4]), bool(match[3])


def reports_of(folder, ending="graph"):
    return [json.loads(path.read_text()) for path in folder.rglob(f"*.{ending}/report.json")]


def robots_of(folder):
    return {path.parent.name: path.read_bytes() for path in folder.rglob("*.graph/robot.json")}


def edit(server):
    server.edit(server.document.edited(server.document.studios[0].name))


def test_calls_are_those_of_the_plan_and_a_rerun_needs_one(sweep, server):
    done = sweep("joints.*.damping=1,2", legs=LEGS[:2])
    assert done.returncode == 0, done.stderr
    assert plan_of(done) == (4, 2, server.count, False)
    assert done.stderr.index(" configurations, ") < done.stderr.index("job 0 starts")
    # The parameters, a definition for each leg, and for the legs, the base and the jaw two each.
    assert server.count == 1 + 2 + 2 * (2 + 2)
    server.reset()
    done = sweep("joints.*.damping=1,2", legs=LEGS[:2])
    assert done.returncode == 0, done.stderr
    assert plan_of(done) == (4, 2, 1, False)
    assert server.count == 1
    edit(server)
    server.reset()
    done = sweep("joints.*.damping=1,2", legs=LEGS[:2])
    assert done.returncode == 0, done.stderr
    jobs, configurations, calls, at_least = plan_of(done)
    assert (jobs, configurations, at_least) == (4, 2, True)
    assert 1 < calls <= server.count
    server.reset()
    done = sweep("joints.*.damping=1,2", "source.refresh=true", legs=LEGS[:2])
    assert done.returncode == 0, done.stderr
    assert plan_of(done)[2] == server.count
    assert len({target for _, target, _ in server.calls}) == server.count, "what they share comes once"


def test_each_job_has_the_robot_of_its_single_build(sweep, server, tmp_path):
    sweep("joints.*.damping=1,2", legs=LEGS[:2])
    swept = robots_of(tmp_path)
    assert len(set(swept.values())) == 4
    single = tmp_path / "alone"
    single.mkdir()
    environ = environment(single, seeded=False, **server.environ)
    robots = set()
    for leg, damping in itertools.product(LEGS[:2], (1, 2)):
        line = [*STAND, "source=onshape", f"source.url='{server.document_url()}'"]
        line += [f"source.configuration.leg_length='{leg}'", f"joints.*.damping={damping}"]
        assert called(single, *line, environ=environ).returncode == 0
        robots.add((single / "outputs" / "stand.graph" / "robot.json").read_bytes())
    assert robots == set(swept.values())


@pytest.mark.parametrize("when", ["at each job", "between two configurations"])
def test_no_job_sees_what_is_changed_while_the_sweep_runs(sweep, server, monkeypatch, tmp_path, when):
    starts, asked = run.Task.__call__, []

    def editing(task, number):
        edit(server)
        return starts(task, number)

    def edit_between(method, target, number):
        if "/assemblies/" in target:
            asked.append(target)
            if len(asked) == 2:
                edit(server)

    if when == "at each job":
        monkeypatch.setattr(run.Task, "__call__", editing)
    else:
        server.fault = edit_between
    done = sweep()
    assert done.returncode == 0, done.stderr
    reports = reports_of(tmp_path)
    assert len(reports) == 3
    assert len({report["source"]["microversion"] for report in reports}) == 1
    assert {report["calls"]["made"] for report in reports} == {0}


def test_the_keys_are_nowhere_but_in_the_process_that_fetches(sweep, monkeypatch, tmp_path):
    seen = []
    starts = run.Task.__call__

    def looking(task, number):
        seen.append(dict(os.environ))
        return starts(task, number)

    monkeypatch.setattr(run.Task, "__call__", looking)
    assert sweep(legs=LEGS[:1]).returncode == 0
    assert len(seen) == 1
    assert not {ACCESS_KEY, SECRET_KEY}.intersection(seen[0].values())
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert not [path for path in files if SECRET_KEY.encode() in path.read_bytes()]


@pytest.mark.parametrize(("allowed", "made", "words"), [
    (3, 3, "source.max_calls is 3"),
    (13, 4, "this sweep made 4 calls and needs 10 more, but source.max_calls is 13"),
])  # fmt: skip
def test_a_sweep_makes_no_more_calls_than_are_allowed(sweep, server, allowed, made, words):
    """Those of the plan, a definition for each configuration, count too."""
    done = sweep(f"source.max_calls={allowed}")
    assert done.returncode == 1
    assert words in done.stderr
    assert server.count == made
    assert "job 0 starts" not in done.stderr
    assert sweep("source.max_calls=14").returncode == 0


def test_configuration_that_fails_to_fetch_fails_its_jobs_alone(sweep, server, tmp_path):
    server.fault = lambda method, target, number: Fault(404) if "0.3%2Bm" in target else None
    done = sweep("joints.*.damping=1,2")
    assert done.returncode == 1
    rows = [line for line in done.stdout.splitlines() if "leg_length" in line]
    assert [("0.3 m" in row, "built up to graph" in row) for row in rows] == [
        ("0.3 m" in row, "0.3 m" not in row) for row in rows
    ]
    assert len(rows) == 6
    failed = reports_of(tmp_path, "failed")
    assert len(failed) == 2
    assert {report["error"]["type"] for report in failed} == {"NotFound"}


def test_a_key_that_is_refused_is_tried_once(sweep, server):
    done = sweep(ONSHAPE_SECRET_KEY="another")
    assert done.returncode == 1
    assert len(server.calls) == 1
    assert "0 of 3 jobs" in done.stdout


def test_jobs_without_quota_have_the_last_state(sweep, server, tmp_path):
    sweep()
    before = robots_of(tmp_path)
    edit(server)
    server.fault = lambda method, target, number: Fault(402)
    done = sweep()
    assert done.returncode == 3, done.stderr
    assert done.stdout.count("not the newest state") == 3
    assert robots_of(tmp_path) == before


@pytest.mark.parametrize("mode", ["use", "refresh"])
def test_a_sweep_offline_asks_nothing(sweep, server, mode):
    assert sweep(f"cache.mode={mode}").returncode == 0
    server.reset()
    done = sweep("source.offline=true", f"cache.mode={mode}", ONSHAPE_ACCESS_KEY="", ONSHAPE_SECRET_KEY="")
    assert done.returncode == 0, done.stderr
    assert plan_of(done) == (3, 3, 0, False)
    assert not server.calls


def test_without_a_cache_a_sweep_of_a_document_is_refused(sweep, server):
    done = sweep("cache.mode=bypass")
    assert done.returncode == 2
    assert "cache.mode" in done.stderr
    assert not server.calls
