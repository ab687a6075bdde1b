"""Prints the error that ended a command as one message."""

import os
import sys
import traceback

from linkwright.pipeline.errors import exit_status, render
from linkwright.pipeline.interrupt import is_cause_of
from linkwright.pipeline.options import UsageError
from linkwright.pipeline.terminal.output import say


def print_error(error: BaseException, *, whole: bool) -> int:
    """Prints an error to the standard error; returns the exit status. If not `whole`, only the worst problems
    of each code are shown for a stage."""
    error = cause(error)
    if isinstance(error, UsageError):
        say(f"error: {error}", sys.stderr)
        return 2
    if os.environ.get("LINKWRIGHT_TRACEBACK", "") not in ("", "0"):
        traceback.print_exception(error)
    say(render(error, whole=whole), sys.stderr)
    return exit_status(error)


def cause(error: BaseException) -> BaseException:
    """Returns the error, or KeyboardInterrupt if Ctrl-C is behind it."""
    return KeyboardInterrupt() if is_cause_of(error) else error
