"""Fixtures that several tests share, and how hypothesis draws.

Examples are the same in every run; `HYPOTHESIS_PROFILE=explore` draws new ones, and more.
"""

import os
import signal

import pytest
from hypothesis import settings

from tests.support.kit import Kit

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # So it is for what a shell starts in the background, and what that starts: Ctrl-C would do nothing.
    signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("same", derandomize=True, deadline=None)
settings.register_profile("explore", max_examples=2000, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))


@pytest.fixture
def kit() -> Kit:
    return Kit()
