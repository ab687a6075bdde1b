"""Memory and processor time that a process uses."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

_STATM = "/proc/{}/statm"
_STAT = "/proc/{}/stat"
_PATIENCE = 5.0
"""How long `ps` may take [s]."""


def is_quick() -> bool:
    """Whether the system shows the memory of a process in a file."""
    return os.path.exists(_STATM.format("self"))  # noqa: PTH110


def resident(process: int) -> int:
    """The resident memory of a process [bytes], 0 where the system does not show it."""
    try:
        with open(_STATM.format(process), "rb") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError, ValueError):
        return 0 if is_quick() else _resident_by_ps(process)


def computed(process: int, unknown: float) -> float:
    """The processor time of a process [s], `unknown` where the system does not show it."""
    try:
        # The name of the program, in brackets, may hold anything.
        fields = Path(_STAT.format(process)).read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except (OSError, IndexError, ValueError):
        return unknown


def _resident_by_ps(process: int) -> int:
    try:
        listed = subprocess.run(
            ["ps", "-o", "rss=", "-p", str(process)],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_PATIENCE,
            check=False,
        )
        return int(listed.stdout) * 1024
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return 0


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "process_cpu_count"):
        return os.process_cpu_count() or 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
