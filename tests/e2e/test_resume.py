"""The command against a server that fails: one message, and the next run goes on where it ended."""

import pytest

from tests.fake_onshape.faults import Fault
from tests.fake_onshape.server import OnshapeServer
from tests.support.cases import mostly_slow
from tests.support.command import called, environment, linkwright, report_of
from tests.support.faulty import CALLS, desk


@pytest.mark.parametrize(
    ("fault", "output_text"),
    mostly_slow(
        [
            (Fault(402), "the yearly quota of API calls is used up (402)"),
            (Fault(429, headers={"Retry-After": "5623"}), "source.max_wait allows 120 s"),
        ],
        keep=1,
    ),
)
def test_a_stopped_build_shows_how_to_go_on_and_goes_on(tmp_path, fault, output_text):
    with OnshapeServer(desk()) as server:
        environ = environment(tmp_path, **server.environ)
        arguments = ["source=onshape", f"source.url='{server.document_url()}'", "until=fetch", "output=desk"]
        server.fault = lambda method, target, number: fault if number == 4 else None
        stopped = linkwright(tmp_path, *arguments, environ=environ, status=1)
        assert output_text in stopped.stderr
        assert "kept" in stopped.stderr
        assert "Traceback" not in stopped.stderr
        assert report_of(tmp_path / "desk.failed")["calls"]["made"] == server.count
        server.fault = None
        called(tmp_path, *arguments, environ=environ, status=0)
        arrived = [target for _, target, status in server.calls if status == 200 and "/w/" not in target]
        assert len(set(arrived)) == len(arrived) == CALLS - 1
        shown = called(tmp_path, "cache", "info", environ=environ).stdout
        assert f" {server.count} " in shown
        assert not any(secret in shown for secret in server.keys)
