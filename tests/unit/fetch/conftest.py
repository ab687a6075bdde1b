"""Replies that the tests of fetches from the local Onshape keep."""

import pytest

from tests.support.kept import Kept


@pytest.fixture
def kept():
    return Kept()
