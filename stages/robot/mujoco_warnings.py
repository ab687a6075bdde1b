"""Collects MuJoCo's warnings, in place of a log file in the working folder."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


@contextmanager
def listening() -> Iterator[list[str]]:
    """Collects MuJoCo's warnings."""
    heard: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(heard.append)
    try:
        yield heard
    finally:
        mujoco.set_mju_user_warning(before)
