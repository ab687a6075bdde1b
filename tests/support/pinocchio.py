"""Pinocchio, imported where a test first uses it; the test is skipped where it is not installed.

It has no wheel for every Python that we support, and what does not use it is tested there all the same.
"""

import pytest


class _Pinocchio:
    def __getattr__(self, name):
        return getattr(pytest.importorskip("pinocchio"), name)


pin = _Pinocchio()
