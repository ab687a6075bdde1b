"""What a user's patience and quota may come to: Ctrl-C, a bound on calls, a sweep."""

import json
import signal
import subprocess
import threading
import time
from pathlib import Path

import pytest

from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.cases import mostly_slow
from tests.support.command import COMMAND, called, environment, linkwright

STUDIOS = 4


@pytest.mark.slow
def test_ctrl_c_ends_a_build_whose_server_does_not_answer(tmp_path: Path) -> None:
    """Within seconds, though the triangles would take half a minute; what arrived is not paid again."""
    slow, asked = threading.Event(), threading.Event()

    def hold(method: str, target: str, number: int) -> Fault | None:
        if "tessellatedfaces" in target and not slow.is_set():
            asked.set()
            slow.wait(30)
        return None

    with OnshapeServer(sample_document(), fault=hold) as server:
        environ = environment(tmp_path, **server.environ)
        line = [str(COMMAND), "source=onshape", f"source.url='{server.document_url()}'", "mesh=visual"]
        build = subprocess.Popen(
            line, cwd=tmp_path, env=environ, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert asked.wait(20)
        time.sleep(0.3)
        began = time.monotonic()
        build.send_signal(signal.SIGINT)
        _, output_text = build.communicate(timeout=20)
        ended = time.monotonic() - began
        slow.set()
        assert build.returncode == 130
        assert ended < 5
        assert output_text.count("error:") == 1
        assert "interrupted" in output_text
        assert "asking again" not in output_text
        server.reset()
        done = linkwright(tmp_path, *line[1:], environ=environ)
        assert done.returncode == 0, done.stderr
        assert server.count <= 1 + STUDIOS


@pytest.mark.slow
def test_max_calls_bounds_what_is_asked_again_too(tmp_path: Path) -> None:
    """Every reply with triangles is cut short once, which costs a call each."""
    cut: set[str] = set()

    def short(method: str, target: str, number: int) -> Fault | None:
        if "tessellatedfaces" in target and target not in cut:
            cut.add(target)
            return Fault(200, b'{"bodies": [')
        return None

    limit = 1 + 2 * STUDIOS
    with OnshapeServer(sample_document(), fault=short) as server:
        environ = environment(tmp_path, **server.environ)
        line = ["source=onshape", f"source.url='{server.document_url()}'", f"source.max_calls={limit}"]
        done = linkwright(tmp_path, *line, environ=environ)
        assert done.returncode == 1
        assert "source.max_calls" in done.stderr
        assert server.count <= limit
        server.reset()
        assert linkwright(tmp_path, *line, environ=environ).returncode == 0
        assert server.count <= limit


@pytest.mark.slow
def test_an_edit_that_the_quota_does_not_allow_builds_what_was_fetched_last_with_exit_status_3(
    tmp_path: Path,
) -> None:
    document = sample_document()
    with OnshapeServer(document) as server:
        environ = environment(tmp_path, **server.environ)
        line = ["source=onshape", f"source.url='{server.document_url()}'", "output=arm", "until=graph"]
        assert linkwright(tmp_path, *line, environ=environ).returncode == 0
        before = (tmp_path / "arm.graph" / "robot.json").read_bytes()
        server.edit(document.edited(document.studios[0].name))
        server.fault = lambda method, target, number: Fault(402) if "/elements" in target else None
        stale = linkwright(tmp_path, *line, environ=environ)
        assert stale.returncode == 3, stale.stderr
        assert "W-QUOTA" in stale.stdout
        assert "source.stale=true" in stale.stdout
        assert (tmp_path / "arm.graph" / "robot.json").read_bytes() == before
        report = json.loads((tmp_path / "arm.graph" / "report.json").read_text())
        assert (report["status"], report["exit_status"]) == ("stale", 3)
        wanted = linkwright(tmp_path, *line, "source.stale=true", environ=environ)
        assert wanted.returncode == 0, wanted.stderr
        assert "W-QUOTA" in wanted.stdout
        report = json.loads((tmp_path / "arm.graph" / "report.json").read_text())
        assert (report["status"], report["exit_status"]) == ("built", 0)
        server.fault = None
        assert linkwright(tmp_path, *line, environ=environ).returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize("launcher", mostly_slow(["basic", "joblib"], keep=1))
def test_the_jobs_of_a_sweep_share_one_state_of_a_workspace(tmp_path: Path, launcher: str) -> None:
    with OnshapeServer(sample_document()) as server:
        environ = environment(tmp_path, **server.environ)
        line = ["-m", "source=onshape", f"source.url='{server.document_url()}'"]
        line += ["root=fixed,free", f"hydra/launcher={launcher}"]
        assert linkwright(tmp_path, *line, environ=environ).returncode == 0
        assert server.count == 1 + 2 * STUDIOS
        server.reset()
        assert linkwright(tmp_path, *line, environ=environ).returncode == 0
        assert server.count == 1
    reports = [json.loads(path.read_text()) for path in tmp_path.rglob("report.json")]
    assert len(reports) == 2
    assert len({report["source"]["microversion"] for report in reports}) == 1


@pytest.mark.slow
@pytest.mark.parametrize("pin", ["v", "w"])
def test_a_refusal_of_faces_that_passes_changes_no_byte_for_good(tmp_path: Path, pin: str) -> None:
    """The build with glTF differs; the next one has the files that it would have had without the fault."""

    def outputs(here: Path, server: OnshapeServer, *more: str) -> dict[str, str]:
        here.mkdir(exist_ok=True)
        environ = environment(here, **server.environ, LINKWRIGHT_PAGE="plain")
        line = ["source=onshape", f"source.url='{server.document_url(pin)}'", "mesh=visual", "name=arm"]
        assert called(here, *line, "until=export", *more, environ=environ).returncode == 0
        report = json.loads((here / "outputs" / "arm" / "report.json").read_text())
        found: dict[str, str] = report["outputs"]
        return found

    def refuse(method: str, target: str, number: int) -> Fault | None:
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
