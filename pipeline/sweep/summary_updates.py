"""Keeps the summary of a sweep up to date while its jobs run."""

import contextlib
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from linkwright.pipeline.errors import LinkwrightError
from linkwright.pipeline.sweep.folder import write_summaries
from linkwright.pipeline.sweep.outcome_files import outcomes_of

MIN_INTERVAL = 30.0
"""The shortest time [s] between two summaries."""

MAX_TIME_SHARE = 0.02
"""Largest share of the time that is spent on writing summaries."""


@contextlib.contextmanager
def updating_summary(root: Path, pause: float = MIN_INTERVAL) -> Iterator[None]:
    """Writes the summary of a sweep again and again in a thread, from the outcomes that its jobs have left;
    and once more if an error or Ctrl-C ends the sweep."""
    end = threading.Event()
    thread = threading.Thread(target=_write_repeatedly, args=(root, pause, end), daemon=True)
    thread.start()
    try:
        yield
    except BaseException:
        end.set()
        thread.join()
        _write_summary(root)
        raise
    finally:
        end.set()
        thread.join()


def _write_repeatedly(root: Path, pause: float, end: threading.Event) -> None:
    wait = pause
    while not end.wait(wait):
        start = time.perf_counter()
        _write_summary(root)
        wait = max(pause, (time.perf_counter() - start) / MAX_TIME_SHARE)


def _write_summary(root: Path) -> None:
    # A disk that is full now may have room in the end, when the error is reported.
    with contextlib.suppress(LinkwrightError, OSError):
        write_summaries(list(outcomes_of(root)), root)
