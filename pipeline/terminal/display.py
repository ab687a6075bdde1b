"""Chooses the display of a build's progress."""

from typing import TextIO

from linkwright.pipeline.terminal.progress import Lines, Progress


def progress_for(stream: TextIO) -> Progress:
    """Returns a live display if `stream` is a terminal, else plain lines."""
    if not stream.isatty():
        return Lines(stream)
    # Imported late, since Rich takes long to import and plain lines do not need it.
    from linkwright.pipeline.terminal.spinner import Terminal

    return Terminal(stream)
