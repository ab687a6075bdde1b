"""Checks files of any origin in a process of its own: some crash their reader, or exhaust time and memory."""

import json
import signal
from pathlib import Path

from linkwright.pipeline.checking.run import checked
from linkwright.pipeline.checking.wire import dump
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.validate.reading.admission import admitted

BASE_SECONDS, BASE_MEMORY = 3.5, 700 << 20
"""Processor time [s] and memory [bytes] that the checks of the smallest file may take."""

SECONDS_PER_TEXT_BYTE, SECONDS_PER_ASSET_BYTE = 20e-6, 4e-6
"""Additional processor time [s] for each byte of a text (XML, USD), and of an asset (mesh, image)."""

MEMORY_PER_TEXT_BYTE, MEMORY_PER_ASSET_BYTE = 60, 12
"""Additional memory [bytes] for each byte of a text, and of an asset."""

STRICT_FACTOR = 4.0
"""Factor of the processor time with `--level strict`."""

_DATA_FIELD = 5
"""Index of the field of Linux's `statm` with the pages of data and stack."""

_HINT = "look for large counts or sizes, models in models, or a file that includes itself"


def answer(request: bytes) -> bytes:
    """Returns the verdict, in the form of `wire`, for a request {"place", "level", "targets"}. Raises
    SourceError if the files cannot be read, or need more time or memory than their sizes explain."""
    options = json.loads(request)
    try:
        # The walk through the files is limited too; their sizes then decide the limits of the checks.
        _limit_process(BASE_SECONDS, BASE_MEMORY)
        sizes = admitted(Path(options["place"]))
        factor = STRICT_FACTOR if options["level"] == "strict" else 1.0
        _limit_process(
            factor
            * (BASE_SECONDS + SECONDS_PER_TEXT_BYTE * sizes.texts + SECONDS_PER_ASSET_BYTE * sizes.assets),
            BASE_MEMORY + MEMORY_PER_TEXT_BYTE * sizes.texts + MEMORY_PER_ASSET_BYTE * sizes.assets,
        )
        return dump(checked(options["place"], options["level"], options["targets"]))
    except MemoryError:
        msg = "checking it needs more memory than its size explains"
    except RecursionError:
        msg = "it is nested too deep to be checked"
    raise SourceError(msg, options["place"], _HINT)


def _limit_process(seconds: float, memory: int) -> None:
    """Limits this process from now on: the kernel ends it after `seconds` of processor time, and gives it at
    most `memory` [bytes] more than it has.

    Only memory that is written to counts, since usd-core reserves 400 MB of addresses for each of its
    threads. On Windows this has no effect; there only the limits that `ask` sets hold.
    """
    if not hasattr(signal, "setitimer"):
        return
    # Imported late: exists only on POSIX systems.
    import resource

    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        used = int(Path("/proc/self/statm").read_text().split()[_DATA_FIELD]) * resource.getpagesize()
    except (OSError, ValueError, IndexError):
        return
    resource.setrlimit(resource.RLIMIT_DATA, (used + memory, resource.RLIM_INFINITY))
