"""Writes to a terminal or a pipe, without control characters and API keys, and no wider than the terminal.

Text comes from servers, files and people. An escape sequence in a part's name could move the cursor,
change the terminal's colours or title, or hide the line above. All printed text passes through here.
"""

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO, cast

from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.terminal.wrapping import wrapped
from linkwright.stages.robot.text.printable import printable_lines

DEFAULT_COLUMNS = 80
"""The width of a terminal that does not tell its width."""


class Clean:
    """A stream on which control characters are shown as their escapes, and keys are blanked.

    `raw` is the wrapped stream, for callers that write control characters themselves and pass each text
    through `clean`.
    """

    def __init__(self, raw: TextIO) -> None:
        self.raw = raw
        self._secrets: Secrets | None = None

    def clean(self, text: str) -> str:
        """Returns `text` with control characters as escapes, and without API keys."""
        if self._secrets is None:
            self._secrets = Secrets(os.environ)
        return printable_lines(self._secrets.blanked(text))

    def write(self, text: str) -> int:
        """Writes `text` with control characters as escapes, and without API keys."""
        self.raw.write(self.clean(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.raw, name)


def clean(stream: Any) -> Clean:
    """Returns the stream wrapped in `Clean`, at most once."""
    return stream if isinstance(stream, Clean) else Clean(stream)


def width_of(stream: Any) -> int | None:
    """Returns the width of a terminal in columns; None for a pipe or a file."""
    if not stream.isatty():
        return None
    with contextlib.suppress(ValueError):
        return max(20, int(os.environ["COLUMNS"])) if os.environ.get("COLUMNS") else _columns(stream)
    return _columns(stream)


def _columns(stream: Any) -> int:
    try:
        return max(20, os.get_terminal_size(stream.fileno()).columns or DEFAULT_COLUMNS)
    except (OSError, ValueError, AttributeError):
        return DEFAULT_COLUMNS


def say(text: str, stream: Any = None) -> None:
    """Prints a message; on a terminal its lines are wrapped."""
    stream = sys.stdout if stream is None else stream
    width = width_of(stream)
    print(text if width is None else wrapped(clean(stream).clean(text), width), file=stream)


@contextlib.contextmanager
def clean_streams() -> Iterator[None]:
    """Cleans everything that is printed to the standard streams."""
    out, err = cast(TextIO, clean(sys.stdout)), cast(TextIO, clean(sys.stderr))
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        yield
