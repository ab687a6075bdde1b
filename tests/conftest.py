"""Fixtures that several tests share, and how hypothesis draws.

Examples are the same in every run; `HYPOTHESIS_PROFILE=explore` draws new ones, and more.
"""

import os

import pytest
from hypothesis import settings

from tests.support.kit import Kit

settings.register_profile("same", derandomize=True, deadline=None)
settings.register_profile("explore", max_examples=2000, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))


@pytest.fixture
def kit() -> Kit:
    return Kit()
