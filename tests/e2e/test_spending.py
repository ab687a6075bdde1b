"""What a user's patience and quota may come to: Ctrl-C, a bound on calls, a sweep."""

import signal
import subprocess
import threading
import time

import pytest

from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.cases import mostly_slow
from tests.support.command import COMMAND, called, environment, linkwright, report_of

STUDIOS = 4


def source_of(server, pin="w"):
    return ["source=onshape", f"source.url='{server.document_url(pin)}'"]


@pytest.mark.slow
def test_ctrl_c_ends_a_build_whose_server_does_not_answer(tmp_path):
    """Within seconds, though the triangles would take half a minute; what arrived is not paid again."""
    slow, asked = threading.Event(), threading.Event()

    def hold(method, target, number):
        if "tessellatedfaces" in target and not slow.is_set():
            asked.set()
            slow.wait(30)
        return

    with OnshapeServer(sample_document(), fault=hold) as server:
        environ = environment(tmp_path, **server.environ)
        line = [str(COMMAND), *source_of(server), "mesh=visual"]
        build = subprocess.Popen(line, cwd=tmp_path, env=environ, stderr=subprocess.PIPE, text=True)
        assert asked.wait(20)
        time.sleep(0.3)
        began = time.monotonic()
        build.send_signal(signal.SIGINT)
        _, message = build.communicate(timeout=20)
        ended = time.monotonic() - began
        slow.set()
        assert build.returncode == 130
        assert ended < 5
        assert message.count("error:") == 1
        assert "interrupted" in message
        assert "asking again" not in message
        server.reset()
        linkwright(tmp_path, *line[1:], environ=environ, status=0)
        assert server.count <= 1 + STUDIOS


@pytest.mark.slow
def test_max_calls_bounds_what_is_asked_again_too(tmp_path):
    """Every reply with triangles is cut short once, which costs a call each."""
    cut: set[str] = set()

    def short(method, target, number):
        if "tessellatedfaces" in target and target not in cut:
            cut.add(target)
            return Fault(200, b'{"bodies": [')
        return None

    limit = 1 + 2 * STUDIOS
    with OnshapeServer(sample_document(), fault=short) as server:
        environ = environment(tmp_path, **server.environ)
        line = [*source_of(server), f"source.max_calls={limit}"]
        done = linkwright(tmp_path, *line, environ=environ, status=1)
        assert "source.max_calls" in done.stderr
        assert server.count <= limit
        server.reset()
        linkwright(tmp_path, *line, environ=environ, status=0)
        assert server.count <= limit


@pytest.mark.slow
def test_without_quota_an_edited_document_is_built_as_fetched_last(tmp_path):
    document = sample_document()
    with OnshapeServer(document) as server:
        environ = environment(tmp_path, **server.environ)
        line = [*source_of(server), "output=arm", "until=graph"]
        linkwright(tmp_path, *line, environ=environ, status=0)
        before = (tmp_path / "arm.graph" / "robot.json").read_bytes()
        server.edit(document.edited(document.studios[0].name))
        server.fault = lambda method, target, number: Fault(402) if "/elements" in target else None
        stale = linkwright(tmp_path, *line, environ=environ, status=3)
        assert "W-QUOTA" in stale.stdout
        assert "source.stale=true" in stale.stdout
        assert (tmp_path / "arm.graph" / "robot.json").read_bytes() == before
        report = report_of(tmp_path / "arm.graph")
        assert (report["status"], report["exit_status"]) == ("stale", 3)
        wanted = linkwright(tmp_path, *line, "source.stale=true", environ=environ, status=0)
        assert "W-QUOTA" in wanted.stdout
        report = report_of(tmp_path / "arm.graph")
        assert (report["status"], report["exit_status"]) == ("built", 0)
        server.fault = None
        linkwright(tmp_path, *line, environ=environ, status=0)


@pytest.mark.slow
@pytest.mark.parametrize("launcher", mostly_slow(["basic", "joblib"], keep=1))
def test_the_jobs_of_a_sweep_share_one_state_of_a_workspace(tmp_path, launcher):
    with OnshapeServer(sample_document()) as server:
        environ = environment(tmp_path, **server.environ)
        line = ["-m", *source_of(server), "root=fixed,free", f"hydra/launcher={launcher}"]
        linkwright(tmp_path, *line, environ=environ, status=0)
        assert server.count == 1 + 2 * STUDIOS
        server.reset()
        linkwright(tmp_path, *line, environ=environ, status=0)
        assert server.count == 1
    reports = [report_of(path.parent) for path in tmp_path.rglob("report.json")]
    assert len(reports) == 2
    assert len({report["source"]["microversion"] for report in reports}) == 1


@pytest.mark.slow
@pytest.mark.parametrize("pin", ["v", "w"])
def test_a_refusal_of_faces_that_passes_changes_no_byte_for_good(tmp_path, pin):
    """The build with glTF differs; the next one has the files that it would have had without the fault."""

    def outputs(here, server, *more):
        here.mkdir(exist_ok=True)
        environ = environment(here, **server.environ, LINKWRIGHT_PAGE="plain")
        line = [*source_of(server, pin), "mesh=visual", "name=arm"]
        called(here, *line, "until=export", *more, environ=environ, status=0)
        return report_of(here / "outputs" / "arm")["outputs"]

    def refuse(method, target, number):
        return Fault(400) if "tessellatedfaces" in target else None

    with OnshapeServer(sample_document()) as server:
        right = outputs(tmp_path / "right", server)
        server.fault = refuse
        assert outputs(tmp_path / "arm", server) != right
        server.fault = None
        assert outputs(tmp_path / "arm", server, "source.offline=true") != right
        assert outputs(tmp_path / "arm", server) == right
        asked = server.count
        assert outputs(tmp_path / "arm", server) == right
        assert server.count == asked + (pin == "w")
