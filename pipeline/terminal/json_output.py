"""Prints the document of a command with `--json`: nothing else comes to the standard output."""

import contextlib
import os
import sys
from collections.abc import Callable, Iterator
from typing import Any

from linkwright.pipeline.errors import render
from linkwright.pipeline.json_documents.document import CommandDocument, text_of
from linkwright.pipeline.json_documents.error import error_document
from linkwright.pipeline.options import UsageError
from linkwright.pipeline.terminal.error_border import cause, print_error

_STDOUT = 1


def print_document(command: Callable[[], Any], verb: str, *, whole: bool) -> int:
    """Runs a command, prints its document or that of its error, and returns the exit status. Everything else
    that is printed goes to the standard error. `command` returns a CommandDocument."""
    document: CommandDocument
    with _stdout_to_stderr():
        try:
            document = command()
        except (Exception, KeyboardInterrupt) as error:
            status = print_error(error, whole=whole)
            message, _, hint = _text(cause(error)).partition("\n  → ")
            document = error_document(
                cause(error), status, verb, message=message.removeprefix("error: "), hint=hint, whole=whole
            )
    print(text_of(document))
    return document.exit_status


def _text(error: BaseException) -> str:
    return str(error) if isinstance(error, UsageError) else render(error)


@contextlib.contextmanager
def _stdout_to_stderr() -> Iterator[None]:
    """Sends what is printed to the standard output to the standard error instead, also by libraries and child
    processes."""
    out, err = sys.stdout, sys.stderr
    with contextlib.redirect_stdout(err):
        try:
            descriptors = out.fileno(), err.fileno()
        except (OSError, ValueError, AttributeError):
            descriptors = (-1, -1)
        if descriptors[0] != _STDOUT:  # A caller replaced the stream.
            yield
            return
        out.flush()
        saved_stdout = os.dup(_STDOUT)
        os.dup2(descriptors[1], _STDOUT)
        try:
            yield
        finally:
            os.dup2(saved_stdout, _STDOUT)
            os.close(saved_stdout)
