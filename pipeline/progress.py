"""Shows the progress of a build on the terminal and in `build.log`."""

import time
from collections.abc import Mapping
from typing import Any, Protocol, TextIO

from pipeline.report import StageReport
from pipeline.secrets import Secrets
from pipeline.terminal import clean
from stages.robot.printable import printable


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
    """A spinner that names the running stage, below the finished stages."""

    def __init__(self, stream: TextIO) -> None:
        from rich.console import Console

        self._clean = clean(stream).clean
        self._console = Console(file=clean(stream).raw, highlight=False)
        self._status: Any = None
        self._last = ""

    def start(self, stage: str) -> None:
        self.close()
        self._last = stage
        self._status = self._console.status(stage)
        self._status.start()

    def detail(self, stage: str, line: str) -> None:
        self._last = self._clean(f"{stage}: {printable(line)}")
        if self._status is None:
            self._console.print(self._last, markup=False)
        else:
            self._update(self._last)

    def transient(self, stage: str, line: str) -> None:
        if self._status is not None:
            self._update(f"{self._last} ({self._clean(printable(line))})")

    def _update(self, text: str) -> None:
        from rich.markup import escape

        self._status.update(escape(text))

    def done(self, stage: StageReport) -> None:
        self.close()
        self._console.print(self._clean(sentence(stage)), style="dim" if stage.cached else "", markup=False)

    def close(self) -> None:
        if self._status is not None:
            self._status.stop()
            self._status = None


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
