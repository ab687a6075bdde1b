"""Keeps the working folder off Python's path, so that no file beside a robot is imported.

Imports only what Python has loaded before: any other import could come from the working folder.
"""

import os
import sys

_OURS = os.path.join("pipeline", "face", "__init__.py")  # noqa: PTH118 (pathlib is not loaded yet)


def is_command() -> bool:
    """Whether Python is loading this package for `python -m linkwright`."""
    words = sys.orig_argv
    named = any(
        word[:1] == "-" and word[-1:] == "m" and module.partition(".")[0] == "linkwright"
        for word, module in zip(words, words[1:])  # noqa: RUF007 (itertools is not loaded yet)
    )
    return sys.argv[:1] == ["-m"] and (named or any(word.startswith("-mlinkwright") for word in words))


def leave_out_working_folder() -> None:
    """Takes the working folder off `sys.path` and, for the processes that this process starts, out of
    PYTHONPATH. Where the working folder is a checkout that Python needs, it becomes the last entry."""
    try:
        here = _real(os.getcwd())  # noqa: PTH109
    except OSError:  # the folder was deleted
        here = ""
    rest = _without(sys.path, here)
    needed = [here] if here and _holds_ours(here) and not any(map(_holds_ours, rest)) else []
    sys.path[:] = [*rest, *needed]
    os.environ["PYTHONSAFEPATH"] = "1"
    if "PYTHONPATH" in os.environ:
        kept = [*_without(os.environ["PYTHONPATH"].split(os.pathsep), here), *needed]
        os.environ["PYTHONPATH"] = os.pathsep.join(kept)


def _without(places: "list[str]", here: str) -> "list[str]":
    return [place for place in places if place and _real(place) != here]


def _real(place: str) -> str:
    return os.path.normcase(os.path.realpath(place))


def _holds_ours(place: str) -> bool:
    return os.path.isfile(os.path.join(place, _OURS))  # noqa: PTH113, PTH118
