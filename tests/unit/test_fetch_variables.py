"""Variables of a document, set for one build: what is written, what it costs, and that it is put back."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from pipeline.build import build
from pipeline.plan import Plan
from pipeline.preflight import before_a_sweep
from stages import fetch as stage
from stages.fetch.plan_of_calls import Calls
from stages.fetch.variables import expression
from stages.graph import build_robot
from stages.robot.errors import (
    AuthError,
    ConfigError,
    NotFound,
    ProtocolError,
    QuotaExhausted,
    SourceError,
)
from tests.building import plan_of
from tests.kept import ADDRESS, Kept, fetched, onshape
from tests.onshape.server import Fault, OnshapeServer
from tests.onshape.settable import driven_stand

TALL = {"LegLength": "400 mm"}


@pytest.fixture
def kept():
    return Kept()


@pytest.fixture
def server():
    with OnshapeServer(driven_stand()) as server:
        yield server


def keys(server, variables=TALL, **more):
    return onshape(server.document_url(), variables=variables, allow_write=True, **more)


def leg(made):
    robot = build_robot(made.bundle, plan_of())
    return next(round(link.inertial.mass, 9) for link in robot.links if link.name == "leg")


def tables(server):
    return [studio.table for studio in server.document.variable_studios]


def posts(server):
    return [target for method, target, _ in server.calls if method == "POST"]


def test_a_variable_changes_what_is_built_and_is_put_back(server, kept):
    before = tables(server)
    made = fetched(keys(server), kept, server.environ)
    assert leg(made) == 0.36
    assert tables(server) == before
    assert len(posts(server)) == 2
    # Probe, tabs, two tables; write, probe, write back, probe; then a cold build of a microversion.
    assert made.calls == server.count == 4 + 4 + 1 + 2 * 3
    assert made.bundle.root["microversion"] != server.document.microversion
    assert leg(fetched(onshape(server.document_url()), kept, server.environ)) == 0.18


def test_the_same_values_again_cost_one_call_and_no_write(server, kept):
    made = fetched(keys(server), kept, server.environ)
    server.reset()
    again = fetched(keys(server), kept, server.environ)
    assert (again.calls, posts(server)) == (1, [])
    assert again.bundle == made.bundle
    other = fetched(keys(server, {"LegLength": 0.3}), kept, server.environ)
    assert leg(other) == 0.27
    assert len(posts(server)) == 2


def test_a_table_is_written_whole(server, kept):
    sent = []
    post = server.replies.post

    def noted(path, body):
        sent.append(body)
        return post(path, body)

    server.replies.post = noted
    fetched(keys(server), kept, server.environ)
    assert b'"Spare"' in sent[0]
    assert b'"400 mm"' in sent[0]
    assert b'"value"' not in sent[0]


def test_values_that_are_there_already_need_no_write(server, kept):
    made = fetched(keys(server, {"LegLength": "200 mm", "Spare": "3"}), kept, server.environ)
    assert posts(server) == []
    assert leg(made) == 0.18


@pytest.mark.parametrize(
    ("value", "kind", "text"),
    [
        (0.25, "LENGTH", "0.25 m"),
        (1, "ANGLE", "1 rad"),
        (2, "NUMBER", "2"),
        (True, "ANY", "true"),
        ("#a + 1 mm", "LENGTH", "#a + 1 mm"),
    ],
)
def test_bare_numbers_are_si(value, kind, text):
    assert expression(value, kind) == text


def test_all_variables_that_the_document_lacks_are_told_and_nothing_is_written(server, kept):
    with pytest.raises(SourceError) as caught:
        fetched(keys(server, {**TALL, "Leglength": 1, "Width": 2}), kept, server.environ)
    assert [problem.where for problem in caught.value.problems] == [
        "source.variables.Leglength", "source.variables.Width"
    ]  # fmt: skip
    assert caught.value.problems[0].hint == "it has: LegLength, Other, Spare, Tilt"
    assert posts(server) == []


def test_a_studio_with_a_configured_variable_is_left_alone(server, kept):
    server.document.variable_studios[0].table["Spare"] = ("NUMBER", "")
    with pytest.raises(SourceError, match="#Spare"):
        fetched(keys(server), kept, server.environ)
    assert posts(server) == []


@pytest.mark.parametrize("number", [5, 7])
def test_a_failure_after_the_write_leaves_the_document_as_it_was(server, kept, number):
    """The fifth call asks what the changed state is, the seventh what the state is after it."""
    before = tables(server)
    server.fault = lambda method, target, at: Fault(404, b"{}") if at == number else None
    calls = Calls()
    with pytest.raises(SourceError):
        fetched(keys(server), kept, server.environ, calls=calls)
    assert calls.made == server.count == 7 - (number == 5)
    assert tables(server) == before
    assert len(posts(server)) == 2


def test_ctrl_c_after_the_write_leaves_the_document_as_it_was(server, kept):
    before = tables(server)
    main = threading.main_thread().ident

    def interrupt(method, target, number):
        if number == 5:
            # The main thread waits for this very reply.
            signal.pthread_kill(main, signal.SIGINT)
            time.sleep(0.2)
        return

    server.fault = interrupt
    with pytest.raises(KeyboardInterrupt):
        fetched(keys(server), kept, server.environ)
    assert tables(server) == before
    assert len(posts(server)) == 2


@pytest.mark.parametrize(("status", "kind"), [(403, AuthError), (404, NotFound), (402, QuotaExhausted)])
def test_a_write_that_is_refused_changes_nothing_and_leaves_nothing_to_put_back(server, kept, status, kind):
    before = tables(server)
    server.fault = lambda method, target, at: Fault(status, b"{}") if method == "POST" else None
    with pytest.raises(kind) as caught:
        fetched(keys(server), kept, server.environ)
    assert ("give the key write permission" in caught.value.hint) == (status == 403)
    assert tables(server) == before
    assert len(posts(server)) == 1
    server.fault = None
    lines = []
    fetched(onshape(server.document_url()), kept, server.environ, lines)
    assert not [line for line in lines if "putting back" in line]


def test_of_two_studios_only_the_one_that_was_written_is_put_back(server, kept):
    before = tables(server)
    server.fault = lambda method, target, at: Fault(403, b"{}") if at == 5 else None
    with pytest.raises(AuthError):
        fetched(keys(server, {**TALL, "Other": "20 deg"}), kept, server.environ)
    assert tables(server) == before
    first, _, third = posts(server)
    assert first == third


def abandoned(server, kept):
    """A build that wrote and could not put back: what is remembered is all that is left of it."""
    server.fault = lambda method, target, at: Fault(403, b"{}") if at == 6 else None
    with pytest.raises(SourceError, match="could not be put back to LegLength = 200 mm") as caught:
        fetched(keys(server), kept, server.environ)
    assert "run the same command again" in caught.value.hint
    assert tables(server)[0]["LegLength"] == ("LENGTH", "400 mm")
    server.fault = None
    server.reset()


@pytest.mark.parametrize("again", ["plain", "same", "other"])
def test_what_a_build_left_is_put_back_by_the_next(server, kept, again):
    before = tables(server)
    abandoned(server, kept)
    wanted = {"plain": {}, "same": TALL, "other": {"LegLength": "300 mm"}}[again]
    lines = []
    made = fetched(keys(server, wanted), kept, server.environ, lines)
    assert leg(made) == {"plain": 0.18, "same": 0.36, "other": 0.27}[again]
    assert tables(server) == before
    assert "putting back the variables that a build which was killed had changed" in lines
    lines.clear()
    fetched(keys(server, wanted), kept, server.environ, lines)
    assert not [line for line in lines if "putting back the variables" in line]


def test_what_was_edited_since_is_left_as_it_is(server, kept):
    abandoned(server, kept)
    document = server.document
    own = {**document.variable_studios[0].table, "LegLength": ("LENGTH", "250 mm")}
    server.edit(document.with_variables(document.variable_studios[0].element, own))
    server.reset()
    lines = []
    made = fetched(onshape(server.document_url()), kept, server.environ, lines)
    assert leg(made) == 0.225
    assert posts(server) == []
    assert any("was edited since: left as it is" in line for line in lines)


def test_two_builds_with_other_values_do_not_disturb_each_other(server):
    before = tables(server)
    found = {}

    def one(text):
        # Each in its own memory, as two computers have; the lock is the workspace's.
        found[text] = leg(fetched(keys(server, {"LegLength": text}), shared, server.environ))

    class Shared(Kept):
        """Kept by several builders at once."""

        def _one_at_a_time(self):
            return threading.RLock()

    shared = Shared()
    threads = [threading.Thread(target=one, args=(f"{size} mm",)) for size in (300, 400, 500)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {"300 mm": 0.27, "400 mm": 0.36, "500 mm": 0.45}
    assert tables(server) == before


def test_what_may_not_be_spent_is_refused_before_the_write(server, kept):
    with pytest.raises(SourceError, match="may make 6"):
        fetched(keys(server, max_calls=6), kept, server.environ)
    assert posts(server) == []


def test_writing_needs_to_be_allowed():
    source = {"kind": "onshape", "url": ADDRESS, "variables": {"a": 1}}
    with pytest.raises(ConfigError) as caught:
        Plan.parse({"name": "x", "source": source})
    (problem,) = caught.value.problems
    assert problem.where == "source.allow_write"
    assert "source.variables writes to the document" in problem.message
    Plan.parse({"name": "x", "source": {**source, "allow_write": True}})


@pytest.mark.parametrize(
    ("kind", "more", "why"),
    [
        ("v", {}, "a version or microversion never changes"),
        ("m", {}, "a version or microversion never changes"),
        ("w", {"offline": True}, "offline makes no call"),
    ],
)
def test_only_a_workspace_that_can_be_reached_takes_variables(server, kind, more, why):
    wanted = onshape(server.document_url(kind), variables=TALL, allow_write=True, **more)
    with pytest.raises(ConfigError, match=why) as caught:
        stage.preflight(wanted, server.environ)
    assert caught.value.where == "source.variables"


def onshape_plan(server, **more):
    source = {
        "kind": "onshape", "url": server.document_url(), "variables": TALL, "allow_write": True
    }  # fmt: skip
    return Plan.parse({"name": "stand", "source": source, **more})


def test_a_sweep_must_not_write(server):
    (problem,) = [one for one in before_a_sweep(onshape_plan(server)) if one.where == "source.variables"]
    assert "a sweep must not change the document" in problem.message
    assert server.calls == []


def test_without_a_lasting_cache_nothing_is_written(server, tmp_path):
    plan = onshape_plan(server, cache={"mode": "bypass"}, output=str(tmp_path / "out"))
    with pytest.raises(ConfigError, match="variables cannot be set without a cache"):
        build(plan, environ=server.environ)
    assert server.calls == []


def test_a_build_of_its_own_cache_sets_and_puts_back(server, tmp_path):
    before = tables(server)
    more = {"cache": {"dir": str(tmp_path / "cache")}, "output": str(tmp_path / "out"), "until": "graph"}
    report = build(onshape_plan(server, **more), environ=server.environ)
    assert report.figures["mass"] == pytest.approx(0.8 + 0.36 + 0.004)
    assert tables(server) == before
    server.reset()
    build(onshape_plan(server, **more), environ=server.environ)
    assert server.count == 1


def test_what_a_killed_process_left_is_put_back_by_the_next(server, tmp_path):
    before = tables(server)
    command = [
        sys.executable, "-m", "pipeline", "source=onshape", f"source.url='{server.document_url()}'",
        "source.variables={LegLength: '400 mm'}", "source.allow_write=true",
        f"cache.dir='{tmp_path / 'cache'}'", f"output='{tmp_path / 'out'}'", "until=graph", "name=stand",
    ]  # fmt: skip
    environ = {**os.environ, **server.environ}
    process = subprocess.Popen(command, env=environ, stderr=subprocess.DEVNULL)

    def kill(method, target, number):
        if number == 5:
            process.kill()
            process.wait()
        return

    server.fault = kill
    assert process.wait(60) == -signal.SIGKILL
    assert tables(server)[0]["LegLength"] == ("LENGTH", "400 mm")
    server.fault = None
    done = subprocess.run(command, env=environ, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert tables(server) == before


def test_a_table_without_names_is_refused(server, kept):
    server.fault = lambda method, target, number: (
        Fault(200, b'[{"variables": [{"type": "LENGTH"}]}]') if target.endswith("/variables") else None
    )
    with pytest.raises(ProtocolError, match="without a name"):
        fetched(keys(server), kept, server.environ)
