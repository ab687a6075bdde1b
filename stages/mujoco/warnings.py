"""MuJoCo's warnings, collected in place of a log file in the working folder, and its errors."""

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco

_QUOTED = re.compile(r"(Line number=\d+): XML.*")


def unquoted(error: Exception) -> str:
    """MuJoCo's message, without the part of a file that is not XML: a model may include any file."""
    return _QUOTED.sub(r"\1", str(error))


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


@contextmanager
def deprecations(heard: list[str]) -> Iterator[None]:
    """Adds to `heard` what MuJoCo's Python module warns of when it compiles, as of attributes that a later
    version will not read. Python would write it on the standard error."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        try:
            yield
        finally:
            heard += [str(one.message) for one in found if issubclass(one.category, UserWarning)]
