"""Random faults over random runs: afterwards a clean run is right, and nothing kept was paid for again."""

import tempfile
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from linkwright.stages.robot.errors import SourceError
from tests.fake_onshape.server import OnshapeServer
from tests.support.faulty import CALLS, DECLINED, FINAL, PASSING, Fetching, desk, reference

DOCUMENT = desk()
# Where triangles are declined glTF stands in, which is another robot: the matrix has those.
FAULTS = {**PASSING, **{name: fault for name, fault in FINAL.items() if name not in DECLINED}}
SCHEDULES = st.lists(
    st.dictionaries(st.integers(0, CALLS + 5), st.sampled_from(sorted(FAULTS)), max_size=8),
    min_size=1,
    max_size=4,
)


@pytest.fixture(scope="module")
def right():
    return {kind: reference(DOCUMENT, kind) for kind in "mw"}


@pytest.fixture(scope="module")
def server():
    with OnshapeServer(DOCUMENT) as running:
        yield running


@pytest.mark.slow
@settings(max_examples=80, suppress_health_check=[HealthCheck.too_slow])
@given(runs=SCHEDULES, kind=st.sampled_from("mw"))
def test_after_any_faults_a_clean_run_is_right(server, right, runs, kind):
    server.reset()
    arrived: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        fetching = Fetching(server, Path(folder) / "cache", kind)
        for faults in [*runs, {}]:
            outcome, met = fetching.run({number: FAULTS[name] for number, name in faults.items()})
            assert isinstance(outcome, SourceError) or outcome == right[kind]
            arrived += met.sound
        assert outcome == right[kind]
    pinned = {target: times for target, times in arrived.items() if "/w/" not in target}
    assert set(pinned.values()) <= {1}
    assert len(pinned) >= CALLS - 1
