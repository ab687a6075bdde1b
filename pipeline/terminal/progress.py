"""Shows the progress of a build on the terminal and in `build.log`."""

import time
from collections.abc import Mapping
from typing import Protocol, TextIO

from linkwright.pipeline.report import StageReport
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.terminal.output import clean_stream
from linkwright.stages.robot.text.printable import printable


class Progress(Protocol):
    """A display of a build's progress, stage by stage.

    `close` is always called at the end, also after an error. `detail` shows a line about the running stage;
    `transient` adds to the last such line, until the next line.
    """

    def start(self, stage: str) -> None: ...

    def detail(self, stage: str, line: str) -> None: ...

    def transient(self, stage: str, line: str) -> None: ...

    def done(self, stage: StageReport) -> None: ...

    def close(self) -> None: ...


def sentence(stage: StageReport) -> str:
    """Returns the line about a finished stage."""
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
    """Prints a plain line for each finished stage and for each detail."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = clean_stream(stream)

    def detail(self, stage: str, line: str) -> None:
        print(f"{stage:<8}     {printable(line)}", file=self._stream, flush=True)

    def done(self, stage: StageReport) -> None:
        print(sentence(stage), file=self._stream, flush=True)


class Log(Quiet):
    """Collects the lines of `build.log`, with the seconds since the build began; secrets are blanked.

    `notes`: the lines about the result, which are the same in every build of the plan: a list of lines for
    each stage, and a last list of the lines after the last stage.
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
        """Returns the content of `build.log`."""
        return (self.secrets.blanked("\n".join(self._lines)) + "\n").encode()


class Tee(Quiet):
    """Forwards everything to several displays."""

    def __init__(self, *to: Progress) -> None:
        self._displays = to

    def start(self, stage: str) -> None:
        for display in self._displays:
            display.start(stage)

    def detail(self, stage: str, line: str) -> None:
        for display in self._displays:
            display.detail(stage, line)

    def transient(self, stage: str, line: str) -> None:
        for display in self._displays:
            display.transient(stage, line)

    def done(self, stage: StageReport) -> None:
        for display in self._displays:
            display.done(stage)

    def close(self) -> None:
        for display in self._displays:
            display.close()
