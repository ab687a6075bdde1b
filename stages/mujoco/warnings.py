"""Collects MuJoCo's warnings, which otherwise go to a log file in the working folder."""

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco

_QUOTED = re.compile(r"(Line number=\d+): XML.*")
"""The end of a message that quotes the text of a file."""


def unquoted(error: Exception) -> str:
    """Returns MuJoCo's message without the text that it quotes from a file that is not XML: a model may
    include any file, also a secret one."""
    return _QUOTED.sub(r"\1", str(error))


@contextmanager
def collected_warnings() -> Iterator[list[str]]:
    """Yields a list to which MuJoCo's warnings inside the context are added."""
    texts: list[str] = []
    previous_handler = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(texts.append)
    try:
        yield texts
    finally:
        mujoco.set_mju_user_warning(previous_handler)


@contextmanager
def deprecations(texts: list[str]) -> Iterator[None]:
    """Adds to `texts` the warnings that MuJoCo's Python module issues inside the context, such as those about
    attributes that a later version will not read. Python would write them to standard error."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            yield
        finally:
            texts += [str(warning.message) for warning in caught if issubclass(warning.category, UserWarning)]
