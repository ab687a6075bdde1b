"""Shows the progress of a build on the terminal and in `build.log`."""

import time
from collections.abc import Mapping
from typing import Any, Protocol, TextIO

from linkwright.pipeline.report import StageReport
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.terminal.output import clean, width_of
from linkwright.pipeline.terminal.wrapping import wrapped
from linkwright.stages.robot.text.printable import printable


class Progress(Protocol):
    """Shows each stage in turn. `close` is always called at the end, also after an error.

    `detail` shows a line about the stage that runs; `transient` adds to the last such line, until the
    next one.
    """

    def start(self, stage: str) -> None: ...

    def detail(self, stage: str, line: str) -> None: ...

    def transient(self, stage: str, line: str) -> None: ...

    def done(self, stage: StageReport) -> None: ...

    def close(self) -> None: ...


_LONG = 3.0
"""A stage that runs longer [s] shows how long."""


def sentence(stage: StageReport) -> str:
    cached = " (cached)" if stage.cached else ""
    outputs = f"  {printable(stage.outputs)}" if stage.outputs else ""
    return f"{stage.name:<8} ... {stage.seconds:.2f} s{cached}{outputs}"


class Quiet:
    """Shows nothing: for sweeps and for use as a library."""

    def start(self, stage: str) -> None:
        pass

    def detail(self, stage: str, line: str) -> None:
        pass

    def transient(self, stage: str, line: str) -> None:
        pass

    def done(self, stage: StageReport) -> None:
        pass

    def close(self) -> None:
        pass


class Lines(Quiet):
    """One plain line for each finished stage and for each detail."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = clean(stream)

    def detail(self, stage: str, line: str) -> None:
        print(f"{stage:<8}     {printable(line)}", file=self._stream, flush=True)

    def done(self, stage: StageReport) -> None:
        print(sentence(stage), file=self._stream, flush=True)


class Terminal(Quiet):
    """A spinner that names the running stage and how long it runs, below the finished stages."""

    def __init__(self, stream: TextIO) -> None:
        # Late: Rich takes a while to import, and plain output needs none of it.
        from rich.console import Console
        from rich.text import Text

        self._text = Text
        self._clean = clean(stream).clean
        self._console = Console(file=clean(stream).raw, highlight=False, width=width_of(stream))
        self._live: Any = None
        self._stage, self._detail, self._transient, self._start = "", "", "", 0.0

    def start(self, stage: str) -> None:
        # Late: Rich takes a while to import, and plain output needs none of it.
        from rich.live import Live
        from rich.spinner import Spinner

        self.close()
        self._stage, self._detail, self._transient, self._start = stage, "", "", time.monotonic()
        spinner = Spinner("dots")
        self._live = Live(console=self._console, get_renderable=lambda: self._drawn(spinner), transient=True)
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

    def _drawn(self, spinner: Any) -> Any:
        """The line of the running stage: one, however long its texts are."""
        seconds = time.monotonic() - self._start
        running = f" {seconds:.0f} s" if seconds >= _LONG else ""
        said = f": {self._detail}{self._transient}" if self._detail else self._transient
        spinner.update(text=self._text(f"{self._stage}{running}{said}", no_wrap=True, overflow="ellipsis"))
        return spinner

    def done(self, stage: StageReport) -> None:
        self.close()
        self._print(self._clean(sentence(stage)), "dim" if stage.cached else "")

    def _print(self, line: str, style: str = "") -> None:
        self._console.print(self._text(wrapped(line, self._console.width), style=style), soft_wrap=True)

    def close(self) -> None:
        if self._live is not None:
            self._live.stop()
            self._live = None


def progress_for(stream: TextIO) -> Progress:
    """A live display where `stream` is a terminal, else plain lines."""
    return Terminal(stream) if stream.isatty() else Lines(stream)


class Log(Quiet):
    """The lines of `build.log`, with the seconds since the build began; secrets are blanked.

    `notes`: the lines about the result, which another build of the same has too: those before the end of each
    stage, and those after the last stage.
    """

    def __init__(self, environ: Mapping[str, str]) -> None:
        self._start = time.perf_counter()
        self.secrets = Secrets(environ)
        self._lines: list[str] = []
        self.notes: list[list[str]] = [[]]

    def line(self, text: str) -> None:
        self.notes[-1].append(text)
        self._add(text)

    def detail(self, stage: str, line: str) -> None:
        self._add(f"{stage}: {line}")

    def done(self, stage: StageReport) -> None:
        self.notes.append([])
        self._add(sentence(stage))

    def _add(self, text: str) -> None:
        self._lines.append(f"{time.perf_counter() - self._start:9.3f}  {printable(text)}")

    def content(self) -> bytes:
        """The content of `build.log`."""
        return (self.secrets.blanked("\n".join(self._lines)) + "\n").encode()


class Tee(Quiet):
    """Forwards everything to several displays."""

    def __init__(self, *to: Progress) -> None:
        self._to = to

    def start(self, stage: str) -> None:
        for one in self._to:
            one.start(stage)

    def detail(self, stage: str, line: str) -> None:
        for one in self._to:
            one.detail(stage, line)

    def transient(self, stage: str, line: str) -> None:
        for one in self._to:
            one.transient(stage, line)

    def done(self, stage: StageReport) -> None:
        for one in self._to:
            one.done(stage)

    def close(self) -> None:
        for one in self._to:
            one.close()
