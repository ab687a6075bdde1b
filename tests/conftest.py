"""Fixtures that several tests share, and how hypothesis draws.

Examples are the same in every run; `HYPOTHESIS_PROFILE=explore` draws new ones, and more.
"""

import gc
import os
import signal

import pytest
from filelock import FileLock
from hypothesis import Phase, settings
from hypothesis.internal.conjecture import engine

from tests.support import kept_colliders, long_tests
from tests.support.kit import Kit

SURROUNDINGS = (
    "ONSHAPE_", "LINKWRIGHT_TRUST", "LINKWRIGHT_HOST", "LINKWRIGHT_PAGE", "LINKWRIGHT_TRACEBACK", "ROS_",
    "AMENT_", "SSL_CERT_", "HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY", "NO_PROXY", "FORCE_COLOR", "NO_COLOR",
    "CLICOLOR", "COLORTERM", "HYDRA_",
)  # fmt: skip
"""What the user's own environment may say, and no test may depend on."""

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # So it is for what a shell starts in the background, and what that starts: Ctrl-C would do nothing.
    signal.signal(signal.SIGINT, signal.default_int_handler)

for name in [name for name in os.environ if name.upper().startswith(SURROUNDINGS)]:
    del os.environ[name]
# Of the many builds of the tests no page shows the robot and none has a picture, but where a test asks.
os.environ["LINKWRIGHT_PAGE"] = "plain"
# A terminal of one size, whatever the tests are started from.
os.environ |= {"COLUMNS": "120", "LINES": "40", "TERM": "xterm-256color"}

# Why an example fails is for a person to find out: to explain it by more examples takes minutes.
PHASES = (Phase.explicit, Phase.reuse, Phase.generate, Phase.target, Phase.shrink)
settings.register_profile("same", derandomize=True, deadline=None, phases=PHASES, report_multiple_bugs=False)
settings.register_profile("explore", max_examples=2000, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))
if os.environ.get("HYPOTHESIS_PROFILE", "same") == "same":
    # [s], of 300. There is no setting for it.
    engine.MAX_SHRINKING_SECONDS = 60


# While tests are collected nearly nothing is garbage.
often = gc.get_threshold()
gc.set_threshold(100_000, 50, 100)


def pytest_collection_modifyitems(items):
    long = long_tests.long_tests()
    for item in items:
        if "e2e" in item.path.parts or long_tests.function_of(item.nodeid) in long:
            item.add_marker("e2e")
    items.sort(key=lambda item: item.get_closest_marker("first") is None)


def pytest_collection_finish():
    """Leaves all that is there now, which stays until the end, out of the garbage collector's rounds."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(*often)


@pytest.fixture
def whole_page(monkeypatch):
    """The builds of the test have the view of the robot in their pages, and its picture."""
    monkeypatch.setenv("LINKWRIGHT_PAGE", "whole")


@pytest.fixture(scope="session")
def run_folder(tmp_path_factory, worker_id):
    """A folder that all processes of this run share."""
    base = tmp_path_factory.getbasetemp()
    return base if worker_id == "master" else base.parent


@pytest.fixture(scope="session")
def shared_cache(run_folder):
    """A cache that builds of real robots share, in all processes of this run: for tests of anything but how
    they are made."""
    folder = run_folder / "cache"
    with FileLock(folder.with_suffix(".lock")):
        if not folder.exists():
            kept_colliders.seed(folder)
    return folder


@pytest.fixture
def guests_at_home(monkeypatch):
    """What reads or checks files of others does so in this process, without a guest and its limits: for the
    many tests of what is read, where tests of the guests show the rest."""
    from tests.support.mjcfs import at_home

    monkeypatch.setattr("linkwright.stages.robot.system.guest.ask", at_home)
    monkeypatch.setattr("linkwright.pipeline.checking.guest._limit_process", lambda *_: None)


@pytest.fixture
def no_thumbnails(monkeypatch):
    """USD files without their picture, which a process of its own draws and which takes most of the time."""
    monkeypatch.setattr("linkwright.stages.export.usd.build.thumbnail", lambda look: b"picture")


@pytest.fixture
def no_score(monkeypatch):
    """Checks without the score of readiness, which compiles the model three times and passes whatever it
    finds: for tests of what does not pass."""
    monkeypatch.setattr("linkwright.stages.validate.run.readiness", lambda *_: ())


@pytest.fixture
def kit():
    return Kit()
