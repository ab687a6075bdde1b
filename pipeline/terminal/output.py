"""Writes text to a terminal or a pipe, without control characters and API keys, wrapped on a terminal.

Text comes from servers, files and people. An escape sequence in a part's name could move the cursor,
change the terminal's colours or title, or hide the line above. All printed text passes through this module.
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
"""Width in columns that is assumed for a terminal of unknown width."""

MIN_COLUMNS = 20
"""Smallest width in columns to which text is wrapped."""


class CleanStream:
    """A stream that writes control characters as their escapes, and blanks API keys. All its other attributes
    are those of the stream that it wraps."""

    def __init__(self, raw: TextIO) -> None:
        self.raw = raw
        """The wrapped stream. Code that writes control characters to it passes each text through
        `clean_text`."""
        self._secrets: Secrets | None = None

    def clean_text(self, text: str) -> str:
        """Returns `text` with control characters as escapes, and with API keys blanked."""
        if self._secrets is None:
            self._secrets = Secrets(os.environ)
        return printable_lines(self._secrets.blanked(text))

    def write(self, text: str) -> int:
        """Writes `clean_text(text)`, and returns the length of `text`."""
        self.raw.write(self.clean_text(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.raw, name)


def clean_stream(stream: Any) -> CleanStream:
    """Returns the stream as a `CleanStream`; a stream that is already clean is not wrapped again."""
    return stream if isinstance(stream, CleanStream) else CleanStream(stream)


def terminal_width(stream: Any) -> int | None:
    """Returns the width of a terminal in columns; None for a pipe or a file. The environment variable COLUMNS
    overrides it."""
    if not stream.isatty():
        return None
    columns = os.environ.get("COLUMNS")
    if columns:
        with contextlib.suppress(ValueError):
            return max(MIN_COLUMNS, int(columns))
    return _columns_of_terminal(stream)


def _columns_of_terminal(stream: Any) -> int:
    try:
        # Some terminals report 0 columns.
        return max(MIN_COLUMNS, os.get_terminal_size(stream.fileno()).columns or DEFAULT_COLUMNS)
    except (OSError, ValueError, AttributeError):
        return DEFAULT_COLUMNS


def say(text: str, stream: Any = None) -> None:
    """Prints a message to `stream`, by default to standard output; on a terminal its lines are wrapped."""
    stream = sys.stdout if stream is None else stream
    width = terminal_width(stream)
    if width is not None:
        # Cleaned first, since escapes are wider than the characters that they replace.
        text = wrapped(clean_stream(stream).clean_text(text), width)
    print(text, file=stream)


@contextlib.contextmanager
def clean_standard_streams() -> Iterator[None]:
    """Cleans everything that the block prints to the standard streams."""
    # A clean stream has all attributes of a TextIO, but not its type.
    out, err = cast(TextIO, clean_stream(sys.stdout)), cast(TextIO, clean_stream(sys.stderr))
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        yield
