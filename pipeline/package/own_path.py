"""Keeps the working folder off Python's path, so that no file beside a robot is imported.

Imports only what Python has loaded before: any other import could come from the working folder.
"""

import os
import sys


def is_command() -> bool:
    """Tells whether Python is loading this package for `python -m linkwright`."""
    words = sys.orig_argv
    names_linkwright = any(
        word[:1] == "-" and word[-1:] == "m" and module.partition(".")[0] == "linkwright"
        for word, module in zip(words, words[1:])  # noqa: RUF007 (itertools is not loaded yet)
    )
    return sys.argv[:1] == ["-m"] and (
        names_linkwright or any(word.startswith("-mlinkwright") for word in words)
    )


def leave_out_working_folder() -> None:
    """Takes the working folder off `sys.path` and, for the processes that this process starts, out of
    PYTHONPATH."""
    try:
        working_folder = _normalized(os.getcwd())  # noqa: PTH109
    except OSError:  # the folder was deleted
        working_folder = ""
    sys.path[:] = _without_folder(sys.path, working_folder)
    os.environ["PYTHONSAFEPATH"] = "1"
    if "PYTHONPATH" in os.environ:
        os.environ["PYTHONPATH"] = os.pathsep.join(
            _without_folder(os.environ["PYTHONPATH"].split(os.pathsep), working_folder)
        )


def _without_folder(places: "list[str]", folder: str) -> "list[str]":
    return [place for place in places if place and _normalized(place) != folder]


def _normalized(place: str) -> str:
    return os.path.normcase(os.path.realpath(place))
