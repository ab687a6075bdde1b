"""Shows the progress of a build on a terminal, by Rich."""

import time
from typing import Any, TextIO

from rich.console import Console
from rich.text import Text

from linkwright.pipeline.report import StageReport
from linkwright.pipeline.terminal.output import clean_stream, terminal_width
from linkwright.pipeline.terminal.progress import Quiet, sentence
from linkwright.pipeline.terminal.wrapping import wrapped
from linkwright.stages.robot.text.printable import printable

_TIME_SHOWN_AFTER = 3.0
"""Time [s] after which a running stage shows its time."""


class Terminal(Quiet):
    """A spinner that names the running stage and its time, below the finished stages."""

    def __init__(self, stream: TextIO) -> None:
        self._clean = clean_stream(stream).clean_text
        self._console = Console(file=clean_stream(stream).raw, highlight=False, width=terminal_width(stream))
        self._live: Any = None
        self._stage, self._detail, self._transient, self._start = "", "", "", 0.0

    def start(self, stage: str) -> None:
        # Late: a build without changes shows no running stage.
        from rich.live import Live
        from rich.spinner import Spinner

        self.close()
        self._stage, self._detail, self._transient, self._start = stage, "", "", time.monotonic()
        spinner = Spinner("dots")
        self._live = Live(
            console=self._console, get_renderable=lambda: self._renderable(spinner), transient=True
        )
        self._live.start()

    def detail(self, stage: str, line: str) -> None:
        self._detail, self._transient = self._clean(printable(line)), ""
        if self._live is None:
            self._print(f"{stage}: {self._detail}")
        else:
            self._live.refresh()

    def transient(self, stage: str, line: str) -> None:
        if self._live is not None:
            self._transient = f" ({self._clean(printable(line))})"
            self._live.refresh()

    def _renderable(self, spinner: Any) -> Any:
        """Returns the line of the running stage: a single line, however long its texts are."""
        seconds = time.monotonic() - self._start
        time_text = f" {seconds:.0f} s" if seconds >= _TIME_SHOWN_AFTER else ""
        detail = f": {self._detail}{self._transient}" if self._detail else self._transient
        spinner.update(text=Text(f"{self._stage}{time_text}{detail}", no_wrap=True, overflow="ellipsis"))
        return spinner

    def done(self, stage: StageReport) -> None:
        self.close()
        self._print(self._clean(sentence(stage)), "dim" if stage.cached else "")

    def _print(self, line: str, style: str = "") -> None:
        self._console.print(Text(wrapped(line, self._console.width), style=style), soft_wrap=True)

    def close(self) -> None:
        if self._live is not None:
            self._live.stop()
            self._live = None
