"""Every fault at the first, a middle and the last call, and random faults over random runs: the right bundle
or the right message.

Whatever happened, a clean run afterwards ends with the right bundle, and no reply that once arrived
is asked for again.
"""

import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from linkwright.stages.fetch.onshape.api.http_errors import Declined
from linkwright.stages.robot.errors import (
    AuthError,
    NotFound,
    Offline,
    ProtocolError,
    QuotaExhausted,
    RateLimited,
    SourceError,
)
from tests.fake_onshape.faults import Fault
from tests.fake_onshape.server import OnshapeServer
from tests.support.cases import mostly_slow
from tests.support.faulty import CALLS, DECLINED, FINAL, PASSING, SLOW, Fetching, desk, reference
from tests.support.places import PROJECT

PLACES = {"first": 0, "middle": 3, "last": CALLS - 1}
DOCUMENT = desk()

TOLD = {
    "204": ProtocolError,
    "400": SourceError,
    "401": AuthError,
    "402": QuotaExhausted,
    "403": AuthError,
    "404": NotFound,
    "406": Declined,
    "410": Declined,
    "429 for an hour": RateLimited,
    "503 for an hour": ProtocolError,
    "307 to nowhere": ProtocolError,
    "307 to others": ProtocolError,
    "a page": ProtocolError,
    "429": RateLimited,
    "429 without a time": RateLimited,
    "slow": Offline,
    "hangs up": Offline,
    "resets at once": Offline,
}
"""The error that a fault leads to where it does not pass; ProtocolError for all others."""

TRIED_OTHERWISE = {(fault, "last") for fault in DECLINED}
"""The last call is for triangles: where these are declined, another way is tried."""
FINAL_AT = sorted({(fault, place) for fault in FINAL for place in PLACES} - TRIED_OTHERWISE)


@pytest.fixture(scope="module")
def right():
    return reference(DOCUMENT)


@pytest.fixture(scope="module")
def server():
    with OnshapeServer(DOCUMENT) as running:
        yield running


@pytest.fixture
def fetching(server, tmp_path):
    server.reset()
    return Fetching(server, tmp_path / "cache")


def assert_resumes(fetching, right, *before):
    """A clean run ends well, and over all runs each reply arrived once."""
    bundle, last = fetching.run({})
    assert bundle == right
    arrived = sum((trouble.sound for trouble in before), last.sound)
    assert set(arrived.values()) == {1}
    assert len(arrived) == CALLS


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("fault", {**PASSING, **SLOW})
def test_a_passing_fault_ends_with_the_right_bundle(fetching, right, fault, place):
    bundle, met = fetching.run({PLACES[place]: {**PASSING, **SLOW}[fault]})
    assert bundle == right
    assert_resumes(fetching, right, met)
    assert len(fetching.server.calls) == CALLS + 1


@pytest.mark.parametrize(("fault", "place"), FINAL_AT)
def test_a_final_fault_is_reported_and_replies_are_kept(fetching, right, fault, place):
    error, met = fetching.run({PLACES[place]: FINAL[fault]})
    assert isinstance(error, TOLD[fault])
    assert error.where == fetching.server.url.removeprefix("http://")
    assert error.hint
    assert_resumes(fetching, right, met)


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("fault", {**PASSING, **SLOW})
def test_a_lasting_fault_is_reported_after_a_few_attempts(fetching, right, fault, place):
    error, met = fetching.run({PLACES[place]: {**PASSING, **SLOW}[fault]}, stubborn=True)
    assert type(error) is TOLD.get(fault, ProtocolError)
    assert_resumes(fetching, right, met)


@pytest.mark.parametrize("place", PLACES)
def test_the_end_of_the_quota_lets_no_call_begin(fetching, place):
    """Those that were on their way beside it may still arrive."""
    error, _ = fetching.run({PLACES[place]: Fault(402)})
    assert isinstance(error, QuotaExhausted)
    assert len(fetching.server.calls) <= PLACES[place] + 4


# Where triangles are declined glTF stands in, which is another robot: the matrix has those.
FAULTS = {**PASSING, **{name: fault for name, fault in FINAL.items() if name not in DECLINED}}
SCHEDULES = st.lists(
    st.dictionaries(st.integers(0, CALLS + 5), st.sampled_from(sorted(FAULTS)), max_size=8),
    min_size=1,
    max_size=4,
)


@pytest.mark.slow
@settings(max_examples=80, suppress_health_check=[HealthCheck.too_slow])
@given(runs=SCHEDULES, kind=st.sampled_from("mw"))
def test_a_clean_run_is_right_after_any_faults(server, runs, kind):
    server.reset()
    arrived, right = Counter(), reference(DOCUMENT, kind)
    with tempfile.TemporaryDirectory() as folder:
        fetching = Fetching(server, Path(folder) / "cache", kind)
        for faults in [*runs, {}]:
            outcome, met = fetching.run({number: FAULTS[name] for number, name in faults.items()})
            assert isinstance(outcome, SourceError) or outcome == right
            arrived += met.sound
        assert outcome == right
    pinned = {target: times for target, times in arrived.items() if "/w/" not in target}
    assert set(pinned.values()) <= {1}
    assert len(pinned) >= CALLS - 1


WORKER = """
import sys
from pathlib import Path
from linkwright.pipeline.caching.actions import Cache
from linkwright.pipeline.caching.store import Store
from linkwright.stages import fetch as stage
from linkwright.stages.fetch.source import FetchContext
from tests.support.kept import QUICK, onshape

print("ready", flush=True)
folder = Path(sys.argv[2])
replies = Cache(Store(folder)).replies()
environ = {"ONSHAPE_ACCESS_KEY": sys.argv[3], "ONSHAPE_SECRET_KEY": sys.argv[4]}
context = FetchContext(replies, environ, ledger=folder / "ledger", patience=QUICK)
stage.fetch(onshape(sys.argv[1]), context)
print("done", flush=True)
"""


@pytest.mark.parametrize("place", mostly_slow(("middle", "first", "last"), keep=1))
def test_a_killed_client_pays_for_no_kept_reply_twice(fetching, right, server, place):
    """It dies when the server gets this call, so what it has on disk is what arrived before."""
    environ = {**os.environ, "PYTHONPATH": str(PROJECT)}
    keys = list(server.environ.values())
    command = [sys.executable, "-c", WORKER, server.document_url("m"), str(fetching.folder), *keys]

    def kill(method, target, number):
        if number == PLACES[place]:
            client.kill()
            return Fault(silent=True)
        return None

    server.fault = kill
    client = subprocess.Popen(command, env=environ, stdout=subprocess.PIPE, text=True)
    output, _ = client.communicate(timeout=60)
    assert "done" not in output
    before = server.count
    bundle, _ = fetching.run({}, check_ledger=False)
    assert bundle == right
    # Up to four were on their way when it died: those were billed in vain.
    assert CALLS <= server.count <= CALLS + 4
    assert server.count - before <= CALLS
