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
from linkwright.pipeline.run.preflight import job_problems
from linkwright.stages import fetch as stage
from linkwright.stages.fetch.onshape.asking.variables import expression
from linkwright.stages.fetch.source import Calls
from linkwright.stages.graph import build_robot
from linkwright.stages.robot import errors
from linkwright.stages.robot.errors import AuthError, ConfigError, NotFound, ProtocolError, SourceError
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.fake_onshape.settable import driven_stand
from tests.support.building import plan_of
from tests.support.kept import ADDRESS, Kept, fetched, onshape
from tests.support.traffic import at_call, at_path

TALL = {"LegLength": "400 mm"}
BOTH = {**TALL, "Other": "20 deg"}
LATER = {"Retry-After": "3600"}


@pytest.fixture
def server():
    """At the test's end the document's tables are as they were, unless it sets `leaves`."""
    with OnshapeServer(driven_stand()) as server:
        before, server.leaves = tables(server), False
        yield server
        assert server.leaves or tables(server) == before


def keys(server, variables=TALL, **more):
    return onshape(server.document_url(), variables=variables, allow_write=True, **more)


def fetch(server, kept, variables=TALL, lines=None, **more):
    """What a build that sets variables fetches; a plain build without any."""
    wanted = keys(server, variables, **more) if variables else onshape(server.document_url(), **more)
    return fetched(wanted, kept, server.environ, lines)


def fails(server, kept, variables=TALL, error=SourceError, match=None, **more):
    spent, before = Calls(), server.count
    wanted = keys(server, variables, **more) if variables else onshape(server.document_url(), **more)
    with pytest.raises(error, match=match) as caught:
        fetched(wanted, kept, server.environ, calls=spent)
    assert spent.made == server.count - before
    return caught.value


def leg(made):
    robot = build_robot(made.bundle, plan_of())
    return next(round(link.inertial.mass, 9) for link in robot.links if link.name == "leg")


def tables(server):
    return [studio.table for studio in server.document.variable_studios]


def posts(server):
    return [target for method, target, _ in server.calls if method == "POST"]


def at_post(fault):
    return lambda method, target, number: fault if method == "POST" else None


def test_a_variable_changes_what_is_built_and_is_put_back(server, kept):
    sent, post = [], server.replies.post
    server.replies.post = lambda path, body: sent.append(body) or post(path, body)
    made = fetch(server, kept)
    # The table is written whole.
    assert [word in sent[0] for word in (b'"Spare"', b'"400 mm"', b'"value"')] == [True, True, False]
    assert leg(made) == 0.36
    assert len(posts(server)) == 2
    # Probe, tabs, two tables; write, probe, write back, probe; then a cold build of a microversion.
    assert made.calls == server.count == 4 + 4 + 1 + 2 * 3
    assert made.bundle.root["microversion"] != server.document.microversion
    assert leg(fetch(server, kept, {})) == 0.18


def test_the_same_values_again_cost_one_call_and_no_write(server, kept):
    made = fetch(server, kept)
    server.reset()
    again = fetch(server, kept)
    assert (again.calls, posts(server), again.bundle) == (1, [], made.bundle)
    assert leg(fetch(server, kept, {"LegLength": 0.3})) == 0.27
    assert len(posts(server)) == 2


def test_values_that_are_there_already_need_no_write(server, kept):
    made = fetch(server, kept, {"LegLength": "200 mm", "Spare": "3"})
    assert (posts(server), leg(made)) == ([], 0.18)


def test_bare_numbers_are_si():
    values = [(0.25, "LENGTH"), (1, "ANGLE"), (2, "NUMBER"), (True, "ANY"), ("#a + 1 mm", "LENGTH")]
    assert [expression(*pair) for pair in values] == ["0.25 m", "1 rad", "2", "true", "#a + 1 mm"]


def test_variables_that_the_document_lacks_are_reported(server, kept):
    problems = fails(server, kept, {**TALL, "Leglength": 1, "Width": 2}).problems
    assert [problem.where[17:] for problem in problems] == ["Leglength", "Width"]
    assert problems[0].hint == "it has: LegLength, Other, Spare, Tilt"
    assert posts(server) == []


def test_a_variable_of_two_studios_is_refused(server, kept):
    server.leaves = True
    server.document.variable_studio("More", {"LegLength": ("LENGTH", "1 m")})
    (problem,) = fails(server, kept).problems
    assert (problem.where, problem.message[:18]) == ("source.variables.LegLength", "2 variable studios")
    assert posts(server) == []


def test_a_studio_with_a_configured_variable_is_left_alone(server, kept):
    server.leaves = True
    server.document.variable_studios[0].table["Spare"] = ("NUMBER", "")
    fails(server, kept, match="#Spare")
    assert posts(server) == []


def after_the_write(status):
    """A fault of each call after the write that asks for the state of the document."""
    fault = at_path(Fault(status, b"{}", LATER), "currentmicroversion")
    return lambda method, target, number: fault(method, target, number) if number > 4 else None


@pytest.mark.parametrize(
    ("fault", "kind"),
    [
        # The fifth call asks what the changed state is, the seventh what the state is after it.
        *((at_call(Fault(404, b"{}"), number), NotFound) for number in (5, 7)),
        (after_the_write(429), errors.RateLimited),
        (after_the_write(402), errors.QuotaExhausted),
    ],
)
def test_a_failure_after_the_write_leaves_the_document_as_it_was(server, kept, fault, kind):
    """Also one that stops all calls."""
    server.fault = fault
    fails(server, kept, error=kind)
    assert len(posts(server)) == 2


def test_ctrl_c_after_the_write_leaves_the_document_as_it_was(server, kept):
    main = threading.main_thread().ident

    def interrupt(method, target, number):
        if number == 5:
            # The main thread waits for this very reply.
            signal.pthread_kill(main, signal.SIGINT)
            time.sleep(0.2)

    server.fault = interrupt
    fails(server, kept, error=KeyboardInterrupt)
    assert len(posts(server)) == 2


@pytest.mark.parametrize(
    ("status", "kind"), [(403, AuthError), (404, NotFound), (402, errors.QuotaExhausted)]
)
def test_a_refused_write_leaves_nothing_to_put_back(server, kept, status, kind):
    server.fault = at_post(Fault(status, b"{}"))
    error = fails(server, kept, error=kind)
    assert ("give the key write permission" in error.hint) == (status == 403)
    assert len(posts(server)) == 1
    server.fault, lines = None, []
    fetch(server, kept, {}, lines)
    assert not [line for line in lines if "putting back" in line]


def test_the_studio_that_was_written_alone_is_put_back(server, kept):
    server.fault = at_call(Fault(403, b"{}"), 5)
    fails(server, kept, BOTH, AuthError)
    first, _, third = posts(server)
    assert first == third


@pytest.mark.parametrize("fault", [Fault(503, b"{}"), Fault(silent=True), Fault(body=None, cut=0, claimed=5)])
def test_a_put_back_that_fails_in_passing_is_done_again(server, kept, fault):
    server.fault = at_call(fault, 6)
    assert leg(fetch(server, kept)) == 0.36
    assert len(posts(server)) == 3


def test_a_studio_is_put_back_whatever_becomes_of_others(server, kept):
    before, stopped = tables(server), []

    def fault(method, target, at):
        if at > 5 and target.endswith("currentmicroversion"):
            stopped.append(target)
            return Fault(402, b"{}")
        # The first studio's put-back.
        first = stopped and method == "POST" and target == posts(server)[0]
        return Fault(429, b"{}", LATER) if first else None

    server.fault = fault
    error = fails(server, kept, BOTH)
    (changed,) = [index for index, table in enumerate(tables(server)) if table != before[index]]
    settings = ["LegLength = 200 mm", "Other = 10 deg"]
    assert settings[changed] in error.message
    assert settings[1 - changed] not in error.message
    assert "yearly quota" in error.message
    assert "it asks to wait 3600 s" in error.message
    assert "in 60 min" in error.hint
    assert f"variable studio {posts(server)[0].split('/')[-2]} was not restored" in error.message
    server.fault = None
    server.reset()
    assert leg(fetch(server, kept, {})) == 0.18
    assert len(posts(server)) == 1


def abandoned(server, kept):
    """A build that wrote and could not put back: what is remembered is all that is left of it."""
    server.fault = at_call(Fault(403, b"{}"), 6)
    error = fails(server, kept, match="could not be restored to LegLength = 200 mm")
    assert "run the same command again" in error.hint
    assert tables(server)[0]["LegLength"] == ("LENGTH", "400 mm")
    server.fault = None
    server.reset()


def test_a_studio_that_cannot_be_read_is_not_written(server, kept):
    server.leaves = True
    abandoned(server, kept)
    server.fault = lambda method, target, at: Fault(429, b"{}", LATER)
    error = fails(server, kept, {}, match="could not be read, so it was not changed")
    assert "LegLength = 200 mm" in error.message
    assert "in 60 min" in error.hint
    assert posts(server) == []


@pytest.mark.parametrize(("variables", "mass"), [({}, 0.18), (TALL, 0.36), ({"LegLength": "300 mm"}, 0.27)])
def test_values_that_a_build_left_are_put_back_by_the_next(server, kept, variables, mass):
    abandoned(server, kept)
    for times in (1, 0):
        lines = []
        assert leg(fetch(server, kept, variables, lines)) == mass
        assert lines.count("restoring the variables that a killed build had changed") == times


def test_a_table_that_was_edited_since_is_left_as_it_is(server, kept):
    server.leaves = True
    abandoned(server, kept)
    studio = server.document.variable_studios[0]
    edited = {**studio.table, "LegLength": ("LENGTH", "250 mm")}
    server.edit(server.document.with_variables(studio.element, edited))
    server.reset()
    lines = []
    assert leg(fetch(server, kept, {}, lines)) == 0.225
    assert posts(server) == []
    assert any("was edited in the meantime and is left as it is" in line for line in lines)


class Shared(Kept):
    """Kept by several builders at once."""

    def _one_at_a_time(self):
        return threading.RLock()


def test_two_builds_with_other_values_do_not_disturb_each_other(server):
    legs, shared = {}, Shared()

    def build_with(size):
        # Each in its own memory, as two computers have; the lock is the workspace's.
        legs[size] = leg(fetch(server, shared, {"LegLength": f"{size} mm"}))

    threads = [threading.Thread(target=build_with, args=(size,)) for size in (300, 400, 500)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert legs == {300: 0.27, 400: 0.36, 500: 0.45}


def test_a_write_beyond_max_calls_is_refused(server, kept):
    fails(server, kept, match="max_calls is 6", max_calls=6)
    assert posts(server) == []


def test_later_calls_are_counted_before_the_write(server, kept):
    """Known since the last build: a definition and two calls for each of three part studios."""
    fetch(server, kept, {})
    server.reset()
    total = 4 + 4 + 1 + 2 * 3
    needs = f"made 4 calls and needs {total - 4} more"
    assert f"source.max_calls={total}" in fails(server, kept, match=needs, max_calls=total - 1).hint
    assert posts(server) == []
    lines = []
    assert fetch(server, kept, lines=lines, max_calls=total).calls == total
    assert any(f"at least 7 more, {total} in all" in line for line in lines)


def test_a_plain_build_waits_until_the_variables_are_put_back(server):
    written, legs, reading = threading.Event(), [], threading.Event()

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

    shared = Late()
    plain = threading.Thread(target=lambda: legs.append(leg(fetch(server, shared, {}))))
    server.fault = fault
    plain.start()
    assert reading.wait(20)
    assert leg(fetch(server, shared)) == 0.36
    plain.join()
    assert legs == [0.18]


@pytest.mark.parametrize("variables", [{}, {"LegLength": "300 mm"}])
def test_variables_left_before_a_turn_are_put_back_first(server, variables):
    class Unseen(Kept):
        """What another build left is there only at the second look."""

        looks = -1

        def recall(self, subject):
            if subject.endswith("#variables") and self.looks >= 0:
                self.looks += 1
                return None if self.looks == 1 else super().recall(subject)
            return super().recall(subject)

    kept = Unseen()
    abandoned(server, kept)
    kept.looks = 0
    assert leg(fetch(server, kept, variables)) == (0.27 if variables else 0.18)
    assert kept.looks > 1


def test_writing_needs_to_be_allowed():
    source = {"kind": "onshape", "url": ADDRESS, "variables": {"a": 1}}
    with pytest.raises(ConfigError) as caught:
        Plan.parse({"name": "x", "source": source})
    (problem,) = caught.value.problems
    assert problem.where == "source.allow_write"
    assert "source.variables writes to the document" in problem.message
    Plan.parse({"name": "x", "source": {**source, "allow_write": True}})


def test_a_workspace_online_alone_takes_variables(server):
    pinned, offline = "a version or microversion never changes", "offline makes no call"
    for kind, more, why in (("v", {}, pinned), ("m", {}, pinned), ("w", {"offline": True}, offline)):
        wanted = onshape(server.document_url(kind), variables=TALL, allow_write=True, **more)
        with pytest.raises(ConfigError, match=why) as caught:
            stage.preflight(wanted, server.environ)
        assert caught.value.where == "source.variables"


def onshape_plan(server, **more):
    source = {"kind": "onshape", "url": server.document_url(), "variables": TALL, "allow_write": True}
    return Plan.parse({"name": "stand", "source": source, **more})


def test_sweeps_and_cacheless_builds_may_not_write(server, tmp_path):
    problems = {problem.where: problem.message for problem in job_problems(onshape_plan(server))}
    assert "a sweep must not change the document" in problems["source.variables"]
    plan = onshape_plan(server, cache={"mode": "bypass"}, output=str(tmp_path / "out"))
    with pytest.raises(ConfigError, match="variables cannot be set without the cache"):
        build(plan, environ=server.environ)
    assert server.calls == []


@pytest.mark.slow
def test_values_of_a_killed_process_are_put_back_by_the_next(server, tmp_path):
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

    server.fault = kill
    assert process.wait(60) == -signal.SIGKILL
    assert tables(server)[0]["LegLength"] == ("LENGTH", "400 mm")
    server.fault = None
    done = subprocess.run(command, env=environ, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_table_without_names_is_refused(server, kept):
    server.fault = at_path(Fault(200, b'[{"variables": [{"type": "LENGTH"}]}]'), "/variables")
    fails(server, kept, error=ProtocolError, match="without a name")
