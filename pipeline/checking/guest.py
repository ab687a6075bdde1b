"""Guest process that checks files of any origin: some crash what reads them, or exhaust time and memory."""

import json
import signal
from pathlib import Path

from linkwright.pipeline.checking.wire import dump
from linkwright.stages.robot.errors import SourceError

SECONDS, MEMORY = 4.0, 700 << 20
"""Of the processor and of memory: what the checks of the smallest file may take."""

PER_TEXT, PER_ASSET = 20e-6, 4e-6
"""More seconds for each byte of a text, and of a mesh or an image."""

MEMORY_PER_TEXT, MEMORY_PER_ASSET = 60, 12
"""More memory [bytes] for each byte of these."""

STRICT = 4.0
"""Times as much of the processor for what only `--level strict` runs."""

_DATA = 5
"""The field of Linux's `statm` that has the pages of data and stack."""

_LARGE = "look for large counts or sizes, models in models, or a file that includes itself"


def answer(request: bytes) -> bytes:
    """To {"place", "level"}: the verdict, as `wire` has it. SourceError where the files cannot be read, or
    need more time or memory than their sizes explain."""
    # Late: it takes a while, and only a guest that checks needs it.
    from linkwright.pipeline.checking.run import checked
    from linkwright.stages.validate.reading.admission import admitted

    asked = json.loads(request)
    try:
        _limit(SECONDS, MEMORY)
        sizes = admitted(Path(asked["place"]))
        times = STRICT if asked["level"] == "strict" else 1.0
        _limit(
            times * (SECONDS + PER_TEXT * sizes.texts + PER_ASSET * sizes.assets),
            MEMORY + MEMORY_PER_TEXT * sizes.texts + MEMORY_PER_ASSET * sizes.assets,
        )
        return dump(checked(asked["place"], asked["level"]))
    except MemoryError:
        msg = "checking it needs more memory than its size explains"
    except RecursionError:
        msg = "it is nested too deep to be checked"
    raise SourceError(msg, asked["place"], _LARGE)


def _limit(seconds: float, memory: int) -> None:
    """From now on: the kernel ends this process after `seconds` of the processor, and gives it no more than
    this memory [bytes] beside what it has. Only memory that is written to counts: usd-core reserves 400 MB of
    addresses for each of its threads. Not on Windows, where the guest's own bounds hold."""
    if not hasattr(signal, "setitimer"):
        return
    # Late: POSIX only.
    import resource

    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        taken = int(Path("/proc/self/statm").read_text().split()[_DATA]) * resource.getpagesize()
    except (OSError, ValueError, IndexError):
        return
    resource.setrlimit(resource.RLIMIT_DATA, (taken + memory, resource.RLIM_INFINITY))
