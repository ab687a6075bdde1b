"""Measures the memory and processor time of a process, and counts the processors that this process may
use."""

from __future__ import annotations

import contextlib
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

_STATM, _STAT = "/proc/{}/statm", "/proc/{}/stat"
"""Linux's files of the memory and of the times of a process."""

_PATIENCE = 5.0
"""Longest time that `ps` may take [s]."""


def has_memory_files() -> bool:
    """Returns whether the system shows the memory of a process in a file, which is quick to read."""
    return os.path.exists(_STATM.format("self"))  # noqa: PTH110


def resident_memory(process: int) -> int:
    """Returns the resident memory of a process [bytes]; 0 if it is unknown."""
    try:
        with open(_STATM.format(process), "rb") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError, ValueError):
        return 0 if has_memory_files() else _resident_memory_by_ps(process)


def processor_time(process: int, unknown: float) -> float:
    """Returns the processor time of a process [s], without that of its children; `unknown` if the system does
    not show it."""
    try:
        # The name of the program, in parentheses, may contain spaces and parentheses.
        fields = Path(_STAT.format(process)).read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except (OSError, IndexError, ValueError):
        return unknown


def _resident_memory_by_ps(process: int) -> int:
    try:
        output = subprocess.run(
            ["ps", "-o", "rss=", "-p", str(process)],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_PATIENCE,
            check=False,
        )
        return int(output.stdout) * 1024
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return 0


_processor_limit: int | None = None
"""Largest number of processors that this process uses; None without a limit."""


def processors() -> int:
    """Returns the number of processors that this process may use, at least 1."""
    if hasattr(os, "process_cpu_count"):
        available = os.process_cpu_count() or 1
    else:
        available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return available if _processor_limit is None else max(1, min(available, _processor_limit))


@contextlib.contextmanager
def limited_processors(number: int | None) -> Iterator[None]:
    """Limits the number of processors that `processors` returns inside the context, since other processes use
    the rest; None removes the limit."""
    global _processor_limit
    previous, _processor_limit = _processor_limit, number
    try:
        yield
    finally:
        _processor_limit = previous
