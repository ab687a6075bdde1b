"""Variables of a document, set for one build: what is written, what it costs, and that it is put back."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.run.build import build
from linkwright.pipeline.run.preflight import sweep_problems
from linkwright.stages import fetch as stage
from linkwright.stages.fetch.onshape.asking.variables import expression
from linkwright.stages.fetch.source import Calls
from linkwright.stages.graph import build_robot
from linkwright.stages.robot.errors import (
    AuthError,
    ConfigError,
    NotFound,
    ProtocolError,
    QuotaExhausted,
    RateLimited,
    SourceError,
)
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.fake_onshape.settable import driven_stand
from tests.support.building import plan_of
from tests.support.kept import ADDRESS, Kept, fetched, onshape

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


def test_all_variables_that_the_document_lacks_are_reported_and_nothing_is_written(server, kept):
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


LATER = {"Retry-After": "3600"}


@pytest.mark.parametrize(("status", "kind"), [(429, RateLimited), (402, QuotaExhausted)])
def test_what_stops_all_calls_after_the_write_does_not_stop_the_put_back(server, kept, status, kind):
    before = tables(server)
    server.fault = lambda method, target, at: (
        Fault(status, b"{}", LATER) if at > 4 and target.endswith("currentmicroversion") else None
    )
    with pytest.raises(kind):
        fetched(keys(server), kept, server.environ)
    assert tables(server) == before
    assert len(posts(server)) == 2


@pytest.mark.parametrize("fault", [Fault(503, b"{}"), Fault(silent=True), Fault(body=None, cut=0, claimed=5)])
def test_a_put_back_that_fails_in_passing_is_done_again(server, kept, fault):
    before = tables(server)
    server.fault = lambda method, target, at: fault if at == 6 else None
    assert leg(fetched(keys(server), kept, server.environ)) == 0.36
    assert tables(server) == before
    assert len(posts(server)) == 3


def test_each_studio_is_put_back_whatever_becomes_of_the_others(server, kept):
    before = tables(server)
    stopped = []

    def fault(method, target, at):
        if at > 5 and target.endswith("currentmicroversion"):
            stopped.append(target)
            return Fault(402, b"{}")
        # The first studio's put-back.
        return (
            Fault(429, b"{}", LATER) if stopped and method == "POST" and target == posts(server)[0] else None
        )

    server.fault = fault
    with pytest.raises(SourceError) as caught:
        fetched(keys(server, {**TALL, "Other": "20 deg"}), kept, server.environ)
    changed = [
        index for index, (then, now) in enumerate(zip(before, tables(server), strict=True)) if then != now
    ]
    assert len(changed) == 1
    still, undone = [("LegLength = 200 mm", "Other = 10 deg"), ("Other = 10 deg", "LegLength = 200 mm")][
        changed[0]
    ]
    assert still in caught.value.message
    assert undone not in caught.value.message
    assert "yearly quota" in caught.value.message
    assert "it asks to wait 3600 s" in caught.value.message
    assert "in 60 min" in caught.value.hint
    assert f"variable studio {posts(server)[0].split('/')[-2]} was not restored" in caught.value.message
    server.fault = None
    server.reset()
    assert leg(fetched(onshape(server.document_url()), kept, server.environ)) == 0.18
    assert tables(server) == before
    assert len(posts(server)) == 1


def test_what_cannot_be_looked_at_is_not_written(server, kept):
    abandoned(server, kept)
    server.fault = lambda method, target, at: Fault(429, b"{}", LATER)
    with pytest.raises(SourceError, match="could not be read, so it was not changed") as caught:
        fetched(onshape(server.document_url()), kept, server.environ)
    assert "LegLength = 200 mm" in caught.value.message
    assert "in 60 min" in caught.value.hint
    assert posts(server) == []


def abandoned(server, kept):
    """A build that wrote and could not put back: what is remembered is all that is left of it."""
    server.fault = lambda method, target, at: Fault(403, b"{}") if at == 6 else None
    with pytest.raises(SourceError, match="could not be restored to LegLength = 200 mm") as caught:
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
    assert "restoring the variables that a killed build had changed" in lines
    lines.clear()
    fetched(keys(server, wanted), kept, server.environ, lines)
    assert not [line for line in lines if "restoring the variables" in line]


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
    assert any("was edited in the meantime and is left as it is" in line for line in lines)


def test_two_builds_with_other_values_do_not_disturb_each_other(server):
    before = tables(server)
    found = {}

    def one(text):
        # Each in its own memory, as two computers have; the lock is the workspace's.
        found[text] = leg(fetched(keys(server, {"LegLength": text}), shared, server.environ))

    shared = Shared()
    threads = [threading.Thread(target=one, args=(f"{size} mm",)) for size in (300, 400, 500)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {"300 mm": 0.27, "400 mm": 0.36, "500 mm": 0.45}
    assert tables(server) == before


def test_what_may_not_be_spent_is_refused_before_the_write(server, kept):
    with pytest.raises(SourceError, match="max_calls is 6"):
        fetched(keys(server, max_calls=6), kept, server.environ)
    assert posts(server) == []


def test_what_the_build_needs_afterwards_is_counted_before_the_write(server, kept):
    """Known since the last build: a definition and two calls for each of three part studios."""
    fetched(onshape(server.document_url()), kept, server.environ)
    server.reset()
    total = 4 + 4 + 1 + 2 * 3
    with pytest.raises(SourceError, match=f"made 4 calls and needs {total - 4} more") as caught:
        fetched(keys(server, max_calls=total - 1), kept, server.environ)
    assert f"source.max_calls={total}" in caught.value.hint
    assert posts(server) == []
    lines = []
    assert fetched(keys(server, max_calls=total), kept, server.environ, lines).calls == total
    assert any(f"at least 7 more, {total} in all" in line for line in lines)


class Shared(Kept):
    """Kept by several builders at once."""

    def _one_at_a_time(self):
        return threading.RLock()


def test_a_plain_build_waits_until_the_variables_are_put_back(server):
    written, found, reading = threading.Event(), [], threading.Event()

    class Late(Shared):
        """The plain build finds nothing to put back, just before the other one begins to write."""

        def recall(self, subject):
            fact = super().recall(subject)
            if threading.current_thread() is plain and subject.endswith("#variables"):
                reading.set()
                assert written.wait(20)
            return fact

    def fault(method, target, number):
        if number == 5:
            written.set()
            time.sleep(0.3)
        return

    def build_plainly():
        found.append(leg(fetched(onshape(server.document_url()), shared, server.environ)))

    shared = Late()
    plain = threading.Thread(target=build_plainly)
    server.fault = fault
    plain.start()
    assert reading.wait(20)
    assert leg(fetched(keys(server), shared, server.environ)) == 0.36
    plain.join()
    assert found == [0.18]


@pytest.mark.parametrize("wanted", [{}, {"LegLength": "300 mm"}])
def test_what_is_left_while_a_build_waits_for_its_turn_is_put_back_first(server, wanted):
    class Unseen(Kept):
        """What another build left is there only at the second look."""

        looks = -1

        def recall(self, subject):
            if subject.endswith("#variables") and self.looks >= 0:
                self.looks += 1
                return None if self.looks == 1 else super().recall(subject)
            return super().recall(subject)

    before, kept = tables(server), Unseen()
    abandoned(server, kept)
    kept.looks = 0
    made = fetched(keys(server, wanted), kept, server.environ)
    assert kept.looks > 1
    assert leg(made) == (0.27 if wanted else 0.18)
    assert tables(server) == before


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
    (problem,) = [one for one in sweep_problems(onshape_plan(server)) if one.where == "source.variables"]
    assert "a sweep must not change the document" in problem.message
    assert server.calls == []


def test_without_a_lasting_cache_nothing_is_written(server, tmp_path):
    plan = onshape_plan(server, cache={"mode": "bypass"}, output=str(tmp_path / "out"))
    with pytest.raises(ConfigError, match="variables cannot be set without the cache"):
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


@pytest.mark.slow
def test_what_a_killed_process_left_is_put_back_by_the_next(server, tmp_path):
    before = tables(server)
    command = [
        sys.executable, "-m", "linkwright", "source=onshape", f"source.url='{server.document_url()}'",
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
